"""isopach compare: polygons, budget, mask, alpha; each acts, and an error names it when it is wrong."""

import csv
import json
import math
import unittest

from support import CliTest, points, without_timing


def square(x, y, side, name=None):
    return ([[x, y], [x + side, y], [x + side, y + side], [x, y + side], [x, y]], name)


class DomainTest(CliTest):
    def geojson(self, path, *polygons, crs=None):
        """Each polygon: (ring, name) or (list of rings, name)."""
        features = []
        for rings, name in polygons:
            rings = rings if isinstance(rings[0][0], list) else [rings]
            features.append({"type": "Feature", "properties": {"name": name} if name else {},
                             "geometry": {"type": "Polygon", "coordinates": rings}})
        content = {"type": "FeatureCollection", "features": features}
        if crs:
            content["crs"] = {"type": "name", "properties": {"name": crs}}
        self.path(path).write_text(json.dumps(content))
        return path

    def mask(self, rows, x=0, y=0, size=2):
        lines = [f"ncols {len(rows[0])}", f"nrows {len(rows)}", f"xllcorner {x}", f"yllcorner {y}", f"cellsize {size}"]
        self.path("m.asc").write_text("\n".join(lines + [" ".join(map(str, r)) for r in rows]) + "\n")
        return "m.asc"

    def lifted(self, origin=(0, 0)):
        """A plane over 20 x 10 and the same 0.5 higher: volume = area / 2, wherever it is cut."""
        grid = [(origin[0] + x, origin[1] + y) for x in range(21) for y in range(11)]
        self.write("a.xyz", [(x, y, 0.125 * (x - origin[0])) for x, y in grid])
        self.write("b.xyz", [(x, y, 0.125 * (x - origin[0]) + 0.5) for x, y in grid])
        return "a.xyz", "b.xyz"

    def area(self, *words):
        r = self.result("compare", "a.xyz", "b.xyz", *words)
        self.assertAlmostEqual(r["volume"]["net"], r["domain"]["area"] / 2, places=11)
        self.assertAlmostEqual(r["domain"]["coverage"], 1, places=11)
        return r["domain"]["area"]


