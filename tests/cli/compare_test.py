"""isopach compare: what its numbers must obey, and that each option acts."""

import json
import random
import re
import unittest

from support import CliTest, points, without_timing


class Laws(CliTest):
    def test_same_bytes_for_any_threads(self):
        self.write("a.xyz", points(1, n=20000))
        self.write("b.xyz", points(2, n=15000, lift=0.5))
        texts = {without_timing(self.run_cli("compare", "a.xyz", "b.xyz", "--json", "-", "--threads", n).stdout)
                 for n in [1, 2, 7]}
        self.assertEqual(len(texts), 1)

    def test_order_of_points_does_not_matter(self):
        a, b = self.scans()
        first = without_timing(self.run_cli("compare", a, b, "--json", "-").stdout)
        for name in [a, b]:
            lines = self.path(name).read_text().split("\n")[:-1]
            random.Random(7).shuffle(lines)
            self.write(name, lines)
        self.assertEqual(without_timing(self.run_cli("compare", a, b, "--json", "-").stdout), first)

    def test_swap_mirrors(self):
        a, b = self.scans()
        forward, back = self.result("compare", a, b), self.result("compare", b, a)
        self.assertEqual(forward["measure"]["rho"], back["measure"]["rho"])
        self.assertEqual(forward["volume"]["above"], back["volume"]["below"])
        self.assertEqual(forward["volume"]["below"], back["volume"]["above"])
        self.assertEqual(forward["volume"]["net"], -back["volume"]["net"])
        self.assertEqual(forward["difference"]["max_above"], back["difference"]["max_below"])

    def test_self_is_zero(self):
        a, _ = self.scans()
        result = self.result("compare", a, a)
        self.assertEqual(result["measure"]["rho"], 0)
        self.assertEqual(set(result["volume"].values()), {0})
        self.assertAlmostEqual(result["domain"]["coverage"], 1, places=12)  # a quotient of two sums

    def test_lifted_plane(self):
        """The same plane 0.25 higher over 29 x 19: every number is known."""
        grid = [(x, y) for x in range(30) for y in range(20)]
        self.write("a.xyz", [(x, y, 1.0) for x, y in grid])
        self.write("b.xyz", [(x, y, 1.25) for x, y in grid])
        result = self.result("compare", "a.xyz", "b.xyz")
        self.assertEqual(result["domain"]["area"], 29 * 19)
        self.assertEqual(result["measure"]["rho"], 0.25)
        self.assertEqual(result["volume"]["net"], 0.25 * 29 * 19)
        self.assertEqual(result["difference"]["mean"], 0.25)


