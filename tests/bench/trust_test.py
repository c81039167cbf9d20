"""What bench/trust_study.py and bench/pulls.py judge poses by. Skipped where numpy or scipy is absent."""

import pathlib
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "bench"))
try:
    import numpy as np

    from trust import geometry, objects, page, pairs, pull_kinds, starts
except ImportError as missing:
    np, why = None, str(missing)


@unittest.skipIf(np is None, "numpy and scipy are not installed")
class TrustTest(unittest.TestCase):
    def setUp(self):
        self.random = np.random.default_rng(1)
        self.points = self.random.uniform(0, [40, 30, 10], (400, 3)) + [1000, 2000, 0]

    def test_error_is_that_of_the_motion_between_two_poses(self):
        truth = geometry.turn((1, 2, 3), 140, (7, 8, 9), (1, 2, 3))
        placed = geometry.moved(self.points, truth)
        size = geometry.extent(self.points)
        found = geometry.turn((3, -1, 1), 4, placed.mean(axis=0), (0.02 * size, 0, 0)) @ truth
        degrees, share = geometry.error(found, truth, self.points)
        self.assertAlmostEqual(degrees, 4, places=6)
        self.assertAlmostEqual(share, 0.02, places=6)
        self.assertEqual(geometry.class_of(degrees, share), "wrong")
        self.assertEqual(geometry.class_of(0.4, 0.009), "right")
        self.assertEqual(geometry.class_of(0.4, 0.02), "between")

    def test_half_a_turn_is_told(self):
        self.assertAlmostEqual(geometry.degrees_between(geometry.turn((0, 1, 0), 180), np.eye(4)), 180)

    def test_twist_is_the_motion_about_the_centre(self):
        truth, centre = geometry.turn((1, 0, 1), 70, shift=(5, 6, 7)), np.array([30.0, 20, 10])
        found = geometry.turn((0, 0, 1), np.degrees(1e-3), centre, (0.1, 0.2, 0.3)) @ truth
        self.assertTrue(np.allclose(pull_kinds.twist(found, truth, centre), [0, 0, 1e-3, 0.1, 0.2, 0.3], atol=1e-9))

    def test_start_is_undone_by_the_truth(self):
        pair = pairs.Pair("test", "test", "rigid", None)
        for start in starts.starts_of(pair)[:6]:
            moving, fixed, truth, common = starts.scans_of(pair, start, self.points, self.points)
            back = geometry.moved(moving, truth)
            self.assertLess(np.abs(back - self.points[: len(back)]).max() if start.share == 1 else 0, 1e-8)
            self.assertAlmostEqual(geometry.degrees_between(truth, np.eye(4)), start.turn, places=6)

    def test_cut_leaves_the_share_in_common(self):
        for share in (0.8, 0.4, 0.0):
            moving, fixed = geometry.cut(self.points, self.points, share, self.random)
            both = {tuple(p) for p in moving} & {tuple(p) for p in fixed}
            self.assertAlmostEqual(len(both) / len(moving), share, delta=0.02)

    def test_best_motion_ignores_the_half_that_changed(self):
        pose = geometry.turn((1, 1, 0), 25, shift=(3, 2, 1))
        target = geometry.moved(self.points, pose)
        target[:150] += [0, 0, 4]
        self.assertTrue(np.allclose(geometry.best_motion(self.points, target), pose, atol=1e-6))

    def test_pairs_are_many_and_have_names_of_their_own(self):
        found = pairs.all_pairs()
        self.assertGreaterEqual(len([p for p in found if p.kind in ("rigid", "changed", "hard")]), 40)
        self.assertEqual(len({p.name for p in found}), len(found))
        self.assertTrue({p.kind for p in found} <= set(page.KINDS))

    def test_generators_are_those_of_their_seed(self):
        for make in (objects.quarry, objects.outcrop, objects.carved_slab):
            x, y = self.random.uniform(0, 50, (2, 50))
            self.assertTrue(np.array_equal(make(3)(x, y), make(3)(x, y)))
            self.assertFalse(np.allclose(make(3)(x, y), make(4)(x, y)))

    def test_page_counts_what_was_wrong_with_exit_0(self):
        row = {"pair": "p", "group": "g", "kind": "rigid", "start": 0, "objective": "measure", "turn": 5.0, "shift": 0.01,
               "common": 1.0, "degrees": 9.0, "off": 0.2, "seconds": 1.0, "good": True, "grade": "trusted",
               "verdict": {"agree": 0.8, "detail": [0.9, 0.7], "stage": "coarse"}}
        rows = [{**row, "code": 0, "class": "wrong"}, {**row, "code": 0, "class": "right", "start": 1},
                {**row, "code": 5, "class": "wrong", "start": 2}]
        text = page.written(rows, [], 100, 300)
        self.assertIn("1 of 3: 33.3 %", text)
        self.assertIn("agree 0.80, detail 0.70, coarse", text)
        self.assertEqual(len(page.trusted(rows, "wrong")), 1)


if __name__ == "__main__":
    unittest.main()
