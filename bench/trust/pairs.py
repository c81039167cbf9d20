"""The pairs of scans of the study: name, group, kind, and the points of both, MOVING already where it belongs on FIXED.

Kinds: `rigid`: one surface scanned twice; `changed`: it changed between the scans, the truth is that of what did not;
`hard`: rigid, but scanned thinly, unevenly or in part; `repeats`: symmetric or a pattern, more than one pose fits;
`other`: no pose is right (other objects, mirrored, other units)."""

import dataclasses
import zlib

import numpy as np

from trust import geometry, objects

POINTS = 10000


@dataclasses.dataclass
class Pair:
    name: str
    group: str
    kind: str
    make: object             # (Source, random) -> moving, fixed
    flat: bool = True        # a height field: mostly the measure; else mostly ICP
    needs: tuple = ()        # folders of the shared data
    tolerance: float = 0.0   # for the overlap of changed pairs: how near is the same place, share of the extent

    def random(self):
        return np.random.default_rng(zlib.crc32(self.name.encode()))


def thinned(points, random, count=POINTS):
    points = points[np.isfinite(points).all(axis=1)]
    return points[random.permutation(len(points))[:count]]


def halves(points, random, count=POINTS):
    """Two scans of one: no point in both."""
    points = points[random.permutation(len(points))]
    middle = len(points) // 2
    return points[:middle][:count], points[middle:][:count]


# --- shared data -------------------------------------------------------------------------------------------------------------


class Source:
    """Reads the shared data and simulates, by the program under test itself."""

    def __init__(self, tool, data, folder):
        self.tool, self.data, self.folder = tool, data, folder
        self.kept = {}

    def points(self, name, *words):
        """Of any file that the program reads; kept if it is shared data."""
        key = (str(name), words)
        if key not in self.kept or self.folder in (self.data / name).parents:
            copy = self.folder / "points.xyz"
            self.tool("convert", self.data / name, copy, *words)
            self.kept[key] = np.loadtxt(copy, usecols=(0, 1, 2), comments=["#", "//"], ndmin=2)
        return self.kept[key]

    def mesh(self, name):
        if name not in self.kept:
            path = self.data / name
            if path.suffix == ".vtk":
                self.kept[name] = legacy_vtk(path)
            else:
                copy = self.folder / "mesh.obj"
                self.tool("convert", path, copy)
                self.kept[name] = wavefront(copy)
        return self.kept[name]

    def simulated(self, scene, *words):
        out = self.folder / scene
        self.tool("simulate", scene, "-o", out, "--format", "ply", *words)
        return out

    def scene(self, scene, *words, names=("b", "a")):
        out = self.simulated(scene, *words)
        return [self.points(out / f"{name}.ply") for name in names]


def wavefront(path):
    corners, faces = [], []
    for line in path.read_text(errors="replace").splitlines():
        words = line.split()
        if words[:1] == ["v"]:
            corners.append([float(w) for w in words[1:4]])
        elif words[:1] == ["f"]:
            ring = [int(w.split("/")[0]) - 1 for w in words[1:]]
            faces += [[ring[0], ring[k], ring[k + 1]] for k in range(1, len(ring) - 1)]
    return np.array(corners), np.array(faces)


def legacy_vtk(path):
    """Points and polygons or strips of an ascii file."""
    words = path.read_text().split()
    at = words.index("POINTS")
    count = int(words[at + 1])
    corners = np.array(words[at + 3:at + 3 + 3 * count], float).reshape(-1, 3)
    faces = []
    for kind in ("POLYGONS", "TRIANGLE_STRIPS"):
        if kind not in words:
            continue
        at = words.index(kind)
        numbers = [int(w) for w in words[at + 3:at + 3 + int(words[at + 2])]]
        at = 0
        while at < len(numbers):
            ring = numbers[at + 1:at + 1 + numbers[at]]
            at += 1 + numbers[at]
            first = (lambda k: 0) if kind == "POLYGONS" else (lambda k: k)
            faces += [[ring[first(k)], ring[k + 1], ring[k + 2]] for k in range(len(ring) - 2)]
    return corners, np.array(faces)


