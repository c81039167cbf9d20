"""What a comparison in tiles writes beside its page (tile_pages_test.py): rasters, pages for clients, all of it of large scans."""

import random
import unittest

from support import CliTest


class TileOutputs(CliTest):
    def setUp(self):
        super().setUp()
        self.run_cli("simulate", "terrain", "--points", "9000", "-o", "scans")
        self.scans = ["scans/a.ply", "scans/b.ply"]

    def job(self, name, points, *words):
        self.run_cli("tile", "plan", *self.scans, "-o", name, "--tile-points", str(points), *words)
        self.run_cli("tile", "run", name)

    def has_rasters(self, *words):
        done = self.run_cli(*words, code=None)
        if done.returncode != 0 and "GDAL" in done.stderr:
            self.skipTest("GDAL is not there")
        self.assertEqual(done.returncode, 0, done.stderr)

    def test_rasters_are_those_of_the_whole_to_the_byte(self):
        level = ["--lod", "0.2"]
        self.has_rasters("compare", *self.scans, "-o", "whole", "--raster", "7", "--no-map", "--no-cells", "--no-points", *level)
        for points in (9000, 400):
            self.job(f"job{points}", points, *level)
            self.run_cli("tile", "reduce", f"job{points}", "-o", f"out{points}", "--raster", "7", "--no-map")
            for file in ("difference.tif", "difference.qml"):
                self.assertEqual(self.path(f"out{points}/{file}").read_bytes(), self.path(f"whole/{file}").read_bytes(), file)

    def test_pages_for_clients(self):
        self.job("job", 4000)
        self.run_cli("tile", "reduce", "job", "-o", "out", "--report", "short", "--pdf", "two.pdf", "--svg", "--title", "Slide & pit",
                     "--author", "A. Surveyor", "--range", "5", "--extent", "412200,5236200,412700,5236700")
        page = self.path("out/report.html").read_text()
        self.assertIn("Slide &amp; pit", page)
        self.assertIn("A. Surveyor", page)
        self.assertTrue(self.path("two.pdf").read_bytes().startswith(b"%PDF"))
        self.assertIn("<svg", self.path("out/difference.svg").read_text())
        self.fails(2, "tile", "reduce", "job", "-o", "far", "--extent", "0,0,1,1", says=["--extent", "do not reach"])
        self.assertFalse(self.path("far").exists())

    def test_ground_narrower_than_squares_is_drawn(self):
        """A corridor across the box of the scans, and a frame far larger than they are."""
        for name, lift in (("a", 0.0), ("b", 0.3)):
            chance = random.Random(name)
            rows = []
            for _ in range(6000):
                s, t = chance.uniform(0, 2000), chance.uniform(-0.6, 0.6)
                rows.append((0.8 * s - 0.6 * t, 0.6 * s + 0.8 * t, lift))
            self.write(f"{name}.xyz", rows)
        self.scans = ["a.xyz", "b.xyz"]
        self.job("job", 5000)
        for words in ([], ["--extent=-1e9,-1e9,1e9,1e9"]):
            self.run_cli("tile", "reduce", "job", "-o", "out", *words)
            self.assertIn('id="view-data"', self.path("out/report.html").read_text())

    def test_large_scans_have_them_too(self):
        self.run_cli("simulate", "terrain", "--points", "1200000", "-o", "large")
        self.run_cli("compare", "large/a.ply", "large/b.ply", "--max-memory", "310M", "-o", "out", "--quiet")
        self.assertTrue(self.path("out/difference.png").exists())
        self.assertIn("drawn by means over squares", self.path("out/report.html").read_text())
        for word in ("--outlines", "--vtu", "--contours=1", "--profile=0,0;1,1"):
            self.fails(2, "compare", "large/a.ply", "large/b.ply", "--max-memory", "310M", "-o", "no", word, says=["tiles"])


if __name__ == "__main__":
    unittest.main()
