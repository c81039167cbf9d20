"""Each kind of failure: its exit code, one line that names the file or option, and nothing left behind."""

import os
import signal
import subprocess
import time
import unittest

from support import BIN, CliTest, points


class Usage(CliTest):
    def test_unknown_verb_option_and_argument(self):
        self.fails(2, "compar", "a", "b", says=["compar", "did you mean 'compare'"])
        self.fails(2, "compare", "a", "b", "--ouput", "x", says=["--ouput", "did you mean '--output'"])
        self.fails(2, "compare", "a", "b", "c", says=["'c'"])
        self.fails(2, "compare", "a", says=["B is required"])

    def test_no_verb_prints_the_overview(self):
        self.assertIn("compare", self.run_cli(code=2).stderr)

    def test_bad_values_name_their_option(self):
        for option, value in [("--threads", "x"), ("--threads", "-1"), ("--surface", "round"), ("--domain", "all"),
                              ("--border", "soft"), ("--max-edge", "0"), ("--max-edge", "-1"), ("--max-edge", "inf"),
                              ("--max-edge", "long"), ("--duplicates", "some"), ("--locate", "luck"),
                              ("--direction", "up"), ("--direction", "0,0,0"), ("--direction", "1,2"),
                              ("--crop", "1,2,3"), ("--crop", "9,0,1,1"), ("--class", "ground"), ("--class", "1.5"),
                              ("--class", "300"), ("--unit", "furlong"), ("--min-coverage", "1.5"),
                              ("--fail-above", "p0=1"), ("--fail-above", "p100=1"), ("--fail-above", "p9x=1"),
                              ("--fail-above", "p95"), ("--fail-above", "p95=x"),
                              ("--fail-above", "p95=-1"), ("--palette", "mud"), ("--map-width", "3"),
                              ("--progress", "loud")]:
            with self.subTest(option=option, value=value):
                a, b = self.scans()
                self.fails(2, "compare", a, b, f"{option}={value}", "-o", "out", says=[option])

    def test_bad_values_are_explained(self):
        a, b = self.scans()
        for words, says in [(["--threads", "x"], "'x' is not a whole number from 0 to 4096"),
                            (["--min-coverage", "2"], "'2' is not a number from 0 to 1"),
                            (["--max-edge", "0"], "--max-edge: '0' is not a number above 0"),
                            (["--duplicates"], "its value is missing: mean|min|max"),
                            (["--crop", "0,0,9,9", "--crop", "0,0,5,5"], "--crop: given more than once"),
                            (["--config", "nowhere.cfg"], "--config nowhere.cfg: cannot be read"),
                            (["--output", ""], "--output: the name is empty"),
                            (["--json", ""], "--json: the name is empty")]:
            with self.subTest(words=words):
                self.fails(2, "compare", a, b, *words, says=[says])

    def test_bad_sizes_of_a_scene(self):
        for option, value in [("--points", "abc"), ("--points", "-5"), ("--points-b", "1e5"), ("--noise", "-1"),
                              ("--noise-b", "nan"), ("--seed", "-1")]:
            with self.subTest(option=option, value=value):
                self.fails(2, "simulate", "plane", "-o", "out", f"{option}={value}", says=[option + ": ", value, "or more"])

    def test_output_that_is_a_file(self):
        a, b = self.scans()
        self.fails(2, "compare", a, b, "-o", a, says=["--output", a])


