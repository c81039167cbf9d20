"""A pose is never confidently wrong: what a matching does where its pose is not to be trusted. Real scans where they are."""

import json
import math
import random
import unittest

from support import SHARED, CliTest

DATA = SHARED / "data"


def relief(x, y):
    """Over the unit square; no place looks like another."""
    return (0.12 * math.sin(5 * x + 1.3 * y) * math.cos(4 * y - x) + 0.05 * math.sin(13 * x * y + 2)
            + 0.04 * math.cos(17 * y - 9 * x * x))


def other(x, y):
    return 0.1 * math.sin(11 * x - 3 * y) + 0.06 * math.cos(4 * x * y + 9 * y) + 0.05 * math.sin(19 * x * x)


def sample(surface, n, seed, noise=0.002):
    r = random.Random(seed)
    places = [(r.random(), r.random()) for _ in range(n)]
    return [(x, y, surface(x, y) + r.gauss(0, noise)) for x, y in places]


def rotation(axis, degrees):
    size = math.hypot(*axis)
    x, y, z = (a / size for a in axis)
    a = math.radians(degrees)
    c, s, k = math.cos(a), math.sin(a), 1 - math.cos(a)
    return [[c + x * x * k, x * y * k - z * s, x * z * k + y * s],
            [y * x * k + z * s, c + y * y * k, y * z * k - x * s],
            [z * x * k - y * s, z * y * k + x * s, c + z * z * k]]


def product(a, b):
    return [[sum(a[i][k] * b[k][j] for k in range(len(b))) for j in range(len(b[0]))] for i in range(len(a))]


def moved(points, turn, shift):
    return [tuple(sum(turn[i][k] * p[k] for k in range(3)) + shift[i] for i in range(3)) for p in points]


def turn_between(a, b):
    """Degrees between two rotations."""
    trace = sum(a[i][j] * b[i][j] for i in range(3) for j in range(3))
    return math.degrees(math.acos(max(-1, min(1, (trace - 1) / 2))))


class Verdict(CliTest):
    def match(self, moving, fixed, *words):
        """The result and the exit code; no result where nothing was found."""
        run = self.run_cli("match", moving, fixed, "--pose-only", "--json", "-", *words, code=None)
        self.assertIn(run.returncode, (0, 4, 5), run.stderr)
        return (json.loads(run.stdout) if run.stdout else None), run

    def assert_right_or_refused(self, moving, fixed, turn, shift, extent, *words):
        """Exit 0 only within 1 degree and 1 % of the extent of p -> turn p + shift, at the middle of `moving`."""
        result, run = self.match(moving, fixed, *words)
        if run.returncode != 0:
            return False
        matrix = result["pose"]["matrix"]
        self.assertLess(turn_between([row[:3] for row in matrix], turn), 1, run.stderr)
        centre = result["centre"]  # of FIXED: where the middle comes to lie
        back = [sum(matrix[k][i] * (centre[k] - matrix[k][3]) for k in range(3)) for i in range(3)]
        there = [sum(turn[i][k] * back[k] for k in range(3)) + shift[i] for i in range(3)]
        self.assertLess(math.dist(there, centre), 0.01 * extent)
        return True


