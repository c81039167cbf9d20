"""Every call that can fail fails once, and the program is killed before every step that changes the disk.

With each fault: an exit code of the contract, one line on standard error, the earlier result or the new one whole, and
nothing left behind that the next run does not remove. Needs the library of tests/faults (ISOPACH_FAULTS). A part of the
calls is tried; ISOPACH_ALL_FAULTS=1 tries all of them, which takes minutes."""

import json
import os
import shutil
import signal
import subprocess
import unittest

from support import BIN, CliTest, points, without_timing

LIBRARY = os.environ.get("ISOPACH_FAULTS", "")
ALL = bool(os.environ.get("ISOPACH_ALL_FAULTS"))
KINDS = ["memory", "open", "read", "write", "rename", "fsync", "mkdir", "remove", "thread"]


def some(count, most):
    """The numbers 1 to `count`; unless all are asked for `most` of them at most: half are the last, half spread."""
    if ALL or count <= most:
        return list(range(1, count + 1))
    last = list(range(count - most // 2 + 1, count + 1))
    return sorted({1 + i * (count - 1) // (most // 2) for i in range(most // 2)} | set(last))


@unittest.skipUnless(os.path.exists(LIBRARY), "the library of tests/faults is not built (ISOPACH_FAULTS)")
class Faults(CliTest):
    def setUp(self):
        super().setUp()
        self.write("a.xyz", points(1, n=80))
        self.write("b.xyz", points(2, n=80, lift=0.5))
        self.write("c.xyz", points(3, n=80, lift=0.25))

    def with_fault(self, words, kind, number, deed="fail"):
        environment = {**os.environ, "LD_PRELOAD": LIBRARY, "ISOPACH_FAULT": f"{kind}:{number}", "ISOPACH_FAULT_DO": deed}
        return subprocess.run([BIN, *words], cwd=self.folder, env=environment, capture_output=True, text=True,
                              errors="replace", timeout=60)

    def count(self, words, kind):
        """How many calls of this kind the run makes."""
        counted = str(self.path("count"))
        environment = {**os.environ, "LD_PRELOAD": LIBRARY, "ISOPACH_FAULT": f"{kind}:0", "ISOPACH_FAULT_COUNT": counted}
        subprocess.run([BIN, *words], cwd=self.folder, env=environment, capture_output=True, check=True, timeout=60)
        number = int(self.path("count").read_text())
        self.path("count").unlink()
        return number

    def contents(self, folder):
        """Files by name; the two that hold times without them."""
        found = {}
        for path in self.path(folder).iterdir():
            found[path.name] = path.read_bytes() if path.is_file() else None
        if "result.json" in found:
            found["result.json"] = without_timing(found["result.json"])
        if "report.html" in found:
            found["report.html"] = b"NEW" in found["report.html"]
        return found

    def check_failure(self, run, what):
        self.assertIn(run.returncode, [0, 1, 2, 3], f"{what}: {run.stderr}")
        if run.returncode != 0:
            self.assertEqual(run.stderr.count("\n"), 1, f"{what}: {run.stderr}")
            self.assertTrue(run.stderr.startswith("isopach: "), f"{what}: {run.stderr}")
            self.assertNotIn(".isopach-", run.stderr, what)
        else:
            self.assertEqual(run.stderr, "", what)

    # --- results in a folder

    COMPARE = ["compare", "b.xyz", "c.xyz", "-o", "out", "--no-map", "--title", "NEW", "--threads", "2", "--quiet"]

    def prepare_results(self):
        """The folder "old" with a result and a file of the user, and what it holds before and after the new run."""
        self.run_cli("compare", "a.xyz", "b.xyz", "-o", "old", "--no-map", "--surface", "both", "--title", "OLD")
        self.path("old/mine.txt").write_text("mine")
        shutil.copytree(self.path("old"), self.path("out"))
        self.run_cli(*self.COMPARE)
        before, after = self.contents("old"), self.contents("out")
        self.assertIn("difference_overlay.ply", before)
        self.assertNotIn("difference_overlay.ply", after)
        self.assertFalse([n for n in after if n != "mine.txt" and after[n] == before.get(n)])
        return before, after

    def begin_again(self):
        shutil.rmtree(self.path("out"))
        shutil.copytree(self.path("old"), self.path("out"))

    def sweep(self):
        """The next run into the folder, which fails."""
        self.run_cli("compare", "a.xyz", "nowhere.xyz", "-o", "out", code=3)

    def test_a_kill_before_every_step_of_a_commit(self):
        before, after = self.prepare_results()
        self.begin_again()
        seen = set()
        for number in some(self.count(self.COMPARE, "step"), 60):
            self.begin_again()
            run = self.with_fault(self.COMPARE, "step", number, "kill")
            self.assertIn(run.returncode, [0, -signal.SIGKILL], run.stderr)
            now = self.contents("out")
            if "result.json" in now:  # a record stands beside the files it lists
                whole = before if now["result.json"] == before["result.json"] else after
                self.assertEqual({n: now.get(n) for n in whole}, whole, number)
            self.sweep()
            now = self.contents("out")
            self.assertIn(now, [before, after], f"step {number}: {sorted(now)}")
            seen.add(now == after)
        self.assertEqual(seen, {False, True})

    def test_a_kill_while_what_was_left_is_finished(self):
        before, after = self.prepare_results()
        self.begin_again()
        sweeping = ["compare", "a.xyz", "nowhere.xyz", "-o", "out"]
        # A commit that is decided and not begun: killed before the last rename but those of its files.
        names = len(json.loads(self.path("old/result.json").read_text())["outputs"])
        renames = self.count(self.COMPARE, "rename")
        self.begin_again()
        self.with_fault(self.COMPARE, "rename", renames - names, "kill")
        shutil.copytree(self.path("out"), self.path("decided"))
        for number in range(1, 200):
            shutil.rmtree(self.path("out"))
            shutil.copytree(self.path("decided"), self.path("out"))
            run = self.with_fault(sweeping, "step", number, "kill")
            self.sweep()
            self.assertEqual(self.contents("out"), after, number)
            if run.returncode == 3:
                break
            if not ALL and number > 25:
                break

    def test_each_fault_while_a_result_is_written(self):
        before, after = self.prepare_results()
        for kind in KINDS:
            self.begin_again()
            for number in some(self.count(self.COMPARE, kind), 8):
                self.begin_again()
                run = self.with_fault(self.COMPARE, kind, number)
                what = f"{kind} {number}: exit {run.returncode}"
                self.check_failure(run, what)
                now = self.contents("out")
                if any(n.startswith(".isopach-") for n in now):  # what could not be removed, the next run removes
                    self.assertIn(kind, ["remove", "open", "thread", "memory"], what)
                    self.sweep()
                    now = self.contents("out")
                self.assertEqual(now, after if run.returncode == 0 else before, what)

    def test_a_disk_that_does_not_tell_what_is_there(self):
        """What is not known to be there must not be taken for missing: a commit would leave files out, or behind."""
        before, after = self.prepare_results()
        for kind in ["stat", "list"]:
            self.begin_again()
            for number in some(self.count(self.COMPARE, kind), 100):
                self.begin_again()
                run = self.with_fault(self.COMPARE, kind, number)
                what = f"{kind} {number}: exit {run.returncode}"
                self.check_failure(run, what)
                if any(n.startswith(".isopach-") for n in self.contents("out")):
                    self.sweep()
                self.assertEqual(self.contents("out"), after if run.returncode == 0 else before, what)

    # --- memory, however little is asked for

    def test_each_request_of_memory(self):
        """Before main as after it; where the standard library must not throw, and while a commit is under way."""
        before, after = self.prepare_results()
        os.environ["ISOPACH_FAULT_LEAST"] = "1"
        self.addCleanup(os.environ.pop, "ISOPACH_FAULT_LEAST")
        for words in [["info", "a.xyz", "--quiet"], self.COMPARE]:
            count = self.count(words, "memory")
            self.assertGreater(count, 400)
            for number in sorted({1, 2, 40, 100, 200, *some(count, 40)}):
                self.begin_again()
                run = self.with_fault(words, "memory", number)
                what = f"{words[0]}: memory {number}: exit {run.returncode}: {run.stderr}"
                if run.returncode == -signal.SIGSEGV and words[0] == "info":
                    continue  # nlohmann-json before 3.11.3, where an object cannot be begun
                self.assertIn(run.returncode, [0, 1], what)
                self.assertEqual(run.stderr.count("\n"), run.returncode, what)
                if run.returncode == 1:
                    self.assertRegex(run.stderr, "^isopach: .*(memory|library gave up)", what)
                if any(n.startswith(".isopach-") for n in self.contents("out")):
                    self.assertRegex(run.stderr, "ended at once|ended by a limit|gave up|^$", what)
                    self.sweep()
                self.assertIn(self.contents("out"), [before, after], what)
                if run.returncode == 0 and words == self.COMPARE:
                    self.assertEqual(self.contents("out"), after, what)

    def test_pictures_without_memory(self):
        """A picture inside another, wrinkles: cairo hands out a surface without pixels. Each large request in turn."""
        self.run_cli("simulate", "terrain", "--points", "300", "--format", "xyz", "-o", "hill", "--quiet")
        words = ["roughness", "hill/a.xyz", "-o", "rough", "--map-width", "400", "--quiet"]
        os.environ["ISOPACH_FAULT_LEAST"] = "65536"
        self.addCleanup(os.environ.pop, "ISOPACH_FAULT_LEAST")
        count = self.count(words, "memory")
        self.assertGreater(count, 20)
        for number in range(1, count + 1):
            run = self.with_fault(words, "memory", number)
            self.assertIn(run.returncode, [0, 1], f"memory {number}: {run.stderr}")
            if run.returncode == 1:
                self.assertRegex(run.stderr, "^isopach: .*memory", f"memory {number}")

    def test_gdal_without_memory(self):
        """GDAL says so by a number, and where it asks for little by a message behind which it ends the program."""
        self.write("field.geojson", ['{"type": "FeatureCollection", "features": [{"type": "Feature", "properties": {"name": "f"}, '
                                     '"geometry": {"type": "Polygon", "coordinates": [[[0, 0], [9, 0], [9, 9], [0, 9], [0, 0]]]}}]}'])
        words = ["compare", "a.xyz", "b.xyz", "-o", "out", "--no-map", "--quiet", "--budget", "field.geojson"]
        os.environ["ISOPACH_FAULT_LEAST"] = "1"
        self.addCleanup(os.environ.pop, "ISOPACH_FAULT_LEAST")
        count = self.count(words, "memory")
        for number in some(count, 60):
            self.sweep()
            run = self.with_fault(words, "memory", number)
            what = f"memory {number}: exit {run.returncode}: {run.stderr}"
            self.assertIn(run.returncode, [0, 1], what)
            self.assertNotIn("mend the file", run.stderr, what)
            self.assertNotIn("FATAL", run.stderr, what)

    # --- single files

    def test_each_fault_while_a_file_is_written(self):
        self.write("grid.asc", ["ncols 8", "nrows 8", "xllcorner 0", "yllcorner 0", "cellsize 1"] + ["1 2 3 4 5 6 7 8"] * 8)
        for source, target in [("a.xyz", "x.ply"), ("a.xyz", "x.las"), ("a.xyz", "x.laz"), ("grid.asc", "x.tif")]:
            words = ["convert", source, target, "--quiet"]
            self.run_cli(*words)
            after = self.path(target).read_bytes()
            for kind in KINDS + ["kill"]:
                deed, kind = ("kill", "step") if kind == "kill" else ("fail", kind)
                for number in some(self.count(words, kind), 5 if deed == "fail" else 12):
                    self.path(target).write_bytes(b"before")
                    run = self.with_fault(words, kind, number, deed)
                    what = f"{target}: {deed} {kind} {number}: exit {run.returncode}"
                    if deed == "kill":
                        self.assertIn(self.path(target).read_bytes(), [b"before", after], what)
                    else:
                        self.check_failure(run, what)
                        self.assertEqual(self.path(target).read_bytes(), after if run.returncode == 0 else b"before", what)
                    if deed == "kill" or kind in ["remove", "open", "thread", "memory"]:
                        self.run_cli(*words)  # the next run sweeps
                    self.assertFalse([p.name for p in self.folder.iterdir() if p.name.startswith(".isopach")], what)

    def test_each_fault_while_files_are_looked_at(self):
        self.run_cli("convert", "a.xyz", "x.laz", "--quiet")
        for words in [["info", "x.laz", "a.xyz", "--quiet"], ["distance", "a.xyz", "b.xyz", "--quiet"],
                      ["roughness", "a.xyz", "--quiet"]]:
            for kind in ["memory", "open", "read", "thread"]:
                for number in some(self.count(words, kind), 4):
                    run = self.with_fault(words, kind, number)
                    self.check_failure(run, f"{words[0]}: {kind} {number}: exit {run.returncode}")


if __name__ == "__main__":
    unittest.main()
