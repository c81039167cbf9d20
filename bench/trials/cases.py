"""The runs that are tried: one or more of every verb, on inputs that `simulate` makes, and what each does undisturbed."""

import dataclasses
import json
import pathlib
import re
import shutil
import subprocess

LONGEST_S = 900  # a run that takes longer hangs, on a machine with much other work as well


@dataclasses.dataclass
class Case:
    """A command; "out" in it is a folder of results, `target` a single file."""
    verb: str
    words: list
    target: str = ""
    share: float = 1.0  # of the trials of a cheap case that this one gets
    code: int = 0  # the rest as an undisturbed run has it
    stderr: str = ""
    stdout: str = ""
    before: dict = dataclasses.field(default_factory=dict)
    after: dict = dataclasses.field(default_factory=dict)
    calls: dict = dataclasses.field(default_factory=dict)  # of each kind that the library of tests/faults knows
    requests: int = 0  # of memory, however small

    @property
    def has_folder(self):
        return "out" in self.words

    def shown(self):
        return "isopach " + " ".join(self.words)


COMPARE = "compare in/a.xyz in/b.xyz -o out --no-map --threads 2"


def all_cases():
    def case(line, target="", share=1.0):
        words = line.split() + ["--quiet"]
        return Case(words[0], words, target, share)

    return [
        case(COMPARE),
        case("compare in/a.las in/b.laz -o out --map-width 400 --budget in/field.geojson --threads 2", share=0.1),
        case("match in/hill_a.xyz in/hill_b.xyz -o out --pose-only", share=0.5),
        case("distance in/a.xyz in/b.xyz -o out"),
        case("roughness in/hill_a.xyz -o out --map-width 400", share=0.3),
        case("accuracy in/reconstruction.ply in/reference.ply -o out --map-width 400", share=0.1),
        case("scanners in/scan_a.ply in/scan_b.ply in/scan_reference.ply -o out", share=0.02),
        case("asymmetry in/face.ply --direction z -o out --map-width 400", share=0.04),
        case("sequence in/frames -o out", share=0.04),
        case("combine in/combine/face.ply in/combine/jaw.ply --reference in/combine/reference.ply -o out", share=0.04),
        case("info in/a.xyz in/a.laz in/a.ply in/a.pcd in/cube.stl in/cube.obj"),
        case("info in/grid.tif", share=0.1),
        case("simulate plane -o out --points 120 --format xyz"),
        case("demo plane -o out --points 120 --no-map"),
        case("convert in/a.xyz x.ply", "x.ply"),
        case("convert in/a.xyz x.las", "x.las"),
        case("convert in/a.xyz x.laz", "x.laz"),
        case("convert in/a.laz x.xyz", "x.xyz"),
        case("convert in/grid.asc x.tif", "x.tif", share=0.1),
    ]


def plain(path):
    """The bytes of a result without the times it took."""
    data = path.read_bytes()
    if path.name == "result.json":
        told = json.loads(data)
        told.pop("timing_s", None)
        return json.dumps(told).encode()
    if path.suffix == ".html":
        data = re.sub(rb"<tr>(?:(?!</tr>).)*timing_s(?:(?!</tr>).)*</tr>", b"", data, flags=re.DOTALL)
        data = re.sub(rb'(?:"|&quot;)timing_s(?:"|&quot;):\s*\{[^}]*\}', b"", data)
    return data


def contents(folder):
    """Files of a folder by name, as plain() has them; None for what is no file, the folder itself None if it is not there."""
    if not folder.is_dir():
        return None
    return {p.name: plain(p) if p.is_file() else None for p in folder.iterdir()}


class Sandbox:
    """A folder in which one run at a time is tried; the inputs are shared."""

    def __init__(self, program, root, inputs):
        self.program, self.root = program, pathlib.Path(root)
        self.root.mkdir(parents=True)
        (self.root / "in").symlink_to(inputs)

    def run(self, words, environment=None, timeout=LONGEST_S, **options):
        options.setdefault("stdout", subprocess.PIPE)
        options.setdefault("stderr", subprocess.PIPE)
        options.setdefault("stdin", subprocess.DEVNULL)
        return subprocess.run([self.program, *words], cwd=self.root, env=environment, timeout=timeout, text=True,
                              errors="replace", **options)

    def popen(self, words, environment=None, **options):
        return subprocess.Popen([self.program, *words], cwd=self.root, env=environment, text=True, errors="replace",
                                **options)

    def clear(self):
        for path in self.root.iterdir():
            if path.name == "in":
                continue
            shutil.rmtree(path) if path.is_dir() and not path.is_symlink() else path.unlink()

    def begin(self, case):
        """Everything as it is before the case: an earlier result in "out", or a file under the name of the target."""
        self.clear()
        if case.has_folder:
            shutil.copytree(self.root / "in" / ("old_scene" if case.verb == "simulate" else "old"), self.root / "out")
        if case.target:
            (self.root / case.target).write_bytes(b"before")

    def state(self, case):
        if case.has_folder:
            return contents(self.root / "out")
        path = self.root / case.target
        return {case.target: path.read_bytes() if path.is_file() else None} if case.target else {}

    def leftovers(self):
        return sorted(str(p.relative_to(self.root)) for p in self.root.rglob(".isopach-*"))

    def sweep(self, case):
        """The next run into the folder, which fails, or to the same file, which does not."""
        if case.has_folder:
            return self.run(["compare", "nowhere.xyz", "in/a.xyz", "-o", "out", "--quiet"])
        return self.run(case.words)


