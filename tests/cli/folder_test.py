"""A result folder holds one result: what an earlier run left in it goes, and nothing else does."""

import json
import unittest

from support import CliTest


class OneResult(CliTest):
    def setUp(self):
        super().setUp()
        self.a, self.b = self.scans()
        square = {"type": "Polygon", "coordinates": [[[2, 2], [20, 2], [20, 16], [2, 16], [2, 2]]]}
        self.path("field.geojson").write_text(json.dumps(
            {"type": "FeatureCollection", "crs": None,
             "features": [{"type": "Feature", "properties": {"name": "field"}, "geometry": square}]}))

    def names(self, folder="out"):
        return {p.name for p in self.path(folder).iterdir()}

    def compare(self, *words, folder="out"):
        self.run_cli("compare", self.a, self.b, "-o", folder, "--no-map", *words)

    def test_files_the_new_run_does_not_write_are_removed(self):
        self.compare("--budget", "field.geojson", "--surface", "both")
        self.assertLessEqual({"budget.csv", "difference_overlay.ply", "points_a.ply"}, self.names())
        self.path("out/notes.txt").write_text("mine")
        self.path("out/budget.old.csv").write_text("mine")
        self.compare("--no-points")
        self.assertEqual(self.names(), {"difference.ply", "histogram.csv", "report.html", "result.json", "notes.txt",
                                        "budget.old.csv"})
        self.assertEqual(self.path("out/notes.txt").read_text(), "mine")

    def test_another_verb_in_the_same_folder(self):
        self.compare("--budget", "field.geojson")
        self.run_cli("distance", self.a, self.b, "-o", "out", "--measure", "c2c")
        self.assertEqual(self.names(), set(json.loads(self.path("out/result.json").read_text())["outputs"]))

    def test_a_failed_run_removes_nothing(self):
        self.compare("--budget", "field.geojson")
        before = {n: self.path(f"out/{n}").read_bytes() for n in self.names()}
        self.run_cli("compare", self.a, "nowhere.xyz", "-o", "out", code=3)
        self.assertEqual({n: self.path(f"out/{n}").read_bytes() for n in self.names()}, before)

    def test_nothing_outside_the_folder_no_folder_and_no_link(self):
        self.path("out").mkdir()
        self.path("out/sub").mkdir()
        for name in ["precious.txt", "out/sub/deep.txt", "out/real.txt"]:
            self.path(name).write_text("mine")
        self.path("out/link.csv").symlink_to(self.path("precious.txt"))
        outputs = ["../precious.txt", str(self.path("precious.txt")), "sub/deep.txt", "sub", ".", "..", "", "link.csv", 7]
        self.path("out/result.json").write_text(json.dumps({"schema": "isopach.compare/1", "outputs": outputs}))
        self.compare("--no-points", "--no-cells")
        self.assertEqual(self.names(), {"sub", "real.txt", "link.csv", "histogram.csv", "report.html", "result.json"})
        for name in ["precious.txt", "out/sub/deep.txt", "out/real.txt", "out/link.csv"]:
            self.assertEqual(self.path(name).read_text(), "mine", name)

    def test_a_result_of_another_program_lists_nothing(self):
        for text in ['{"schema": "other/1", "outputs": ["mine.csv"]}', '{"outputs": ["mine.csv"]}', "[1", "[]",
                     '{"schema": "isopach.compare/1", "outputs": "mine.csv"}', '{"schema": 3, "outputs": ["mine.csv"]}']:
            with self.subTest(text=text):
                self.path("out").mkdir(exist_ok=True)
                self.path("out/mine.csv").write_text("mine")
                self.path("out/result.json").write_text(text)
                self.compare("--no-points", "--no-cells")
                self.assertIn("mine.csv", self.names())

    def test_inputs_of_the_new_run_stay(self):
        self.run_cli("demo", "plane", "-o", "demo", "--points", "400", "--no-map")
        self.run_cli("compare", "demo/a.ply", "./demo/b.ply", "-o", "demo", "--no-points", "--no-cells", "--no-map")
        self.assertLessEqual({"a.ply", "b.ply"}, self.names("demo"))
        self.assertNotIn("difference.ply", self.names("demo"))

    def test_inputs_named_in_a_config_file_stay(self):
        self.run_cli("match", self.a, self.b, "-o", "out")
        self.path("again.cfg").write_text('pose = "out/pose.txt"\n')
        self.run_cli("compare", self.b, self.a, "--config", "again.cfg", "-o", "out", "--no-map")
        self.assertIn("pose.txt", self.names())
        self.assertNotIn("moved.ply", self.names())
        self.compare()
        self.assertIn("points_a.ply", self.names())

    def test_scenes(self):
        self.run_cli("simulate", "chewing", "-o", "out", "--frames", "3", "--points", "500")
        self.path("out/frame_000.txt").write_text("mine")
        self.run_cli("simulate", "chewing", "-o", "out", "--frames", "2", "--points", "500")
        self.assertEqual(self.names(), {"frame_000.ply", "frame_001.ply", "truth.json", "frame_000.txt"})
        self.run_cli("simulate", "plane", "-o", "out", "--points", "400", "--format", "xyz")
        self.assertEqual(self.names(), {"a.xyz", "b.xyz", "truth.json", "frame_000.txt"})


if __name__ == "__main__":
    unittest.main()