class Polygons(DomainTest):
    def test_include_exclude_and_their_overlaps(self):
        for origin in [(0, 0), (4500000, 5236000)]:
            x, y = origin
            self.lifted(origin)
            two = self.geojson("two.geojson", square(x + 1.25, y + 1, 4), square(x + 3.25, y + 2, 4))
            away = self.geojson("away.geojson", square(x + 4, y + 0.5, 2))
            holed = self.geojson("holed.geojson", ([square(x + 10, y + 2, 6)[0], square(x + 11.5, y + 3, 3)[0]], "ring"))
            for surface in ["common", "overlay"]:
                with self.subTest(origin=origin, surface=surface):
                    cut = ("--surface", surface)
                    self.assertAlmostEqual(self.area(*cut), 200)
                    self.assertAlmostEqual(self.area("--include", two, *cut), 32 - 6)
                    self.assertAlmostEqual(self.area("--include", holed, *cut), 27)
                    self.assertAlmostEqual(self.area("--include", two, "--include", holed, *cut), 53)
                    self.assertAlmostEqual(self.area("--exclude", away, *cut), 196)
                    # of the excluded 2 x 2, in the union: x from 4 to 6, y from 1 to 2.5, but for the corner right
                    # of 5.25 and under 2
                    self.assertAlmostEqual(self.area("--include", two, "--exclude", away, *cut), 26 - (3 - 0.75))
                    self.assertAlmostEqual(self.area("--exclude", away, "--exclude", holed, *cut), 200 - 4 - 27)

    def test_both_surfaces_are_cut(self):
        self.scans()
        p = self.geojson("p.geojson", square(5, 5, 6.5))
        r = self.result("compare", "a.xyz", "b.xyz", "--surface", "both", "--include", p)
        self.assertAlmostEqual(r["surfaces"]["common"]["area"], 6.5 ** 2)
        self.assertAlmostEqual(r["surfaces"]["overlay"]["area"], 6.5 ** 2)

    def test_everything_written_is_cut(self):
        self.scans()
        p = self.geojson("p.geojson", square(5, 5, 6.5, "the <pit>, \"one\""))
        for surface, file in [("common", "difference.ply"), ("both", "difference_overlay.ply")]:
            self.run_cli("compare", "a.xyz", "b.xyz", "--include", p, "--surface", surface, "-o", surface)
            info = self.run_cli("info", surface + "/" + file).stdout
            self.assertIn("x            5 to 11.5", info)
        with open(self.path("common/budget.csv"), newline="") as file:
            rows = list(csv.DictReader(file))
        result = json.loads(self.path("common/result.json").read_text())
        self.assertEqual(rows[0]["name"], "the <pit>, \"one\"")
        self.assertEqual(float(rows[0]["net"]), result["budget"][0]["net"])
        self.assertIn("budget.csv", result["outputs"])
        page = self.path("common/report.html").read_text()
        self.assertIn("By polygon", page)
        self.assertIn("the &lt;pit&gt;", page)

    def test_noise_of_a_clipped_domain(self):
        """A shift of B moves net by shift x area: the area is that of the polygon, on either surface."""
        self.scans()
        p = self.geojson("p.geojson", square(5, 5, 6.5))
        for surface in ["common", "overlay"]:
            r = self.result("compare", "a.xyz", "b.xyz", "--include", p, "--uncertainty-model", "registration",
                            "--registration-error", "0.1", "--surface", surface, "--lod", "0.01",
                            *(["--noise-floor"] if surface == "common" else []))
            self.assertAlmostEqual(r["uncertainty"]["sigma_net"], 0.1 * 6.5 ** 2)
            self.assertLessEqual(r["uncertainty"]["significant_area"], 6.5 ** 2 + 1e-9)
            if surface == "common":
                self.assertGreater(r["uncertainty"]["noise_floor"]["rho"], 0)
        whole = self.result("compare", "a.xyz", "b.xyz", "--sigma1", "0.1", "--sigma2", "0.1", "--uncertainty-model",
                            "independent")["uncertainty"]["sigma_net"]
        parts = [self.result("compare", "a.xyz", "b.xyz", "--sigma1", "0.1", "--sigma2", "0.1", "--uncertainty-model",
                             "independent", word, p)["uncertainty"]["sigma_net"] for word in ["--include", "--exclude"]]
        self.assertLess(math.hypot(*parts), whole)  # both parts use the nodes along the cut
        self.assertGreater(sum(parts), whole)

    def test_weights_and_detail_are_cut(self):
        """A weight of x: in the square from 1.25 to 5.25 its mean is 3.25, wherever cells lie."""
        grid = [(x, y) for x in range(21) for y in range(11)]
        for name, lift in [("a.csv", 0), ("b.csv", 0.5)]:
            self.write(name, ["x,y,z,w"] + [f"{x},{y},{lift + 0.125 * x},{x}" for x, y in grid])
        self.path("w.asc").write_text("ncols 24\nnrows 14\nxllcorner -2\nyllcorner -2\ncellsize 1\n" +
                                      (" ".join(str(x + 1.5) for x in range(-2, 22)) + "\n") * 14)  # x + 1
        p = self.geojson("p.geojson", square(1.25, 1, 4))
        for surface in ["common", "overlay"]:
            for weight, mean in [("x", 3.25), ("@w", 3.25), ("w.asc", 4.25)]:
                with self.subTest(surface=surface, weight=weight):
                    r = self.result("compare", "a.csv", "b.csv", "--include", p, "--weight", weight, "--surface", surface)
                    self.assertAlmostEqual(r["measure"]["weight"]["integral"], 16 * mean, places=9)
                    self.assertAlmostEqual(r["measure"]["weight"]["rho"], 0.5 * mean, places=9)
        r = self.result("compare", "a.csv", "b.csv", "--include", p, "--measure", "dV")
        self.assertAlmostEqual(r["measure"]["rho_dv"], 0.5)
        self.assertAlmostEqual(r["measure"]["detail"]["area"], 16)
        r = self.result("compare", "a.csv", "b.csv", "--include", p, "--interpolation", "cubic")
        self.assertAlmostEqual(r["volume"]["net"], 8)
        self.fails(4, "compare", "a.csv", "b.csv", "--include", self.geojson("far.geojson", square(100, 100, 1)),
                   "--measure", "dV", says=["--measure dV", "--include"])

    def test_same_bytes_for_any_threads_and_order(self):
        self.write("a.xyz", points(1, n=20000))
        self.write("b.xyz", points(2, n=15000, lift=0.5))
        p = self.geojson("p.geojson", *[square(x, y, 2.3) for x in range(0, 24, 2) for y in range(0, 18, 3)])
        words = ("compare", "a.xyz", "b.xyz", "--include", p, "--json", "-")
        texts = {without_timing(self.run_cli(*words, "--threads", n).stdout) for n in [1, 2, 7]}
        self.write("a.xyz", list(reversed(points(1, n=20000))))
        texts.add(without_timing(self.run_cli(*words).stdout))
        self.assertEqual(len(texts), 1)

    def test_currents(self):
        self.lifted()
        p = self.geojson("p.geojson", square(1.3, 1.1, 3.2))
        wide = ("--measure", "currents", "--sigma", "1e6", "--border", "hull")  # then the norm is the area
        told = [self.result("compare", "a.xyz", "b.xyz", *wide, *words)["measure"]["currents"]
                for words in [(), ("--include", p), ("--exclude", p)]]
        area = 3.2 ** 2 * math.hypot(1, 0.125)
        self.assertAlmostEqual(told[1]["norm_a"], area, places=6)
        self.assertAlmostEqual(told[1]["norm_b"], area, places=6)
        self.assertAlmostEqual(told[2]["norm_a"], told[0]["norm_a"] - area, places=6)
        self.assertGreater(told[0]["triangles_a"], told[1]["triangles_a"])
        same = self.result("compare", "a.xyz", "a.xyz", "--measure", "currents", "--include", p)["measure"]["currents"]
        self.assertEqual(same["distance"], 0)
        self.fails(4, "compare", "a.xyz", "b.xyz", "--include", self.geojson("far.geojson", square(100, 100, 1)), *wide,
                   says=["inside the polygons"])

    def test_wrong_polygons(self):
        self.lifted()
        p = self.geojson("p.geojson", square(1, 1, 3))
        for option in ["--include", "--exclude", "--budget"]:
            self.fails(3, "compare", "a.xyz", "b.xyz", option, "none.geojson", says=["none.geojson", "no such file"])
            self.fails(2, "compare", "a.xyz", "b.xyz", option, p, "--direction", "x", says=[option, "--direction z"])
        self.fails(4, "compare", "a.xyz", "b.xyz", "--include", self.geojson("far.geojson", square(100, 100, 1)),
                   says=["--include"])
        self.fails(2, "compare", "a.xyz", "b.xyz", "--budget", p, "--direction", "fit", says=["--budget"])
        self.fails(4, "compare", "a.xyz", "b.xyz", "--exclude", self.geojson("all.geojson", square(-1, -1, 99)),
                   says=["--exclude"])
        tie = self.geojson("tie.geojson", ([[1, 1], [3, 3], [3, 1], [1, 3], [1, 1]], "tie"))
        self.assertAlmostEqual(self.area("--include", tie), 2)
        run = self.run_cli("compare", "a.xyz", "b.xyz", "--include", tie)
        self.assertIn("'tie' crosses itself", run.stdout)
        flat = self.geojson("flat.geojson", ([[1, 1], [2, 2], [3, 3], [1, 1]], "flat"))
        self.fails(3, "compare", "a.xyz", "b.xyz", "--budget", flat, says=["flat.geojson", "no area"])

    def test_crs(self):
        self.lifted()
        other = self.geojson("o.geojson", square(1, 1, 3), crs="urn:ogc:def:crs:EPSG::32633")
        self.area("--include", other)  # the scans say nothing of theirs
        for name in ["g1", "g2"]:
            self.path(name + ".asc").write_text("ncols 4\nnrows 4\nxllcorner 0\nyllcorner 0\ncellsize 1\n" +
                                                "1 2 3 4\n" * 4)
            self.path(name + ".prj").write_text(
                'PROJCS["WGS_1984_UTM_Zone_32N",GEOGCS["GCS_WGS_1984",DATUM["D_WGS_1984",SPHEROID["WGS_1984",6378137.0,'
                '298.257223563]],PRIMEM["Greenwich",0.0],UNIT["Degree",0.0174532925199433]],PROJECTION['
                '"Transverse_Mercator"],PARAMETER["False_Easting",500000.0],PARAMETER["False_Northing",0.0],PARAMETER['
                '"Central_Meridian",9.0],PARAMETER["Scale_Factor",0.9996],PARAMETER["Latitude_Of_Origin",0.0],'
                'UNIT["Meter",1.0]]')
        same = self.geojson("s.geojson", square(1, 1, 2), crs="urn:ogc:def:crs:EPSG::32632")
        self.result("compare", "g1.asc", "g2.asc", "--include", same)
        self.fails(3, "compare", "g1.asc", "g2.asc", "--include", other, says=["o.geojson", "--include", "--allow-crs"])
        self.result("compare", "g1.asc", "g2.asc", "--include", other, "--allow-crs")


