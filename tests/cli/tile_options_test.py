"""Options of compare that a comparison in tiles keeps: thresholds and changes; those that it cannot have are refused by name."""

import json
import re
import unittest

from support import CliTest


def told(text):
    """A result without what counts the work of one way of doing it."""
    result = json.loads(text)
    result.pop("timing_s"), result.pop("outputs")
    result["localisation"] = {}
    return result


class TileOptions(CliTest):
    def setUp(self):
        super().setUp()
        self.run_cli("simulate", "terrain", "--points", "6000", "-o", "scans")
        self.a, self.b = "scans/a.ply", "scans/b.ply"

    def in_tiles(self, *words, job, points="700"):
        self.run_cli("tile", "plan", self.a, self.b, "-o", job, "--tile-points", points, *words)
        self.run_cli("tile", "run", job)
        return self.run_cli("tile", "reduce", job, "-o", f"{job}-result", "--json", "-")

    def test_a_level_of_detection_and_changes(self):
        cases = [["--lod", "0.2"], ["--lod", "0.2", "--confidence", "0.9"], ["--lod", "0.2", "--changes"],
                 ["--changes", "--change-height", "0.3", "--min-change-area", "0"],
                 ["--changes", "--lod", "0.1", "--change-height", "0.3", "--min-change-volume", "5"],
                 ["--changes", "--lod", "0.2", "--duplicates", "max", "--border", "hull"]]
        for number, words in enumerate(cases):
            with self.subTest(words):
                whole = self.run_cli("compare", self.a, self.b, "--json", "-", "-o", f"whole{number}", "--no-map",
                                     "--no-cells", "--no-points", *words)
                tiled = self.in_tiles(*words, job=f"job{number}", points=["700", "3000", "30"][number % 3])
                self.assertEqual(told(tiled.stdout), told(whole.stdout))
                if "--changes" not in words:
                    self.assertGreater(told(tiled.stdout)["uncertainty"]["thresholded"]["area"], 0)
                    continue
                self.assertGreater(len(told(tiled.stdout)["changes"]), 0)
                for name in ["changes.csv", "changes.geojson"]:
                    self.assertEqual(self.path(f"job{number}-result/{name}").read_bytes(),
                                     self.path(f"whole{number}/{name}").read_bytes(), name)
                    self.assertIn(name, json.loads(tiled.stdout)["outputs"])

    def test_the_raster_has_the_level(self):
        self.run_cli("tile", "plan", self.a, self.b, "-o", "job", "--tile-points", "2000", "--lod", "0.2")
        self.run_cli("tile", "run", "job")
        done = self.run_cli("tile", "reduce", "job", "-o", "tiled", "--raster", "20", code=None)
        if done.returncode != 0 and "GDAL" in done.stderr:
            self.skipTest("GDAL is not there")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.run_cli("compare", self.a, self.b, "-o", "whole", "--raster", "20", "--lod", "0.2", "--no-map",
                     "--no-cells", "--no-points")
        bands = [re.findall(rb'role="description">([^<]*)<', self.path(f"{folder}/difference.tif").read_bytes())
                 for folder in ("tiled", "whole")]
        self.assertEqual(bands[0], [b"d", b"coverage", b"z_a", b"z_b", b"lod", b"significance"])
        self.assertEqual(bands[0], bands[1])

    def test_refusals_name_the_option(self):
        self.path("area.geojson").write_text(json.dumps(
            {"type": "Polygon", "coordinates": [[[412100, 5236100], [412500, 5236100], [412500, 5236500], [412100, 5236100]]]}))
        for words in [["--sigma1", "0.1", "--sigma2", "0.1"], ["--include", "area.geojson"], ["--exclude", "area.geojson"],
                      ["--budget", "area.geojson"], ["--mask", "area.geojson"]]:
            with self.subTest(words):
                self.fails(2, "tile", "plan", self.a, self.b, "-o", "job", *words, says=[words[0], "tiles"])
                self.assertFalse(self.path("job").exists())
        self.fails(2, "tile", "plan", self.a, self.b, "-o", "job", "--changes", says=["--changes", "--lod"])
        self.fails(2, "tile", "plan", self.a, self.b, "-o", "job", "--changes", "--lod", "1", "--direction=x",
                   says=["--changes", "--direction z"])
        self.assertFalse(self.path("job").exists())


if __name__ == "__main__":
    unittest.main()
