"""isopach compare: rasters, contours, profiles, outlines, cells for ParaView: the files, and what is refused."""

import csv
import json
import math
import re
import struct
import unittest

from support import CliTest


class Layers(CliTest):
    def compare(self, *words, code=0):
        self.scans()
        return self.run_cli("compare", "a.xyz", "b.xyz", "-o", "out", "--no-map", *words, code=code)

    def json(self, name):
        return json.loads(self.path(f"out/{name}").read_text())

    def test_files_are_listed_and_replaced(self):
        self.compare("--raster", "2", "--contours", "0.25", "--profile", "1,1;20,15", "--outlines", "--vtu")
        files = {"difference.tif", "difference.qml", "contours.geojson", "profile.csv", "profile.svg", "outlines.geojson",
                 "cells.vtu"}
        self.assertLessEqual(files, set(self.json("result.json")["outputs"]))
        there = {path.name for path in self.path("out").iterdir()}
        self.assertLessEqual(files, there)
        self.assertEqual(there, set(self.json("result.json")["outputs"]))  # GDAL leaves nothing beside
        self.compare()
        self.assertFalse(files & {path.name for path in self.path("out").iterdir()})

    def test_the_raster_is_one_again(self):
        self.compare("--raster", "0.5")
        told = self.run_cli("info", "out/difference.tif").stdout
        self.assertIn("6 bands" if "lod" in told else "4 bands", told)
        r = self.json("result.json")
        self.run_cli("convert", "out/difference.tif", "d.csv")
        with open(self.path("d.csv"), newline="") as file:
            rows = list(csv.reader(file))[1:]
        mean = sum(float(row[2]) for row in rows) / len(rows)
        self.assertAlmostEqual(mean, r["difference"]["mean"], delta=0.02)
        for row in rows[:50]:
            self.assertAlmostEqual(float(row[0]) % 0.5, 0.25)

    def test_contours_lie_where_the_difference_is_theirs(self):
        self.compare("--contours", "0.25")
        features = self.json("contours.geojson")["features"]
        self.assertGreater(len(features), 3)
        for feature in features:
            self.assertEqual(feature["properties"]["d"] % 0.25, 0)
            self.assertEqual(feature["geometry"]["type"], "LineString")

    def test_profiles_by_words_and_by_files(self):
        line = [[1.5, 2], [12, 9.25], [20, 4]]
        self.compare("--profile", ";".join(f"{x},{y}" for x, y in line))
        first = self.path("out/profile.csv").read_text()
        rows = list(csv.DictReader(first.splitlines()))
        self.assertAlmostEqual(float(rows[-1]["s"]), sum(math.dist(p, q) for p, q in zip(line, line[1:])), places=9)
        self.assertEqual([float(rows[0]["x"]), float(rows[0]["y"])], line[0])
        for row in rows:
            self.assertAlmostEqual(float(row["d"]), float(row["z_b"]) - float(row["z_a"]), places=12)
        self.path("line.txt").write_text("".join(f"{x} {y}\n" for x, y in line))
        self.path("line.csv").write_text("".join(f"{x},{y}\n" for x, y in line))
        self.path("line.geojson").write_text(json.dumps({"type": "FeatureCollection", "features": [
            {"type": "Feature", "properties": {}, "geometry": {"type": "LineString", "coordinates": line}}]}))
        for name in ("line.txt", "line.csv", "line.geojson"):
            self.compare("--profile", name)
            self.assertEqual(self.path("out/profile.csv").read_text(), first)
        self.assertTrue(self.path("out/profile.svg").read_text().startswith("<svg xmlns"))

    def test_the_cells_are_those_of_the_domain(self):
        self.compare("--vtu", "--lod", "0.1")
        data = self.path("out/cells.vtu").read_bytes()
        head, appended = data.split(b'<AppendedData encoding="raw">\n_', 1)
        points, cells = (int(re.search(rb'%s="(\d+)"' % name, head).group(1)) for name in (b"NumberOfPoints", b"NumberOfCells"))
        arrays = {}
        for kind, name, offset in re.findall(rb'type="(\w+)" Name="(\w+)" NumberOfComponents="\d" format="appended" '
                                             rb'offset="(\d+)"', head):
            at = int(offset)
            size = struct.unpack_from("<Q", appended, at)[0]
            code = {b"Float64": "d", b"Int64": "q", b"UInt8": "B"}[kind]
            arrays[name.decode()] = struct.unpack_from(f"<{size // struct.calcsize(code)}{code}", appended, at + 8)
        self.assertEqual(set(arrays), {"points", "connectivity", "offsets", "types", "d", "z_a", "z_b", "lod"})
        self.assertEqual([len(arrays["points"]), len(arrays["connectivity"])], [3 * points, 3 * cells])
        self.assertEqual(arrays["offsets"], tuple(range(3, 3 * cells + 1, 3)))
        self.assertEqual(set(arrays["types"]), {5})
        xyz, d = arrays["points"], arrays["d"]
        area = net = 0
        for k in range(cells):
            a, b, c = arrays["connectivity"][3 * k:3 * k + 3]
            part = ((xyz[3 * b] - xyz[3 * a]) * (xyz[3 * c + 1] - xyz[3 * a + 1]) -
                    (xyz[3 * b + 1] - xyz[3 * a + 1]) * (xyz[3 * c] - xyz[3 * a])) / 2
            area, net = area + part, net + part * (d[a] + d[b] + d[c]) / 3
        r = self.json("result.json")
        self.assertAlmostEqual(area, r["domain"]["area"], places=9)
        self.assertAlmostEqual(net, r["volume"]["net"], places=9)

    def test_outlines(self):
        self.compare("--outlines")
        r = self.json("result.json")
        domain, a, b = self.json("outlines.geojson")["features"]
        self.assertAlmostEqual(domain["properties"]["area"], r["domain"]["area"], places=6)
        self.assertEqual([a["properties"]["name"], b["properties"]["name"]], ["footprint_a", "footprint_b"])

    def test_vectors_in_other_formats(self):
        asked = ("--outlines", "--contours", "0.5", "--changes", "--lod", "0.1")
        self.compare(*asked)
        r = self.json("result.json")
        for kind in ("gpkg", "fgb"):
            self.compare("--vectors", kind, *asked)
            there = {path.name for path in self.path("out").iterdir()}
            self.assertLessEqual({f"outlines.{kind}", f"contours.{kind}", f"changes.{kind}"}, there)
            self.assertFalse({"outlines.geojson", "contours.geojson", "changes.geojson"} & there)
            inside = self.result("compare", "a.xyz", "b.xyz", "--budget", f"out/outlines.{kind}")
            row = next(row for row in inside["budget"] if row["name"] == "domain")
            self.assertAlmostEqual(row["polygon_area"], r["domain"]["area"], places=6)
            changes = self.result("compare", "a.xyz", "b.xyz", "--budget", f"out/changes.{kind}")["budget"]
            self.assertEqual(len(changes), len(r["changes"]))
            self.assertIn(f"changes.{kind}", self.path("out/report.html").read_text().split("<h2>Changes as objects")[1])
            for row, change in zip(changes, r["changes"]):
                self.assertAlmostEqual(row["net"], change["net"], places=6)
        self.fails(2, "compare", "a.xyz", "b.xyz", "--vectors", "gpkg", says=["--vectors", "--output"])
        self.fails(2, "compare", "a.xyz", "b.xyz", "--vectors", "shp", says=["--vectors", "shp"])

    def test_the_same_for_any_threads(self):
        asked = ["--raster", "1", "--contours", "0.25", "--profile", "1,1;20,15", "--outlines", "--vtu"]
        contents = []
        for threads in ("1", "3"):
            self.compare(*asked, "--threads", threads)
            contents.append({path.name: path.read_bytes() for path in self.path("out").iterdir()
                             if path.suffix not in (".json", ".html")})
        self.assertEqual(*contents)

    def test_refused(self):
        self.scans()
        self.fails(2, "compare", "a.xyz", "b.xyz", "--outlines", says=["--outlines", "--output"])
        self.fails(2, "compare", "a.xyz", "b.xyz", "--vtu", says=["--vtu", "--output"])
        layers = [("--raster", "1"), ("--contours", "1"), ("--profile", "1,1;5,5"), ("--outlines",), ("--vtu",)]
        for words in layers:
            self.fails(2, "compare", "a.xyz", "b.xyz", *words, says=[words[0], "--output"])
            if words[0] != "--vtu":
                self.fails(2, "compare", "a.xyz", "b.xyz", "-o", "out", *words, "--direction", "fit", says=[words[0], "--direction"])
        for words in [("--raster", "0"), ("--raster", "-1"), ("--contours", "0"), ("--raster", "1e-9"), ("--contours", "1e-9"),
                      ("--profile", "1,1;2"), ("--profile", ";"), ("--profile", "1,nan;2,2"), ("--profile", "900,900;901,901")]:
            self.fails(2, "compare", "a.xyz", "b.xyz", "-o", "out", *words, says=[words[0]])
        self.path("bad.txt").write_text("1 2\n3 four\n")
        self.path("one.txt").write_text("1 2\n")
        self.path("bad.geojson").write_text("{\"type\": \"Point\", \"coordinates\": [1, 2]}")
        for name in ("bad.txt", "one.txt", "bad.geojson", "nowhere.txt"):
            self.fails(3, "compare", "a.xyz", "b.xyz", "-o", "out", "--profile", name, says=[name])
        self.assertFalse(self.path("out").exists())


if __name__ == "__main__":
    unittest.main()