class Relief(Verdict):
    def setUp(self):
        super().setUp()
        self.write("fixed.xyz", sample(relief, 5000, 1))
        self.write("moving.xyz", sample(relief, 5000, 2))

    def test_trusted_in_the_first_lines_and_in_the_result(self):
        run = self.run_cli("match", "moving.xyz", "fixed.xyz", "-o", "out")
        self.assertIn("verdict", run.stdout.splitlines()[1])
        self.assertIn("trusted: of what both scans see", run.stdout)
        result = json.loads(self.path("out/result.json").read_text())
        verdict = result["verdict"]
        self.assertEqual([verdict["grade"], verdict["stage"], verdict["rival"]], ["trusted", "start", None])
        self.assertGreater(min(verdict["agree"], verdict["shape"]), 0.8)
        self.assertIn("agreement.png", result["outputs"])
        self.assertIn("agreement", self.result("info", "out/moved.ply")["files"][0]["attributes"])
        self.assertIn("The pose is <strong>trusted", self.path("out/report.html").read_text())

    def test_turned_and_far_away_is_found_by_itself(self):
        right = 0
        for seed in range(4):
            r = random.Random(seed)
            turn = rotation([r.gauss(0, 1) for _ in range(3)], r.uniform(20, 180))
            shift = [r.uniform(-2, 2) for _ in range(3)]
            self.write("turned.xyz", moved(sample(relief, 5000, 10 + seed), turn, shift))
            back = [list(row) for row in zip(*turn)]
            home = [-sum(back[i][k] * shift[k] for k in range(3)) for i in range(3)]
            right += self.assert_right_or_refused("turned.xyz", "fixed.xyz", back, home, 1.4)
        self.assertGreaterEqual(right, 3)

    def test_another_surface_is_refused_and_has_no_precision(self):
        self.write("other.xyz", sample(other, 5000, 3))
        result, run = self.match("other.xyz", "fixed.xyz")
        self.assertIn(run.returncode, (4, 5))
        self.assertIn("--accept-doubt", run.stderr)
        if result is not None:
            self.assertEqual(result["verdict"]["grade"], "doubted")
            self.assertIsNone(result["covariance"])
        text = self.run_cli("match", "other.xyz", "fixed.xyz", "--pose-only", code=None).stdout
        self.assertNotIn("precision", text)
        accepted = self.run_cli("match", "other.xyz", "fixed.xyz", "--accept-doubt", "--json", "-", code=0)
        accepted = json.loads(accepted.stdout)
        self.assertEqual([accepted["verdict"]["grade"], accepted["verdict"]["accepted"]], ["doubted", True])
        self.assertIsNotNone(accepted["covariance"])

    def test_mirrored_is_refused(self):
        self.write("mirrored.xyz", [(1 - x, y, z) for x, y, z in sample(relief, 5000, 4)])
        for words in [(), ("--coarse",), ("--objective", "icp-plane")]:
            self.assertIn(self.match("mirrored.xyz", "fixed.xyz", *words)[1].returncode, (4, 5), words)

    def test_restricted_freedom_is_respected(self):
        turn = rotation([0, 0, 1], 40)
        self.write("turned.xyz", moved(sample(relief, 5000, 5), turn, [0.5, 0, 0]))
        result, run = self.match("turned.xyz", "fixed.xyz", "--freedom", "x,y,z")
        self.assertIn(run.returncode, (4, 5))
        if result is not None:
            self.assertEqual(result["pose"]["angle_deg"], 0)
            self.assertEqual(result["verdict"]["stage"], "start")

    def test_every_verb_that_matches_refuses(self):
        self.write("other.xyz", sample(other, 5000, 3))
        for words in [("compare", "fixed.xyz", "other.xyz", "--match"), ("accuracy", "other.xyz", "fixed.xyz"),
                      ("scanners", "other.xyz", "moving.xyz", "fixed.xyz"),
                      ("roughness", "fixed.xyz", "other.xyz", "--match")]:
            run = self.run_cli(*words, code=None)
            self.assertIn(run.returncode, (4, 5), words)
            self.assertEqual(run.stdout, "", words)
            self.run_cli(*words, "--accept-doubt", "--no-layer-check" if words[0] in ("compare", "roughness") else "--quiet",
                         code=None)
        run = self.run_cli("compare", "fixed.xyz", "other.xyz", "--match", "--accept-doubt", code=0)
        self.assertIn("doubted", run.stdout)
        self.assertIn("--accept-doubt", self.run_cli("compare", "fixed.xyz", "other.xyz", "--accept-doubt", code=2).stderr)

    def test_a_matched_comparison_says_what_was_moved(self):
        turn = rotation([0, 0, 1], 3)
        self.write("near.xyz", moved(sample(relief, 5000, 6), turn, [0.02, -0.01, 0.03]))
        text = self.run_cli("compare", "fixed.xyz", "near.xyz", "--match", "-o", "out").stdout
        lines = text.splitlines()
        self.assertIn("B was moved by", lines[0])
        self.assertTrue(any(line.strip().startswith("moved") and "turned by" in line and "standard deviation" in line
                            for line in lines))
        result = json.loads(self.path("out/result.json").read_text())
        self.assertAlmostEqual(result["matched"]["angle_deg"], 3, delta=0.3)
        self.assertLess(result["matched"]["axis"][2], -0.99)
        self.assertEqual(result["verdict"]["grade"], "trusted")
        self.assertIn("B was moved by", self.path("out/report.html").read_text())
        plain = self.result("compare", "fixed.xyz", "near.xyz")
        self.assertEqual([plain["matched"], plain["verdict"]], [None, None])

    def test_what_slides_is_undetermined(self):
        r = random.Random(1)
        for name in ("sphere", "plane"):
            for file in ("a.xyz", "b.xyz"):
                points = []
                while len(points) < 4000:
                    x, y = r.uniform(-0.7, 0.7), r.uniform(-0.7, 0.7)
                    z = math.sqrt(1 - x * x - y * y) if name == "sphere" else 0.1 * x
                    points.append((x, y, z + r.gauss(0, 0.002)))
                self.write(file, points)
            for words in [(), ("--objective", "icp-plane")]:
                result, run = self.match("a.xyz", "b.xyz", *words)
                self.assertEqual(run.returncode, 5, name)
                self.assertEqual(result["verdict"]["grade"], "undetermined")
                self.assertIn("held least", run.stderr)

    def test_before_and_after_are_drawn_alike(self):
        self.run_cli("match", "moving.xyz", "fixed.xyz", "-o", "out")
        before, after = (self.path(f"out/{n}.png").read_bytes()[16:24] for n in ("before", "after"))
        self.assertEqual(before, after)  # width and height in pixels

    def test_the_rms_of_what_was_fitted(self):
        result = self.result("match", "moving.xyz", "fixed.xyz")
        self.assertAlmostEqual(result["fitted_rms"], 0.0028, delta=0.001)
        self.assertIn("rms ", [l for l in self.run_cli("match", "moving.xyz", "fixed.xyz").stdout.splitlines()
                               if l.strip().startswith("fitted")][0])


