"""What a job in tiles tells: files that cannot be read, time and memory of each tile, the tiles as a layer, and spots that no
tile can part."""

import fcntl
import json
import os
import pty
import random
import shutil
import struct
import subprocess
import termios
import unittest

from support import BIN, CliTest, points

LIBRARY = os.environ.get("ISOPACH_FAULTS", "")
LIMIT = 310_000_000


def told(text):
    """A result without what counts the work of one way of doing it, or says how inputs were named."""
    result = json.loads(text)
    for key in ("timing_s", "outputs", "localisation", "warnings"):
        result.pop(key)
    for scan in result["inputs"]:
        scan.pop("path"), scan.pop("format")
    return result


class Job(CliTest):
    def status(self, job="job"):
        return json.loads(self.run_cli("tile", "status", job, "--json", "-").stdout)

    def reduced(self, *words, job="job"):
        return json.loads(self.run_cli("tile", "reduce", job, "--json", "-", *words).stdout)

    def compared(self, a, b, *words):
        return told(self.run_cli("compare", a, b, "--json", "-", *words).stdout)

    def equal(self, a, b, *words, job="job"):
        found = self.run_cli("tile", "reduce", job, "--json", "-", *words).stdout
        self.assertEqual(told(found), self.compared(a, b))


class BrokenFiles(Job):
    def setUp(self):
        super().setUp()
        self.write("a.xyz", points(1))
        rows = points(2, n=900, lift=0.5)
        os.mkdir(self.path("parts"))
        for k in range(3):
            self.write(f"parts/{k}.xyz", rows[k::3])
        shutil.copytree(self.path("parts"), self.path("whole"))
        shutil.copytree(self.path("parts"), self.path("rest"))
        self.path("rest/1.xyz").unlink()
        self.path("parts/1.xyz").write_text("1 2 3\n4 5 6\n7 what 9\n")

    def plan(self, code=0, job="job", a="a.xyz", b="parts/*.xyz"):
        return self.run_cli("tile", "plan", a, b, "-o", job, "--tile-points", "200", code=code)

    def test_it_is_named_and_the_rest_goes_on(self):
        said = self.plan().stderr
        self.assertIn("parts/1.xyz: line 3", said)
        self.assertIn("1 of 3 files", said)
        self.run_cli("tile", "run", "job")
        self.assertIn("left out: parts/1.xyz: line 3", self.run_cli("tile", "status", "job").stdout)
        status = self.status()
        self.assertEqual([(file["scan"], file["path"]) for file in status["broken"]], [("B", "parts/1.xyz")])
        self.assertEqual((status["done"], status["failed"], status["missing"]), (status["tiles"], 0, 0))
        self.fails(3, "tile", "reduce", "job", says=["parts/1.xyz: line 3", "plan the job again", "--allow-missing"])
        warned = self.reduced("--allow-missing")["warnings"]
        self.assertTrue(any("1 of 3 files could not be read" in text and "parts/1.xyz" in text for text in warned), warned)
        self.equal("a.xyz", "rest/*.xyz", "--allow-missing")
        shutil.copy(self.path("whole/1.xyz"), self.path("parts/1.xyz"))
        self.plan(job="again")
        self.run_cli("tile", "run", "again")
        self.equal("a.xyz", "whole/*.xyz", job="again")

    def test_of_the_reference_too(self):
        self.plan(a="parts/*.xyz", b="a.xyz")
        self.run_cli("tile", "run", "job")
        self.fails(3, "tile", "reduce", "job", says=["parts/1.xyz: line 3"])
        self.equal("rest/*.xyz", "a.xyz", "--allow-missing")

    def test_where_nothing_is_left_it_is_an_error(self):
        self.fails(3, "tile", "plan", "a.xyz", "parts/1.xyz", "-o", "job", says=["parts/1.xyz: line 3"])
        for k in (0, 2):
            self.path(f"parts/{k}.xyz").write_text("what\n")
        self.fails(3, "tile", "plan", "a.xyz", "parts/*.xyz", "-o", "job", says=["none of its 3 files", "parts/0.xyz"])

    def test_compare_refuses_it(self):
        temporary = self.path("temporary")
        temporary.mkdir()
        run = subprocess.run([BIN, "compare", "a.xyz", "parts/*.xyz", "--max-memory", "310M"], cwd=self.folder,
                             env={**os.environ, "TMPDIR": str(temporary)}, capture_output=True, text=True)
        self.assertEqual((run.returncode, run.stdout), (3, ""))
        self.assertIn("parts/1.xyz: line 3", run.stderr)
        self.assertEqual(os.listdir(temporary), [])

    def test_contradictions_are_no_broken_files(self):
        for name, unit in (("3", "ft"), ("4", "m")):
            head = ["ply", "format ascii 1.0", f"comment unit {unit}", "element vertex 1"]
            self.write(f"parts/{name}.ply", head + [f"property double {axis}" for axis in "xyz"] + ["end_header", "1 2 3"])
        self.fails(3, "tile", "plan", "a.xyz", "parts/*.ply", "-o", "job", says=["3.ply", "4.ply"])

    def test_what_can_be_read_once_is_refused(self):
        for words in (["tile", "plan", "a.xyz", "pipe.xyz", "-o", "job"], ["compare", "a.xyz", "pipe.xyz", "--max-memory", "400M"]):
            os.mkfifo(self.path("pipe.xyz"))
            feed = subprocess.Popen(["cp", "a.xyz", "pipe.xyz"], cwd=self.folder)
            self.fails(3, *words, says=["pipe.xyz", "once", "write it to a file"])
            feed.wait()
            self.path("pipe.xyz").unlink()

    @unittest.skipUnless(os.path.exists(LIBRARY), "the library of tests/faults is not built (ISOPACH_FAULTS)")
    def test_no_failure_leaves_half_of_a_file(self):
        """Every open and every read fails once: a file is whole in the job, or out of it and named, or there is no job."""
        shutil.copy(self.path("whole/1.xyz"), self.path("parts/1.xyz"))
        size = {name: len(self.path(f"parts/{name}").read_text().splitlines()) for name in os.listdir(self.path("parts"))}
        words = [BIN, "tile", "plan", "a.xyz", "parts/*.xyz", "-o", "job", "--tile-points", "200", "--threads", "1"]
        left_out = refused = 0
        for kind in ("open", "read"):
            counted = self.path("count")
            env = {**os.environ, "LD_PRELOAD": LIBRARY, "ISOPACH_FAULT": f"{kind}:0", "ISOPACH_FAULT_COUNT": str(counted)}
            subprocess.run(words, cwd=self.folder, env=env, capture_output=True, check=True)
            shutil.rmtree(self.path("job"))
            for number in range(1, int(counted.read_text()) + 1):
                env["ISOPACH_FAULT"] = f"{kind}:{number}"
                run = subprocess.run(words, cwd=self.folder, env=env, capture_output=True, text=True)
                with self.subTest(f"{kind}:{number}"):
                    if run.returncode != 0:
                        self.assertIn(run.returncode, (1, 2, 3), run.stderr)
                        self.assertEqual(run.stderr.count("\n"), 1, run.stderr)
                        self.assertFalse(self.path("job").exists())
                        refused += 1
                        continue
                    status = self.status()
                    broken = [os.path.basename(file["path"]) for file in status["broken"]]
                    left_out += len(broken)
                    self.assertEqual(sum(tile["points_b"] for tile in status["each"]), 900 - sum(size[name] for name in broken))
                    self.assertEqual(sum(tile["points_a"] for tile in status["each"]), 400)
                    shutil.rmtree(self.path("job"))
        self.assertGreater(left_out, 0)
        self.assertGreater(refused, 0)


