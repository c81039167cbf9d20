"""isopach accuracy and isopach scanners: outputs, and that each option acts and is named when it is wrong."""

import json
import random
import unittest

from support import CliTest, hill, points


def noisy(seed, n, sigma, lift=0.0):
    numbers = random.Random(seed)
    return [(x, y, hill(x, y) + lift + numbers.gauss(0, sigma)) for x, y, _ in points(seed, n=n)]


class AccuracyCli(CliTest):
    def setUp(self):
        super().setUp()
        self.write("made.xyz", noisy(1, 900, 0.02, 0.3))
        self.write("truth.xyz", noisy(2, 3000, 0.0))

    def told(self, *words):
        return self.result("accuracy", "made.xyz", "truth.xyz", *words)

    def test_numbers_and_files(self):
        told = self.told("--align", "none")
        self.assertAlmostEqual(told["surface"]["bias"], 0.3, delta=0.01)
        self.assertAlmostEqual(told["points"]["noise"], 0.02, delta=0.005)
        self.run_cli("accuracy", "made.xyz", "truth.xyz", "-o", "out", "--unit", "mm")
        files = {p.name for p in self.path("out").iterdir()}
        self.assertEqual(files, {"result.json", "report.html", "accuracy.png", "pose.txt"})
        self.assertEqual(set(json.loads(self.path("out/result.json").read_text())["outputs"]), files)
        aligned = self.told()
        self.assertLess(abs(aligned["surface"]["bias"]), 0.02)
        self.assertEqual(aligned["alignment"]["scale"], 1)
        self.assertNotEqual(self.told("--align", "scale")["alignment"]["scale"], 1)

    def test_verdict(self):
        words = ("accuracy", "made.xyz", "truth.xyz", "--align", "none")
        self.run_cli(*words, "--fail-above", "bias=0.5,p95=0.5", "--fail-below", "completeness=0.5")
        self.assertIn("bias", self.run_cli(*words, "--fail-above", "bias=0.1", code=6).stderr)
        self.assertIn("completeness", self.run_cli(*words, "--fail-below", "completeness=1.5", code=6).stderr)
        told = json.loads(self.run_cli(*words, "--fail-above", "rms=0.1", "--json", "-", code=6).stdout)
        self.assertFalse(told["verdict"]["passed"])
        self.assertIsNotNone(self.told("--within", "0.4")["completeness"]["within"])

    def test_options_act(self):
        plain = self.told("--align", "none")
        self.assertLess(self.told("--align", "none", "--crop", "0,0,12,18")["completeness"]["area"],
                        0.7 * plain["completeness"]["area"])
        self.assertNotEqual(self.told("--align", "none", "--border", "hull")["completeness"], plain["completeness"])
        self.assertEqual(self.told("--freedom", "z")["parameters"]["freedom"], ["z"])
        self.write("down.txt", ["1 0 0 0", "0 1 0 0", "0 0 1 -0.3", "0 0 0 1"])
        self.assertLess(abs(self.told("--align", "none", "--start", "down.txt")["surface"]["bias"]), 0.01)

    def test_wrong_ones_are_named(self):
        for words in [("--align", "soft"), ("--within", "0"), ("--fail-above", "p95"), ("--fail-above", "ps=1"),
                      ("--fail-below", "within=0.9"), ("--fail-above", "rms=-1"), ("--overlap", "2"),
                      ("--unit", "mile"), ("--output", ""), ("--map-width", "1")]:
            self.assertIn(words[0], self.run_cli("accuracy", "made.xyz", "truth.xyz", *words, code=2).stderr)


