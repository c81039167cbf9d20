"""Steps of `tile` that are killed (SIGKILL) or find the disk full: run again they give the bytes of compare.

No file is left that is not whole. Parts of it need the library of tests/faults (ISOPACH_FAULTS), or to be root, who may
mount a small disk; with ISOPACH_ENGINES=all it is a failure where that cannot be done."""

import contextlib
import json
import os
import random
import re
import shutil
import signal
import subprocess
import time
import unittest

from support import BIN, CliTest
from tile_test import told

LIBRARY = os.environ.get("ISOPACH_FAULTS", "")
IS_REQUIRED = os.environ.get("ISOPACH_ENGINES") == "all"


class Job(CliTest):
    def setUp(self):
        super().setUp()
        self.run_cli("simulate", "terrain", "--points", "3000", "-o", "scans")
        self.scans = ["scans/a.ply", "scans/b.ply"]
        self.whole = told(self.run_cli("compare", *self.scans, "--json", "-").stdout)

    def plan(self, job="job", points="700"):
        self.run_cli("tile", "plan", *self.scans, "-o", job, "--tile-points", points)

    def result(self, job="job"):
        return told(self.run_cli("tile", "reduce", job, "--json", "-").stdout)

    def check_whole(self, job="job"):
        """Nothing but what a job is made of, and the result of the whole."""
        names = sorted(str(path.relative_to(self.path(job))) for path in self.path(job).rglob("*"))
        ours = r"manifest\.json|points|tiles|tiles/\d{6}\.(part|cells|json)"
        strays = [name for name in names if not re.fullmatch(ours, name)]
        self.assertEqual(strays, [])
        self.assertEqual(self.result(job), self.whole)

    def with_fault(self, *words, fault, deed="kill", **more):
        environment = {**os.environ, "LD_PRELOAD": LIBRARY, "ISOPACH_FAULT": fault, "ISOPACH_FAULT_DO": deed, **more}
        return subprocess.run([BIN, *words], cwd=self.folder, env=environment, capture_output=True, text=True,
                              timeout=60)

    def count(self, *words, kind, code=0):
        """How many calls of this kind a run makes."""
        run = self.with_fault(*words, fault=f"{kind}:0", ISOPACH_FAULT_COUNT=str(self.path("count")))
        self.assertEqual(run.returncode, code, run.stderr)
        return int(self.path("count").read_text())


