"""What a comparison in tiles writes: pages, maps and rasters, the same for any tiling."""

import json
import re
import struct
import unittest
import zlib

from support import CliTest


def pixels_of(png):
    """Width, height, and rows of RGB bytes of a PNG with 8 bits a channel and no interlacing."""
    data, at, packed = png.read_bytes(), 8, b""
    while at < len(data):
        size, kind = struct.unpack_from(">I4s", data, at)
        if kind == b"IHDR":
            width, height = struct.unpack_from(">II", data, at + 8)
        if kind == b"IDAT":
            packed += data[at + 8:at + 8 + size]
        at += 12 + size
    raw, stride = zlib.decompress(packed), 3 * width
    rows, before = [], bytes(stride)
    for y in range(height):
        how, line = raw[y * (stride + 1)], bytearray(raw[y * (stride + 1) + 1:(y + 1) * (stride + 1)])
        for i in range(stride):
            left, up, corner = line[i - 3] if i > 2 else 0, before[i], before[i - 3] if i > 2 else 0
            guess = left + up - corner
            nearest = min((left, up, corner), key=lambda value: abs(guess - value))
            line[i] = (line[i] + (0, left, up, (left + up) // 2, nearest)[how]) & 255
        rows.append(bytes(line))
        before = rows[-1]
    return width, height, rows


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

    def test_page_and_map_stand_beside_the_result(self):
        self.job("job", 3000)
        self.run_cli("tile", "reduce", "job", "-o", "tiled")
        self.run_cli("compare", *self.scans, "-o", "whole")
        self.assertEqual(sorted(file.name for file in self.path("tiled").iterdir()),
                         ["difference.png", "histogram.csv", "report.html", "result.json"])
        pages = [self.path(f"{folder}/report.html").read_text() for folder in ("tiled", "whole")]
        numbers = [dict(re.findall(r'data-key="([^"]+)"[^>]*value="([^"]+)"', page)) for page in pages]
        keys = [key for key in numbers[1] if not key.startswith(("timing", "localisation"))]
        self.assertGreater(len(keys), 20)
        for key in keys:
            self.assertEqual(numbers[0][key], numbers[1][key], key)
        self.assertIn("drawn by means over squares of", pages[0])
        self.assertNotIn("drawn by means over squares", pages[1])
        maps = [pixels_of(self.path(f"{folder}/difference.png")) for folder in ("tiled", "whole")]
        self.assertEqual(maps[0][0], maps[1][0])
        if maps[0][1] == maps[1][1]:
            inside = [(x, y) for x in range(300, 1000, 25) for y in range(300, 1000, 25)]
            far = sum(max(abs(p - q) for p, q in zip(maps[0][2][y][3 * x:3 * x + 3], maps[1][2][y][3 * x:3 * x + 3])) > 60
                      for x, y in inside)
            self.assertLess(far, len(inside) / 10)
        colours = {bytes(maps[0][2][y][3 * x:3 * x + 3]) for x in range(200, 1100, 30) for y in range(250, 1200, 30)}
        self.assertGreater(len(colours), 100)

    def test_any_tiling_gives_the_same_files(self):
        for name, points in (("few", 9000), ("many", 500)):
            self.job(name, points)
            self.run_cli("tile", "reduce", name, "-o", f"{name}-out")
        self.assertEqual(self.path("few-out/difference.png").read_bytes(), self.path("many-out/difference.png").read_bytes())
        views = [re.search(r'<script type="application/json" id="view-data">(.*?)</script>', self.path(f"{name}-out/report.html").read_text(),
                           re.S) for name in ("few", "many")]
        self.assertTrue(all(views))
        self.assertEqual(views[0].group(1), views[1].group(1))

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

    def test_without_map(self):
        self.job("job", 4000)
        self.run_cli("tile", "reduce", "job", "-o", "out", "--no-map", "--report-vertices", "0")
        self.assertEqual(sorted(file.name for file in self.path("out").iterdir()), ["histogram.csv", "report.html", "result.json"])
        outputs = json.loads(self.path("out/result.json").read_text())["outputs"]
        self.assertEqual(sorted(outputs), ["histogram.csv", "report.html", "result.json"])

    def test_large_scans_have_them_too(self):
        self.run_cli("simulate", "terrain", "--points", "1200000", "-o", "large")
        self.run_cli("compare", "large/a.ply", "large/b.ply", "--max-memory", "310M", "-o", "out", "--quiet")
        self.assertTrue(self.path("out/difference.png").exists())
        self.assertIn("drawn by means over squares", self.path("out/report.html").read_text())
        for word in ("--outlines", "--vtu", "--contours=1", "--profile=0,0;1,1"):
            self.fails(2, "compare", "large/a.ply", "large/b.ply", "--max-memory", "310M", "-o", "no", word, says=["tiles"])


if __name__ == "__main__":
    unittest.main()