def made_inputs(program, folder):
    """The inputs of all cases in `folder`: small, so that many runs can be tried."""
    folder = pathlib.Path(folder)
    folder.mkdir(parents=True)

    def isopach(line, codes=(0,)):
        done = subprocess.run([program, *line.split(), "--quiet"], cwd=folder, capture_output=True, text=True, timeout=600)
        if done.returncode not in codes:
            raise SystemExit(f"the inputs cannot be made: isopach {line}: exit {done.returncode}: {done.stderr}")

    def scene(line, **names):
        isopach(f"simulate {line} -o made")
        for new, old in names.items():
            (folder / "made" / old).rename(folder / new.replace("__", "."))
        shutil.rmtree(folder / "made")

    scene("plane --points 150 --format xyz", a__xyz="a.xyz", b__xyz="b.xyz")
    scene("plane --points 150 --format las", a__las="a.las", b__las="b.las")
    scene("terrain --points 300 --format xyz", hill_a__xyz="a.xyz", hill_b__xyz="b.xyz")
    scene("accuracy --points 300 --points-b 500", reconstruction__ply="reconstruction.ply", reference__ply="reference.ply")
    scene("scanners --points 150", scan_a__ply="a.ply", scan_b__ply="b.ply", scan_reference__ply="reference.ply")
    scene("face --points 1500", face__ply="a.ply")
    isopach("simulate chewing -o chewing --points 4000 --frames 9")
    (folder / "frames").mkdir()
    for k in (0, 3, 6, 8):  # the first frames of a cycle hardly move
        (folder / "chewing" / f"frame_00{k}.ply").rename(folder / "frames" / f"frame_00{k}.ply")
    shutil.rmtree(folder / "chewing")
    isopach("simulate combine -o combine --points 6000 --seed 3")
    for line in ["a.las a.laz", "b.las b.laz", "a.xyz a.ply", "a.xyz a.pcd"]:
        isopach("convert " + line, (0, 2))
    write_by_hand(folder)
    isopach("convert grid.asc grid.tif")
    isopach("compare b.xyz a.xyz -o old --no-map --surface both --title OLD")
    (folder / "old" / "mine.txt").write_text("mine")
    isopach("simulate cone --points 100 -o old_scene")
    (folder / "old_scene" / "mine.txt").write_text("mine")


CUBE = [(x, y, z) for x in (0, 4) for y in (0, 4) for z in (0, 4)]
SIDES = [(0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1), (2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4),
         (1, 5, 7), (1, 7, 3)]


def write_by_hand(folder):
    """Files of the formats that isopach reads and does not write."""
    rows = [" ".join(str((x * y) % 7 + 0.5 * x) for x in range(12)) for y in range(12)]
    (folder / "grid.asc").write_text("ncols 12\nnrows 12\nxllcorner 0\nyllcorner 0\ncellsize 1\n" + "\n".join(rows) + "\n")
    square = [[[1, 1], [6, 1], [6, 5], [1, 5], [1, 1]]]
    (folder / "field.geojson").write_text(json.dumps({"type": "FeatureCollection", "features": [
        {"type": "Feature", "properties": {"name": "field"}, "geometry": {"type": "Polygon", "coordinates": square}}]}))
    corners = "".join("v %g %g %g\n" % p for p in CUBE)
    (folder / "cube.obj").write_text(corners + "".join("f %d %d %d\n" % tuple(i + 1 for i in side) for side in SIDES))
    facets = "".join("facet normal 0 0 0\nouter loop\n" + "".join("vertex %g %g %g\n" % CUBE[i] for i in side) +
                     "endloop\nendfacet\n" for side in SIDES)
    (folder / "cube.stl").write_text("solid cube\n" + facets + "endsolid cube\n")
    points = [tuple(map(float, line.split()[:3])) for line in (folder / "a.xyz").read_text().splitlines()
              if line and not line.startswith("#")]
    header = f"VERSION 0.7\nFIELDS x y z\nSIZE 8 8 8\nTYPE F F F\nCOUNT 1 1 1\nWIDTH {len(points)}\nHEIGHT 1\n"
    (folder / "a.pcd").write_text(header + f"VIEWPOINT 0 0 0 1 0 0 0\nPOINTS {len(points)}\nDATA ascii\n" +
                                  "".join("%r %r %r\n" % p for p in points))


def measure(sandbox, case, injector):
    """What a case does undisturbed, twice: what differs between two such runs cannot be held against a third. Its calls are
    counted by the way."""
    states = []
    for least in (1 << 16, 1):
        sandbox.begin(case)
        case.before = sandbox.state(case)
        done, calls = injector.counted(sandbox, case, least)
        states.append((done.returncode, done.stdout, done.stderr, sandbox.state(case)))
        case.calls = case.calls or calls
        case.requests = calls["memory"]
    if states[0] != states[1]:
        raise SystemExit(f"{case.shown()}: two undisturbed runs differ")
    case.code, case.stdout, case.stderr, case.after = states[0]
    if case.code not in (0, 5):
        raise SystemExit(f"{case.shown()}: exit {case.code}: {case.stderr}")
    if case.before == case.after and (case.has_folder or case.target):
        raise SystemExit(f"{case.shown()}: changes nothing")
