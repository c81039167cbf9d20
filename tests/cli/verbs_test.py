"""info, simulate, demo, convert, and what all verbs share."""

import json
import struct
import unittest

from support import CliTest, points


class Help(CliTest):
    def test_every_verb(self):
        overview = self.run_cli("--help").stdout
        verbs = ["compare", "match", "distance", "asymmetry", "accuracy", "scanners", "sequence", "combine",
                 "roughness", "info", "simulate", "demo", "convert"]
        for verb in verbs:
            self.assertIn(f"\n  {verb} ", overview)
            text = self.run_cli(verb, "--help").stdout
            for word in [f"Usage: isopach {verb}", "Examples:", "--threads", "--config"]:
                self.assertIn(word, text)
            self.assertLessEqual(max(map(len, text.splitlines())), 120)
            self.assertRegex(self.run_cli(verb, "--version").stdout, r"^isopach \d+\.\d+\.\d+\n$")

    def test_version(self):
        self.assertRegex(self.run_cli("--version").stdout, r"^isopach \d+\.\d+\.\d+\n$")


class Info(CliTest):
    def test_report(self):
        a, b = self.scans()
        run = self.run_cli("info", a, b, "-o", "out", "--json", "copy.json")
        self.assertIn("report: out/report.html", run.stdout)
        self.assertEqual({p.name for p in self.path("out").iterdir()}, {"result.json", "report.html"})
        self.assertEqual(self.path("copy.json").read_text(), self.path("out/result.json").read_text())
        page, files = self.path("out/report.html").read_text(), json.loads(self.path("copy.json").read_text())["files"]
        self.assertLess(len(page), 5e6)
        for i, file in enumerate(files):
            self.assertIn(f'data-key="files.{i}.points" value="{file["points"]}"', page)
        for words in ["data:image/png", "script-src 'sha256-", 'id="view-data"', "coloured by height"]:
            self.assertIn(words, page)
        self.fails(3, "info", "nowhere.ply", "-o", "none", says=["nowhere.ply"])
        self.assertFalse(self.path("none").exists())

    def test_report_of_a_name_that_is_markup(self):
        name = "<img src=x onerror=alert(1)>.xyz"
        self.write(name, points(1))
        self.run_cli("info", name, "-o", "out")
        self.assertNotIn("<img src=x", self.path("out/report.html").read_text())

    def test_numbers(self):
        grid = [(float(x), float(y), 0.5 * x) for x in range(30) for y in range(20)]
        self.write("grid.xyz", grid + [(3.0, 4.0, 9.0)])
        info = self.result("info", "grid.xyz")["files"][0]
        self.assertEqual((info["points"], info["nodes"], info["duplicates"]), (601, 600, 1))
        self.assertEqual(info["bounds"], {"min": [0, 0, 0], "max": [29, 19, 14.5]})
        self.assertEqual(info["spacing"], 1)
        self.assertEqual(info["crs"], None)
        text = self.run_cli("info", "grid.xyz", "grid.xyz").stdout
        self.assertEqual(text.count("grid.xyz\n"), 2)


class Simulate(CliTest):
    def simulate(self, folder, *words):
        self.run_cli("simulate", "terrain", "-o", folder, "--points", "3000", *words)
        return {p.name: p.read_bytes() for p in self.path(folder).iterdir()}

    def test_files_and_seed(self):
        first = self.simulate("one", "--noise", "0.01")
        self.assertEqual(set(first), {"a.ply", "b.ply", "truth.json"})
        self.assertEqual(self.simulate("two", "--noise", "0.01", "--threads", "1"), first)
        self.assertNotEqual(self.simulate("three", "--noise", "0.01", "--seed", "2")["a.ply"], first["a.ply"])
        self.assertNotEqual(self.simulate("four", "--noise", "0.02")["a.ply"], first["a.ply"])
        more = self.simulate("five", "--noise", "0.01", "--points-b", "6000")
        self.assertEqual(more["a.ply"], first["a.ply"])
        self.assertGreater(len(more["b.ply"]), 1.5 * len(first["b.ply"]))
        self.assertNotEqual(self.simulate("six", "--noise", "0.01", "--noise-b", "0.5")["b.ply"], first["b.ply"])
        self.assertEqual(set(self.simulate("seven", "--format", "xyz")), {"a.xyz", "b.xyz", "truth.json"})

    def test_denser_scans_come_closer_to_the_truth(self):
        errors = []
        for points_of_each in [5000, 80000]:
            self.run_cli("simulate", "terrain", "-o", "scans", "--points", points_of_each)
            truth = json.loads(self.path("scans/truth.json").read_text())["volume"]
            volume = self.result("compare", "scans/a.ply", "scans/b.ply")["volume"]
            errors.append([abs(volume[part] / truth[part] - 1) for part in ["above", "below"]])
        for coarse, dense in zip(*errors):
            self.assertLess(dense, coarse / 2)
            self.assertLess(dense, 0.1)

    def test_unknown_names(self):
        self.fails(2, "simulate", "moon", "-o", "out", says=["moon", "terrain"])
        self.fails(2, "simulate", "terrain", "-o", "out", "--variant", "green", says=["green"])
        self.fails(2, "simulate", "terrain", says=["--output"])


