"""isopach distance: outputs, and that each option acts and is named when it is wrong."""

import json
import unittest

from support import CliTest, points, without_timing

M3C2 = ("--measure", "m3c2", "--normal-scale", "4", "--projection-scale", "3", "--max-depth", "2")


class Output(CliTest):
    def test_text_only_without_output(self):
        a, b = self.scans()
        run = self.run_cli("distance", a, b)
        for word in ["c2c", "c2s", "normal", "vertical", "Hausdorff"]:
            self.assertIn(word, run.stdout)
        self.assertEqual(run.stderr, "")
        self.assertEqual({p.name for p in self.folder.iterdir()}, {a, b})

    def test_folder(self):
        a, b = self.scans()
        self.run_cli("distance", a, b, "-o", "out/new", "--json", "copy.json")
        files = {p.name for p in self.path("out/new").iterdir()}
        self.assertEqual(files, {"report.html", "result.json", "points_a.ply", "points_b.ply"})
        result = json.loads(self.path("out/new/result.json").read_text())
        self.assertEqual(set(result["outputs"]), files)
        self.assertEqual(self.path("copy.json").read_text(), self.path("out/new/result.json").read_text())
        info = self.result("info", "out/new/points_a.ply")["files"][0]
        self.assertEqual(set(info["attributes"]), {"c2c", "c2s", "normal", "vertical"})

    def test_formats(self):
        a, b = self.scans()
        self.run_cli("distance", a, b, *M3C2, "-o", "csv", "--format", "csv")
        self.assertEqual({p.name for p in self.path("csv").iterdir()}, {"report.html", "result.json", "core_points.csv"})
        head, *rows = self.path("csv/core_points.csv").read_text().splitlines()
        self.assertIn("lod", head)
        self.assertEqual(len(rows), 400)
        self.run_cli("convert", a, "a.las")
        self.run_cli("distance", "a.las", b, "--measure", "c2c", "-o", "las")
        self.assertEqual({p.name for p in self.path("las").iterdir()},
                         {"report.html", "result.json", "points_a.las", "points_a.ply", "points_b.ply"})
        self.run_cli("distance", "a.las", b, "--measure", "c2c", "-o", "only", "--format", "las")
        self.assertEqual({p.name for p in self.path("only").iterdir()},
                         {"report.html", "result.json", "points_a.las", "points_b.las"})
        self.assertIn("c2c", self.result("info", "only/points_a.las")["files"][0]["attributes"])

    def test_report(self):
        a, b = self.scans()
        run = self.run_cli("distance", a, b, *M3C2[:1], "m3c2,c2s", *M3C2[2:], "-o", "out")
        self.assertIn("out/report.html", run.stdout)
        page, result = self.path("out/report.html").read_text(), json.loads(self.path("out/result.json").read_text())
        self.assertLess(len(page), 5e6)
        for words in ["Where they differ", "Is it more than the noise?", "data:image/png", "script-src 'sha256-", 'id="view-data"']:
            self.assertIn(words, page)
        self.assertIn(f'data-key="m3c2.significant" value="{result["m3c2"]["significant"]}"', page)
        # Without a distance of points there is nothing to colour: the page has its tables, and no script.
        self.run_cli("distance", a, b, "--measure", "hausdorff", "-o", "farthest")
        page = self.path("farthest/report.html").read_text()
        self.assertIn("Hausdorff", page)
        self.assertNotIn("script-src", page)

    def test_failure_leaves_nothing(self):
        a, _ = self.scans()
        self.fails(3, "distance", a, "nowhere.ply", "-o", "out", says=["nowhere.ply"])

    def test_same_bytes_for_any_threads(self):
        self.write("a.xyz", points(1, n=5000))
        self.write("b.xyz", points(2, n=4000, lift=0.5))
        texts = {without_timing(self.run_cli("distance", "a.xyz", "b.xyz", "--measure", "c2s,hausdorff,surface", "--json",
                                             "-", "--threads", n).stdout) for n in [1, 3]}
        self.assertEqual(len(texts), 1)


