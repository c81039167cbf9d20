"""isopach roughness: outputs, and that each option acts and is named when it is wrong."""

import json
import math
import random
import unittest

from support import CliTest, without_timing


def skin(seed, n=2500, groove=0.3, bow=0.02, shift=0.0):
    """n random points over [0, 24] x [0, 18]: a bowed plane, fine relief, waves, a groove of a known depth."""
    numbers = random.Random(seed)
    found = []
    for _ in range(n):
        x, y = round(numbers.uniform(0, 24), 3), round(numbers.uniform(0, 18), 3)
        z = 0.1 * x + bow * (x - 12) ** 2 + 0.02 * math.sin(3 * x) * math.cos(2 * y) + 0.1 * math.sin(x / 2)
        if abs(y - 9) < 0.8 and abs(x - 12) < 8:
            z -= groove
        found.append((round(x + shift, 6), y, round(z, 6)))
    return found


class RoughnessTest(CliTest):
    def setUp(self):
        super().setUp()
        self.write("before.xyz", skin(1))
        self.write("after.xyz", skin(2, groove=0.15))
        self.words = ("roughness", "before.xyz", "--form", "polynomial", "--l-filter", "8", "--margin", "1",
                      "--wrinkle-depth", "0.1", "--wrinkle-length", "6")


class Output(RoughnessTest):
    def test_text_only_without_output(self):
        run = self.run_cli(*self.words)
        for word in ["Sa", "Sq", "Sz", "Ssk", "Sku", "Sdr", "Sdq", "wrinkles", "removed"]:
            self.assertIn(word, run.stdout)
        self.assertEqual(run.stderr, "")
        self.assertEqual({p.name for p in self.folder.iterdir()}, {"before.xyz", "after.xyz"})

    def test_a_curved_form_hides_wrinkles(self):
        arch = self.run_cli("roughness", "before.xyz")
        self.assertRegex(arch.stdout, "before.xyz are a curved form, which sets the depth that wrinkles need, [0-9.]+: remove")
        for cure in (["--form", "polynomial"], ["--l-filter", "8"], ["--wrinkle-depth", "0.2"]):
            self.assertNotIn("curved form", self.run_cli("roughness", "before.xyz", *cure).stdout)

    def test_folder(self):
        self.run_cli(*self.words, "-o", "out/new", "--json", "copy.json", "--map-width", "400")
        files = {p.name for p in self.path("out/new").iterdir()}
        self.assertEqual(files, {"result.json", "report.html", "roughness.png", "wrinkles.png", "wrinkles.csv", "points.ply"})
        result = json.loads(self.path("out/new/result.json").read_text())
        self.assertEqual(set(result["outputs"]), files)
        self.assertEqual(self.path("copy.json").read_text(), self.path("out/new/result.json").read_text())
        attributes = self.result("info", "out/new/points.ply")["files"][0]["attributes"]
        self.assertEqual(set(attributes), {"waviness", "roughness", "valley", "wrinkle"})
        self.assertEqual(self.path("out/new/wrinkles.csv").read_text().count("\n"), 1 + result["scan"]["wrinkles"]["count"])
        self.assertEqual(int.from_bytes(self.path("out/new/roughness.png").read_bytes()[16:20], "big"), 400)

    def test_before_and_after(self):
        words = list(self.words)
        words.insert(2, "after.xyz")
        self.run_cli(*words, "-o", "out", "--map-width", "300", "--format", "csv")
        files = {p.name for p in self.path("out").iterdir()}
        self.assertEqual(files, {"result.json", "report.html", "roughness.png", "wrinkles.png", "wrinkles.csv", "points.csv",
                                 "roughness_after.png", "wrinkles_after.png", "points_after.csv"})
        result = json.loads(self.path("out/result.json").read_text())
        self.assertEqual(result["scan"]["wrinkles"]["count"], 1)
        depth = result["scan"]["wrinkles"]["list"][0]["mean_depth"]
        self.assertAlmostEqual(depth, 0.3, delta=0.06)
        self.assertAlmostEqual(result["change"]["wrinkles"][0]["mean_depth"] / depth, 0.5, delta=0.15)
        self.assertLess(result["change"]["parameters"]["sq"], -0.2)
        self.assertIn("depth_after", self.path("out/wrinkles.csv").read_text())

    def test_las_points(self):
        self.run_cli("convert", "before.xyz", "before.las")
        self.run_cli("roughness", "before.las", "-o", "out", "--format", "las", "--map-width", "300")
        self.assertIn("roughness", self.result("info", "out/points.las")["files"][0]["attributes"])

    def test_failure_leaves_nothing(self):
        self.fails(3, "roughness", "nowhere.ply", "-o", "out", says=["nowhere.ply"])
        self.fails(2, "roughness", "before.xyz", "--margin", "30", "-o", "out", says=["--margin"])

    def test_same_bytes_for_any_threads(self):
        texts = {without_timing(self.run_cli(*self.words, "--json", "-", "--threads", n).stdout) for n in [1, 3]}
        self.assertEqual(len(texts), 1)


