"""Differences at the points, tile by tile: those of compare, to the last bit, as sets of points."""

import math
import random
import shutil
import struct
import unittest

from support import CliTest, hill


def bits(value):
    return struct.pack("<d", value) if not math.isnan(value) else b"nan"


class PointFields(CliTest):
    def rows(self, name):
        """Points of a file with dz_signed, ascending."""
        self.run_cli("convert", name, "rows.csv")
        lines = self.path("rows.csv").read_text().splitlines()
        head = lines[0].lstrip("#/ ").split(",")
        columns = [head.index(column) for column in ("x", "y", "z", "dz_signed")]
        found = []
        for line in lines[1:]:
            fields = line.split(",")
            x, y, z, d = (float(fields[column]) for column in columns)
            found.append((round(x, 6), round(y, 6), round(z, 6), bits(d)))  # LAS has the sum of an offset and steps
        return found

    def check(self, a, b, *words, tiles=("30", "200", "100000")):
        """Gives how many points have a difference, of A and of B."""
        self.write("a.xyz", a), self.write("b.xyz", b)
        self.run_cli("compare", "a.xyz", "b.xyz", "-o", "whole", "--no-map", "--no-cells", *words)
        whole = {key: sorted(self.rows(f"whole/points_{key}.ply")) for key in "ab"}
        for points in tiles:
            with self.subTest(tiles=points, words=words):
                self.run_cli("tile", "plan", "a.xyz", "b.xyz", "-o", f"job{points}", "--tile-points", points, *words)
                self.run_cli("tile", "run", f"job{points}")
                self.run_cli("tile", "reduce", f"job{points}", "-o", "result", "--no-map", "--report-vertices", "0", "--points")
                for key in "ab":
                    found = [row for path in sorted(self.path("result").glob(f"points_{key}_*.laz")) for row in self.rows(path)]
                    self.assertEqual(sorted(found), whole[key])
                shutil.rmtree(self.path(f"job{points}"))
        return [sum(row[3] != b"nan" for row in whole[key]) for key in "ab"]

    def random(self, seed, n, x0=0.0, x1=24.0, lift=0.0):
        chance = random.Random(seed)
        found = []
        for _ in range(n):
            x, y = round(chance.uniform(x0, x1), 3), round(chance.uniform(0, 18), 3)
            found.append((x, y, round(hill(x, y) + lift + chance.uniform(0, 0.01), 3)))
        return found

    def test_random_points(self):
        counts = self.check(self.random(1, 500), self.random(2, 700, lift=0.5))
        self.assertGreater(min(counts), 400)

    def test_a_part_of_the_other(self):
        """Most of A lies beyond the hull of B."""
        counts = self.check(self.random(3, 900), self.random(4, 400, x0=5, x1=11))
        self.assertLess(counts[0], 400)

    def test_scans_that_only_meet(self):
        counts = self.check(self.random(5, 500, x1=14), self.random(6, 500, x0=12))
        self.assertTrue(all(0 < count < 200 for count in counts), counts)

    def test_a_hole(self):
        b = [p for p in self.random(7, 2000) if math.hypot(p[0] - 12, p[1] - 9) > 4]
        for words in ([], ["--border", "hull"], ["--max-edge", "1.5"]):
            self.check(self.random(8, 900), b, *words, tiles=("40", "300"))

    def test_lattices_share_places(self):
        lattice = [(float(x), float(y), round(hill(x, y), 3)) for x in range(24) for y in range(18)]
        moved = [(x, y, round(z + 0.1 * math.sin(x), 3)) for x, y, z in lattice]
        finer = [(x / 2, y / 2, round(hill(x / 2, y / 2), 3)) for x in range(48) for y in range(36)]
        self.check(lattice, moved)
        self.check(lattice, finer)

    def test_points_of_one_place(self):
        rows = self.random(9, 400)
        twice = rows + [(x, y, round(z + 0.25, 3)) for x, y, z in rows[::3]] + rows[::5]
        for policy in ("mean", "median", "max", "first"):
            self.check(twice, self.random(10, 500), "--duplicates", policy, tiles=("50",))

    def test_layers(self):
        """An overhang over a part of A: folds of A are no part of it, and B is not compared there."""
        roof = [(x, y, round(z + 6, 3)) for x, y, z in self.random(11, 900, x0=8, x1=14) if 5 < y < 12]
        a, b = self.random(12, 2500) + roof, self.random(13, 1500, lift=0.2)
        left_out = self.check(a, b, tiles=("60", "400"))
        kept = self.check(a, b, "--folds", "keep", tiles=("60", "400"))
        self.assertLess(left_out[1], kept[1])
        self.check(a, b, "--no-layer-check", tiles=("60",))

    def test_directions(self):
        turned = [[(round(z, 3), x, y) for x, y, z in self.random(seed, 500)] for seed in (14, 15)]
        self.check(*turned, "--direction", "x", tiles=("60",))
        self.check(self.random(16, 400), self.random(17, 400), "--direction=0,0,-1", tiles=("60",))

    def test_of_a_pose_the_points_lie_where_it_puts_them(self):
        a, b = self.random(18, 400), self.random(19, 500)
        self.check(a, b, tiles=("60",))
        plain = {key: sorted(self.rows(f"whole/points_{key}.ply")) for key in "ab"}
        self.path("pose.txt").write_text("0 -1 0 0\n1 0 0 0\n0 0 1 0\n0 0 0 1\n")
        self.write("b.xyz", [(y, -x, z) for x, y, z in b])
        self.run_cli("tile", "plan", "a.xyz", "b.xyz", "-o", "job", "--tile-points", "100", "--pose", "pose.txt")
        self.run_cli("tile", "run", "job")
        self.run_cli("tile", "reduce", "job", "-o", "result", "--no-map", "--report-vertices", "0", "--points")
        for key in "ab":
            found = [row for path in sorted(self.path("result").glob(f"points_{key}_*.laz")) for row in self.rows(path)]
            self.assertEqual(sorted(found), plain[key])

    def test_they_belong_to_the_result(self):
        self.write("a.xyz", self.random(20, 300)), self.write("b.xyz", self.random(21, 300))
        self.run_cli("tile", "plan", "a.xyz", "b.xyz", "-o", "job", "--tile-points", "100")
        self.run_cli("tile", "run", "job")
        self.fails(2, "tile", "reduce", "job", "--points", says=["--points", "--output"])
        self.run_cli("tile", "reduce", "job", "-o", "result", "--no-map", "--report-vertices", "0", "--points")
        names = {path.name for path in self.path("result").glob("points_*")}
        self.assertGreater(len(names), 4)
        again = self.result("tile", "reduce", "job", "-o", "result", "--no-map", "--report-vertices", "0", "--points")
        self.assertLessEqual(names, set(again["outputs"]))
        self.path("job/tiles/000001.part").unlink()
        self.run_cli("tile", "reduce", "job", "-o", "result", "--no-map", "--report-vertices", "0", "--points", "--allow-missing")
        left = {path.name for path in self.path("result").glob("points_*")}
        self.assertEqual(names - left, {"points_a_000001.laz", "points_b_000001.laz"} & names)
        self.run_cli("tile", "reduce", "job", "-o", "result", "--allow-missing")
        self.assertEqual(list(self.path("result").glob("points_*")), [])


if __name__ == "__main__":
    unittest.main()
