"""Maps and reports for people who were not there: one range, one frame, author, logo, two pages, SVG, PDF, styles of QGIS."""

import base64
import json
import re
import struct
import unittest
import xml.etree.ElementTree as ElementTree
import zlib

from support import CliTest, points

SVG = "{http://www.w3.org/2000/svg}"


def png(width, height, pixel=(200, 30, 30, 255), declared=None):
    """An RGBA picture of one colour; `declared`: what its head says of its size."""
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    rows = b"".join(b"\0" + bytes(pixel) * width for _ in range(height))
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", *(declared or (width, height)), 8, 6, 0, 0, 0)) +
            chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))


class Picture(CliTest):
    def compare(self, *words, b="b.xyz", code=0):
        if not self.path("a.xyz").exists():
            self.scans()
        return self.run_cli("compare", "a.xyz", b, "-o", "out", "--map-width", "500", "--no-points", "--no-cells",
                            "--report-vertices", "400", *words, code=code)

    def text(self, name):
        return self.path(f"out/{name}").read_text()

    def words_of_map(self, name="difference.svg"):
        return [e.text for e in ElementTree.fromstring(self.text(name)).iter(f"{SVG}text")]

    def panel(self):
        image, = ElementTree.fromstring(self.text("difference.svg")).iter(f"{SVG}image")
        return [image.get(key) for key in ("x", "y", "width", "height")]

    def view_data(self):
        return json.loads(re.search(r'id="view-data">(.*?)</script>', self.text("report.html"), re.DOTALL).group(1))

    def test_one_range_for_results_side_by_side(self):
        self.scans()
        self.write("c.xyz", points(3, n=450, lift=0.8))
        for b in ("b.xyz", "c.xyz"):
            self.compare("--range", "2.5", "--svg", "--raster", "2", b=b)
            words = self.words_of_map()
            for label in ("+2.5", "+1.25", "−1.25", "−2.5"):
                self.assertIn(label, words)
            self.assertTrue(any("colours end at ±2.5" in w and "as asked" in w for w in words))
            self.assertEqual(self.view_data()["limit"], 2.5)
            self.assertIn('classificationMin="-2.5"', self.text("difference.qml"))
            histogram = self.text("report.html").split("How the area is spread over d")[1].split("</figure>")[0]
            self.assertIn(">+2.50<", histogram)
            self.assertIn("all that lies beyond", histogram)

    def test_what_lies_beyond_the_range_is_said(self):
        self.scans(lift=0.5)
        self.compare("--range", "0.4", "--svg")
        words = self.words_of_map()
        self.assertTrue(any(w.startswith("≥") and "+0.4" in w for w in words))
        self.assertTrue(any("differences reach" in w for w in words))
        self.assertRegex(self.text("report.html"), r"About [\d.]+\s% of the area lies below it, [\d.]+\s% above")
        self.compare("--svg")
        self.assertFalse(any("as asked" in w for w in self.words_of_map()))

    def test_ranges_that_are_none(self):
        self.scans()
        for limit in ("0", "-1", "nan", "inf", "wide"):
            self.fails(2, "compare", "a.xyz", "b.xyz", "-o", "out", "--range", limit, says=["--range", limit])

    def test_one_frame_for_results_side_by_side(self):
        self.scans()
        self.write("c.xyz", [p for p in points(3, n=900) if p[0] < 14])
        found = []
        for b in ("b.xyz", "c.xyz"):
            self.compare("--extent", "-2,-3,28,22", "--svg", b=b)
            words = self.words_of_map()
            found.append((self.panel(), [w for w in words if re.fullmatch(r"−?\d+", w)]))
        self.assertEqual(*found)
        self.compare("--extent", "3,3,9,8", "--svg")
        self.assertTrue(any("the frame leaves out part of what was compared" in w for w in self.words_of_map()))

    def test_frames_that_show_nothing(self):
        self.scans()
        for extent, says in [("100,100,200,200", "no point of the scans lies in it"), ("0,0,0,5", "min below max"), ("0,0,5", "--extent"),
                             ("5,0,0,5", "min below max"), ("0,nan,5,5", "nan"), ("0,0,1000,1", "would be a line")]:
            self.fails(2, "compare", "a.xyz", "b.xyz", "-o", "out", "--extent", extent, says=["--extent", says])
        self.fails(2, "compare", "a.xyz", "b.xyz", "-o", "out", "--extent", "0,0,9,9", "--direction", "fit",
                   says=["--extent", "--direction"])
        self.fails(2, "compare", "a.xyz", "b.xyz", "--extent", "0,0,9,9", says=["--extent", "--output"])

    def test_author_date_and_coordinate_system(self):
        self.scans()
        self.compare("--author", "<b>A. Surveyor</b>", "--svg")
        page = self.text("report.html")
        self.assertIn("&lt;b&gt;A. Surveyor&lt;/b&gt; · 2026-01-01", page)
        self.assertNotIn("<b>A. Surveyor", page)
        self.assertTrue(any("<b>A. Surveyor</b>   ·   2026-01-01" in w for w in self.words_of_map()))
        self.assertNotIn("N", self.words_of_map(), "no north where x and y are not known to be those of a map")
        far = [(x + 412000, y + 5236000, z) for x, y, z in points(1)]
        self.write("far.xyz", far)
        self.run_cli("compare", "far.xyz", "far.xyz", "-o", "out", "--unit", "m", "--svg", "--map-width", "500")
        words = self.words_of_map()
        self.assertIn("N", words)
        self.assertTrue(any("no coordinate system named in the files" in w for w in words))
        self.run_cli("compare", "far.xyz", "far.xyz", "-o", "out", "--unit", "mm", "--svg", "--map-width", "500")
        self.assertNotIn("N", self.words_of_map())

    def test_a_logo(self):
        self.scans()
        self.path("logo.png").write_bytes(png(60, 20) + b"<script>alert(1)</script>")
        for report in ("full", "short"):
            self.compare("--logo", "logo.png", "--report", report, "--svg", "--pdf", "logo.pdf")
            page = self.text("report.html")
            pictures = [base64.b64decode(data) for data in re.findall(r'src="data:image/png;base64,([^"]+)"', page)]
            self.assertEqual(len(pictures), 2)
            for picture in pictures:
                self.assertTrue(picture.startswith(b"\x89PNG") and picture.endswith(b"IEND\xaeB`\x82"))
            self.assertEqual(struct.unpack(">II", pictures[0][16:24]), (60, 20))
        images = list(ElementTree.fromstring(self.text("difference.svg")).iter(f"{SVG}image"))
        self.assertEqual(len(images), 2)

    def test_logos_that_are_none(self):
        self.scans()
        good = png(60, 20)
        for name, data, says in [("text.png", b"hello", "no PNG"), ("cut.png", good[:60], "PNG"), ("long.png", good + bytes(1_000_001), "kB"),
                                 ("wide.png", png(2001, 1), "pixels"), ("bomb.png", png(3, 3, declared=(100000, 100000)), "pixels"),
                                 ("wrong.png", good[:45] + b"xxxx" + good[49:], "PNG"), ("empty.png", b"", "empty"),
                                 ("page.svg", b"<svg onload='alert(1)'/>", "no PNG")]:
            self.path(name).write_bytes(data)
            self.fails(3, "compare", "a.xyz", "b.xyz", "-o", "out", "--logo", name, says=[name, says])
        self.path("folder").mkdir()
        self.fails(3, "compare", "a.xyz", "b.xyz", "-o", "out", "--logo", "folder", says=["folder", "--logo"])
        self.fails(3, "compare", "a.xyz", "b.xyz", "-o", "out", "--logo", "nowhere.png", says=["nowhere.png"])

    def test_the_short_report(self):
        self.scans()
        self.compare("--report", "short", "--sigma1", "0.03", "--sigma2", "0.03", "--changes", "--title", "Quarry <north>")
        page = self.text("report.html")
        for absent in ("Options in force", "<script", "Behind the numbers", "timing_s"):
            self.assertNotIn(absent, page)
        for there in ("Quarry &lt;north&gt;", "The numbers", "How sure they are", "level of detection", "The largest changes", "± ",
                      "@page{size:A4", "2026-01-01"):
            self.assertIn(there, page)
        result = json.loads(self.text("result.json"))
        for key, exact in re.findall(r'<data data-key="([^"]+)" value="([^"]+)"', page):
            value = result
            for part in key.split("."):
                value = value[part]
            self.assertEqual(json.loads(exact), value)
        self.compare("--report", "short")
        self.assertIn("No error of the scans was stated", self.text("report.html"))

    def test_pdf(self):
        self.scans()
        words = ("--pdf", "report.pdf", "--sigma1", "0.03", "--sigma2", "0.03", "--changes", "--author", "A. Surveyor")
        self.compare(*words)
        first = self.path("report.pdf").read_bytes()
        self.assertTrue(first.startswith(b"%PDF-1."))
        self.assertEqual(len(re.findall(rb"/Type /Page\b(?!s)", first)), 2)
        self.assertIn(b"/ToUnicode", first)  # its text can be selected and found
        self.assertLess(len(first), 5_000_000)
        self.compare(*words, "--threads", "3")
        self.assertEqual(self.path("report.pdf").read_bytes(), first)
        self.compare("--pdf", "bare.pdf", "--no-map")
        self.assertEqual(len(re.findall(rb"/Type /Page\b(?!s)", self.path("bare.pdf").read_bytes())), 2)

    def test_svg(self):
        self.scans()
        self.compare("--svg", "--changes", "--lod", "0.1", "--title", "A & <B>")
        root = ElementTree.fromstring(self.text("difference.svg"))
        self.assertEqual(root.find(f"{SVG}title").text, "A & <B>")
        self.assertIn("B above A (gained)", self.words_of_map())
        self.assertNotIn("<script", self.text("difference.svg"))
        for link in re.findall(r'(?:href|url)=?[("]+([^")]+)', self.text("difference.svg")):
            self.assertTrue(link.startswith(("data:image/png;base64,", "#")), link[:40])
        self.run_cli("compare", "a.xyz", "b.xyz", "-o", "out", "--svg", "--no-map", "--map-width", "16000")
        self.assertEqual(ElementTree.fromstring(self.text("difference.svg")).get("width"), "2400")
        self.assertLess(self.path("out/difference.svg").stat().st_size, 12_000_000)
        self.assertFalse(self.path("out/difference.png").exists())

    def test_styles_stand_beside_their_layers(self):
        self.compare("--contours", "0.25", "--outlines", "--changes", "--lod", "0.1", "--vectors", "gpkg", "--range", "1")
        outputs = json.loads(self.text("result.json"))["outputs"]
        for name in ("contours", "outlines", "changes"):
            self.assertIn(f"{name}.qml", outputs)
            self.assertIn(f"{name}.gpkg", outputs)
            style = ElementTree.fromstring(self.text(f"{name}.qml"))
            rules = list(style.iter("rule"))
            symbols = {s.get("name") for s in style.iter("symbol")}
            self.assertEqual({r.get("symbol") for r in rules}, symbols)
        filters = [r.get("filter") for r in ElementTree.fromstring(self.text("contours.qml")).iter("rule")]
        self.assertIn('"d" > 0.75', filters)

    def test_other_verbs_have_the_range_and_svg(self):
        self.run_cli("simulate", "accuracy", "--points", "1500", "--points-b", "2500", "-o", "s")
        self.run_cli("accuracy", "s/reconstruction.ply", "s/reference.ply", "--align", "none", "--range", "0.5", "--svg", "-o", "out",
                     "--author", "A. Surveyor", "--map-width", "500", "--report-vertices", "0")
        self.assertTrue(any(w.endswith("+0.5") for w in self.words_of_map("accuracy.svg")))
        self.assertIn("A. Surveyor · 2026-01-01", self.text("report.html"))
        self.fails(2, "accuracy", "s/reconstruction.ply", "s/reference.ply", "--svg", says=["--svg", "--output"])


if __name__ == "__main__":
    unittest.main()