class Demo(CliTest):
    def test_report(self):
        run = self.run_cli("demo", "-o", "out", "--points", "5000")
        self.assertIn("out/report.html", run.stdout)
        names = {p.name for p in self.path("out").iterdir()}
        self.assertLessEqual({"report.html", "result.json", "truth.json", "a.ply", "b.ply", "difference.png"}, names)


class Convert(CliTest):
    def test_round_trip(self):
        rows = points(1)
        self.write("a.xyz", rows)
        for extension in ["ply", "pcd", "obj", "csv"]:
            self.run_cli("convert", "a.xyz", f"b.{extension}")
            self.run_cli("convert", f"b.{extension}", "c.xyz")
            back = [tuple(map(float, line.split()[:3])) for line in self.path("c.xyz").read_text().splitlines()
                    if line[:1] not in "#/x"]
            self.assertEqual(back, rows, extension)

    def test_pose(self):
        self.write("a.xyz", points(1))
        self.write("pose.txt", ["0 -1 0 10", "1 0 0 20", "0 0 1 30", "0 0 0 1"])
        self.run_cli("convert", "a.xyz", "b.ply", "--pose", "pose.txt")
        before, after = self.result("info", "a.xyz", "b.ply")["files"]
        low, high = before["bounds"]["min"], before["bounds"]["max"]
        self.assertEqual(after["bounds"]["min"], [10 - high[1], 20 + low[0], 30 + low[2]])

    def test_says_what_the_format_cannot_hold(self):
        self.write("a.csv", ["x,y,z,intensity"] + ["%r,%r,%r,7" % p for p in points(1)])
        self.assertEqual(self.run_cli("convert", "a.csv", "b.ply").stdout, "b.ply: 400 points, 1 attributes\n")
        self.assertEqual(self.run_cli("convert", "a.csv", "b.npy").stdout,
                         "b.npy: 400 points; .npy cannot hold 1 attributes\n")
        self.write("mesh.obj", ["v 0 0 0", "v 1 0 0", "v 0 1 0", "f 1 2 3"])
        self.assertEqual(self.run_cli("convert", "mesh.obj", "b.stl").stdout, "b.stl: 3 points, 1 faces\n")
        self.assertEqual(self.run_cli("convert", "mesh.obj", "b.xyz").stdout,
                         "b.xyz: 3 points; .xyz cannot hold 1 faces\n")

    def test_says_how_las_stores_what_it_stored_otherwise(self):
        """LAS 1.2, point format 3, steps of 0.01, an extra field of 16 bits: none of these stays as it is."""
        record = struct.Struct("<iiiHBBbBHdHHHH")
        extra = b"\0\0" + bytes([3, 0]) + b"range".ljust(188, b"\0")
        vlr = struct.pack("<H16sHH32s", 0, b"LASF_Spec", 4, len(extra), b"") + extra
        header = struct.pack("<4sHHIHH8sBB32s32sHHHIIBHI5I", b"LASF", 0, 0, 0, 0, 0, b"", 1, 2, b"", b"", 0, 0, 227,
                             227 + len(vlr), 1, 3, record.size, 3, 3, 0, 0, 0, 0)
        header += struct.pack("<12d", 0.01, 0.01, 0.01, 0, 0, 0, 10, 0, 10, 0, 1, 0)
        rows = [record.pack(100 * x, 100 * y, 25, 7, 9, 2, 0, 0, 1, 0.5, 1, 2, 3, 400) for x, y in [(0, 0), (10, 0), (0, 10)]]
        self.path("old.las").write_bytes(header + vlr + b"".join(rows))
        lines = self.run_cli("convert", "old.las", "new.las").stdout.splitlines()
        self.assertEqual(lines[1], "stored as LAS 1.4, point format 7, steps of 0.0001, 0.0001 and 0.0001; read from LAS 1.2, "
                         "point format 3, steps of 0.01, 0.01 and 0.01; extra bytes: range as double (was uint16)")
        self.assertEqual(len(self.run_cli("convert", "old.las", "new.ply").stdout.splitlines()), 1)
        again = self.run_cli("convert", "new.las", "again.las").stdout.splitlines()[1]
        self.assertNotIn("read from", again)
        self.assertNotIn("was", again)

    def test_unknown_extension(self):
        self.write("a.xyz", points(1))
        run = self.run_cli("convert", "a.xyz", "b.doc", code=2)
        self.assertIn("b.doc", run.stderr)


if __name__ == "__main__":
    unittest.main()