class Output(CliTest):
    FILES = {"result.json", "histogram.csv", "report.html", "difference.png", "difference.ply", "points_a.ply", "points_b.ply"}

    def test_text_only_without_output(self):
        a, b = self.scans()
        run = self.run_cli("compare", a, b)
        self.assertGreater(run.stdout.count("\n"), 5)
        self.assertEqual(run.stderr, "")
        self.assertNotIn("\x1b", run.stdout)
        self.assertEqual({p.name for p in self.folder.iterdir()}, {a, b})

    def test_folder(self):
        a, b = self.scans()
        self.run_cli("compare", a, b, "-o", "new/folder", "--json", "copy.json")
        self.assertEqual({p.name for p in self.path("new/folder").iterdir()}, self.FILES)
        result = json.loads(self.path("new/folder/result.json").read_text())
        self.assertEqual(set(result["outputs"]), self.FILES)
        self.assertEqual(self.path("copy.json").read_text(), self.path("new/folder/result.json").read_text())
        self.assertTrue(self.path("new/folder/difference.png").read_bytes().startswith(b"\x89PNG"))
        rows = [[float(v) for v in line.split(",")] for line in self.path("new/folder/histogram.csv").read_text().split()[1:]]
        self.assertEqual([row[2] for row in rows], result["difference"]["histogram"]["areas"])
        self.assertEqual([row[0] for row in rows] + [rows[-1][1]], result["difference"]["histogram"]["edges"])
        self.assertTrue(self.path("new/folder/difference.ply").read_bytes().startswith(b"ply\n"))
        self.run_cli("compare", a, b, "-o", "new/folder")  # again, over the old files

    def test_files_left_out(self):
        a, b = self.scans()
        for option, gone in [("--no-map", {"difference.png"}), ("--no-cells", {"difference.ply"}),
                             ("--no-points", {"points_a.ply", "points_b.ply"})]:
            self.run_cli("compare", a, b, "-o", option[2:], option)
            self.assertEqual({p.name for p in self.path(option[2:]).iterdir()}, self.FILES - gone)

    def test_cells_of_the_overlay(self):
        a, b = self.scans()
        for surface, more in [("common", set()), ("overlay", set()), ("both", {"difference_overlay.ply"})]:
            self.run_cli("compare", a, b, "-o", surface, "--surface", surface)
            self.assertEqual({p.name for p in self.path(surface).iterdir()}, self.FILES | more)
        read = lambda name: self.path(name).read_bytes()
        self.assertEqual(read("overlay/difference.ply"), read("both/difference_overlay.ply"))
        self.assertEqual(read("common/difference.ply"), read("both/difference.ply"))
        self.assertNotEqual(read("common/difference.ply"), read("overlay/difference.ply"))

    def test_failure_keeps_the_old_files(self):
        a, b = self.scans()
        self.run_cli("compare", a, b, "-o", "out")
        before = {p.name: p.read_bytes() for p in self.path("out").iterdir()}
        self.fails(3, "compare", a, "nowhere.ply", "-o", "out")
        self.assertEqual({p.name: p.read_bytes() for p in self.path("out").iterdir()}, before)

    def test_json_alone_on_stdout(self):
        a, b = self.scans()
        run = self.run_cli("compare", a, b, "--json", "-", "-o", "out")
        result = json.loads(run.stdout)
        self.assertEqual(result["schema"], "isopach.compare/1")
        self.assertNotIn("NaN", run.stdout)
        self.assertEqual(list(result)[:2], ["schema", "tool"])
        self.assertEqual(list(result)[-1], "timing_s")

    def test_map_options(self):
        a, b = self.scans()
        maps = set()
        for words in [(), ("--flip-palette",), ("--palette", "purple-orange"), ("--map-width", "800"),
                      ("--title", "Another")]:
            self.run_cli("compare", a, b, "-o", "out", *words)
            maps.add(self.path("out/difference.png").read_bytes())
        self.assertEqual(len(maps), 5)

    def test_vertices_of_the_report(self):
        a, b = self.scans()

        def scene():
            text = re.search('<script type="application/json" id="view-data">(.*?)</script>', self.path("out/report.html").read_text())
            return json.loads(text.group(1))["scenes"][0] if text else None

        self.run_cli("compare", a, b, "-o", "out", "--threads", "1")
        whole = scene()
        self.assertTrue(whole["whole"])
        self.assertEqual(whole["nodes"], whole["of"])
        self.run_cli("compare", a, b, "-o", "out", "--threads", "3")
        self.assertEqual(scene(), whole)
        self.run_cli("compare", a, b, "-o", "out", "--report-vertices", "150")
        thin = scene()
        self.assertFalse(thin["whole"])
        self.assertLessEqual(thin["nodes"], 150)
        self.assertGreater(thin["error"]["d"], whole["error"]["d"])
        self.run_cli("compare", a, b, "-o", "out", "--report-vertices", "0")
        self.assertIsNone(scene())

    def test_las_in_las_out(self):
        a, b = self.scans()
        self.run_cli("convert", a, "a.las")
        self.run_cli("compare", "a.las", b, "-o", "out")
        self.assertTrue(self.path("out/points_a.las").read_bytes().startswith(b"LASF"))
        info = json.loads(self.run_cli("info", "out/points_a.las", "--json", "-").stdout)["files"][0]
        self.assertEqual(info["points"], 400)
        self.assertLessEqual({"dz_signed", "dz_abs"}, set(info["attributes"]))

    def test_quiet_verbose_progress(self):
        a, b = self.scans()
        run = self.run_cli("compare", a, b, "--quiet")
        self.assertEqual((run.stdout, run.stderr), ("", ""))
        self.assertIn("delaunay", self.run_cli("compare", a, b, "--verbose").stderr)
        self.assertIn("%", self.run_cli("compare", a, b, "--progress", "bar").stderr)
        self.assertEqual(self.run_cli("compare", a, b, "--progress", "none").stderr, "")
        for line in self.run_cli("compare", a, b, "--progress", "json").stderr.splitlines():
            self.assertEqual(set(json.loads(line)), {"stage", "fraction"})


