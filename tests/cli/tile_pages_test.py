"""Pages, maps and rasters of comparisons in tiles: the same map, view and raster for any tiles; those of compare as near as means are."""

import json
import pathlib
import re
import struct
import unittest
import zlib

from support import CliTest, points


def image(path):
    """Width, height and rows of an RGB PNG."""
    data = pathlib.Path(path).read_bytes()
    assert data[:8] == b"\x89PNG\r\n\x1a\n"
    at, packed, head = 8, b"", None
    while at < len(data):
        size, kind = struct.unpack(">I4s", data[at:at + 8])
        body = data[at + 8:at + 8 + size]
        head = body if kind == b"IHDR" else head
        packed += body if kind == b"IDAT" else b""
        at += size + 12
    width, height, depth, colour = struct.unpack(">IIBB", head[:10])
    assert (depth, colour) == (8, 2), (depth, colour)
    raw, rows, before = zlib.decompress(packed), [], bytearray(3 * width)
    for y in range(height):
        kind, row = raw[y * (3 * width + 1)], bytearray(raw[y * (3 * width + 1) + 1:(y + 1) * (3 * width + 1)])
        for i in range(3 * width):
            left, up, corner = (row[i - 3] if i > 2 else 0), before[i], (before[i - 3] if i > 2 else 0)
            nearest = min((abs(up - corner), 0, left), (abs(left - corner), 1, up), (abs(left + up - 2 * corner), 2, corner))[2]
            row[i] = (row[i] + (0, left, up, (left + up) // 2, nearest)[kind]) & 255
        rows.append(bytes(row))
        before = row
    return width, height, rows


def view_of(page):
    return json.loads(re.search(r'id="view-data">(.*?)</script>', page, re.S).group(1))


def told(page):
    """Names, values and words of all numbers of a page, but of how they were found and how long it took."""
    data = re.findall(r'<data data-key="([^"]*)" value="([^"]*)"[^>]*>(.*?)</data>', page)
    return [row for row in data if not row[0].startswith(("timing_s.", "localisation."))]


class TilePages(CliTest):
    def tiled(self, a, b, tiles, *words, plan=()):
        """The folder of a result in tiles of so many points."""
        job, result = f"job{tiles}", f"tiled{tiles}"
        if not self.path(job).exists():
            self.run_cli("tile", "plan", a, b, "-o", job, "--tile-points", tiles, *plan)
            self.run_cli("tile", "run", job)
        self.run_cli("tile", "reduce", job, "-o", result, *words)
        return self.path(result)

    def terrain(self):
        self.run_cli("simulate", "terrain", "--points", "6000", "-o", "scans")
        return "scans/a.ply", "scans/b.ply"

    def text(self, folder, name="report.html"):
        return (folder / name).read_text()

    def need_gdal(self, a, b):
        done = self.run_cli("compare", a, b, "-o", "probe", "--raster", "5", "--no-map", "--no-cells", "--no-points", code=None)
        if done.returncode != 0 and "GDAL" in done.stderr:
            self.skipTest("GDAL is not there")
        self.assertEqual(done.returncode, 0, done.stderr)

    def test_map_and_view_do_not_depend_on_the_tiles(self):
        a, b = self.terrain()
        maps, views = set(), set()
        for tiles in (100000, 3000, 400):
            folder = self.tiled(a, b, tiles, "--svg", "--map-width", "500")
            maps.add((folder / "difference.png").read_bytes() + (folder / "difference.svg").read_bytes())
            views.add(json.dumps(view_of(self.text(folder))))
            listed = json.loads(self.text(folder, "result.json"))["outputs"]
            self.assertEqual(sorted(listed), sorted(path.name for path in folder.iterdir()))
        self.assertEqual((len(maps), len(views)), (1, 1))

    def test_the_map_is_near_that_of_compare(self):
        a, b = self.terrain()
        look = ["--map-width", "500", "--extent", "412050,5236050,412950,5236950"]  # the same frame, so the same pixels
        folder = self.tiled(a, b, 3000, *look)
        self.run_cli("compare", a, b, "-o", "whole", *look, "--no-cells", "--no-points")
        (width, height, tiled), (*size, whole) = image(folder / "difference.png"), image(self.path("whole/difference.png"))
        self.assertEqual([width, height], size)
        near = coloured = 0
        for y in range(height):
            for x in range(0, 3 * width, 3):
                p, q = tiled[y][x:x + 3], whole[y][x:x + 3]
                near += max(abs(u - v) for u, v in zip(p, q)) <= 24
                coloured += max(p) - min(p) > 60
        self.assertGreater(near, 0.97 * width * height)
        self.assertGreater(coloured, 0.01 * width * height)

    def test_numbers_of_the_page_are_those_of_compare(self):
        a, b = self.terrain()
        page = self.text(self.tiled(a, b, 3000))
        self.run_cli("compare", a, b, "-o", "whole", "--no-cells", "--no-points")
        whole = self.path("whole/report.html").read_text()
        self.assertGreater(len(told(page)), 25)
        self.assertEqual(told(page), told(whole))
        self.assertEqual((self.path("tiled3000/histogram.csv")).read_bytes(), self.path("whole/histogram.csv").read_bytes())
        self.assertRegex(page, r"Map and view are drawn by means over squares of [\d.]+\u00a0m; all numbers are of the cells")
        self.assertRegex(view_of(page)["drawn"], r"^drawn by means over squares of ")
        self.assertNotIn("drawn", view_of(whole))
        self.assertNotIn("drawn by means", re.sub(r"<script.*?</script>", "", whole, flags=re.S))

    def test_the_raster_is_that_of_compare(self):
        """Byte for byte: of whole scans, of one with a hole, of scans that only meet."""
        self.write("a.xyz", points(1, n=900))
        self.write("b.xyz", points(2, n=1100, lift=0.5))
        self.write("hole.xyz", [p for p in points(2, n=1500, lift=0.5) if (p[0] - 12) ** 2 + (p[1] - 9) ** 2 > 16])
        self.write("far.xyz", points(3, n=900, shift=15.0))
        self.need_gdal("a.xyz", "b.xyz")
        for b in ("b.xyz", "hole.xyz", "far.xyz"):
            for words in ([], ["--border", "hull"]):
                self.run_cli("compare", "a.xyz", b, "-o", "whole", "--raster", "0.7", "--no-map", "--no-cells", "--no-points", *words)
                expected = self.path("whole/difference.tif").read_bytes()
                for tiles in (100000, 300, 40):
                    with self.subTest(b, words=words, tiles=tiles):
                        job = f"job{tiles}{b}{''.join(words)}"
                        self.run_cli("tile", "plan", "a.xyz", b, "-o", job, "--tile-points", tiles, *words)
                        self.run_cli("tile", "run", job)
                        self.run_cli("tile", "reduce", job, "-o", "tiled", "--raster", "0.7", "--no-map")
                        self.assertEqual(self.path("tiled/difference.tif").read_bytes(), expected)
                        self.assertTrue(self.path("tiled/difference.qml").exists())

    def test_a_hole_of_both_scans_is_not_hatched(self):
        """The squares do not tell who scanned it: nothing is said."""
        def ring(n, lift, name):
            self.write(name, [p for p in points(n, n=3000, lift=lift) if (p[0] - 12) ** 2 + (p[1] - 9) ** 2 > 16])
        ring(1, 0, "a.xyz"), ring(2, 0.5, "b.xyz")
        folder = self.tiled("a.xyz", "b.xyz", 400, "--svg", "--map-width", "500")
        self.assertNotIn("points of one scan only", self.text(folder, "difference.svg"))
        width, height, rows = image(folder / "difference.png")
        colours = {rows[y][x:x + 3] for y in range(height) for x in range(0, 3 * width, 3)}
        self.assertNotIn(bytes([204, 204, 203]), colours)  # the hatching

    def test_options_of_page_and_map(self):
        a, b = self.terrain()
        extent = "412200,5236300,412700,5236800"
        folder = self.tiled(a, b, 3000, "--title", "Hang <1>", "--author", "N. N.", "--extent", extent, "--range", "5",
                            "--palette", "purple-orange", "--report", "short", "--pdf", "short.pdf", "--svg")
        page, svg = self.text(folder), self.text(folder, "difference.svg")
        for text in (page, svg):
            self.assertIn("Hang &lt;1&gt;", text)
            self.assertIn("N. N.", text)
        self.assertIn("The map is drawn by means over squares", page)
        self.assertIn("the frame leaves out part of what was compared", svg)
        self.assertTrue(self.path("short.pdf").read_bytes().startswith(b"%PDF-"))

    def test_without_a_map(self):
        a, b = self.terrain()
        folder = self.tiled(a, b, 3000, "--no-map", "--report-vertices", "0")
        self.assertEqual(sorted(path.name for path in folder.iterdir()), ["histogram.csv", "report.html", "result.json"])
        self.assertNotIn("drawn by means", self.text(folder))
        folder = self.tiled(a, b, 3000, "--no-map", "--report", "short")
        self.assertNotIn("drawn by means", self.text(folder))

    def test_what_is_refused(self):
        a, b = self.terrain()
        self.tiled(a, b, 3000)
        self.fails(2, "tile", "reduce", "job3000", "-o", "none", "--extent", "0,0,1,1", says=["--extent", "do not reach into it"])
        self.fails(2, "tile", "reduce", "job3000", "--svg", says=["--svg", "--output"])
        self.fails(2, "tile", "reduce", "job3000", "-o", "none", "--raster", "1e-6", says=["--raster", "larger step"])
        for option in (["--contours", "1"], ["--profile", "0,0;1,1"], ["--outlines"], ["--vtu"]):
            self.fails(2, "tile", "reduce", "job3000", "-o", "none", *option, says=[option[0]])
            self.fails(2, "compare", a, b, "-o", "none", "--max-memory", "1M", *option, says=[option[0], "in tiles"])


if __name__ == "__main__":
    unittest.main()