class Options(RoughnessTest):
    def scan(self, *words):
        return self.result("roughness", "before.xyz", *words)["scan"]

    def test_each_option_acts(self):
        base = self.scan("--l-filter", "8")
        seen = {json.dumps(base)}
        for words in [("--form", "none"), ("--form", "polynomial"), ("--form", "polynomial", "--degree", "4"),
                      ("--s-filter", "1.5"), ("--filter", "robust"), ("--filter-degree", "0"),
                      ("--margin", "2"), ("--interpolation", "linear"), ("--wrinkle-depth", "0.02"),
                      ("--wrinkle-length", "2"), ("--border", "hull"), ("--max-edge", "1.6"), ("--crop", "2,2,20,15"),
                      ("--direction", "0.1,0,1"), ("--direction", "fit")]:
            with self.subTest(words=words):
                text = json.dumps(self.scan("--l-filter", "8", *words))
                self.assertNotIn(text, seen)
                seen.add(text)
        self.assertNotIn(json.dumps(self.scan("--l-filter", "6")), seen)

    def test_duplicates_and_class(self):
        twice = skin(1, n=800)
        self.write("twice.csv", ["x,y,z,classification"] + ["%r,%r,%r,2" % p for p in twice]
                   + ["%r,%r,%r,3" % (x, y, z + 1) for x, y, z in twice[::5]])
        sq = [self.result("roughness", "twice.csv", *words)["scan"]["parameters"]["sq"]
              for words in [("--duplicates", "min"), ("--duplicates", "max"), ("--duplicates", "mean"), ("--class", "2")]]
        self.assertEqual(len(set(sq)), 3)
        self.assertEqual(sq[0], sq[3])
        self.fails(3, "roughness", "twice.csv", "--duplicates", "error", says=["twice.csv"])

    def test_reference(self):
        self.write("form.xyz", skin(3, groove=0.0))
        words = ("--form", "reference", "--reference", "form.xyz")
        own = self.scan("--form", "plane")
        result = self.result("roughness", "before.xyz", *words)
        self.assertLess(result["scan"]["parameters"]["sq"], 0.5 * own["parameters"]["sq"])
        self.assertEqual(result["inputs"][1]["role"], "reference")
        self.write("moved.xyz", skin(3, groove=0.0, shift=0.4))
        moved = ("--form", "reference", "--reference", "moved.xyz")
        astray = self.result("roughness", "before.xyz", *moved)["scan"]["parameters"]["sq"]
        matched = self.result("roughness", "before.xyz", *moved, "--match", "--accept-doubt")  # one lacks the groove
        self.assertLess(matched["scan"]["parameters"]["sq"], astray)
        self.assertNotEqual(matched["reference_pose"]["matrix"][0][3], 0)
        self.write("far.xyz", skin(3, shift=500))
        self.fails(4, "roughness", "before.xyz", "--form", "reference", "--reference", "far.xyz", says=["--reference"])

    def test_pose_and_match_move_the_second_scan(self):
        self.write("moved.xyz", skin(2, groove=0.3, shift=9.0))
        self.write("pose.txt", ["1 0 0 -9", "0 1 0 0", "0 0 1 0", "0 0 0 1"])
        words = ("roughness", "before.xyz", "moved.xyz", *self.words[2:])
        astray, placed = self.result(*words), self.result(*words, "--pose", "pose.txt")
        key = lambda r: r["change"]["wrinkles"][0]["mean_depth"]
        self.assertGreater(key(placed), key(astray) + 0.05)
        self.assertEqual(placed["pose"]["matrix"][0][3], -9)
        matched = self.result(*words, "--pose", "pose.txt", "--match")
        self.assertNotEqual(matched["pose"]["matrix"], placed["pose"]["matrix"])
        self.assertAlmostEqual(matched["pose"]["matrix"][0][3], -9, delta=0.5)

    def test_unit_and_crs(self):
        self.assertIn(" mm", self.run_cli("roughness", "before.xyz", "--unit", "mm").stdout)
        self.assertTrue(self.result("roughness", "before.xyz", "--allow-crs")["parameters"]["allow_crs"])

    def test_layers(self):
        self.write("two.xyz", skin(1, n=4000) + [(x, y, z + 30) for x, y, z in skin(4, n=4000)])
        self.assertIn("layers", self.run_cli("roughness", "two.xyz").stdout)
        self.assertNotIn("layers", self.run_cli("roughness", "two.xyz", "--no-layer-check").stdout)

    def test_wrong_values_name_the_option(self):
        for option, value in [("--form", "sphere"), ("--degree", "0"), ("--degree", "9"), ("--s-filter", "0"),
                              ("--s-filter", "wide"), ("--l-filter", "-1"), ("--filter", "median"), ("--filter-degree", "2"),
                              ("--margin", "-1"), ("--interpolation", "spline"), ("--wrinkle-depth", "0"),
                              ("--wrinkle-length", "long"), ("--border", "none"), ("--max-edge", "0"), ("--format", "doc"),
                              ("--map-width", "9"), ("--duplicates", "all"), ("--direction", "0,0,0"), ("--crop", "1,2"),
                              ("--class", "900"), ("--unit", "mile"), ("--output", ""), ("--json", ""), ("--reference", "")]:
            with self.subTest(option=option, value=value):
                self.fails(2, "roughness", "before.xyz", f"{option}={value}", says=[option])
        self.fails(3, "roughness", "before.xyz", "after.xyz", "--pose", "nowhere.txt", says=["nowhere.txt"])
        self.fails(3, "roughness", "before.xyz", "--form", "reference", "--reference", "nowhere.ply", says=["nowhere.ply"])

    def test_options_that_would_do_nothing(self):
        self.write("pose.txt", ["1 0 0 -9", "0 1 0 0", "0 0 1 0", "0 0 0 1"])
        for words in [("--degree", "3"), ("--reference", "after.xyz"), ("--form", "reference"), ("--match",),
                      ("--pose", "pose.txt"), ("--filter", "robust"), ("--format", "csv"),
                      ("--s-filter", "9", "--l-filter", "8"), ("--l-filter", "0.1"), ("--s-filter", "0.1")]:
            with self.subTest(words=words):
                self.fails(2, "roughness", "before.xyz", *words, says=[words[0]])


if __name__ == "__main__":
    unittest.main()