class Budget(DomainTest):
    def test_rows_are_each_polygons_own(self):
        self.lifted()
        p = self.geojson("p.geojson", square(1.25, 1, 4, "left"), square(3.25, 2, 4, "right"), square(18, 8, 4, "half"))
        r = self.result("compare", "a.xyz", "b.xyz", "--budget", p)
        self.assertEqual(r["domain"]["area"], 200)
        rows = {row["name"]: row for row in r["budget"]}
        for name, area in [("left", 16), ("right", 16), ("half", 4)]:
            row = rows[name]
            for key, expected in [("area", area), ("above", area / 2), ("below", 0), ("net", area / 2), ("mean", 0.5),
                                  ("rho", 0.5), ("polygon_area", 16), ("coverage", area / 16)]:
                self.assertAlmostEqual(row[key], expected, msg=f"{name} {key}")
            self.assertFalse(row["restricts"])
        far = self.geojson("far.geojson", square(500, 1, 4, "far"))
        told = self.run_cli("compare", "a.xyz", "b.xyz", "--budget", p, "--budget", far, "-o", "o").stdout
        table = told[told.index("by polygon"):].splitlines()
        self.assertEqual([line.split()[0] for line in table[1:5]], ["left", "right", "half", "far"])
        self.assertEqual(table[3].split()[1:], ["2.000", "0", "+2.000", "4.000", "+0.5000", "25.0", "%"])
        row = json.loads(self.path("o/result.json").read_text())["budget"][3]
        self.assertEqual([row[key] for key in ["name", "area", "net", "mean", "rho", "coverage"]],
                         ["far", 0, 0, None, None, 0])
        with open(self.path("o/budget.csv"), newline="") as file:
            self.assertEqual(list(csv.DictReader(file))[3]["mean"], "")
        include = self.result("compare", "a.xyz", "b.xyz", "--include", p)
        self.assertEqual([row["restricts"] for row in include["budget"]], [True] * 3)
        self.assertAlmostEqual(include["domain"]["area"], 36 - 6)
        away = self.geojson("away.geojson", square(1.25, 1, 2))
        cut = self.result("compare", "a.xyz", "b.xyz", "--budget", p, "--exclude", away)["budget"]
        self.assertAlmostEqual(cut[0]["area"], 12)
        self.assertAlmostEqual(cut[0]["coverage"], 0.75)
        self.assertEqual(self.result("compare", "a.xyz", "b.xyz")["budget"], [])

    def test_disjoint_rows_sum_to_the_whole(self):
        self.scans()
        xs, ys = [-1, 3.3, 12, 12.75, 25], [-1, 7.7, 19]
        quads = [([[x, y], [u, y], [u, v], [x, v], [x, y]], f"{x} {y}")
                 for x, u in zip(xs, xs[1:]) for y, v in zip(ys, ys[1:])]
        p = self.geojson("p.geojson", *quads)
        for surface in ["common", "overlay"]:
            r = self.result("compare", "a.xyz", "b.xyz", "--budget", p, "--surface", surface)
            for key in ["above", "below", "net", "absolute"]:
                total = sum(row[key] for row in r["budget"])
                self.assertLess(abs(total - r["volume"][key]), 1e-10 * r["volume"]["absolute"])


