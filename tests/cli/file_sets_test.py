"""A scan may be a folder, a pattern, a list or a catalogue of tiles: the result is that of one file with all their points."""

import json
import unittest

from support import CliTest


class FileSets(CliTest):
    def setUp(self):
        super().setUp()
        self.a, self.b = self.scans()
        rows = self.path(self.a).read_text().splitlines()
        self.path("tiles").mkdir()
        for k in range(3):
            self.path(f"tiles/{k}.xyz").write_text("\n".join(rows[k::3]) + "\n")
        self.path("list.txt").write_text("# of the first survey\ntiles/2.xyz\ntiles/0.xyz\ntiles/1.xyz\n")
        item = lambda k: {"type": "Feature", "stac_version": "1.0.0", "id": str(k), "assets": {"data": {"href": f"./tiles/{k}.xyz"}}}
        self.path("tiles.vpc").write_text(json.dumps({"type": "FeatureCollection", "features": [item(2), item(1), item(0)]}))

    SETS = ["tiles", "tiles/*.xyz", "list.txt", "tiles.vpc"]

    def test_the_result_is_that_of_one_file(self):
        def numbers(*words):
            result = self.result(*words)
            return {k: v for k, v in result.items() if k not in ("inputs", "timing_s")}, [i["points"] for i in result["inputs"]]

        whole = numbers("compare", self.a, self.b)
        for word in self.SETS:
            with self.subTest(word=word):
                self.assertEqual(numbers("compare", word, self.b), whole)
                self.assertEqual(self.result("compare", word, self.b)["inputs"][0]["path"], word)
        self.assertEqual(self.result("distance", "tiles", self.b)["inputs"][0]["points"],
                         self.result("distance", self.a, self.b)["inputs"][0]["points"])

    def test_info_and_convert(self):
        def points(word):
            return self.result("info", word)["files"][0]["points"]

        for word in self.SETS:
            self.assertEqual(points(word), points(self.a))
        self.run_cli("convert", "tiles", "one.ply")
        self.assertEqual(points("one.ply"), points(self.a))

    def test_results_beside_the_tiles_leave_them_alone(self):
        before = {p.name: p.read_bytes() for p in self.path("tiles").iterdir()}
        outputs = json.dumps({"schema": "isopach.compare/1", "outputs": [*before, "result.json"]})
        self.path("tiles/result.json").write_text(outputs)  # as if an earlier run had written the tiles
        self.run_cli("compare", "tiles/*.xyz", self.b, "-o", "tiles", "--no-map")
        for name, content in before.items():
            self.assertEqual(self.path("tiles/" + name).read_bytes(), content)

    def test_failures_name_what_is_wrong(self):
        self.fails(3, "compare", "tiles/*.las", self.b, says=["tiles/*.las", "no file"])
        self.path("empty").mkdir()
        self.fails(3, "compare", "empty", self.b, says=["empty", "no scan"])
        self.path("gone.txt").write_text("tiles/0.xyz\ntiles/7.xyz\n")
        self.fails(3, "compare", "gone.txt", self.b, says=["gone.txt", "tiles/7.xyz", "no such file"])
        self.path("far.txt").write_text("https://example.com/a.laz\n")
        self.fails(3, "compare", self.a, "far.txt", says=["https://example.com/a.laz", "download"])
        self.path("tiles/3.xyz").write_text("1 2 three\n")
        self.fails(3, "compare", "tiles", self.b, says=["tiles/3.xyz", "line 1"])
        self.fails(3, "compare", "tiles/[012].xyz", self.b, "--max-input", "100", says=["tiles/[012].xyz", "--max-input"])


if __name__ == "__main__":
    unittest.main()
