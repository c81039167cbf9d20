"""What a summary says so that nobody is misled: hints, intervals, digits, coverage, units."""

import json
import math
import random
import re
import unittest

from support import CliTest, hill, points


def rows(seed, n=800, change=lambda x, y: 0.0, noise=0.01):
    numbers = random.Random(seed)
    found = []
    for _ in range(n):
        x, y = numbers.uniform(0, 24), numbers.uniform(0, 18)
        found.append((x, y, hill(x, y) + change(x, y) + numbers.gauss(0, noise)))
    return found


class Said(CliTest):
    def pair(self, change=lambda x, y: 0.0, **options):
        self.write("a.xyz", rows(1, **options))
        self.write("b.xyz", rows(2, change=change, **options))
        return "a.xyz", "b.xyz"

    def warnings(self, *words):
        return self.result(*words)["warnings"]

    def square(self, name, x, y, side, path="p.geojson"):
        ring = [[x, y], [x + side, y], [x + side, y + side], [x, y + side], [x, y]]
        self.path(path).write_text(json.dumps({"type": "FeatureCollection", "features": [
            {"type": "Feature", "properties": {"name": name}, "geometry": {"type": "Polygon", "coordinates": [ring]}}]}))
        return path


class Matching(Said):
    def hints(self, *words):
        return [w for w in self.warnings("compare", "a.xyz", "b.xyz", *words) if "--match" in w]

    def test_an_offset_or_tilt_names_match(self):
        for change, says in [(lambda x, y: 0.5, "a plain offset of 0.499"),
                             (lambda x, y: -0.02 * (x - 12) + 0.03 * (y - 9), "a tilt of 2")]:
            self.pair(change)
            with self.subTest(says=says):
                told = self.hints()
                self.assertEqual(len(told), 1)
                self.assertIn(says, told[0])
                self.assertIn("--match", self.run_cli("compare", "a.xyz", "b.xyz").stdout)

    def test_no_hint_where_a_part_changed_or_nothing_did(self):
        for change in [lambda x, y: 0.0, lambda x, y: 2.0 if x < 9 else 0.0,
                       lambda x, y: 0.3 * math.sin(x / 2) * math.cos(y / 2),
                       lambda x, y: 1.5 * math.exp(-((x - 15) ** 2 + (y - 8) ** 2) / 20)]:
            self.pair(change)
            self.assertEqual(self.hints(), [])

    def test_no_hint_where_it_was_matched(self):
        self.pair(lambda x, y: 0.5)
        self.assertEqual(self.hints("--match"), [])