def usgs_dem(path):
    """Profiles of an ascii DEM, in its own units: records of 1024 characters."""
    text = path.read_text()
    found = []
    records = [text[k:k + 1024] for k in range(1024, len(text), 1024)]
    step = [float(text[816 + 12 * k:828 + 12 * k].replace("D", "E")) for k in range(3)]
    at = 0
    while at < len(records):
        head = records[at]
        rows = int(head[12:18]) if head[12:18].strip() else 0
        if rows < 1 or int(head[18:24] or 0) != 1:
            break
        x, y, datum = (float(head[24 + 24 * k:48 + 24 * k].replace("D", "E")) for k in range(3))
        cells = [head[144 + 6 * k:150 + 6 * k] for k in range(146)]
        at += 1
        while len(cells) < rows:
            cells += [records[at][6 * k:6 * k + 6] for k in range(170)]
            at += 1
        found += [(x, y + k * step[1], datum + int(cells[k]) * step[2]) for k in range(rows)]
    return np.array(found)


def bunny(moving, fixed):
    def make(source, random):
        poses = {}
        for line in (source.data / "stanford-bunny-range/bun.conf").read_text().splitlines():
            words = line.split()
            if words[:1] == ["bmesh"]:  # the rotation is that of the conjugate quaternion
                x, y, z, w = map(float, words[5:9])
                poses[words[1][:6]] = geometry.by_quaternion(list(map(float, words[2:5])), -x, -y, -z, w)
        a, b = (source.points(f"stanford-bunny-range/{n}.ply") for n in (moving, fixed))
        truth = geometry.inverse(poses[fixed]) @ poses[moving]
        return geometry.moved(thinned(a, random), truth), thinned(b, random)

    return make


def mesh_views(name, angles, noise=8e-4, about=(0, 1, 0), front=(0, 0, 1), count=POINTS):
    """Two scans of a mesh, seen from the front turned by these angles; noise as a share of the extent."""
    def make(source, random):
        corners, faces = name(7) if callable(name) else source.mesh(name)
        noise_length = noise * geometry.extent(corners)
        sides = [geometry.turn(about, angle)[:3, :3] @ np.asarray(front, float) for angle in angles]
        return [geometry.seen(corners, faces, side, count, noise_length, random) for side in sides]

    return make


def whole_mesh(name, noise=8e-4, counts=(POINTS, POINTS)):
    """Two samples of all of a mesh, hidden parts and all."""
    def make(source, random):
        corners, faces = name(7) if callable(name) else source.mesh(name)
        size = noise * geometry.extent(corners)
        scans = [geometry.sample(corners, faces, count, random)[0] for count in counts]
        return [s + random.normal(0, size, s.shape) for s in scans]

    return make


