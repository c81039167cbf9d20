"""isopach compare: options of uncertainty and --fail-above; each acts, and an error names it when it is wrong."""

import json
import math
import random
import unittest

from support import CliTest, points


class UncertaintyTest(CliTest):
    def noisy(self, lift=0.0, n=500):
        """Two scans of a tilted plane with noise 0.05 and an attribute that says so."""
        for name, seed, offset in [("a", 1, 0.0), ("b", 2, lift)]:
            numbers = random.Random(seed)
            rows = ["x,y,z,noise"]
            for _ in range(n):
                x, y = numbers.uniform(0, 24), numbers.uniform(0, 18)
                rows.append(f"{x},{y},{0.1 * x + offset + numbers.gauss(0, 0.05)},{0.05 if x < 12 else 0.1}")
            self.write(name + ".csv", rows)
        return "a.csv", "b.csv"

    SIGMAS = ("--sigma1", "0.05", "--sigma2", "0.05")

    def uncertainty(self, *words):
        return self.result("compare", "a.csv", "b.csv", *words)["uncertainty"]


class Models(UncertaintyTest):
    def test_nothing_is_said_unless_asked(self):
        self.noisy()
        u = self.uncertainty()
        self.assertEqual(u["model"], "none")
        for key in ["lod", "sigma_net", "interval_net", "thresholded", "significant_area", "rectification_bias_max"]:
            self.assertIsNone(u[key])
        self.assertNotIn("uncertainty", self.run_cli("compare", "a.csv", "b.csv").stdout)

    def test_each_option_acts(self):
        self.noisy()
        seen = set()
        for words in [("--uncertainty-model", "independent"), ("--confidence", "0.9"),
                      ("--uncertainty-model", "independent", "--confidence", "0.9"),
                      ("--uncertainty-model", "correlated", "--correlation-range", "2"),
                      ("--uncertainty-model", "correlated", "--correlation-range", "4"),
                      ("--uncertainty-model", "correlated", "--correlation-range", "4", "--correlation", "exponential"),
                      ("--uncertainty-model", "correlated", "--correlation-range", "4", "--correlation", "gaussian"),
                      ("--uncertainty-model", "registration", "--registration-error", "0.01"),
                      ("--uncertainty-model", "registration", "--registration-error", "0.02"),
                      ("--uncertainty-model", "registration", "--registration-error", "0.02",
                       "--correlation-range", "4"),
                      ("--lod", "0.07"), ("--lod", "0.08")]:
            with self.subTest(words=words):
                text = json.dumps(self.uncertainty(*self.SIGMAS, *words))
                self.assertNotIn(text, seen)
                seen.add(text)
        for words in [("--sigma1", "0.06", "--sigma2", "0.05"), ("--sigma1", "@noise", "--sigma2", "0.05"),
                      ("--sigma1", "0.05", "--sigma2", "@noise")]:
            text = json.dumps(self.uncertainty(*words))
            self.assertNotIn(text, seen)
            seen.add(text)

    def test_interval_is_net_and_deviations(self):
        self.noisy()
        result = self.result("compare", "a.csv", "b.csv", *self.SIGMAS, "--uncertainty-model", "independent")
        u, net = result["uncertainty"], result["volume"]["net"]
        self.assertAlmostEqual(u["interval_net"][0], net - 1.959963984540054 * u["sigma_net"], places=12)
        self.assertAlmostEqual(u["interval_net"][1], net + 1.959963984540054 * u["sigma_net"], places=12)
        self.assertEqual(result["parameters"]["sigma1"], 0.05)
        # Alone a registration error shifts the whole area.
        u = self.uncertainty("--uncertainty-model", "registration", "--registration-error", "0.5")
        self.assertAlmostEqual(u["sigma_net"], 0.5 * result["domain"]["area"], places=9)

    def test_sentences(self):
        self.noisy()
        model = (*self.SIGMAS, "--uncertainty-model", "independent")
        say = lambda *words: self.run_cli("compare", "a.csv", "b.csv", *words).stdout
        self.assertIn("the net change is not distinguishable from zero at 95 %", say(*model))
        self.assertIn("not distinguishable from zero at 99.9 %", say(*model, "--confidence", "0.999"))
        self.noisy(lift=0.1)
        self.assertIn("the net change is a gain at 95 %", say(*model))
        self.assertIn("level of detection of 0.2000 units", say("--lod", "0.2"))

    def test_net_is_never_thresholded(self):
        self.noisy()
        plain = self.result("compare", "a.csv", "b.csv")
        cut = self.result("compare", "a.csv", "b.csv", "--lod", "0.05")
        self.assertEqual(plain["volume"], cut["volume"])
        self.assertEqual(set(cut["uncertainty"]["thresholded"]), {"above", "below", "area"})
        self.assertLess(cut["uncertainty"]["thresholded"]["above"], plain["volume"]["above"])
        self.assertAlmostEqual(cut["uncertainty"]["significant_area"],
                               cut["uncertainty"]["thresholded"]["area"] / cut["domain"]["area"])

    def test_noise_floor(self):
        self.noisy()
        u = self.uncertainty()
        self.assertIsNone(u["noise_floor"]["rho"])
        self.assertIsNone(u["debiased"])
        result = self.result("compare", "a.csv", "b.csv", "--noise-floor")
        self.assertTrue(result["parameters"]["noise_floor"])
        floor, debiased = result["uncertainty"]["noise_floor"], result["uncertainty"]["debiased"]
        self.assertAlmostEqual(floor["rho"] / result["measure"]["rho"], 1, delta=0.2)  # nothing has changed
        self.assertLess(debiased["rho"], 0.3 * result["measure"]["rho"])
        self.assertAlmostEqual(debiased["above"] - debiased["below"], result["volume"]["net"])
        self.assertAlmostEqual(floor["above"] + floor["below"], floor["absolute"])
        text = self.run_cli("compare", "a.csv", "b.csv", "--noise-floor").stdout
        self.assertIn("would also appear between two scans of an unchanged surface", text)
        for other in [("--surface", "overlay"), ("--interpolation", "cubic")]:
            self.fails(2, "compare", "a.csv", "b.csv", "--noise-floor", *other, says=["--noise-floor"])

    def test_raster_of_sigmas(self):
        self.noisy()
        header = ["ncols 2", "nrows 1", "xllcorner 0", "yllcorner 0", "cellsize 24", "NODATA_value -1"]
        self.write("even.asc", header + ["0.05 0.05"])
        even = self.uncertainty("--sigma1", "even.asc", "--sigma2", "0.05", "--uncertainty-model", "independent")
        self.assertEqual(even, self.uncertainty(*self.SIGMAS, "--uncertainty-model", "independent"))
        header[0], header[4] = "ncols 2", "cellsize 12"
        header[1] = "nrows 2"
        self.write("halves.asc", header + ["0.05 0.1"] * 2)
        words = ("--sigma2", "0.05", "--uncertainty-model", "independent")
        self.assertEqual(self.uncertainty("--sigma1", "halves.asc", *words), self.uncertainty("--sigma1", "@noise", *words))

    def test_errors_name_the_option(self):
        a, b = self.noisy()
        self.write("small.asc", ["ncols 1", "nrows 1", "xllcorner 0", "yllcorner 0", "cellsize 5", "0.1"])
        for code, says, words in [
                (2, "--sigma1", ("--sigma1", "wide", "--sigma2", "0.1")),
                (2, "--sigma2", ("--sigma1", "0.1", "--sigma2", "-0.1")),
                (2, "--sigma2", ("--sigma1", "0.1")),
                (3, "--sigma1", ("--sigma1", "@nothing", "--sigma2", "0.1")),
                (3, "--sigma2", ("--sigma1", "0.1", "--sigma2", "small.asc")),
                (3, "--sigma1", ("--sigma1", "a.csv", "--sigma2", "0.1")),
                (2, "--lod", ("--lod", "0")), (2, "--lod", ("--lod", "high")),
                (2, "--confidence", ("--confidence", "95", *self.SIGMAS)),
                (2, "--confidence", ("--confidence", "1", *self.SIGMAS)),
                (2, "--uncertainty-model", ("--uncertainty-model", "vague")),
                (2, "--uncertainty-model", ("--uncertainty-model", "independent")),
                (2, "--correlation-range", ("--uncertainty-model", "correlated", *self.SIGMAS)),
                (2, "--correlation-range", ("--correlation-range", "3", *self.SIGMAS)),
                (2, "--correlation-range", ("--correlation-range", "-3", *self.SIGMAS)),
                (2, "--correlation", ("--correlation", "square")),
                (2, "--registration-error", ("--registration-error", "0.1")),
                (2, "--registration-error", ("--registration-error", "0")),
                (2, "--registration-error", ("--registration-error", "none.json")),
                (3, "--registration-error", ("--registration-error", "a.csv")),
                (2, "--registration-error", ("--uncertainty-model", "registration", *self.SIGMAS))]:
            with self.subTest(words=words):
                self.fails(code, "compare", a, b, *words, says=[says])


