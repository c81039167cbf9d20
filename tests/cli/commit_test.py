"""Results are committed whole: one run a folder, failures and signals leave what was there, the next run sweeps."""

import os
import resource
import signal
import subprocess
import time
import unittest

from support import BIN, CliTest


class Commit(CliTest):
    def setUp(self):
        super().setUp()
        self.a, self.b = self.scans()

    def snapshot(self, folder="out"):
        return {p.relative_to(self.folder): p.read_bytes() if p.is_file() else None
                for p in self.path(folder).rglob("*")}

    def compare(self, *words, **options):
        return self.run_cli("compare", self.a, self.b, "-o", "out", "--no-map", *words, **options)

    def test_a_folder_in_the_place_of_a_file_changes_nothing(self):
        self.compare()
        self.path("out/report.html").unlink()
        self.path("out/report.html").mkdir()
        before = self.snapshot()
        line = self.fails(2, "compare", self.b, self.a, "-o", "out", "--no-map", says=["--output", "report.html"])
        self.assertNotIn(".isopach-", line)
        self.assertEqual(self.snapshot(), before)

    def test_a_second_run_into_a_folder_is_refused(self):
        self.compare("--title", "FIRST")
        before = self.snapshot()
        os.mkfifo(self.path("slow.xyz"))  # the first run waits for its input, and has the folder
        first = subprocess.Popen([BIN, "compare", "slow.xyz", self.b, "-o", "out", "--quiet"], cwd=self.folder)
        while not [n for n in os.listdir(self.path("out")) if n.startswith(".isopach-")]:
            time.sleep(0.01)
        held = self.compare(code=2)
        self.assertEqual(held.stderr.count("\n"), 1, held.stderr)
        self.assertIn("another run", held.stderr)
        self.path("slow.xyz").write_bytes(self.path(self.a).read_bytes())
        self.assertEqual(first.wait(60), 0)
        self.assertNotEqual(self.snapshot(), before)
        self.assertFalse([n for n in os.listdir(self.path("out")) if n.startswith(".isopach-")])

    def test_the_next_run_sweeps_what_a_kill_left(self):
        os.mkfifo(self.path("slow.xyz"))
        run = subprocess.Popen([BIN, "compare", "slow.xyz", self.b, "-o", "out"], cwd=self.folder)
        while not self.path("out").exists() or not os.listdir(self.path("out")):
            time.sleep(0.01)
        run.kill()
        run.wait()
        self.assertTrue(os.listdir(self.path("out")))
        self.path("out/mine.txt").write_text("mine")
        self.path("out/.isopach-notes").mkdir()  # a folder of the user that only looks like one of ours
        self.path(".isopach-1-0badcafe-x.ply").write_text("half a file")
        self.run_cli("convert", self.a, "x.ply")
        self.assertFalse(self.path(".isopach-1-0badcafe-x.ply").exists())
        self.run_cli("compare", self.a, "nowhere.xyz", "-o", "out", code=3)
        self.assertEqual(sorted(os.listdir(self.path("out"))), [".isopach-notes", "mine.txt"])

    def test_hang_up_leaves_nothing(self):
        os.mkfifo(self.path("slow.xyz"))
        run = subprocess.Popen([BIN, "compare", "slow.xyz", self.b, "-o", "deep/out"], cwd=self.folder,
                               stderr=subprocess.PIPE, text=True)
        while not self.path("deep/out").exists():
            time.sleep(0.01)
        run.send_signal(signal.SIGHUP)
        self.assertEqual(run.communicate(timeout=60)[1].count("\n"), 1)
        self.assertEqual(run.returncode, 130)
        self.assertFalse(self.path("deep").exists())

    def test_a_limit_of_file_sizes_is_a_full_disk(self):
        self.compare("--title", "FIRST")
        before = self.snapshot()
        limit = lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (4096, 4096))
        for words in [["compare", self.b, self.a, "-o", "out", "--no-map"], ["compare", self.b, self.a, "-o", "fresh"],
                      ["convert", self.b, "x.ply"], ["convert", self.b, "x.laz"], ["convert", self.b, "x.xyz"]]:
            run = self.run_cli(*words, code=1, preexec_fn=limit)
            self.assertEqual(run.stderr.count("\n"), 1, run.stderr)
            self.assertNotIn(".isopach-", run.stderr)
            self.assertIn("cannot be written", run.stderr)
            self.assertFalse([p.name for p in self.folder.rglob(".isopach*")])
        self.assertEqual(self.snapshot(), before)
        self.assertFalse(self.path("fresh").exists())

    def test_a_reader_that_leaves_ends_the_run_quietly(self):
        run = subprocess.Popen([BIN, "compare", self.a, self.b, "-o", "out", "--no-map"], cwd=self.folder,
                               stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        run.stdout.close()
        with run.stderr:
            self.assertEqual(run.stderr.read(), b"")
        self.assertEqual(run.wait(60), -signal.SIGPIPE)
        self.assertTrue(self.path("out/result.json").exists())
        self.assertFalse([n for n in os.listdir(self.path("out")) if n.startswith(".isopach-")])


if __name__ == "__main__":
    unittest.main()