def quaternion_turn(x, y, z, w):
    """The transposed rotation, as bun.conf means it."""
    n = math.sqrt(x * x + y * y + z * z + w * w)
    x, y, z, w = x / n, y / n, z / n, w / n
    r = [[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
         [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
         [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]]
    return [list(row) for row in zip(*r)]


class RealScans(Verdict):
    def data(self, name):
        if not (DATA / name).exists():
            self.skipTest(f"shared data absent: {name}")
        return DATA / name

    def test_bunny_views_270_and_315_from_the_identity(self):
        folder = self.data("stanford-bunny-range")
        poses = {}
        for line in (folder / "bun.conf").read_text().splitlines():
            words = line.split()
            if words and words[0] == "bmesh":
                numbers = [float(w) for w in words[2:]]
                poses[words[1]] = (quaternion_turn(*numbers[3:]), numbers[:3])
        r0, t0 = poses["bun000.ply"]
        inverse = [list(row) for row in zip(*r0)]
        for view in ("bun270.ply", "bun315.ply"):
            r, t = poses[view]
            turn = product(inverse, r)
            shift = [sum(inverse[i][k] * (t[k] - t0[k]) for k in range(3)) for i in range(3)]
            for words in [(), ("--objective", "icp-plane")]:
                right = self.assert_right_or_refused(folder / view, folder / "bun000.ply", turn, shift, 0.22, *words)
                print(view, words, "right" if right else "refused")

    def turned(self, points, seeds, extent, least_right):
        r = random.Random(7)
        half = [p for p in points]
        r.shuffle(half)
        middle = len(half) // 2
        self.write("fixed.xyz", half[:middle])
        right = 0
        for seed in seeds:
            r = random.Random(seed)
            turn = rotation([r.gauss(0, 1) for _ in range(3)], r.uniform(10, 180))
            shift = [r.uniform(-0.3, 0.3) * extent for _ in range(3)]
            self.write("moving.xyz", moved(half[middle:], turn, shift))
            back = [list(row) for row in zip(*turn)]
            home = [-sum(back[i][k] * shift[k] for k in range(3)) for i in range(3)]
            right += self.assert_right_or_refused("moving.xyz", "fixed.xyz", back, home, extent)
        self.assertGreaterEqual(right, least_right)

    def test_turned_faces_are_right_or_refused(self):
        text = self.data("rvcg-face/humfaceClean.obj").read_text()
        points = [tuple(float(w) for w in line.split()[1:4]) for line in text.splitlines() if line.startswith("v ")]
        self.turned(points, range(3), 240, 2)

    def test_different_people_are_refused(self):
        smile = self.data("goast-faces/neutral.ply")
        run = self.run_cli("match", smile, self.data("rvcg-face/humfaceClean.obj"), "--pose-only", code=None)
        self.assertIn(run.returncode, (4, 5))
        self.assertNotIn("precision", run.stdout)


if __name__ == "__main__":
    unittest.main()
