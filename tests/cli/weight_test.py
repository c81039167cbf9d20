"""isopach compare --weight: each kind of weight acts, the plain numbers stay, and an error names the option."""

import json
import random
import unittest

from support import CliTest


class WeightTest(CliTest):
    def lifted(self):
        """B lies 2 above A, with an attribute 'trust' = x of B, and 'trust' = 1, 'own' = y of A."""
        for name, seed, z in [("a", 1, 0), ("b", 2, 2)]:
            numbers = random.Random(seed)
            places = [(0, 0), (20, 0), (20, 10), (0, 10)] + [(20 * t / 40, y) for t in range(1, 40) for y in (0, 10)]
            places += [(x, y / 4) for x in (0, 20) for y in range(1, 40)]
            places += [(numbers.uniform(0, 20), numbers.uniform(0, 10)) for _ in range(800)]
            header = "x,y,z,trust" + (",own" if name == "a" else "")
            self.write(name + ".csv", [header] + [
                f"{x},{y},{z}," + (f"1,{y}" if name == "a" else f"{x}") for x, y in places])
        return "compare", "a.csv", "b.csv"

    def raster(self, name, value, cells=(20, 10), size=1.0, corner=(0, 0)):
        columns, rows = cells
        self.write(name, [f"ncols {columns}", f"nrows {rows}", f"xllcorner {corner[0]}", f"yllcorner {corner[1]}",
                          f"cellsize {size}", "NODATA_value -9999"] +
                   [" ".join(str(value(corner[0] + (c + 0.5) * size, corner[1] + (rows - r - 0.5) * size))
                             for c in range(columns)) for r in range(rows)])
        return name

    def weighted(self, *words):
        result = self.result(*words)
        return result["measure"]["weight"], result


class Acts(WeightTest):
    def test_without_a_weight_nothing_is_said(self):
        pair = self.lifted()
        w, plain = self.weighted(*pair)
        self.assertIsNone(w)
        self.assertIsNone(plain["parameters"]["weight"])
        self.assertNotIn("weight", self.run_cli(*pair).stdout)

    def test_each_kind(self):
        pair = self.lifted()
        plain = self.result(*pair)
        self.raster("x.asc", lambda x, y: x + 2, (24, 14), 1, (-2, -2))
        kinds = {"expression": "x", "attribute": "@trust", "raster": "x.asc"}
        for surface in ["common", "overlay", "both"]:
            for kind, text in kinds.items():
                w, result = self.weighted(*pair, "--weight", text, "--surface", surface, "--border", "hull")
                self.assertEqual((w["kind"], w["expression"]), (kind, text))
                self.assertEqual(result["parameters"]["weight"], text)
                integral = 2400 if kind == "raster" else 2000  # x + 2, or x, over 20 by 10
                self.assertAlmostEqual(w["integral"], integral, delta=1e-6)
                self.assertAlmostEqual(w["above"], 2 * integral, delta=1e-6)
                self.assertAlmostEqual(w["rho"], integral / 100, delta=1e-8)
                self.assertEqual((w["below"], w["net"]), (0, w["above"]))
                self.assertLess(w["error_estimate"], 1e-9)
        weighted = self.result(*pair, "--weight", "x")
        for key in ["volume", "difference", "domain"]:
            self.assertEqual(weighted[key], plain[key])
        self.assertEqual(weighted["measure"]["rho"], plain["measure"]["rho"])

    def test_attribute_of_the_scan_that_is_named(self):
        pair = self.lifted() + ("--border", "hull", "--weight")
        for text, integral in [("@trust", 2000), ("@b:trust", 2000), ("@a:trust", 200), ("@own", 1000), ("@a:own", 1000)]:
            w, _ = self.weighted(*pair, text)
            self.assertAlmostEqual(w["integral"], integral, delta=1e-6)
            self.assertEqual(w["expression"], text)

    def test_heights_and_slopes(self):
        pair = self.lifted() + ("--border", "hull", "--weight")
        self.assertAlmostEqual(self.weighted(*pair, "z2 + slope1")[0]["integral"], 400, delta=1e-9)
        self.assertAlmostEqual(self.weighted(*pair, "x > 5 && x < 15 ? 1 : 0")[0]["integral"], 100, delta=1e-2)

    def test_direction(self):
        self.lifted()
        for name in ["a", "b"]:
            rows = [line.split(",") for line in self.path(name + ".csv").read_text().splitlines()[1:]]
            self.write(name + ".xyz", [f"{y} {z} {x}" for x, y, z, *_ in rows])
        w, _ = self.weighted("compare", "a.xyz", "b.xyz", "--direction", "y", "--border", "hull", "--weight", "x")
        self.assertAlmostEqual(w["integral"], 2000, delta=1e-6)

    def test_summary_report_and_warning(self):
        pair = self.lifted()
        text = self.run_cli(*pair, "--weight", "x < 9", "-o", "out").stdout
        self.assertIn("weighted rho", text)
        self.assertIn("x &lt; 9", self.path("out/report.html").read_text())
        self.assertEqual(json.loads(self.path("out/result.json").read_text())["measure"]["weight"]["expression"], "x < 9")
        self.assertIn("0 everywhere", self.run_cli(*pair, "--weight", "x > 50").stdout)


class Errors(WeightTest):
    def test_one_line_that_names_the_option(self):
        pair = self.lifted()
        self.raster("small.asc", lambda x, y: 1, (10, 10))
        self.raster("hole.asc", lambda x, y: -9999 if 5 < x < 6 and 5 < y < 6 else 1)
        self.raster("negative.asc", lambda x, y: x - 5)
        for code, says, text in [
                (2, "unknown name 'distance'", "distance^2"), (2, "not a formula", "x +"), (2, "==", "x = 1"),
                (2, "several", "x, y"), (2, "0 or more", "x - 5"), (2, "finite", "1/(x-x)"), (2, "finite", "ln(x-30)"),
                (2, "attribute", "@"), (2, "attribute", "@b:"), (3, "nothing", "@nothing"), (3, "own", "@b:own"),
                (3, "no such file", "missing.tif"), (3, "no raster", "a.csv"), (3, "small.asc", "small.asc"),
                (3, "hole.asc", "hole.asc"), (2, "negative.asc", "negative.asc")]:
            self.fails(code, *pair, "--weight", text, says=["--weight", says])
        self.fails(2, *pair, "--weight", "x", "--interpolation", "cubic", says=["--weight", "--interpolation"])
        self.fails(2, *pair, "--weight", "small.asc", "--direction", "0,0.1,1", says=["--weight", "--direction"])

    def test_attribute_that_is_no_weight(self):
        self.lifted()
        self.write("c.csv", ["x,y,z,trust", "0,0,1,1", "20,0,1,1", "20,10,1,-1", "0,10,1,1"])
        self.fails(3, "compare", "a.csv", "c.csv", "--weight", "@trust", says=["--weight", "point 3", "c.csv"])


if __name__ == "__main__":
    unittest.main()