class Options(CliTest):
    def test_each_option_acts(self):
        a, b = self.scans(n=600)
        self.write("b.xyz", points(2, n=600, lift=0.5) + [(x, y, z + 4) for x, y, z in points(2, n=600, lift=0.5)[::9]])
        self.write("pose.txt", ["1 0 0 0.5", "0 1 0 0", "0 0 1 -0.5", "0 0 0 1"])
        seen = {json.dumps(self.result("compare", a, b)["measure"])}
        for words in [("--domain", "hull"), ("--border", "hull"), ("--max-edge", "2"), ("--duplicates", "min"), ("--duplicates", "max"), ("--direction", "0.1,0,1"),
                      ("--direction", "fit"), ("--crop", "2,2,20,15"), ("--pose", "pose.txt")]:
            with self.subTest(words=words):
                text = json.dumps(self.result("compare", a, b, *words)["measure"])
                self.assertNotIn(text, seen)
                seen.add(text)

    def test_surface(self):
        a, b = "a.xyz", "b.xyz"
        self.write(a, points(1, n=600))
        self.write(b, points(2, n=600, lift=0.01))  # above and below
        common, overlay, both = (self.result("compare", a, b, "--surface", s) for s in ["common", "overlay", "both"])
        self.assertEqual(self.result("compare", a, b)["measure"], common["measure"])
        self.assertEqual(both["measure"], common["measure"])
        self.assertEqual(both["difference"], common["difference"])
        self.assertIsNone(common["surfaces"])
        self.assertIsNone(overlay["surfaces"])
        for key in ["above", "below", "net", "absolute"]:
            self.assertNotEqual(overlay["volume"][key], common["volume"][key])
            self.assertEqual(both["surfaces"]["common"][key], common["volume"][key])
            self.assertEqual(both["surfaces"]["overlay"][key], overlay["volume"][key])
            self.assertEqual(both["surfaces"]["overlay_minus_common"][key], overlay["volume"][key] - common["volume"][key])
        self.assertEqual(both["surfaces"]["overlay"]["area"], overlay["domain"]["area"])
        self.assertAlmostEqual(overlay["domain"]["area"] / common["domain"]["area"], 1, places=12)
        self.assertAlmostEqual(sum(overlay["difference"]["histogram"]["areas"]), overlay["domain"]["area"], places=6)
        self.assertIn("exact overlay", self.run_cli("compare", a, b, "--surface", "both").stdout)
        self.assertIn("exact overlay", self.run_cli("compare", a, b, "--surface", "overlay").stdout)
        self.assertNotIn("exact overlay", self.run_cli("compare", a, b).stdout)
        self.run_cli("compare", a, b, "--surface", "both", "-o", "out")
        self.assertIn("exact overlay", self.path("out/report.html").read_text())
        for surface in ["overlay", "both"]:
            self.fails(2, "compare", a, b, "--surface", surface, "--domain", "hull", says=["--surface", "--domain hull"])

    def test_surface_does_not_depend_on_threads_or_way(self):
        a, b = self.scans(n=3000)
        results = [self.result("compare", a, b, "--surface", "overlay", *more)
                   for more in [("--threads", "1"), ("--threads", "7"), ("--locate", "tree"), ("--locate", "interface"),
                                ("--locate", "order")]]
        for key in ["domain", "measure", "volume", "difference"]:
            for result in results[1:]:
                self.assertEqual(result[key], results[0][key])

    def test_rho_dv_is_told_where_densities_differ(self):
        a, b = self.scans(n=2000)
        for name, rows in {"even.xyz": 1, "sparse.xyz": 3}.items():
            self.write(name, self.path(a).read_text().splitlines()[::rows])
        told = self.run_cli("compare", a, "even.xyz").stdout, self.run_cli("compare", a, "sparse.xyz").stdout
        self.assertNotIn("rho_dV", told[0])
        self.assertIn("rho_dV", told[1])
        self.assertIn("rho_dV", self.run_cli("compare", a, "even.xyz", "--measure", "dV").stdout)
        self.assertIsNotNone(self.result("compare", a, "even.xyz")["measure"]["rho_dv"])

    def test_measure_dv_is_told_first(self):
        a, b = self.scans(n=4000)
        plain, detail = self.result("compare", a, b), self.result("compare", a, b, "--measure", "dV")
        self.assertEqual([r["parameters"]["measure"] for r in [plain, detail]], ["V", "dV"])
        self.assertEqual(plain["measure"], detail["measure"])
        self.assertAlmostEqual(detail["measure"]["rho_dv"], 0.5, places=1)
        self.assertEqual(detail["measure"]["detail"]["coarser"], "A")
        self.assertEqual(self.result("compare", b, a)["measure"]["detail"]["coarser"], "B")
        first = [self.run_cli("compare", a, b, *words).stdout.splitlines()[0] for words in [(), ("--measure", "dV")]]
        self.assertIn("gained", first[0])
        self.assertIn("detail that B alone can hold", first[1])
        self.run_cli("compare", a, b, "--measure", "dV", "-o", "out")
        self.assertIn("detail that B alone can hold", self.path("out/report.html").read_text())
        self.fails(2, "compare", a, b, "--measure", "W", says=["--measure"])
        self.write("wide.xyz", ["-90 -90 0", "190 -90 0", "190 190 0", "-90 190 0", "12 300 0"])
        self.fails(4, "compare", "wide.xyz", b, "--measure", "dV", "--border", "hull", says=["--measure dV"])
        self.assertIsNone(self.result("compare", "wide.xyz", b, "--domain", "overlap", "--border", "hull")["measure"]["rho_dv"])
        self.run_cli("compare", a, b, "--fail-above", "rho_dv=0.1", code=6)

    def test_interpolation_cubic_bends_the_scans(self):
        self.run_cli("simulate", "relief", "-o", self.path("relief"), "--points", "5000", "--format", "xyz")
        pair = ("compare", "relief/a.xyz", "relief/b.xyz")
        linear, cubic = self.result(*pair), self.result(*pair, "--interpolation", "cubic")
        self.assertEqual([r["parameters"]["interpolation"] for r in [linear, cubic]], ["linear", "cubic"])
        error = [abs(r["volume"]["absolute"] - 625000) for r in [linear, cubic]]
        self.assertLess(error[1], 0.2 * error[0])
        for surface in ["overlay", "both"]:
            self.fails(2, *pair, "--interpolation", "cubic", "--surface", surface, says=["--interpolation"])
        self.fails(2, *pair, "--interpolation", "quintic", says=["--interpolation"])

    def test_border_says_what_it_trimmed(self):
        """A ring: its hole is no part of it, unless the hull is asked for."""
        ring = [(x / 2, y / 2) for x in range(-40, 41) for y in range(-40, 41) if 100 <= x * x + y * y <= 1600]
        self.write("a.xyz", [(x, y, 1.0) for x, y in ring])
        self.write("b.xyz", [(x, y, 1.25) for x, y in ring])
        trim, hull = self.result("compare", "a.xyz", "b.xyz"), self.result("compare", "a.xyz", "b.xyz", "--border", "hull")
        self.assertEqual([r["border"]["rule"] for r in [trim, hull]], ["trim", "hull"])
        self.assertEqual([r["parameters"]["border"] for r in [trim, hull]], ["trim", "hull"])
        self.assertAlmostEqual(trim["border"]["trimmed_area"], 1 - trim["domain"]["area"] / hull["domain"]["area"])
        self.assertAlmostEqual(trim["border"]["trimmed_volume"], trim["border"]["trimmed_area"], msg="the lift is even")
        self.assertGreater(trim["border"]["trimmed_area"], 0.05)
        self.assertEqual(hull["border"]["trimmed_area"], 0)
        self.assertIn(" % of the area left out, triangles that bridge", self.run_cli("compare", "a.xyz", "b.xyz").stdout)
        self.assertIn("hull: nothing left out", self.run_cli("compare", "a.xyz", "b.xyz", "--border", "hull").stdout)
        overlay = [self.result("compare", "a.xyz", "b.xyz", "--surface", "overlay", "--border", rule)["domain"]["area"]
                   for rule in ["trim", "hull"]]
        self.assertAlmostEqual(overlay[0], trim["domain"]["area"])
        self.assertAlmostEqual(overlay[1], hull["domain"]["area"])

    def test_max_edge_is_in_the_parameters(self):
        a, b = self.scans()
        self.assertIsNone(self.result("compare", a, b)["parameters"]["max_edge"])
        result = self.result("compare", a, b, "--border", "hull", "--max-edge", "2.5")
        self.assertEqual(result["parameters"]["max_edge"], 2.5)
        self.assertGreater(result["border"]["trimmed_area"], 0)

    def test_locate_changes_the_way_and_not_the_result(self):
        a, b = self.scans()
        results = {way: self.result("compare", a, b, "--locate", way) for way in ["tree", "interface", "order"]}
        self.assertEqual(self.result("compare", a, b)["localisation"], results["order"]["localisation"])
        visited = set()
        for way, result in results.items():
            self.assertEqual(result["parameters"].pop("locate"), way)
            located = result.pop("localisation")
            self.assertEqual(located["method"], way)
            visited.add((located["visited_1_in_2"], located["visited_2_in_1"]))
            timing = result.pop("timing_s")
            self.assertEqual(timing["spanning_tree"] > 0, way == "tree")
            self.assertGreater(timing["localise"], 0)
        self.assertEqual(len(visited), 3)
        self.assertEqual(results["interface"], results["order"])
        self.assertEqual(results["tree"], results["order"])

    def test_locate_changes_no_bit_of_anything_that_can_be_asked_for(self):
        a, b = self.scans(n=2500, lift=0.02)
        ring = [[2, 2], [20, 3], [19, 15], [4, 14], [2, 2]]
        self.path("p.geojson").write_text(json.dumps({"type": "Feature", "properties": {"name": "p"}, "geometry": {
            "type": "Polygon", "coordinates": [ring]}}))
        for asked in [("--noise-floor", "--budget", "p.geojson"), ("--include", "p.geojson", "--border", "hull"),
                      ("--sigma1", "0.05", "--sigma2", "0.03", "--uncertainty-model", "independent"),
                      ("--sigma1", "0.05", "--sigma2", "0.03", "--uncertainty-model", "correlated", "--correlation-range", "2"),
                      ("--lod", "0.1", "--surface", "both"), ("--weight", "1 + x", "--measure", "dV"),
                      ("--interpolation", "cubic"), ("--domain", "hull")]:
            texts = set()
            for way in ["tree", "interface", "order"]:
                result = json.loads(without_timing(self.run_cli("compare", a, b, "--json", "-", "--locate", way, *asked).stdout))
                del result["parameters"]["locate"], result["localisation"]
                texts.add(json.dumps(result))
            self.assertEqual(len(texts), 1, asked)

    def test_exchanged_scans_give_the_same_digits(self):
        a, b = self.scans(n=2500, lift=0.02)
        for asked in [("--noise-floor",), ("--surface", "overlay")]:
            one, other = self.result("compare", a, b, *asked), self.result("compare", b, a, *asked)
            for key in ["above", "below"]:
                self.assertEqual(one["volume"][key], other["volume"]["below" if key == "above" else "above"])
                self.assertGreater(one["volume"][key], 0)
            self.assertEqual(one["volume"]["net"], -other["volume"]["net"])
            self.assertEqual(one["volume"]["absolute"], other["volume"]["absolute"])
            for key in ["rho", "rho_dv"]:
                self.assertEqual(one["measure"][key], other["measure"][key])
            for key in ["mean", "median"]:
                self.assertEqual(one["difference"][key], -other["difference"][key])
            for key in ["rms", "std", "nmad", "abs_percentiles"]:
                self.assertEqual(one["difference"][key], other["difference"][key])
            self.assertEqual(one["difference"]["histogram"]["areas"], other["difference"]["histogram"]["areas"][::-1])
            for key in ["domain", "border"]:
                self.assertEqual(one[key], other[key])
            self.assertEqual(one["uncertainty"]["noise_floor"]["rho"], other["uncertainty"]["noise_floor"]["rho"])

    def test_pose_undoes_a_shift(self):
        self.write("a.xyz", points(1))
        self.write("b.xyz", [(x + 64, y - 32, z + 2) for x, y, z in points(1)])
        self.write("pose.txt", ["1 0 0 -64 0 1 0 32 0 0 1 -2 0 0 0 1"])
        self.assertLess(self.result("compare", "a.xyz", "b.xyz", "--pose", "pose.txt")["measure"]["rho"], 1e-9)

    def test_unit(self):
        a, b = self.scans()
        self.assertIn(" mm", self.run_cli("compare", a, b, "--unit", "mm").stdout)
        self.assertNotIn(" mm", self.run_cli("compare", a, b).stdout)

    def test_direction_y_is_a_rotated_z(self):
        a, b = self.scans()
        for name in [a, b]:
            rows = [line.split() for line in self.path(name).read_text().splitlines()]
            self.write("turned-" + name, [f"{y} {z} {x}" for x, y, z in rows])
        self.assertAlmostEqual(self.result("compare", "turned-a.xyz", "turned-b.xyz", "--direction", "y")["measure"]["rho"],
                               self.result("compare", a, b)["measure"]["rho"], places=12)