class Masks(DomainTest):
    def test_mask(self):
        self.lifted()
        rows = [[1] * 10 for _ in range(5)]
        rows[1][4] = rows[2][5] = rows[4][0] = 0
        for surface in ["common", "overlay"]:
            self.assertAlmostEqual(self.area("--mask", self.mask(rows), "--surface", surface), 200 - 12)
        p = self.geojson("p.geojson", square(7, 1, 4))
        # of the two inner pixels (8..10 x 6..8, 10..12 x 4..6) the second is met: 10..11 x 4..5
        self.assertAlmostEqual(self.area("--mask", self.mask(rows), "--include", p), 15)
        self.assertAlmostEqual(self.area("--mask", self.mask([[1, 1]], x=2.3, y=1.1, size=3)), 18)

    def test_wrong_mask(self):
        self.lifted()
        self.fails(3, "compare", "a.xyz", "b.xyz", "--mask", "none.tif", says=["none.tif"])
        self.fails(3, "compare", "a.xyz", "b.xyz", "--mask", self.mask([[0, 0]]), says=["m.asc", "0"])
        self.fails(4, "compare", "a.xyz", "b.xyz", "--mask", self.mask([[1]], x=500), says=["--mask"])
        self.fails(2, "compare", "a.xyz", "b.xyz", "--mask", self.mask([[1]]), "--direction", "fit", says=["--mask"])


