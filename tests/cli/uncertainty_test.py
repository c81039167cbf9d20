"""isopach compare: options of uncertainty and --fail-above; each acts, and an error names it when it is wrong."""

import json
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
                (2, "--registration-error", ("--uncertainty-model", "registration", *self.SIGMAS))]:
            with self.subTest(words=words):
                self.fails(code, "compare", a, b, *words, says=[says])


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

    def test_significant_area_needs_a_level(self):
        self.noisy()
        self.fails(2, "compare", "a.csv", "b.csv", "--fail-above", "significant_area=0.1", says=["--fail-above", "--lod"])


if __name__ == "__main__":
    unittest.main()