class Digits(Said):
    MODEL = ("--sigma1", "0.05", "--sigma2", "0.05", "--uncertainty-model", "independent")

    def test_the_interval_of_net_is_in_the_summary(self):
        self.pair(lambda x, y: 0.013)
        text = self.run_cli("compare", "a.xyz", "b.xyz", *self.MODEL).stdout
        u = self.result("compare", "a.xyz", "b.xyz", *self.MODEL)["uncertainty"]
        line = next(line for line in text.splitlines() if line.startswith("  net "))
        found = re.search(r"; 95 %: ([+-][\d.]+) to ([+-][\d.]+)$", line)
        self.assertTrue(found, line)
        for shown, exact in zip(found.groups(), u["interval_net"]):
            self.assertLessEqual(abs(float(shown) - exact), 0.05 * u["sigma_net"])

    def test_no_more_digits_than_sigma_carries(self):
        self.pair(lambda x, y: 0.013)
        self.run_cli("compare", "a.xyz", "b.xyz", *self.MODEL, "-o", "out", "--no-map")
        result = json.loads(self.path("out/result.json").read_text())
        sigma, net = result["uncertainty"]["sigma_net"], result["volume"]["net"]
        self.assertNotEqual(net, round(net, 6))  # JSON keeps all digits
        decimals = 1 - math.floor(math.log10(float("%.1e" % sigma)))
        text = self.run_cli("compare", "a.xyz", "b.xyz", *self.MODEL).stdout
        line = next(line for line in text.splitlines() if line.startswith("  net "))
        self.assertEqual(line.split()[1], "%+.*f" % (decimals, net))
        self.assertIn("standard deviation is %.*f " % (decimals, sigma), text)
        page = self.path("out/report.html").read_text()
        shown = re.findall(r'data-key="volume\.net"[^>]*>([^<]*)<', page)
        self.assertTrue(shown)
        self.assertEqual(set(shown), {"%+.*f" % (decimals, net)})

    def test_large_numbers_are_rounded_before_the_point(self):
        self.write("a.xyz", [(100 * x, 100 * y, z) for x, y, z in rows(1)])
        self.write("b.xyz", [(100 * x, 100 * y, z + 1.0) for x, y, z in rows(2)])
        text = self.run_cli("compare", "a.xyz", "b.xyz", *self.MODEL).stdout
        line = next(line for line in text.splitlines() if line.startswith("  net "))
        self.assertRegex(line, r"net +\+[\d ]+00 units")

    def test_sigmas_without_a_model_say_so(self):
        self.pair()
        told = [w for w in self.warnings("compare", "a.xyz", "b.xyz", *self.MODEL[:4]) if "--uncertainty-model" in w]
        self.assertEqual(len(told), 1)
        self.assertEqual([w for w in self.warnings("compare", "a.xyz", "b.xyz", *self.MODEL) if "--uncertainty-model" in w], [])


class Polygons(Said):
    def test_coverage_is_in_the_summary(self):
        self.pair()
        self.square("half", -4, 2, 8)
        text = self.run_cli("compare", "a.xyz", "b.xyz", "--budget", "p.geojson").stdout
        head, row = text[text.index("by polygon"):].splitlines()[:2]
        self.assertTrue(head.endswith("measured"), head)
        coverage = self.result("compare", "a.xyz", "b.xyz", "--budget", "p.geojson")["budget"][0]["coverage"]
        self.assertTrue(row.endswith("%.1f %%" % (100 * coverage)), row)

    def test_a_polygon_that_nothing_was_measured_in_warns(self):
        self.pair()
        self.square("far", 40, 2, 8)
        told = [w for w in self.warnings("compare", "a.xyz", "b.xyz", "--budget", "p.geojson") if "'far'" in w]
        self.assertEqual(len(told), 1)
        self.assertIn("1 of 1 polygons", told[0])
        self.square("near", 4, 4, 8)
        self.assertEqual([w for w in self.warnings("compare", "a.xyz", "b.xyz", "--budget", "p.geojson") if "polygons" in w], [])

    def test_degrees_beside_projected_scans(self):
        for name in ["a", "b"]:
            self.write(name + ".xyz", [(x + 412000, y + 5236000, z) for x, y, z in rows(ord(name))])
        self.square("lake", 7.84, 47.27, 0.001)
        for option in ["--include", "--exclude", "--budget"]:
            self.fails(3, "compare", "a.xyz", "b.xyz", option, "p.geojson",
                       says=["p.geojson", option, "look like degrees", "reproject"])
        self.square("elsewhere", 400000, 5000000, 10)
        self.fails(4, "compare", "a.xyz", "b.xyz", "--include", "p.geojson", says=["--include"])

    def test_words_of_the_csv_are_those_of_the_summary(self):
        self.pair(lambda x, y: 0.4 if x < 12 else -0.2)
        self.square("all", 2, 2, 12)
        self.run_cli("compare", "a.xyz", "b.xyz", "--budget", "p.geojson", "-o", "out", "--no-map")
        head = self.path("out/budget.csv").read_text().splitlines()[0]
        self.assertEqual(head, "name,gained,lost,net,gross,area,mean,rho,polygon_area,coverage,file")