class Registration(UncertaintyTest):
    """A whole pose that is uncertain: from a file, or from --match."""

    def setUp(self):
        super().setUp()
        for name, seed in [("a.xyz", 1), ("b.xyz", 2)]:
            self.write(name, [(x, y, z + 0.3 * math.sin(x) * math.cos(0.8 * y)) for x, y, z in points(seed, n=900)])

    def covariance(self, name, *deviations):
        matrix = [[d * d if i == j else 0.0 for j in range(6)] for i, d in enumerate(deviations)]
        self.path(name).write_text(json.dumps({"covariance": matrix, "centre": [12, 9, 0]}))
        return name

    def registered(self, *words):
        return self.result("compare", "a.xyz", "b.xyz", *words)

    def test_covariance_of_a_file(self):
        model = ("--uncertainty-model", "registration", "--registration-error")
        up = self.registered(*model, self.covariance("up.json", 0, 0, 0, 0, 0, 0.2))
        plain = self.registered(*model, "0.2")
        self.assertAlmostEqual(up["uncertainty"]["sigma_net"], plain["uncertainty"]["sigma_net"])
        self.assertAlmostEqual(plain["uncertainty"]["sigma_net"], 0.2 * plain["domain"]["area"])
        self.assertEqual(up["parameters"]["registration_error"], "up.json")
        self.assertEqual(plain["parameters"]["registration_error"], 0.2)
        # A turn about the centre moves what lies east of it up and what lies west of it down.
        turn = self.registered(*model, self.covariance("turn.json", 0, 0.02, 0, 0, 0, 0))
        self.assertLess(turn["uncertainty"]["sigma_net"], 0.1 * 0.02 * 12 * turn["domain"]["area"])
        self.assertGreater(turn["uncertainty"]["sigma_net"], 0)

    def test_covariance_of_a_match(self):
        sigmas = ("--sigma1", "0.01", "--sigma2", "0.01")
        self.run_cli("match", "b.xyz", "a.xyz", "-o", "m")
        model = ("--uncertainty-model", "registration")
        by_file = self.registered("--pose", "m/pose.txt", *sigmas, *model, "--registration-error", "m/result.json")
        by_match = self.registered("--match", *sigmas, *model)
        self.assertEqual(by_match["parameters"]["registration_error"], "match")
        self.assertGreater(by_match["uncertainty"]["sigma_net_registration"], 0)
        for key in ["sigma_net", "sigma_net_registration", "sigma_above", "lod"]:
            self.assertEqual(by_file["uncertainty"][key], by_match["uncertainty"][key], key)
        self.assertEqual(self.registered("--match", *sigmas)["uncertainty"], by_match["uncertainty"])
        told = self.registered("--match", *sigmas, "--uncertainty-model", "independent")
        self.assertIsNone(told["uncertainty"]["sigma_net_registration"])
        self.assertLess(told["uncertainty"]["lod"], by_match["uncertainty"]["lod"])
        self.assertIsNone(self.registered("--match")["uncertainty"]["sigma_net"])
        shift = self.registered("--match", *sigmas, *model, "--registration-error", "0.5")
        self.assertEqual(shift["parameters"]["registration_error"], 0.5)

    def test_a_file_that_is_wrong_is_named(self):
        for text in ["{}", "[1, 2]", '{"covariance": [[1, 2], [3, 4]], "centre": [0, 0, 0]}', "no json",
                     '{"covariance": "none", "centre": null}']:
            self.path("bad.json").write_text(text)
            self.fails(3, "compare", "a.xyz", "b.xyz", "--registration-error", "bad.json", says=["bad.json", "--registration-error"])
        bent = [[1.0 if i == j else 2.0 for j in range(6)] for i in range(6)]
        self.path("bent.json").write_text(json.dumps({"covariance": bent, "centre": [0, 0, 0]}))
        self.fails(3, "compare", "a.xyz", "b.xyz", "--uncertainty-model", "registration", "--registration-error",
                   "bent.json", says=["bent.json", "--registration-error"])
        self.covariance("up.json", 0, 0, 0, 0, 0, 0.2)
        self.fails(2, "compare", "a.xyz", "b.xyz", "--registration-error", "up.json", says=["--registration-error"])