class Alpha(DomainTest):
    def test_alpha(self):
        # Two blocks of unit squares (circumradius √½) with a gap of 4 between them, and a missing node in one.
        grid = [(x, y) for x in list(range(6)) + list(range(9, 15)) for y in range(6) if (x, y) != (2, 2)]
        for name, lift in [("a.xyz", 0), ("b.xyz", 0.5)]:
            self.write(name, [(x, y, lift + 0.125 * x) for x, y in grid])
        whole = ("--border", "hull")
        self.assertAlmostEqual(self.area(*whole), 70)
        self.assertAlmostEqual(self.area(*whole, "--alpha", "2"), 50)
        self.assertAlmostEqual(self.area(*whole, "--alpha", "0.75"), 48)  # the missing node: a circle of 1
        r = self.result("compare", "a.xyz", "b.xyz", *whole, "--alpha", "0.75")
        self.assertEqual(r["parameters"]["alpha"], 0.75)
        self.assertAlmostEqual(r["border"]["trimmed_area"], 22 / 70)
        p = self.geojson("p.geojson", square(4, 0, 4))  # 1 x 4 of a block, 3 x 4 of the gap
        r = self.result("compare", "a.xyz", "b.xyz", *whole, "--alpha", "0.75", "--include", p)
        self.assertAlmostEqual(r["domain"]["area"], 4)
        self.assertAlmostEqual(r["domain"]["area_union"], 4)
        self.assertAlmostEqual(r["border"]["trimmed_area"], 0.75)
        for wrong in ["0", "-1", "wide"]:
            self.fails(2, "compare", "a.xyz", "b.xyz", "--alpha", wrong, says=["--alpha"])
        self.fails(4, "compare", "a.xyz", "b.xyz", "--alpha", "0.1", says=["--alpha"])


class Coverage(DomainTest):
    def test_counts_inside_the_polygons_alone(self):
        self.write("a.xyz", [(x, y, 0.0) for x in range(11) for y in range(11)])
        self.write("b.xyz", [(x, y, 1.0) for x in range(5, 16) for y in range(11)])
        p = self.geojson("p.geojson", square(3, 2, 4))  # A holds all of it, B the half right of 5
        for words in [(), ("--border", "hull")]:
            d = self.result("compare", "a.xyz", "b.xyz", "--include", p, *words)["domain"]
            self.assertAlmostEqual(d["area"], 8)
            self.assertAlmostEqual(d["area_union"], 16)
            self.assertAlmostEqual(d["coverage"], 0.5)
        self.fails(4, "compare", "a.xyz", "b.xyz", "--include", p, "--min-coverage", "0.6", says=["--min-coverage"])
        self.assertAlmostEqual(self.result("compare", "a.xyz", "b.xyz")["domain"]["coverage"], 1 / 3)


if __name__ == "__main__":
    unittest.main()