class Config(CliTest):
    def test_file_acts_and_the_command_line_wins(self):
        a, b = self.scans()
        self.write("options.txt", ["# options of this project", 'domain = "hull"  # wider', "crop = [2, 2, 20, 15]", "quiet"])
        quiet = self.run_cli("compare", a, b, "--config", "options.txt", "--json", "-")
        options = ("compare", a, b, "--json", "-", "--crop", "2,2,20,15")
        self.assertEqual(without_timing(quiet.stdout), without_timing(self.run_cli(*options, "--domain", "hull").stdout))
        self.assertEqual(without_timing(self.run_cli("compare", a, b, "--json", "-", "--config", "options.txt", "--domain",
                                                     "overlap").stdout),
                         without_timing(self.run_cli(*options).stdout))
        self.assertEqual(self.run_cli("compare", a, b, "--config", "options.txt").stdout, "")

    def test_unknown_key_and_bad_value(self):
        a, b = self.scans()
        self.write("options.txt", ["", "domian = hull"])
        self.fails(2, "compare", a, b, "--config", "options.txt", says=["options.txt:2", "domian", "'domain'"])
        self.write("options.txt", ["domain = everywhere"])
        self.fails(2, "compare", a, b, "--config", "options.txt", says=["--domain", "everywhere"])
        self.fails(2, "compare", a, b, "--config", "nowhere.txt", says=["nowhere.txt"])


if __name__ == "__main__":
    unittest.main()
