"""isopach combine and simulate combine: outputs, refusals, and that each option acts and is named when it is wrong."""

import json
import unittest

from support import CliTest, without_timing


class CombineCli(CliTest):
    def setUp(self):
        super().setUp()
        self.run_cli("simulate", "combine", "-o", ".", "--points", "9000", "--seed", "3")
        self.truth = json.loads(self.path("truth.json").read_text())
        for name in ("face", "jaw"):
            self.write(f"{name}.txt", [" ".join(map(repr, row)) for row in self.truth[f"{name}_reference"]])
        self.near = ["--start-face", "face.txt", "--start-jaw", "jaw.txt"]

    def combine(self, *words):
        return self.result("combine", "face.ply", "jaw.ply", "--reference", "reference.ply", *words)


class Output(CombineCli):
    def test_folder(self):
        run = self.run_cli("combine", "face.ply", "jaw.ply", "--reference", "reference.ply", "-o", "out", "--json", "c.json")
        self.assertIn("out/report.html", run.stdout)
        files = {p.name for p in self.path("out").iterdir()}
        self.assertEqual(files, {"result.json", "report.html", "pose.txt", "combined.ply"})
        result = json.loads(self.path("out/result.json").read_text())
        self.assertEqual(set(result["outputs"]), files)
        self.assertEqual(self.path("c.json").read_text(), self.path("out/result.json").read_text())
        rows = [[float(w) for w in line.split()] for line in self.path("out/pose.txt").read_text().splitlines()]
        self.assertEqual(rows, result["pose"]["matrix"])
        self.assertIn("part", self.result("info", "out/combined.ply")["files"][0]["attributes"])
        # The jaw's middle is where the truth puts it.
        middle = result["uncertainty"]["jaw_middle"]
        in_jaw = [sum(rows[k][i] * (middle[k] - rows[k][3]) for k in range(3)) for i in range(3)]
        for i in range(3):
            true = self.truth["face_jaw"][i]
            self.assertAlmostEqual(sum(true[k] * in_jaw[k] for k in range(3)) + true[3], middle[i], delta=0.15)

    def test_threads(self):
        texts = {without_timing(json.dumps(self.combine(*self.near, "--threads", n))) for n in "12"}
        self.assertEqual(len(texts), 1)


class Options(CombineCli):
    def test_they_act(self):
        plain = self.combine(*self.near)
        self.assertIsNotNone(plain["parameters"]["start_face"])
        self.assertEqual(self.combine(*self.near, "--unit", "cm")["parameters"]["unit"], "cm")
        self.fails(4, "combine", "face.ply", "jaw.ply", "--reference", "reference.ply", *self.near, "--least-share", "1",
                   says=["--least-share", "face.ply"])
        self.write("far.txt", ["1 0 0 5000", "0 1 0 0", "0 0 1 0", "0 0 0 1"])
        for starts in (["--start-face", "far.txt", *self.near[2:]], [*self.near[:2], "--start-jaw", "far.txt"]):
            self.fails(4, "combine", "face.ply", "jaw.ply", "--reference", "reference.ply", *starts, says=["not found"])

    def test_wrong_ones_are_named(self):
        files = ["face.ply", "jaw.ply", "--reference", "reference.ply"]
        self.fails(2, "combine", "face.ply", "jaw.ply", says=["--reference"])
        self.fails(2, "combine", *files, "--least-share", "2", says=["--least-share"])
        self.fails(2, "combine", *files, "--least-share", "0", says=["--least-share"])
        self.fails(2, "combine", *files, "--unit", "miles", says=["--unit"])
        self.fails(3, "combine", *files, "--start-face", "none.txt", says=["--start-face"])
        self.fails(3, "combine", *files, "--start-jaw", "none.txt", says=["--start-jaw"])
        self.fails(3, "combine", "face.ply", "jaw.ply", "--reference", "none.ply", says=["none.ply"])
        self.fails(2, "simulate", "combine", "-o", "x", "--variant", "lost", says=["lost", "forgotten"])
        self.fails(2, "simulate", "combine", "-o", "x", "--points-b", "500", says=["--points-b"])

    def test_refuses_when_the_object_is_not_there(self):
        self.run_cli("simulate", "combine", "-o", "without", "--points", "9000", "--variant", "forgotten")
        self.fails(4, "combine", "face.ply", "without/jaw.ply", "--reference", "reference.ply", says=["without/jaw.ply"])


if __name__ == "__main__":
    unittest.main()