class Sources(UncertaintyTest):
    """Each sigma as a number, as an attribute and as a raster, of A and of B: the same noise, the same result."""

    def test_number_attribute_and_raster_agree(self):
        self.noisy()
        header = ["ncols 2", "nrows 2", "xllcorner 0", "yllcorner 0", "cellsize 12", "NODATA_value -1"]
        self.write("halves.asc", header + ["0.05 0.1"] * 2)  # what the attribute "noise" says
        self.write("even.asc", header + ["0.05 0.05"] * 2)
        model = ("--uncertainty-model", "independent")
        for this, other in [("--sigma1", "--sigma2"), ("--sigma2", "--sigma1")]:
            of = lambda source: self.uncertainty(this, source, other, "0.02", *model)
            number, even, attribute, raster = of("0.05"), of("even.asc"), of("@noise"), of("halves.asc")
            self.assertEqual(number, even)
            self.assertEqual(attribute, raster)
            self.assertGreater(attribute["sigma_net"], number["sigma_net"])
            self.assertGreater(attribute["lod"], number["lod"])
            self.assertLess(attribute["significant_area"], number["significant_area"])


class Files(UncertaintyTest):
    def test_fields_of_points_and_cells(self):
        self.noisy()
        self.run_cli("convert", "a.csv", "a.las")
        for words, name in [(self.SIGMAS, "lod95"), ((*self.SIGMAS, "--confidence", "0.999"), "lod99_9"),
                            (("--lod", "0.1"), "lod")]:
            self.run_cli("compare", "a.las", "b.csv", "-o", "out", *words)
            for file in ["points_a.las", "points_a.ply", "points_b.ply", "difference.ply"]:
                info = json.loads(self.run_cli("info", "out/" + file, "--json", "-").stdout)["files"][0]
                self.assertLessEqual({name, "significant"}, set(info["attributes"]), file)
        for surface, file in [("overlay", "difference.ply"), ("both", "difference_overlay.ply")]:  # a level that varies
            self.run_cli("compare", "a.csv", "b.csv", "-o", "cells", "--surface", surface, "--sigma1", "@noise", "--sigma2", "0.1")
            info = self.result("info", "cells/" + file)["files"][0]
            self.assertLessEqual({"lod95", "significant"}, set(info["attributes"]), file)
        u = [self.uncertainty("--surface", surface, "--sigma1", "@noise", "--sigma2", "0.1")["thresholded"]
             for surface in ["common", "overlay"]]
        self.assertNotEqual(*u)
        self.run_cli("convert", "out/points_a.ply", "points.csv")
        header, *rows = self.path("points.csv").read_text().splitlines()
        names = header.replace(",", " ").split()
        judged = 0
        for row in rows:
            values = dict(zip(names, map(float, row.replace(",", " ").split())))
            if values["dz_abs"] == values["dz_abs"]:
                judged += 1
                self.assertEqual(values["lod"], 0.1)
                self.assertEqual(values["significant"], values["dz_abs"] > 0.1)
            else:
                self.assertNotEqual(values["significant"], values["significant"])
        self.assertGreater(judged, 300)

    def test_report_and_map(self):
        self.noisy()
        self.run_cli("compare", "a.csv", "b.csv", "-o", "plain")
        self.run_cli("compare", "a.csv", "b.csv", "-o", "told", *self.SIGMAS, "--uncertainty-model", "independent")
        plain, told = (self.path(folder + "/report.html").read_text() for folder in ["plain", "told"])
        self.assertIn("none is claimed here", plain)
        self.assertNotIn("none is claimed here", told)
        self.assertIn("The net change is not distinguishable from zero at 95 %", told)
        self.assertIn("uncertainty.interval_net.0", told)
        self.assertNotEqual(*(self.path(folder + "/difference.png").read_bytes() for folder in ["plain", "told"]))