class ScannersCli(CliTest):
    def setUp(self):
        super().setUp()
        self.write("a.xyz", noisy(1, 900, 0.02))
        self.write("b.xyz", noisy(3, 600, 0.05, 0.1))
        self.write("truth.xyz", noisy(2, 4000, 0.0))

    def told(self, *words):
        return self.result("scanners", "a.xyz", "b.xyz", "truth.xyz", *words)

    def test_numbers_and_files(self):
        told = self.told("--align", "none")
        self.assertAlmostEqual(told["scanners"][0]["noise"], 0.02, delta=0.006)
        self.assertAlmostEqual(told["scanners"][1]["noise"], 0.05, delta=0.01)
        self.assertAlmostEqual(told["scanners"][1]["bias"], 0.1, delta=0.01)
        self.assertAlmostEqual(told["between"]["bias"], 0.1, delta=0.01)
        self.assertLess(self.told("--align", "none", "--reference-sigma", "0.03")["scanners"][1]["noise"],
                        told["scanners"][1]["noise"])
        self.assertLess(abs(self.told()["scanners"][1]["bias"]), 0.02)
        self.run_cli("scanners", "a.xyz", "b.xyz", "truth.xyz", "-o", "out")
        files = {p.name for p in self.path("out").iterdir()}
        self.assertEqual(files, {"result.json", "report.html", "difference.png"})

    def test_options_act(self):
        plain = self.told("--align", "none")
        cropped = self.told("--align", "none", "--crop", "0,0,12,18")
        self.assertEqual(cropped["parameters"]["crop"], [0, 0, 12, 18])
        self.assertLess(cropped["detail"][0]["stretches"], 0.7 * plain["detail"][0]["stretches"])
        self.write("up.txt", ["1 0 0 0", "0 1 0 0", "0 0 1 0.5", "0 0 0 1"])
        raised = self.told("--align", "none", "--start", "up.txt")["scanners"]
        for before, after in zip(plain["scanners"], raised):
            self.assertAlmostEqual(after["bias"], before["bias"] + 0.5, delta=1e-3)
        moved = self.told("--freedom", "z")
        self.assertEqual(moved["parameters"]["freedom"], ["z"])
        self.assertAlmostEqual(moved["scanners"][1]["pose"]["matrix"][2][3], -0.1, delta=0.01)
        self.assertIn(" in,", self.run_cli("scanners", "a.xyz", "b.xyz", "truth.xyz", "--unit", "in").stdout)

    def test_wrong_ones_are_named(self):
        for words in [("--align", "soft"), ("--reference-sigma", "-1"), ("--overlap", "2"), ("--json", "")]:
            self.assertIn(words[0], self.run_cli("scanners", "a.xyz", "b.xyz", "truth.xyz", *words, code=2).stderr)


class Simulated(CliTest):
    def truth(self, folder):
        return json.loads(self.path(f"{folder}/truth.json").read_text())

    def test_accuracy_returns_the_truth(self):
        self.run_cli("simulate", "accuracy", "-o", "in", "--points", "4000", "--points-b", "12000", "--noise", "0.1")
        truth = self.truth("in")
        told = self.result("accuracy", "in/reconstruction.ply", "in/reference.ply", "--align", "none")
        self.assertAlmostEqual(told["surface"]["bias"], truth["bias"], delta=0.01)
        self.assertAlmostEqual(told["points"]["noise"], truth["noise"], delta=0.1 * truth["noise"])
        self.assertAlmostEqual(told["completeness"]["share"], truth["completeness"], delta=0.01)
        self.run_cli("simulate", "accuracy", "-o", "out", "--points", "4000", "--points-b", "12000", "--variant", "scaled",
                     "--noise-b", "0.02", "--format", "xyz")
        truth = self.truth("out")
        self.assertEqual(truth["parameters"]["reference"]["noise"], 0.02)
        told = self.result("accuracy", "out/reconstruction.xyz", "out/reference.xyz", "--align", "scale")
        self.assertAlmostEqual(told["alignment"]["scale"], truth["scale"], delta=5e-4)
        for found, true in zip(sum(told["alignment"]["matrix"], []), sum(truth["reference_reconstruction"], [])):
            self.assertAlmostEqual(found, true, delta=0.1)

    def test_scanners_returns_the_truth(self):
        self.run_cli("simulate", "scanners", "-o", ".", "--points", "8000", "--points-b", "800", "--noise", "0.04",
                     "--noise-b", "0.05")
        truth = self.truth(".")["scanners"]
        told = self.result("scanners", "a.ply", "b.ply", "reference.ply", "--align", "none")["scanners"]
        for true, found in zip(truth, told):
            self.assertAlmostEqual(found["noise"], true["noise"], delta=0.1 * true["noise"])
            self.assertAlmostEqual(found["bias"], true["bias"], delta=0.01)
        self.assertIsNone(told[0]["spot"])
        self.assertAlmostEqual(told[1]["spot"], truth[1]["spot"], delta=0.3 * truth[1]["spot"])
        self.assertLess(told[0]["resolved"], told[1]["resolved"])

    def test_wrong_ones_are_named(self):
        for words in [("accuracy", "--variant", "lost"), ("scanners", "--variant", "lost"), ("scanners", "--frames", "3")]:
            self.assertIn(words[1], self.run_cli("simulate", words[0], "-o", "x", *words[1:], code=2).stderr.replace(
                "variant 'lost'", "--variant"))
        self.assertIn("100", self.run_cli("simulate", "scanners", "-o", "x", "--points", "50", code=2).stderr)


if __name__ == "__main__":
    unittest.main()