class Records(Job):
    def setUp(self):
        super().setUp()
        self.run_cli("simulate", "terrain", "--points", "6000", "-o", "scans")
        self.a, self.b = "scans/a.ply", "scans/b.ply"

    def plan(self, *words, job="job"):
        self.run_cli("tile", "plan", self.a, self.b, "-o", job, *words)

    def test_each_tile_tells_what_it_took(self):
        self.plan("--tile-points", "2000", "--max-memory", "1G")
        before = self.status()
        self.assertEqual((before["done"], before["missing"], before["memory"]), (0, before["tiles"], 10**9))
        for key in ("points_per_second", "seconds_left", "peak_bytes"):
            self.assertIsNone(before[key], key)
        self.run_cli("tile", "run", "job", "--index", "0-2", "--threads", "1")
        status = self.status()
        self.assertEqual((status["done"], status["failed"], status["missing"]), (3, 0, status["tiles"] - 3))
        done = [tile for tile in status["each"] if tile["state"] == "done"]
        for tile in done:
            self.assertGreater(tile["seconds"], 0)
            self.assertGreater(tile["cpu_seconds"], 0)
            self.assertEqual(tile["threads"], 1)
            self.assertEqual(tile["host"], os.uname().nodename)
            self.assertRegex(tile["ended"], r"^\d{4}-\d\d-\d\dT\d\d:\d\d:\d\dZ$")
            self.assertEqual(tile["points"], tile["points_a"] + tile["points_b"])
        for tile in status["each"][3:]:
            self.assertEqual([tile[key] for key in ("seconds", "cpu_seconds", "peak_bytes", "threads", "host", "ended")], [None] * 6)
        rate = sum(tile["points"] for tile in done) / sum(tile["seconds"] for tile in done)
        self.assertAlmostEqual(status["points_per_second"], rate, delta=1e-9 * rate)
        left = (status["points"] - status["points_done"]) / rate
        self.assertAlmostEqual(status["seconds_left"], left, delta=1e-9 * left)
        text = self.run_cli("tile", "status", "job").stdout
        self.assertIn("3 of", text)
        self.assertIn("points/s", text)
        self.assertIn("left", text)
        if status["peak_bytes"] is not None:  # Linux tells
            self.assertEqual(status["peak_bytes"], max(tile["peak_bytes"] for tile in done))
            self.assertIn("allowed 1 GB", text)

    def test_the_peak_is_that_of_the_tile(self):
        """A small tile that is done in one process behind a large one has not taken its memory."""
        shutil.rmtree(self.path("scans"))
        chance = random.Random(3)
        for name in "ab":
            dense = [(chance.uniform(0, 1), chance.uniform(0, 1), chance.uniform(0, 0.1)) for _ in range(60000)]
            thin = [(chance.uniform(3, 4), chance.uniform(3, 4), chance.uniform(0, 0.1)) for _ in range(50)]
            self.write(f"{name}.xyz", dense + thin)
        self.a, self.b = "a.xyz", "b.xyz"
        self.plan("--tile-points", "120050")
        self.run_cli("tile", "run", "job", "--threads", "1")
        each = self.status()["each"]
        sizes = {tile["points"]: tile["peak_bytes"] for tile in each}
        if None in sizes.values():
            self.skipTest("the system does not tell how much memory was taken")
        self.assertGreater(max(sizes), 100 * min(sizes))
        self.assertGreater(sizes[max(sizes)], sizes[min(sizes)] + 10_000_000)

    def test_results_do_not_depend_on_them(self):
        self.plan("--tile-points", "2000")
        self.run_cli("tile", "run", "job")
        self.equal(self.a, self.b)
        kept = {path.name: path.read_bytes() for path in self.path("job/tiles").iterdir()}
        self.assertEqual({name[-5:] for name in kept}, {".part", "cells", ".json"})
        for path in self.path("job/tiles").iterdir():
            path.unlink()
        self.run_cli("tile", "run", "job", "--threads", "1")
        for name, content in kept.items():
            if not name.endswith(".json"):
                self.assertEqual(self.path(f"job/tiles/{name}").read_bytes(), content, name)
        self.path("job/tiles/000000.json").unlink()
        self.path("job/tiles/000001.json").write_text("{\"schema\": 7")
        self.path("job/tiles/000002.json").write_text("[]")
        foreign = json.loads(kept["000003.json"])
        foreign["job"] = "another"
        self.path("job/tiles/000003.json").write_text(json.dumps(foreign))
        status = self.status()
        self.assertEqual(status["done"], status["tiles"])
        self.assertEqual([tile["seconds"] is None for tile in status["each"][:5]], [True] * 4 + [False])
        self.equal(self.a, self.b)

    def test_progress_tells_how_long_it_takes(self):
        self.plan("--tile-points", "1000")
        run = self.run_cli("tile", "run", "job", "--progress", "json")
        steps = [json.loads(line) for line in run.stderr.splitlines()]
        self.assertRegex(steps[0]["stage"], r"^tile 0, 1 of \d+$")
        self.assertRegex(steps[-1]["stage"], r"^tile \d+, (\d+) of \1, .* left, \d+ points/s$")
        self.assertEqual([step["fraction"] for step in steps], sorted(step["fraction"] for step in steps))
        shutil.rmtree(self.path("job"))
        self.plan("--tile-points", "1000")
        self.assertEqual(self.run_cli("tile", "run", "job").stderr, "")  # no terminal

    def test_progress_stays_on_one_line_of_the_terminal(self):
        self.plan("--tile-points", "300")
        terminal, program = pty.openpty()
        fcntl.ioctl(program, termios.TIOCSWINSZ, struct.pack("4H", 20, 50, 0, 0))
        run = subprocess.Popen([BIN, "tile", "run", "job", "--progress", "bar"], cwd=self.folder, stderr=program,
                               stdout=subprocess.DEVNULL)
        os.close(program)
        said = b""
        while True:
            try:
                part = os.read(terminal, 4096)
            except OSError:  # Linux: the other end is closed
                break
            if not part:
                break
            said += part
        os.close(terminal)
        self.assertEqual(run.wait(), 0)
        lines = said.decode().split("\r")
        self.assertTrue(any("tile 0, 1" in line for line in lines), lines[:3])
        self.assertEqual(max(map(len, lines)), 49)
        self.assertNotIn("\n", said.decode())

    def test_a_failure_has_its_first_line(self):
        self.plan("--tile-points", "2000")
        whole = self.path("job/points").read_bytes()
        self.path("job/points").write_bytes(whole[: len(whole) // 2])
        self.run_cli("tile", "run", "job", code=3)
        status = self.status()
        self.assertGreater(status["failed"], 0)
        self.assertEqual(status["done"] + status["failed"] + status["missing"], status["tiles"])
        text = self.run_cli("tile", "status", "job").stdout
        self.assertIn(f"{status['failed']} failed", text)
        self.assertIn("job/points: it is cut short", text)

    def test_no_overlap_names_the_scans(self):
        self.write("a.xyz", points(1))
        self.write("b.xyz", points(2, shift=100))
        self.run_cli("tile", "plan", "a.xyz", "b.xyz", "-o", "apart", "--tile-points", "200")
        self.run_cli("tile", "run", "apart")
        self.fails(4, "tile", "reduce", "apart", says=["a.xyz", "b.xyz"])


def ring_area(ring):
    return sum(p[0] * q[1] - q[0] * p[1] for p, q in zip(ring, ring[1:])) / 2


class Layer(Job):
    def setUp(self):
        super().setUp()
        self.write("a.xyz", points(1))
        self.write("b.xyz", points(2, n=600, lift=0.5))
        self.run_cli("tile", "plan", "a.xyz", "b.xyz", "-o", "job", "--tile-points", "150")

    def layer(self, name="tiles.geojson"):
        self.run_cli("tile", "status", "job", "--tiles", name)
        return json.loads(self.path(name).read_text())["features"]

    def test_each_point_lies_in_the_square_of_its_tile(self):
        features = self.layer()
        status = self.status()
        self.assertEqual([feature["properties"]["index"] for feature in features], list(range(status["tiles"])))
        scans = {key: [tuple(map(float, line.split())) for line in self.path(f"{key}.xyz").read_text().splitlines()] for key in "ab"}
        boxes = [feature["geometry"]["coordinates"] for feature in features]
        for box, feature in zip(boxes, features):
            (ring,) = box
            self.assertEqual(len(ring), 5)
            self.assertGreater(ring_area(ring), 0)
            (x0, y0), (x1, y1) = ring[0], ring[2]
            for key in "ab":  # sides are shared, and no point of these lies on an inner one
                inside = sum(x0 <= x <= x1 and y0 <= y <= y1 for x, y, _ in scans[key])
                self.assertEqual(inside, feature["properties"][f"points_{key}"])
        xs = [x for scan in scans.values() for x, _, _ in scan]
        ys = [y for scan in scans.values() for _, y, _ in scan]
        corners = [corner for (ring,) in boxes for corner in ring]
        self.assertEqual((min(x for x, _ in corners), max(x for x, _ in corners)), (min(xs), max(xs)))
        self.assertEqual((min(y for _, y in corners), max(y for _, y in corners)), (min(ys), max(ys)))

    def test_states(self):
        self.assertEqual({feature["properties"]["state"] for feature in self.layer()}, {"missing"})
        self.run_cli("tile", "run", "job", "--index", "0,2")
        whole = self.path("job/points").read_bytes()
        (self.path("job/tiles/000001.failed")).write_text("it was Tuesday\n")
        self.path("job/points").write_bytes(whole)
        of = {feature["properties"]["index"]: feature["properties"] for feature in self.layer()}
        self.assertEqual([of[k]["state"] for k in range(4)], ["done", "failed", "done", "missing"])
        self.assertEqual(of[1]["why"], "it was Tuesday")
        self.assertGreater(of[0]["seconds"], 0)
        self.assertIsNone(of[3]["seconds"])
        style = self.path("tiles.qml").read_text()
        for state in ("done", "failed", "missing"):
            self.assertIn(f"'{state}'", style)
        self.path("tiles.qml").write_text("mine")
        self.layer()
        self.assertEqual(self.path("tiles.qml").read_text(), "mine")

    def test_formats(self):
        for ending in ("gpkg", "fgb"):
            run = self.run_cli("tile", "status", "job", "--tiles", f"tiles.{ending}", code=None)
            if run.returncode != 0 and "GDAL" in run.stderr:
                self.skipTest("GDAL is not there")
            self.assertEqual(run.returncode, 0, run.stderr)
            self.assertGreater(self.path(f"tiles.{ending}").stat().st_size, 1000)
            self.assertTrue(self.path("tiles.qml").exists())

    def test_refusals(self):
        for name in ("tiles", "tiles.shp", "tiles.geojson.txt"):
            self.fails(2, "tile", "status", "job", "--tiles", name, says=["--tiles", ".gpkg"])
        for number, direction in enumerate(("x", "y", "0,0,-1")):
            self.run_cli("tile", "plan", "a.xyz", "b.xyz", "-o", f"other{number}", f"--direction={direction}", "--tile-points", "300")
            self.fails(2, "tile", "status", f"other{number}", "--tiles", "tiles.geojson", says=["--tiles", "--direction z"])


class DenseSpots(Job):
    """A scan over 10 km of which most points lie on one spot."""

    def scan(self, name, dense):
        chance = random.Random(name)
        rows = [(chance.uniform(0, 1e4), chance.uniform(0, 1e4), chance.uniform(0, 1)) for _ in range(20000)]
        rows += [dense(chance) for _ in range(500_000)]
        with open(self.path(name), "wb") as file:
            file.write(f"ply\nformat binary_little_endian 1.0\nelement vertex {len(rows)}\n".encode())
            file.write(b"property double x\nproperty double y\nproperty double z\nend_header\n")
            file.write(b"".join(struct.pack("<3d", *row) for row in rows))

    def peak(self, *words):
        """Largest resident size of a run, which ends well."""
        run = subprocess.Popen([BIN, *words], cwd=self.folder, stdout=subprocess.DEVNULL)
        _, code, used = os.wait4(run.pid, 0)
        run.returncode = os.waitstatus_to_exitcode(code)
        self.assertEqual(run.returncode, 0, words)
        return used.ru_maxrss * 1024

    def scans_of(self, dense):
        self.scan("a.ply", lambda chance: (chance.uniform(0, 1e4), chance.uniform(0, 1e4), 0.5))
        self.scan("b.ply", dense)

    def test_every_step_stays_below_the_limit(self):
        self.scans_of(lambda chance: (5000 + chance.uniform(0, 1e-3), 5000 + chance.uniform(0, 1e-3), chance.uniform(0, 1)))
        for words in (["plan", "a.ply", "b.ply", "-o", "job", "--max-memory", str(LIMIT)], ["run", "job"], ["reduce", "job"]):
            self.assertLess(self.peak("tile", *words), LIMIT, words)
        status = self.status()
        self.assertLessEqual(max(tile["points"] for tile in status["each"]), (LIMIT - 150_000_000) / 420)
        for tile in status["each"]:
            if tile["peak_bytes"] is not None:
                self.assertLess(tile["peak_bytes"], LIMIT)
        self.equal("a.ply", "b.ply")

    def test_what_no_tile_can_part_is_refused_or_done_at_once(self):
        for dense in (lambda chance: (5000.0, 5000.0, chance.uniform(0, 1)),
                      lambda chance: (5000 + chance.uniform(0, 1e-9), 5000 + chance.uniform(0, 1e-9), chance.uniform(0, 1))):
            self.scans_of(dense)
            self.fails(2, "tile", "plan", "a.ply", "b.ply", "-o", "job", "--max-memory", str(LIMIT),
                       says=["--max-memory", "500000 points", "5000, 5000"])
            run = self.run_cli("tile", "plan", "a.ply", "b.ply", "-o", "job", "--tile-points", "20000")
            self.assertIn("500000 points lie on one spot", run.stderr)
            # The points that are kept, and those of the spot once more for each of a few cuts: not one for each level.
            self.assertLess(self.path("job/points").stat().st_size, 24 * 4 * 1_040_000)
            self.run_cli("tile", "run", "job", "--quiet")
            self.equal("a.ply", "b.ply")
            shutil.rmtree(self.path("job"))

    def test_the_memory_that_the_refusal_names_is_enough(self):
        self.scans_of(lambda chance: (7.0, 7.0, chance.uniform(0, 1)))
        said = self.fails(2, "tile", "plan", "a.ply", "b.ply", "-o", "job", "--max-memory", str(LIMIT))
        named = said.split("give --max-memory ")[1].split()[0]
        self.run_cli("tile", "plan", "a.ply", "b.ply", "-o", "job", "--max-memory", named)
        self.assertLess(self.peak("tile", "run", "job"), int(named[:-1]) * 1_000_000)


if __name__ == "__main__":
    unittest.main()