class Options(CliTest):
    def test_measure_chooses(self):
        a, b = self.scans()
        result = self.result("distance", a, b, "--measure", "c2s,surface")
        self.assertEqual({key for key in ["c2c", "c2s", "normal", "vertical", "surface", "hausdorff", "m3c2"] if result[key]},
                         {"c2s", "surface"})

    def test_each_option_acts(self):
        a, b = self.scans(n=600)
        self.write("b.xyz", points(2, n=600, lift=0.5) + [(x, y, z + 4) for x, y, z in points(2, n=600, lift=0.5)[::9]])
        self.write("pose.txt", ["1 0 0 0.5", "0 1 0 0", "0 0 1 -0.5", "0 0 0 1"])
        seen = {json.dumps(self.result("distance", a, b)["c2s"])}
        for words in [("--duplicates", "min"), ("--duplicates", "max"), ("--direction", "0.1,0,1"), ("--direction", "fit"),
                      ("--crop", "2,2,20,15"), ("--pose", "pose.txt")]:
            with self.subTest(words=words):
                text = json.dumps(self.result("distance", a, b, *words)["c2s"])
                self.assertNotIn(text, seen)
                seen.add(text)

    def test_mesh(self):
        a, b = self.scans()
        self.write("lid.obj", ["v 0 0 9", "v 24 0 9", "v 24 18 9", "v 0 18 9", "v 12 9 99", "f 1 2 3", "f 1 3 4"])
        own = self.result("distance", a, "lid.obj")
        self.assertEqual([i["surface"] for i in own["inputs"]], ["delaunay", "faces"])
        self.assertEqual(own["inputs"][1]["faces"], 2)
        made = self.result("distance", a, "lid.obj", "--mesh", "delaunay")
        self.assertEqual(made["inputs"][1]["faces"], 4)
        self.assertGreater(made["vertical"]["a_to_b"]["mean"], own["vertical"]["a_to_b"]["mean"])
        self.fails(3, "distance", "lid.obj", b, "--mesh", "faces", says=[b, "--mesh faces"])

    def test_border(self):
        hole = [p for p in points(1, n=3000) if not (8 < p[0] < 16 and 5 < p[1] < 13)]
        self.write("a.xyz", hole)
        self.write("b.xyz", points(2, n=3000, lift=0.5))
        told = {words: self.result("distance", "a.xyz", "b.xyz", "--measure", "vertical,c2s", *words)
                for words in [(), ("--border", "hull"), ("--border", "hull", "--max-edge", "3")]}
        trim, hull, edge = told.values()
        self.assertEqual(hull["inputs"][0]["trimmed_area"], 0)
        self.assertAlmostEqual(trim["inputs"][0]["trimmed_area"], 64 / (24 * 18), delta=0.03)
        self.assertAlmostEqual(edge["inputs"][0]["trimmed_area"], 64 / (24 * 18), delta=0.03)
        self.assertEqual((trim["parameters"]["border"], edge["parameters"]["max_edge"]), ("trim", 3))
        self.assertGreater(trim["vertical"]["b_to_a"]["missing"], hull["vertical"]["b_to_a"]["missing"] + 300)
        self.assertGreater(trim["c2s"]["b_to_a"]["max"], hull["c2s"]["b_to_a"]["max"])
        self.assertIn("of the area of the hull", self.run_cli("distance", "a.xyz", "b.xyz", "--measure", "c2s").stdout)
        for words in [("--border", "hull"), ("--max-edge", "3")]:
            self.fails(2, "distance", "a.xyz", "b.xyz", "--measure", "c2c", *words, says=[words[0], "--measure"])
            self.fails(2, "distance", "a.xyz", "b.xyz", "--mesh", "faces", *words, says=[words[0], "--mesh faces"])
        self.fails(3, "distance", "a.xyz", "b.xyz", "--max-edge", "1e-6", says=["a.xyz", "--max-edge"])

    def test_tolerance(self):
        a, b = self.scans()
        width = {}
        for tolerance in [1, 1e-6]:
            h = self.result("distance", a, b, "--measure", "hausdorff", "--tolerance", tolerance)["hausdorff"]
            self.assertLessEqual(h["upper"] - h["lower"], tolerance)
            width[tolerance] = (h["lower"], h["upper"])
        self.assertLessEqual(width[1][0], width[1e-6][1])
        self.assertGreaterEqual(width[1][1], width[1e-6][0])
        self.assertNotEqual(width[1], width[1e-6])
        self.fails(2, "distance", a, b, "--tolerance", "1e-18", says=["--tolerance"])

    def test_samples(self):
        a, b = self.scans()
        few, many = (self.result("distance", a, b, "--measure", "surface", "--samples", n)["surface"]["a_to_b"]
                     for n in [1, 200])  # six a triangle are the least: two sets of three
        self.assertGreater(many["samples"], 10 * few["samples"])
        for figures in few, many:
            self.assertLessEqual(figures["mean_error"], 1e-3 * figures["mean"])
            self.assertLessEqual(figures["rms_error"], 1e-3 * figures["rms"])
        self.assertLess(abs(few["mean"] - many["mean"]), 5 * (few["mean_error"] + many["mean_error"]))
        self.assertIn("± ", self.run_cli("distance", a, b, "--measure", "surface").stdout)

    def test_m3c2(self):
        a, b = self.scans()
        self.write("cores.xyz", points(1)[:7])
        first = self.result("distance", a, b, *M3C2)["m3c2"]
        self.assertEqual(first["cores"], 400)
        self.assertGreater(first["significant"], 0)
        self.assertEqual(self.result("distance", a, b, *M3C2, "--core-points", "cores.xyz")["m3c2"]["cores"], 7)
        loose = self.result("distance", a, b, *M3C2, "--registration-error", "0.25")["m3c2"]
        self.assertAlmostEqual(loose["median_lod"], first["median_lod"] + 1.96 * 0.25, places=9)
        self.assertLess(loose["significant"], first["significant"])
        for option, value in [("--normal-scale", "6"), ("--projection-scale", "5"), ("--max-depth", "0.6")]:
            words = list(M3C2)
            words[words.index(option) + 1] = value
            self.assertNotEqual(self.result("distance", a, b, *words)["m3c2"], first, option)

    def test_class(self):
        self.write("a.csv", ["x,y,z,classification"] + ["%r,%r,%r,%d" % (*p, 2 + i % 2) for i, p in enumerate(points(1))])
        self.write("b.csv", ["x,y,z,classification"] + ["%r,%r,%r,2" % p for p in points(2)])
        self.assertEqual(self.result("distance", "a.csv", "b.csv", "--class", "2")["inputs"][0]["measured"], 200)

    def test_unit(self):
        a, b = self.scans()
        self.assertIn(" mm", self.run_cli("distance", a, b, "--unit", "mm").stdout)
        self.assertEqual(self.result("distance", a, b, "--unit", "ft")["parameters"]["unit"], "ft")

    def test_wrong_values_name_the_option(self):
        a, b = self.scans()
        for option, value in [("--measure", "c2x"), ("--measure", ","), ("--mesh", "voxels"), ("--border", "none"), ("--max-edge", "0"), ("--format", "doc"),
                              ("--tolerance", "0"), ("--tolerance", "wide"), ("--samples", "0"), ("--normal-scale", "-1"),
                              ("--projection-scale", "0"), ("--max-depth", "deep"), ("--registration-error", "-1"),
                              ("--duplicates", "all"), ("--direction", "0,0,0"), ("--crop", "1,2"), ("--class", "900"),
                              ("--unit", "mile"), ("--output", ""), ("--json", "")]:
            with self.subTest(option=option, value=value):
                self.fails(2, "distance", a, b, f"{option}={value}", says=[option])
        self.fails(3, "distance", a, b, "--pose", "nowhere.txt", says=["nowhere.txt"])
        self.fails(3, "distance", a, b, *M3C2, "--core-points", "nowhere.xyz", says=["nowhere.xyz"])

    def test_options_of_what_is_not_measured(self):
        a, b = self.scans()
        for words in [("--measure", "c2c", "--tolerance", "1"), ("--samples", "5"), ("--normal-scale", "1"),
                      ("--projection-scale", "1"), ("--max-depth", "1"), ("--registration-error", "1"),
                      ("--core-points", "a.xyz")]:
            with self.subTest(words=words):
                self.fails(2, "distance", a, b, *words, says=[words[-2], "--measure"])
        self.fails(2, "distance", a, b, "--measure", "m3c2", says=["--normal-scale"])

    def test_units_that_do_not_fit(self):
        a, b = self.scans()
        self.assertEqual(without_timing(self.run_cli("distance", a, b, "--allow-crs", "--json", "-").stdout).count("true"), 1)


if __name__ == "__main__":
    unittest.main()
