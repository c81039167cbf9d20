"""isopach compare --changes: the objects, their files, and what is refused."""

import csv
import json
import random
import unittest

from support import CliTest

LEVEL = ["--sigma1", "0.02", "--sigma2", "0.02", "--uncertainty-model", "independent"]


class Changes(CliTest):
    def scene(self, origin=(0, 0), shuffle=None):
        """A plane with a block of 3 x 2 x 1.5 with steep flanks, and a pit of 2 x 2 x 1; noise in the third decimal."""
        numbers = random.Random(11)

        def height(x, y):
            block = min(1.0, max(0.0, 10 * min(x - 4, 7 - x, y - 5, 7 - y)))
            pit = min(1.0, max(0.0, 10 * min(x - 12, 14 - x, y - 3, 5 - y)))
            return 1.5 * block - pit

        for name, of in (("a.xyz", lambda x, y: 0.0), ("b.xyz", height)):
            found = []
            for _ in range(6000):
                x, y = round(numbers.uniform(0, 18), 3), round(numbers.uniform(0, 10), 3)
                found.append((origin[0] + x, origin[1] + y, round(0.1 * x + of(x, y) + numbers.gauss(0, 0.01), 4)))
            if shuffle is not None:
                random.Random(shuffle).shuffle(found)
            self.write(name, found)
        return "a.xyz", "b.xyz"

    def test_objects_are_found_with_their_volumes(self):
        self.scene((4500000, 5236000))
        r = self.result("compare", "a.xyz", "b.xyz", "--changes", *LEVEL)
        block, pit = r["changes"][:2]
        self.assertEqual([len(r["changes"]), block["id"], pit["id"]], [2, 1, 2])
        self.assertAlmostEqual(block["net"], 1.5 * 2.9 * 1.9, delta=0.3)
        self.assertAlmostEqual(pit["net"], -1.9 * 1.9, delta=0.25)
        self.assertAlmostEqual(block["centroid"][0], 4500005.5, delta=0.1)
        self.assertAlmostEqual(pit["centroid"][1], 5236004, delta=0.1)
        self.assertEqual([block["below"], pit["above"]], [0, 0])
        self.assertGreater(block["max"], 1.45)
        self.assertLess(pit["max"], -0.98)
        for change in (block, pit):
            self.assertTrue(change["significant"])
            self.assertAlmostEqual(change["significance"], abs(change["net"]) / change["sigma_net"])
            for points in ("points_a", "points_b"):  # 6000 on 180
                self.assertAlmostEqual(change[points] / change["area"], 6000 / 180, delta=8)
            low, high = change["bounds"]["min"], change["bounds"]["max"]
            for k in (0, 1):
                self.assertTrue(low[k] < change["centroid"][k] < high[k])
        s = r["change_summary"]
        self.assertEqual([s["level"], s["height"], s["gained"], s["lost"]], ["lod", None, 1, 1])

    def test_volumes_add_up_to_the_thresholded_gross(self):
        self.scene()
        for r in (self.result("compare", "a.xyz", "b.xyz", "--changes", *LEVEL),
                  self.result("compare", "a.xyz", "b.xyz", "--changes", "--min-change-area", "0", *LEVEL),
                  self.result("compare", "a.xyz", "b.xyz", "--changes", "--min-change-volume", "5", *LEVEL)):
            whole, s = r["uncertainty"]["thresholded"], r["change_summary"]
            self.assertEqual(s["all"]["above"], whole["above"])
            self.assertEqual(s["all"]["below"], whole["below"])
            for key in ("above", "below", "area"):
                self.assertAlmostEqual(s["small"][key] + sum(c[key] for c in r["changes"]), whole[key], places=11)
            volumes = [abs(c["net"]) for c in r["changes"]]
            self.assertEqual(volumes, sorted(volumes, reverse=True))
            frequency = s["frequency"]
            self.assertEqual(frequency["gained"], sorted(frequency["gained"], reverse=True))
            self.assertEqual(frequency["gained"][0] + frequency["lost"][0], len(r["changes"]))
        self.assertEqual([len(r["changes"]), r["change_summary"]["min_volume"]], [1, 5])

    def test_a_height_of_its_own(self):
        self.scene()
        r = self.result("compare", "a.xyz", "b.xyz", "--changes", "--change-height", "1.2")
        self.assertEqual([len(r["changes"]), r["changes"][0]["id"]], [1, 1])
        self.assertEqual([r["change_summary"]["level"], r["change_summary"]["height"]], ["height", 1.2])
        self.assertEqual([r["changes"][0]["sigma_net"], r["changes"][0]["significant"]], [None, None])
        self.assertEqual(r["uncertainty"]["thresholded"], None)

    def test_the_files(self):
        self.scene((500000, 5200000))
        text = self.run_cli("compare", "a.xyz", "b.xyz", "--changes", *LEVEL, "-o", "out", "--map-width", "400").stdout
        self.assertIn("changes ", text)
        r = json.loads(self.path("out/result.json").read_text())
        self.assertLessEqual({"changes.csv", "changes.geojson"}, set(r["outputs"]))
        with open(self.path("out/changes.csv"), newline="") as file:
            rows = list(csv.DictReader(file))
        self.assertEqual([float(row["net"]) for row in rows], [c["net"] for c in r["changes"]])
        self.assertEqual([row["change"] for row in rows], ["gained", "lost"])
        outlines = json.loads(self.path("out/changes.geojson").read_text())["features"]
        for feature, change in zip(outlines, r["changes"], strict=True):
            self.assertEqual(feature["properties"]["net"], change["net"])
            self.assertEqual(feature["geometry"]["type"], "Polygon")
            area = 0
            for ring in feature["geometry"]["coordinates"]:
                self.assertEqual(ring[0], ring[-1])
                x0, y0 = ring[0]
                area += sum((p[0] - x0) * (q[1] - y0) - (q[0] - x0) * (p[1] - y0) for p, q in zip(ring, ring[1:])) / 2
            self.assertAlmostEqual(area, change["area"], places=6)
        page = self.path("out/report.html").read_text()
        self.assertIn("Changes as objects", page)
        self.assertIn('data-key="changes.1.net"', page)
        self.run_cli("compare", "a.xyz", "b.xyz", "-o", "out")
        self.assertFalse(self.path("out/changes.csv").exists())
        self.assertNotIn("changes", json.loads(self.path("out/result.json").read_text()))

    def test_the_order_of_points_and_the_threads_do_not_matter(self):
        self.scene()
        asked = ["--changes", *LEVEL, "--min-change-area", "0"]
        one = self.result("compare", "a.xyz", "b.xyz", *asked, "--threads", "1")
        self.scene(shuffle=5)
        other = self.result("compare", "a.xyz", "b.xyz", *asked, "--threads", "3")
        self.assertEqual(one["changes"], other["changes"])
        self.assertEqual(one["change_summary"], other["change_summary"])
        swapped = self.result("compare", "b.xyz", "a.xyz", *asked)
        self.assertEqual([-c["net"] for c in swapped["changes"]], [c["net"] for c in one["changes"]])

    def test_the_surfaces_and_the_border_make_no_difference_to_sums(self):
        self.scene()
        ring = [[3.3, 2.1], [13.1, 2.7], [13.4, 6.3], [3.9, 6.1], [3.3, 2.1]]
        self.path("p.geojson").write_text(json.dumps({"type": "Polygon", "coordinates": [ring]}))
        for more in (["--include", "p.geojson"], ["--exclude", "p.geojson"], ["--surface", "both"], ["--border", "hull"],
                     ["--uncertainty-model", "correlated", "--correlation-range", "2"],
                     ["--uncertainty-model", "registration", "--registration-error", "0.01"]):
            level = LEVEL[:4] if "--uncertainty-model" in more else LEVEL
            r = self.result("compare", "a.xyz", "b.xyz", "--changes", *level, *more)
            self.assertEqual(r["change_summary"]["all"]["above"], r["uncertainty"]["thresholded"]["above"])
            self.assertTrue(all(c["sigma_net"] > 0 for c in r["changes"]))

    def test_refused(self):
        a, b = self.scans()
        self.fails(2, "compare", a, b, "--changes", says=["--changes", "--lod", "--change-height"])
        self.fails(2, "compare", a, b, "--change-height", "1", says=["--change-height", "--changes"])
        self.fails(2, "compare", a, b, "--min-change-area", "1", says=["--min-change-area", "--changes"])
        self.fails(2, "compare", a, b, "--min-change-volume", "1", says=["--min-change-volume", "--changes"])
        for option in ("--change-height", "--min-change-area", "--min-change-volume"):
            self.fails(2, "compare", a, b, "--changes", option, "-1", says=[option])
        self.fails(2, "compare", a, b, "--changes", "--lod", "1", "--surface", "overlay", says=["--changes", "--surface"])
        self.fails(2, "compare", a, b, "--changes", "--lod", "1", "--direction", "fit", says=["--changes", "--direction"])


if __name__ == "__main__":
    unittest.main()