class Words(Said):
    def test_sigma_that_means_sigma1(self):
        self.pair()
        self.fails(2, "compare", "a.xyz", "b.xyz", "--sigma", "0.05", says=["--sigma:", "--sigma1", "--sigma2"])

    def test_border_is_a_sentence_about_what_was_left_out(self):
        """A line of points far off: thin triangles of great height."""
        far = [(60 + 0.1 * k, 9 + 0.3 * k, 500.0) for k in range(6)]
        self.write("a.xyz", rows(1))
        self.write("b.xyz", rows(2) + far)
        self.write("c.xyz", rows(3) + [(x + 1, y, 0.0) for x, y, _ in far])
        text = self.run_cli("compare", "c.xyz", "b.xyz").stdout
        line = next(line for line in text.splitlines() if line.startswith("  border"))
        self.assertNotIn("of the volume left out", line)
        self.assertIn("bridge places without points; with them,", line)

    def test_no_error_of_an_integral_in_closed_form(self):
        self.pair()
        self.run_cli("compare", "a.xyz", "b.xyz", "-o", "out", "--no-map", "--weight", "1+x")
        text = self.path("out/report.html").read_text()
        self.assertFalse("error of the integral" in text)
        self.assertFalse("error of ρ, weighted" in text)
        self.run_cli("compare", "a.xyz", "b.xyz", "-o", "out", "--no-map", "--interpolation", "cubic")
        self.assertTrue("error of the integral" in self.path("out/report.html").read_text())

    def test_units_are_known_once_unit_says_them(self):
        self.pair()
        self.write("face.xyz", [(x - 12, y, z) for x, y, z in rows(5)])
        runs = [("compare", "a.xyz", "b.xyz"), ("distance", "a.xyz", "b.xyz"), ("match", "b.xyz", "a.xyz"),
                ("accuracy", "a.xyz", "b.xyz", "--align", "none"), ("roughness", "a.xyz"),
                ("scanners", "a.xyz", "b.xyz", "face.xyz", "--align", "none")]
        for words in runs:
            with self.subTest(verb=words[0]):
                run = self.run_cli(*words, "--unit", "mm", "-o", "out")
                shown = run.stdout + run.stderr
                page = self.path("out/report.html")
                if page.exists():
                    shown += re.sub(r"<script.*?</script>|<details.*?</details>", "", page.read_text(), flags=re.S)
                self.assertEqual(re.findall(".{0,40}unknown.{0,40}", shown), [])

    def test_layers_are_named_where_heights_are_used(self):
        """Two sheets above one another: no height field (refused but for --folds keep); pairs of points do not mind."""
        for name, seed in [("a", 1), ("b", 2)]:
            self.write(name + ".xyz", rows(seed, n=3000) + [(x, y, z + 5) for x, y, z in rows(seed + 10, n=3000)])
        layers = lambda *words: [w for w in self.warnings(*words) if "several layers" in w]
        self.fails(4, "compare", "a.xyz", "b.xyz", says=["several layers", "--folds keep"])
        self.assertGreaterEqual(len(layers("compare", "a.xyz", "b.xyz", "--folds", "keep")), 2)


class NoiseFloor(Said):
    def told(self):
        return [w for w in self.warnings("compare", "a.xyz", "b.xyz", "--noise-floor") if "noise floor" in w]

    def test_scans_that_share_their_nodes(self):
        numbers = random.Random(5)
        grid = [(x, y) for x in range(25) for y in range(19)]
        ground = {p: hill(*p) + numbers.gauss(0, 0.2) for p in grid}
        self.write("a.xyz", [(*map(float, p), ground[p]) for p in grid])
        self.write("b.xyz", [(*map(float, p), ground[p] + numbers.gauss(0, 0.01)) for p in grid])
        told = self.told()
        self.assertEqual(len(told), 1)
        self.assertIn("too high", told[0])
        result = self.result("compare", "a.xyz", "b.xyz", "--noise-floor")
        self.assertGreater(result["uncertainty"]["noise_floor"]["rho"], 2 * result["measure"]["rho"])

    def test_scans_of_their_own(self):
        self.pair()
        self.assertEqual(self.told(), [])


if __name__ == "__main__":
    unittest.main()