class Killed(Job):
    def test_a_third_of_the_runs(self):
        self.plan(points="200")
        n = json.loads(self.run_cli("tile", "status", "job", "--json", "-").stdout)["tiles"]
        chance = random.Random(5)
        order = chance.sample(range(n), n)
        for place, k in enumerate(order):
            run = subprocess.Popen([BIN, "tile", "run", "job", "--index", str(k), "--quiet"], cwd=self.folder)
            if place % 3 == 0:
                time.sleep(chance.uniform(0, 0.04))
                run.send_signal(signal.SIGKILL)
                run.wait()
            else:
                self.assertEqual(run.wait(), 0)
        done = [name for name in os.listdir(self.path("job/tiles")) if re.fullmatch(r"\d+\.part", name)]
        self.assertGreaterEqual(len(done), n - (n + 2) // 3)
        self.assertLess(len(done), n)
        self.run_cli("tile", "run", "job", "--missing")
        self.check_whole()

    @unittest.skipUnless(os.path.exists(LIBRARY), "the library of tests/faults is not built (ISOPACH_FAULTS)")
    def test_before_every_step_of_run(self):
        self.plan(points="100000")
        steps = self.count("tile", "run", "job", kind="step")
        self.assertGreater(steps, 4)
        for n in range(1, steps + 1):
            with self.subTest(n):
                shutil.rmtree(self.path("job/tiles"))
                self.path("job/tiles").mkdir()
                self.assertEqual(self.with_fault("tile", "run", "job", fault=f"step:{n}").returncode, -signal.SIGKILL)
                self.run_cli("tile", "run", "job", "--missing")
                self.check_whole()

    @unittest.skipUnless(os.path.exists(LIBRARY), "the library of tests/faults is not built (ISOPACH_FAULTS)")
    def test_before_every_step_of_a_run_that_fails(self):
        self.plan(points="100000")
        points = self.path("job/points")
        kept = points.read_bytes()
        points.write_bytes(kept[:100])
        words = ["tile", "run", "job", "--index", "0"]
        steps = self.count(*words, kind="step", code=3)
        self.assertGreater(steps, 1)
        for n in range(1, steps + 1):
            with self.subTest(n):
                points.write_bytes(kept[:100])
                self.path("job/tiles/000000.failed").unlink(missing_ok=True)
                self.assertEqual(self.with_fault(*words, fault=f"step:{n}").returncode, -signal.SIGKILL)
                points.write_bytes(kept)
                self.run_cli(*words)
                self.result()  # sweeps what nobody writes any more
                self.check_whole()
                for name in ("part", "cells", "json"):
                    self.path(f"job/tiles/000000.{name}").unlink(missing_ok=True)

    @unittest.skipUnless(os.path.exists(LIBRARY), "the library of tests/faults is not built (ISOPACH_FAULTS)")
    def test_before_every_step_of_plan(self):
        words = ["tile", "plan", *self.scans, "-o", "job", "--tile-points", "100000"]
        steps = self.count(*words, kind="step")
        for n in range(1, steps + 1):
            with self.subTest(n):
                shutil.rmtree(self.path("job"), ignore_errors=True)
                self.assertEqual(self.with_fault(*words, fault=f"step:{n}").returncode, -signal.SIGKILL)
                if not self.path("job/manifest.json").exists():
                    self.fails(2, "tile", "run", "job", says=["no job"])
                    self.run_cli(*words)
                self.run_cli("tile", "run", "job")
                self.check_whole()

    @unittest.skipUnless(os.path.exists(LIBRARY), "the library of tests/faults is not built (ISOPACH_FAULTS)")
    def test_compare_in_tiles(self):
        """What it leaves in the folder for temporary files is removed by the next, but for that of a run that lives."""
        self.path("temporary").mkdir()
        place = {"TMPDIR": str(self.path("temporary"))}
        self.run_cli("simulate", "terrain", "--points", "700000", "-o", "large")
        words = ["compare", "large/a.ply", "large/b.ply", "--json", "-", "--max-memory", "310M"]
        for n in (3, 30):
            self.assertEqual(self.with_fault(*words, fault=f"step:{n}", **place).returncode, -signal.SIGKILL)
            left = os.listdir(self.path("temporary"))
            self.assertEqual(len(left), 1)
        environment = {**os.environ, **place}
        lives = subprocess.Popen([BIN, *words], cwd=self.folder, env=environment, stdout=subprocess.PIPE, text=True)
        while not [path for path in self.path("temporary").glob("*/points") if path.parent.name not in left]:
            time.sleep(0.01)
        lives.send_signal(signal.SIGSTOP)
        held = os.listdir(self.path("temporary"))
        self.assertEqual(len(held), 1)
        other = subprocess.run([BIN, *words], cwd=self.folder, env=environment, capture_output=True, text=True,
                               check=True)
        self.assertEqual(os.listdir(self.path("temporary")), held)
        lives.send_signal(signal.SIGCONT)
        self.assertEqual(told(lives.communicate()[0]), told(other.stdout))
        self.assertEqual(os.listdir(self.path("temporary")), [])


@contextlib.contextmanager
def small_disk(folder, size):
    folder.mkdir()
    words = ["mount", "-t", "tmpfs", "-o", f"size={size}", "tmpfs", folder]
    made = subprocess.run(words, capture_output=True, text=True)
    if made.returncode != 0:
        raise (RuntimeError if IS_REQUIRED else unittest.SkipTest)(f"no disk can be mounted: {made.stderr}")
    try:
        yield folder
    finally:
        subprocess.run(["umount", "-l", folder], check=True)


class FullDisk(Job):
    def setUp(self):
        super().setUp()
        self.disk = contextlib.ExitStack()
        self.addCleanup(self.disk.close)
        self.disk.enter_context(small_disk(self.path("disk"), "4m"))

    def fill(self, room):
        """Until `room` bytes are left."""
        with open(self.path("disk/filler"), "wb", buffering=0) as filler:
            with contextlib.suppress(OSError):
                while True:
                    filler.write(b"\0" * 4096)
            filler.truncate(max(0, filler.tell() - room))

    def make_room(self):
        self.path("disk/filler").unlink()

    def test_run(self):
        for room in (0, 4096, 40960, 122880):
            with self.subTest(room):
                self.plan("disk/job")
                self.fill(room)
                run = self.run_cli("tile", "run", "disk/job", code=1)
                self.assertRegex(run.stderr, r"^isopach: disk/job/tiles/\d{6}\.\w+: cannot be written \(No space left on "
                                             r"device\): make room on the disk, or choose another folder\n$")
                names = os.listdir(self.path("disk/job/tiles"))
                self.assertEqual([name for name in names if name.startswith(".")], [])
                for name in names:  # where there is room for so much it is noted
                    if name.endswith(".failed"):
                        self.assertIn("make room", self.path(f"disk/job/tiles/{name}").read_text())
                self.make_room()
                self.run_cli("tile", "run", "disk/job", "--missing")
                self.check_whole("disk/job")
                shutil.rmtree(self.path("disk/job"))

    def test_plan(self):
        """Room that is known to be too small is told before any work; nothing is left."""
        for room in (0, 4096, 65536):
            with self.subTest(room):
                self.fill(room)
                self.fails(1, "tile", "plan", *self.scans, "-o", "disk/job", "--tile-points", "700",
                           says=["disk/job", "cannot be written", "make room"])
                self.make_room()
        self.plan("disk/job")
        self.run_cli("tile", "run", "disk/job")
        self.check_whole("disk/job")

    @unittest.skipUnless(os.path.exists(LIBRARY), "the library of tests/faults is not built (ISOPACH_FAULTS)")
    def test_plan_while_it_writes(self):
        words = ["tile", "plan", *self.scans, "-o", "disk/job", "--tile-points", "700"]
        writes = self.count(*words, kind="write")
        shutil.rmtree(self.path("disk/job"))
        self.assertGreater(writes, 10)
        for n in {1, 2, writes // 2, writes - 1, writes}:
            with self.subTest(n):
                run = self.with_fault(*words, fault=f"write:{n}", deed="fail")
                self.assertEqual(run.returncode, 1)
                self.assertRegex(run.stderr, r"^isopach: disk/job/(points|manifest\.json): cannot be written .*make room"
                                             r".*\n$")
                self.assertFalse(self.path("disk/job").exists())

    def test_reduce(self):
        self.plan()
        self.run_cli("tile", "run", "job")
        for room in (0, 4096, 8192):
            with self.subTest(room):
                self.fill(room)
                self.fails(1, "tile", "reduce", "job", "-o", "disk/result", says=["disk/result", "make room"])
                self.make_room()
        self.run_cli("tile", "reduce", "job", "-o", "disk/result")
        self.assertEqual(told(self.path("disk/result/result.json").read_text()), self.whole)

    def test_compare_in_tiles(self):
        self.run_cli("simulate", "terrain", "--points", "700000", "-o", "large")
        run = subprocess.run([BIN, "compare", "large/a.ply", "large/b.ply", "--json", "-", "--max-memory", "310M"],
                             cwd=self.folder, env={**os.environ, "TMPDIR": str(self.path("disk"))}, capture_output=True,
                             text=True)
        self.assertEqual(run.returncode, 1)
        self.assertRegex(run.stderr, r"^isopach: .*cannot be written.*make room.*\n$")
        self.assertEqual(os.listdir(self.path("disk")), [])


if __name__ == "__main__":
    unittest.main()
