"""isopach sequence and simulate chewing: outputs, bad frames, and that each option acts and is named when it is wrong."""

import json
import os
import signal
import subprocess
import time
import unittest

from support import BIN, CliTest, without_timing


class SequenceCli(CliTest):
    def setUp(self):
        super().setUp()
        self.run_cli("simulate", "chewing", "-o", "scans", "--frames", "4", "--points", "2500")
        self.frames = sorted(str(p) for p in self.path("scans").glob("*.ply"))
        # The first frames of a cycle hardly move: take a wide one as the second.
        self.run_cli("simulate", "chewing", "-o", "all", "--frames", "9", "--points", "4000")  # fewer: no chin
        self.path("few").mkdir()
        for new, old in enumerate([0, 3, 6, 8]):
            self.path(f"all/frame_{old:03d}.ply").rename(self.path(f"few/f{9 + new}.ply"))

    def sequence(self, *words):
        return self.result("sequence", "few", *words)


class Simulate(SequenceCli):
    def test_files(self):
        self.assertEqual(len(self.frames), 4)
        truth = json.loads(self.path("scans/truth.json").read_text())
        self.assertEqual(len(truth["frames"]), 4)
        self.assertEqual(truth["parameters"]["points"], 2500)
        info = self.result("info", "scans/frame_002.ply")["files"][0]
        self.assertIn("blend", info["attributes"])
        self.run_cli("simulate", "chewing", "-o", "x", "--frames", "2", "--points", "500", "--format", "xyz", "--noise", "0")
        self.assertTrue(self.path("x/frame_001.xyz").exists())

    def test_wrong_options_are_named(self):
        for words, option in [
            (("chewing", "--points-b", "500"), "--points-b"),
            (("chewing", "--noise-b", "1"), "--noise-b"),
            (("chewing", "--variant", "slow"), "--variant"),
            (("chewing", "--frames", "0"), "--frames"),
            (("terrain", "--frames", "3"), "--frames"),
            (("chewing", "--points", "5"), "5 points"),
        ]:
            self.fails(2, "simulate", *words, "-o", "new", says=[option])


class Output(SequenceCli):
    def test_folder(self):
        run = self.run_cli("sequence", "few", "-o", "out", "--json", "copy.json")
        self.assertIn("out/report.html", run.stdout)
        files = {p.name for p in self.path("out").iterdir()}
        self.assertEqual(files, {"result.json", "report.html", "motion.csv", "parts.ply"})
        result = json.loads(self.path("out/result.json").read_text())
        self.assertEqual(set(result["outputs"]), files)
        self.assertEqual(self.path("copy.json").read_text(), self.path("out/result.json").read_text())
        self.assertIn("part", self.result("info", "out/parts.ply")["files"][0]["attributes"])
        # Names count as numbers: f9 is the first frame, before f10.
        self.assertEqual([f["name"] for f in result["frames"]], ["f9.ply", "f10.ply", "f11.ply", "f12.ply"])
        self.assertGreater(result["widest_deg"], 10)

    def test_threads_and_named_frames(self):
        frames = [f"few/f{k}.ply" for k in (9, 10, 11, 12)]
        texts = {without_timing(self.run_cli("sequence", *w, "--json", "-", "--threads", n).stdout)
                 for w, n in [(["few"], 1), (["few"], 3), (frames, 2)]}
        self.assertEqual(len(texts), 1)

    def test_bad_frame_is_reported_and_skipped(self):
        self.path("few/f11.ply").write_text("ply\nformat ascii 1.0\n")
        run = self.run_cli("sequence", "few", "--json", "-")
        result = json.loads(run.stdout)
        self.assertEqual(result["inputs"]["used"], 3)
        self.assertIn("f11.ply", result["frames"][2]["skipped"])
        self.assertIn("warning: frame 2 (f11.ply) was skipped", run.stderr)

    def test_progress_tells_the_frames(self):
        run = self.run_cli("sequence", "few", "--progress", "json")
        stages = [json.loads(line)["stage"] for line in run.stderr.splitlines() if line.startswith("{")]
        self.assertIn("parts", stages)
        self.assertIn("motions", stages)

    def test_interrupt_leaves_nothing(self):
        run = subprocess.Popen([BIN, "sequence", *["few"] * 200, "-o", "out"], cwd=self.folder, stderr=subprocess.PIPE,
                               stdout=subprocess.PIPE, text=True)
        time.sleep(1)
        run.send_signal(signal.SIGINT)
        _, message = run.communicate(timeout=60)
        self.assertEqual(run.returncode, 130, message)
        self.assertFalse(self.path("out").exists())
        self.assertFalse([p for p in os.listdir(self.folder) if p.startswith(".") or "out" in p])


class Options(SequenceCli):
    def test_they_act(self):
        plain = self.sequence()
        self.assertLess(plain["frames"][1]["point"][1], -60)
        other = self.sequence("--reference", "2", "--rate", "10", "--smooth", "0", "--follow", "0,-70,95", "--unit", "cm")
        self.assertAlmostEqual(other["frames"][2]["angle_deg"], 0, delta=0.1)
        self.assertEqual(other["frames"][3]["time"], 0.3)
        self.assertEqual(other["point"], [0, -70, 95])
        self.assertEqual(other["parameters"]["unit"], "cm")
        for a, b in zip(other["frames"][1]["point"], other["frames"][1]["point_smooth"]):
            self.assertAlmostEqual(a, b)
        self.assertNotEqual(plain["frames"][1]["point"], plain["frames"][1]["point_smooth"])
        swapped = self.sequence("--static-at", "0,-75,95")
        self.assertEqual(swapped["parts"]["static"], plain["parts"]["moving"])
        self.assertNotEqual(self.sequence("--model-points", "2500")["frames"][1]["motion"], plain["frames"][1]["motion"])
        # The chin is about a fifth of the scan: a part that must have more is not there.
        run = self.run_cli("sequence", "few", "--least-part", "0.45", code=3)
        self.assertIn("0.45", run.stderr)

    def test_wrong_ones_are_named(self):
        for words, option in [
            (("--reference", "-1"), "--reference"),
            (("--reference", "7"), "--reference"),
            (("--rate", "0"), "--rate"),
            (("--smooth", "-1"), "--smooth"),
            (("--follow", "1,2"), "--follow"),
            (("--follow", "1,2,x"), "--follow"),
            (("--static-at", "1,2,3,4"), "--static-at"),
            (("--least-part", "0.7"), "--least-part"),
            (("--model-points", "10"), "--model-points"),
            (("--unit", "miles"), "--unit"),
        ]:
            self.fails(2, "sequence", "few", *words, says=[option])

    def test_exit_codes(self):
        self.fails(2, "sequence", "few/f9.ply", says=["at least 2"])
        self.fails(3, "sequence", "few/f9.ply", "few/f9.ply", "few/f9.ply", says=["move as one"])
        self.path("empty").mkdir()
        self.fails(3, "sequence", "empty", says=["empty"])
        self.fails(3, "sequence", "none.ply", "few/f9.ply", says=["none.ply"])


if __name__ == "__main__":
    unittest.main()