def expressions(moving, fixed, folder):
    """Two faces with the same corners; the truth is the motion of the half that moved least."""
    def make(source, random):
        a, b = (source.points(f"{folder}/{n}") for n in (moving, fixed))
        a = geometry.moved(a, geometry.best_motion(a, b))
        order = random.permutation(len(a))
        return a[order[:len(a) // 2]][:POINTS], b[order[len(a) // 2:]][:POINTS]

    return make


def split(name, *words, count=POINTS):
    return lambda source, random: halves(source.points(name, *words), random, count)


def both(moving, fixed, shift=(0, 0, 0)):
    return lambda source, random: (thinned(source.points(moving), random) + shift, thinned(source.points(fixed), random))


def street(source, random):
    d = "small-gicp/"
    a, b = (source.points(d + f"{n}.ply") for n in ("source", "target"))
    truth = np.loadtxt(source.data / d / "T_target_source.txt")
    a, b = (p[np.any(p != 0, axis=1)] for p in (a, b))  # zeros: rays without an echo
    return geometry.moved(thinned(a, random), truth), thinned(b, random)


def car(source, random):
    d = source.data / "libpointmatcher"
    truth = np.loadtxt(d / "defaultIdentityDataPointsFilter.ref_trans")
    rows = [[line.replace(",", " ").split()[:3] for line in (d / f"car_cloud{k}.csv").read_text().splitlines()]
            for k in (400, 401)]
    a, b = (np.array([r for r in own if r and r[0][-1].isdigit()], float) for own in rows)
    return geometry.moved(thinned(a, random), truth), thinned(b, random)


def dome(moving, fixed):
    """Two epochs of a volcano's dome: the part of the grid that was surveyed, no cell in both."""
    def make(source, random):
        a, b, base = (source.points(f"msh-dome/{n}.tif") for n in (moving, fixed, 2))
        changed = np.abs(a[:, 2] - b[:, 2]) + np.abs(a[:, 2] - base[:, 2]) > 1
        low, high = np.percentile(a[changed, :2], [1, 99], axis=0)
        inside = ((a[:, :2] > low - 250) & (a[:, :2] < high + 250)).all(axis=1)
        order = random.permutation(np.flatnonzero(inside))
        return a[order[::2]][:POINTS], b[order[1::2]][:POINTS]

    return make


def toronto(source, random):
    scans = []
    for year in (15, 23):
        rows = np.loadtxt(source.data / f"toronto-ttp/TTP_{year}_xyzc.csv", delimiter=",", skiprows=1)
        scans.append(thinned(rows[rows[:, 3] == 2][:, :3], random))
    return scans[1] + [0, 0, 0.407], scans[0]


def debris_flow(source, random):
    before, change = (source.points(f"landlab-runout/{n}.asc") for n in ("pre_runout_DEM", "DEM_of_Difference"))
    lift = {(x, y): z for x, y, z in change}
    after = before.copy()
    after[:, 2] += [lift.get((x, y), 0.0) if abs(lift.get((x, y), 0.0)) < 100 else 0.0 for x, y in before[:, :2]]
    order = random.permutation(len(before))
    return after[order[::2]], before[order[1::2]]


def st_helens(source, random):
    points = usgs_dem(source.data / "vtk-sthelens/SainteHelens.dem")
    a, b = halves(points, random)
    return a + random.normal(0, 0.5, a.shape), b + random.normal(0, 0.5, b.shape)


def short_and_long_nose(source, random):
    """Landmarks of two noses: other objects that look alike."""
    a, b = (np.loadtxt(source.data / f"morpho-nose/{n}nose.lm.csv", delimiter=",", skiprows=1, usecols=(1, 2, 3))
            for n in ("long", "short"))
    return a, b


def shared():
    views = ["bun000", "bun045", "bun315", "bun270"]
    found = [Pair(f"{a} on {b}", "bunny", "rigid", bunny(a, b), False, ("stanford-bunny-range",))
             for k, b in enumerate(views) for a in views[k + 1:]]
    lee, james = "leeperrysmith/LeePerrySmith.obj", "menpo-face/james.obj"
    found += [Pair(f"head 1, views {a} degrees apart", "head-1", "rigid", mesh_views(lee, (0, a)), False,
                   ("leeperrysmith",)) for a in (0, 40, 90, 180)]
    found += [Pair(f"head 2, views {a} degrees apart", "head-2", "rigid", mesh_views(james, (-a / 2, a / 2)), False,
                   ("menpo-face",)) for a in (0, 50)]
    found += [
        Pair("face, cleaned, two samples", "face-3", "rigid", whole_mesh("rvcg-face/humfaceClean.obj"), True,
             ("rvcg-face",)),
        Pair("face, cleaned, views 30 degrees apart", "face-3", "rigid",
             mesh_views("rvcg-face/humfaceClean.obj", (0, 30)), False, ("rvcg-face",)),
        Pair("face of a turning scanner, two samples", "face-4", "rigid", whole_mesh("vtk-fran/fran_cut.vtk"), True,
             ("vtk-fran",)),
        Pair("face model, two samples", "face-5", "rigid", whole_mesh("mediapipe-face/canonical_face_model.obj"), True,
             ("mediapipe-face",)),
        Pair("bust, halves", "bust", "rigid", split("zaghetto/Zaghetto.pcd"), True, ("zaghetto",)),
        Pair("nose, two samples", "nose", "rigid", whole_mesh("morpho-nose/shortnose.mesh.obj"), False,
             ("morpho-nose",)),
        Pair("neutral face, two samples", "expressions", "rigid", split("goast-faces/neutral.ply"), True,
             ("goast-faces",)),
        Pair("smile on neutral", "expressions", "changed", expressions("smile.ply", "neutral.ply", "goast-faces"), True,
             ("goast-faces",), 0.02),
        Pair("surprise on neutral", "expressions", "changed",
             expressions("surprise.ply", "neutral.ply", "goast-faces"), True, ("goast-faces",), 0.03),
        Pair("open mouth on closed", "expressions", "changed", expressions("face-x.txt", "face-y.txt", "probreg"), True,
             ("probreg",), 0.02),
        Pair("street, vehicle", "street", "rigid", street, False, ("small-gicp",)),
        Pair("street, turning scanner", "car", "rigid", car, False, ("libpointmatcher",)),
        Pair("strips over an island", "strips-1", "rigid",
             both("santacruz/blanca_strip8707_120m.las", "santacruz/blanca_strip8706_120m.las"), True, ("santacruz",)),
        Pair("strips over a forest, ground", "strips-2", "rigid",
             both("lasr-bcts/bcts_ground_strip68.las", "lasr-bcts/bcts_ground_strip67.las"), True, ("lasr-bcts",)),
        Pair("dome, epochs 5 and 8", "dome", "changed", dome(8, 5), True, ("msh-dome",), 0.02),
        Pair("dome, epochs 12 and 16", "dome", "changed", dome(16, 12), True, ("msh-dome",), 0.02),
        Pair("dome, epochs 24 and 27", "dome", "changed", dome(27, 24), True, ("msh-dome",), 0.02),
        Pair("shore, 2015 and 2023", "shore", "changed", toronto, True, ("toronto-ttp",), 0.01),
        Pair("volcano, cells apart", "volcano", "rigid", st_helens, True, ("vtk-sthelens",)),
        Pair("debris flow", "debris", "changed", debris_flow, True, ("landlab-runout",), 0.01),
        Pair("mountain, halves", "mountain", "rigid", split("pdal-terrain/hexbin-crop.las"), True, ("pdal-terrain",)),
        Pair("forest, halves", "forest", "rigid", split("coromandel/points_test.las"), True, ("coromandel",)),
        Pair("race track, 2010 and 2023", "track", "changed",
             both("autzen-bmx/autzen-bmx-2010.las", "autzen-bmx/autzen-bmx-2023.las", (0, 0, 1.0)), True,
             ("autzen-bmx",), 0.01),
    ]
    return found


# --- made by the program's simulator -------------------------------------------------------------------------------------------


def scene(name, *words):
    few = ("--points", POINTS, "--points-b", POINTS)
    return lambda source, random: [thinned(p, random) for p in source.scene(name, *few, *words)]


def simulated():
    return [
        Pair("terrain, slides", "made terrain", "changed", scene("terrain", "--noise", 0.1, "--noise-b", 0.1), True, (),
             0.02),
        Pair("face, swollen", "made face", "changed", scene("face", "--noise", 0.1, "--noise-b", 0.1), True, (), 0.02),
        Pair("relief, mound and pit", "made relief", "changed",
             scene("relief", "--variant", "rough", "--noise", 0.2, "--noise-b", 0.2), True, (), 0.02),
        Pair("cliff that retreats", "made relief", "repeats", scene("relief", "--variant", "cliff", "--noise", 0.05,
                                                                   "--noise-b", 0.05), True, (), 0.02),
        Pair("skin, wrinkles filled", "made skin", "changed", scene("skin"), True, (), 0.02),
    ]


# --- objects of our own ----------------------------------------------------------------------------------------------------------


def surface(make, width, depth, noise, counts=(POINTS, POINTS)):
    """Two scans of a height field."""
    def scans(source, random):
        height = make(7)
        return [objects.field(height, width, depth, count, noise, random) for count in counts]

    return scans


def mound_on(make, width, depth, noise, tall, size):
    """The same with a heap in one of them."""
    def scans(source, random):
        height = make(11)
        a, b = (objects.field(height, width, depth, POINTS, noise, random) for _ in range(2))
        a[:, 2] += tall * np.exp(-((a[:, 0] - 0.6 * width) ** 2 + (a[:, 1] - 0.4 * depth) ** 2) / size ** 2)
        return a, b

    return scans


def own():
    o = objects
    fields = [("carved slab", o.carved_slab, 300, 200, 0.15), ("outcrop", o.outcrop, 60, 60, 0.05),
              ("quarry", o.quarry, 400, 300, 0.15), ("dunes", o.dunes, 500, 400, 0.1), ("town", o.town, 220, 220, 0.1)]
    found = [Pair(f"{name}, scanned twice", name, "rigid", surface(make, width, depth, noise))
             for name, make, width, depth, noise in fields]
    found += [Pair("outcrop, a heap", "outcrop", "changed", mound_on(o.outcrop, 60, 60, 0.05, 3, 8), True, (), 0.02),
              Pair("quarry, a heap", "quarry", "changed", mound_on(o.quarry, 400, 300, 0.15, 15, 50), True, (), 0.02)]
    solids = [("boulder", o.boulder, (0, 0, 1), (1, 0, 0), (0, 55)), ("shell", o.shell, (1, 0, 0), (0, 0.3, 1), (0, 40)),
              ("machined part", o.machined, (1, 0.2, 0), (0, 0, 1), (0, 35)),
              ("torso", o.torso, (0, 0, 1), (0, 1, 0), (-20, 25)),
              ("branches", o.branches, (0, 0, 1), (1, 0.3, 0.2), (0, 30))]
    for name, make, about, front, angles in solids:
        found += [Pair(f"{name}, seen from {angles[0]} and {angles[1]} degrees", name, "rigid",
                       mesh_views(make, angles, about=about, front=front), False),
                  Pair(f"{name}, all of it twice", name, "rigid", whole_mesh(make), False)]
    return found


# --- what cannot be decided, what is not the same, what is scanned badly -----------------------------------------------------


def symmetric():
    o = objects
    found = [Pair(name, "symmetric", "repeats", whole_mesh(make, 1e-3), False)
             for name, make in [("ball", o.plain_ball), ("ball with a faint bump", o.bumped_ball),
                                ("cylinder", o.cylinder), ("cone", o.cone), ("cog of 12 teeth", o.cog)]]
    return found + [
        Pair("plane", "symmetric", "repeats", surface(lambda seed: lambda x, y: 0.02 * x, 100, 80, 0.1)),
        Pair("pattern of waves", "self-similar", "repeats", surface(o.waves, 100, 100, 0.05)),
        Pair("furrows", "self-similar", "repeats", surface(o.furrows, 100, 100, 0.03)),
    ]


def scaled_to(points, model):
    """As large as another scan, middle on middle."""
    own = points - points.mean(axis=0)
    return own * geometry.extent(model) / geometry.extent(points) + model.mean(axis=0)


def two(first, second):
    """Two makers of pairs: MOVING of the one, as large as FIXED of the other."""
    def make(source, random):
        a, b = first(source, random)[0], second(source, random)[1]
        return scaled_to(a, b), b

    return make


def with_seeds(make, width, depth, noise):
    def scans(source, random):
        return [objects.field(make(seed), width, depth, POINTS, noise, random) for seed in (21, 22)]

    return scans


def jaw_and_face(source, random):
    out = source.simulated("combine")
    return [thinned(source.points(out / f"{n}.ply"), random) for n in ("jaw", "face")]


def mirrored(make):
    def scans(source, random):
        a, b = make(source, random)
        return a * [-1, 1, 1] + [2 * a[:, 0].mean(), 0, 0], b

    return scans


def in_other_units(make, factor):
    def scans(source, random):
        a, b = make(source, random)
        return a * factor, b

    return scans


def strangers():
    o = objects
    lee = mesh_views("leeperrysmith/LeePerrySmith.obj", (0, 0))
    clean, quarry = whole_mesh("rvcg-face/humfaceClean.obj"), surface(o.quarry, 400, 300, 0.15)
    return [
        Pair("head 1 on the bunny", "strangers", "other", two(lee, bunny("bun045", "bun000")), False,
             ("leeperrysmith", "stanford-bunny-range")),
        Pair("another face", "strangers", "other", two(clean, split("goast-faces/neutral.ply")), True,
             ("rvcg-face", "goast-faces")),
        Pair("dunes elsewhere", "strangers", "other", with_seeds(o.dunes, 500, 400, 0.1)),
        Pair("outcrop elsewhere", "strangers", "other", with_seeds(o.outcrop, 60, 60, 0.05)),
        Pair("town elsewhere", "strangers", "other", with_seeds(o.town, 220, 220, 0.1)),
        Pair("quarry on terrain", "strangers", "other", two(quarry, scene("terrain"))),
        Pair("shell on boulder", "strangers", "other", two(whole_mesh(o.shell), whole_mesh(o.boulder)), False),
        Pair("jaw on face", "strangers", "other", jaw_and_face, False),
        Pair("boulder, mirrored", "mirrored", "other", mirrored(whole_mesh(o.boulder)), False),
        Pair("quarry, mirrored", "mirrored", "other", mirrored(quarry)),
        Pair("bunny, mirrored", "mirrored", "other", mirrored(bunny("bun045", "bun000")), False,
             ("stanford-bunny-range",)),
        Pair("outcrop, mm and m", "units", "other", in_other_units(surface(o.outcrop, 60, 60, 0.05), 1000)),
        Pair("torso, inches and cm", "units", "other", in_other_units(whole_mesh(o.torso), 2.54), False),
    ]


def the_same(make):
    """Every point of one scan also in the other, in another order."""
    def scans(source, random):
        b = make(source, random)[1]
        return b[random.permutation(len(b))], b

    return scans


def inside(make, share):
    """MOVING is a round part of what FIXED shows."""
    def scans(source, random):
        a, b = make(source, random)
        off = np.linalg.norm(a - a[len(a) // 3], axis=1)
        return a[off <= np.quantile(off, share)], b

    return scans


def repeated(make, times):
    """Every point several times in the file, as merged scans have them."""
    def scans(source, random):
        a, b = make(source, random)
        return np.repeat(a, times, axis=0), np.repeat(b, times, axis=0)

    return scans


def noisier(make, size):
    def scans(source, random):
        a, b = make(source, random)
        return a + random.normal(0, size, a.shape), b

    return scans


def badly_scanned():
    o, many = objects, 20000
    dunes, boulder = surface(o.dunes, 500, 400, 0.1), whole_mesh(o.boulder)
    return [
        Pair("outcrop, a scan twice", "odd scans", "hard", the_same(surface(o.outcrop, 60, 60, 0.05))),
        Pair("dunes, a part of them", "odd scans", "hard", inside(dunes, 0.15)),
        Pair("boulder, a part of it", "odd scans", "hard", inside(boulder, 0.2), False),
        Pair("boulder, 200 points", "few points", "hard", whole_mesh(o.boulder, counts=(200, 200)), False),
        Pair("quarry, 200 points", "few points", "hard", surface(o.quarry, 400, 300, 0.15, (200, 200))),
        Pair("carved slab, points three times", "odd scans", "hard", repeated(surface(o.carved_slab, 300, 200, 0.15,
                                                                                     (3000, 3000)), 3)),
        Pair("outcrop, 100 times denser", "few points", "hard", surface(o.outcrop, 60, 60, 0.05, (many, many // 100))),
        Pair("torso, 100 times denser", "few points", "hard", whole_mesh(o.torso, counts=(many // 100, many)), False),
        Pair("quarry, one scan noisy", "odd scans", "hard", noisier(surface(o.quarry, 400, 300, 0.15), 1.5)),
    ]


def all_pairs():
    return shared() + simulated() + own() + symmetric() + strangers() + badly_scanned()