class Input(CliTest):
    def test_missing_file(self):
        a, _ = self.scans()
        self.fails(3, "compare", a, "nowhere.ply", "-o", "out", says=["nowhere.ply"])
        self.fails(3, "info", "nowhere.ply", says=["nowhere.ply"])
        self.fails(3, "convert", "nowhere.ply", "out.ply", says=["nowhere.ply"])

    def test_broken_file(self):
        a, _ = self.scans()
        self.path("broken.ply").write_bytes(b"ply\nformat binary_little_endian 1.0\nelement vertex 1000000000\n"
                                            b"property double x\nproperty double y\nproperty double z\nend_header\nabc")
        self.path("empty.xyz").write_bytes(b"")
        for name in ["broken.ply", "empty.xyz"]:
            self.fails(3, "compare", a, name, "-o", "out", says=[name])
            self.fails(3, "compare", name, a, "-o", "out", says=[name])

    def test_broken_pose(self):
        a, b = self.scans()
        for lines, says in [(["1 0 0 0", "0 1 0 0", "0 0 1 0"], "12 numbers"),
                            (["1 0 0 0", "0 1 0 0", "0 0 1 0", "5 0 0 1"], "last row"),
                            (["1 0 0 0", "0 1 0 0", "0 0 nan 0", "0 0 0 1"], "nan"),
                            (["1 0 0 0", "0 1 0 0", "0 0 0 0", "0 0 0 1"], "determinant")]:
            self.write("pose.txt", lines)
            self.fails(3, "compare", a, b, "--pose", "pose.txt", "-o", "out", says=["pose.txt", says])

    def test_classes_that_are_not_there(self):
        a, b = self.scans()
        self.fails(3, "compare", a, b, "--class", "2", "-o", "out", says=["class"])

    def test_duplicates_forbidden(self):
        a, b = self.scans()
        self.write("twice.xyz", points(1) + points(1)[:1])
        self.fails(3, "compare", "twice.xyz", b, "--duplicates", "error", says=["twice.xyz"])


class Overlap(CliTest):
    def test_disjoint(self):
        a, b = self.scans(shift=100.0)
        self.fails(4, "compare", a, b, "-o", "out", says=["overlap"])

    def test_coverage(self):
        a, b = self.scans(shift=12.0)
        self.assertLess(self.result("compare", a, b)["domain"]["coverage"], 0.5)
        self.fails(4, "compare", a, b, "--min-coverage", "0.9", "-o", "out", says=["--min-coverage"])


class Tolerance(CliTest):
    def test_fail_above(self):
        a, b = self.scans()
        rms = self.result("compare", a, b)["difference"]["rms"]
        self.run_cli("compare", a, b, "--fail-above", f"rms={rms * 1.01}")
        run = self.run_cli("compare", a, b, "--fail-above", f"rms={rms * 0.99}", "--fail-above", "max=1000", code=6)
        self.assertEqual(run.stderr.count("\n"), 1, run.stderr)
        self.assertIn("rms", run.stderr)
        self.assertNotIn("max is", run.stderr)
        for name in ["rho", "rms", "mean", "net", "above", "absolute", "p50", "p90", "p95", "p99", "max"]:
            self.run_cli("compare", a, b, "--quiet", "--fail-above", f"{name}=0", code=6)
        self.run_cli("compare", b, a, "--quiet", "--fail-above", "below=0", code=6)


class Interrupt(CliTest):
    def test_ctrl_c_leaves_nothing(self):
        for number in [signal.SIGINT, signal.SIGTERM]:
            # The size is such that the run lasts for seconds; it is stopped as soon as it has made its folder.
            process = subprocess.Popen([BIN, "demo", "-o", "deep/out", "--points", "3000000"], cwd=self.folder,
                                       stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
            while not self.path("deep/out").exists() and process.poll() is None:
                time.sleep(0.005)
            process.send_signal(number)
            out, err = process.communicate(timeout=120)
            self.assertEqual(process.returncode, 130, err)
            self.assertEqual((out, err.count("\n")), ("", 1), err)
            self.assertTrue(err.startswith("isopach: interrupted"), err)
            self.assertEqual(list(self.folder.iterdir()), [])


class FullDisk(CliTest):
    @unittest.skipUnless(os.path.exists("/dev/full"), "no /dev/full here")
    def test_standard_output_that_is_full(self):
        a, b = self.scans()
        with open("/dev/full", "w") as full:
            run = subprocess.run([BIN, "compare", a, b], cwd=self.folder, stdout=full, stderr=subprocess.PIPE, text=True)
        self.assertEqual(run.returncode, 1)
        self.assertIn("standard output", run.stderr)


if __name__ == "__main__":
    unittest.main()