class FailAbove(UncertaintyTest):
    def test_each_statistic_acts(self):
        """Just under its value each ends the run with 6, just over it the run passes."""
        self.noisy(lift=0.02)
        r = self.result("compare", "a.csv", "b.csv", "--lod", "0.05")
        d, v = r["difference"], r["volume"]
        values = {"rho": r["measure"]["rho"], "mean": d["mean"], "median": d["median"], "rms": d["rms"], "std": d["std"],
                  "nmad": d["nmad"], "net": v["net"], "above": v["above"], "below": v["below"], "absolute": v["absolute"],
                  "max": max(d["max_above"], d["max_below"]),
                  "significant_area": r["uncertainty"]["significant_area"],
                  **{"p" + level: value for level, value in d["abs_percentiles"].items()}}
        for name, value in values.items():
            with self.subTest(name=name):
                self.assertNotEqual(value, 0)
                words = ("compare", "a.csv", "b.csv", "--lod", "0.05", "--fail-above")
                self.run_cli(*words, f"{name}={abs(value) * 1.0001}")
                self.assertIn(name, self.run_cli(*words, f"{name}={abs(value) * 0.9999}", code=6).stderr)

    def test_any_percentile(self):
        self.noisy(lift=0.02)
        words = ("compare", "a.csv", "b.csv")
        d = self.result(*words, "--fail-above", "p97.5=9", "--fail-above", "p1=9,p95=9")["difference"]
        self.assertEqual(list(d["abs_percentiles"]), ["1", "50", "90", "95", "97.5", "99"])
        self.assertEqual(sorted(d["abs_percentiles"].values()), list(d["abs_percentiles"].values()))
        for level in ["1", "97.5"]:
            value = d["abs_percentiles"][level]
            self.run_cli(*words, "--fail-above", f"p{level}={value * 1.0001}")
            self.assertIn(f"p{level}", self.run_cli(*words, "--fail-above", f"p{level}={value * 0.9999}", code=6).stderr)
        self.run_cli(*words, "--fail-above", "p97.5=9", "-o", "out")
        self.assertIn('data-key="difference.abs_percentiles.97.5"', self.path("out/report.html").read_text())
        self.assertIn("97.5 %", self.run_cli(*words, "--fail-above", "p97.5=9").stdout)

    def test_significant_area_needs_a_level(self):
        self.noisy()
        self.fails(2, "compare", "a.csv", "b.csv", "--fail-above", "significant_area=0.1", says=["--fail-above", "--lod"])


if __name__ == "__main__":
    unittest.main()
