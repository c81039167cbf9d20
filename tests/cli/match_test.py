"""isopach match: outputs, and that each option acts and is named when it is wrong."""

import json
import math
import random
import unittest

from support import CliTest, points, without_timing


def waves(x, y):
    return math.sin(0.9 * x) * math.cos(0.7 * y) + 0.1 * x


def scan(seed, dx=0.0, dy=0.0, dz=0.0, n=900):
    return [(x + dx, y + dy, waves(x, y) + dz) for x, y, _ in points(seed, n=n)]


class MatchCli(CliTest):
    def setUp(self):
        super().setUp()
        self.write("fixed.xyz", scan(1))
        self.write("moving.xyz", scan(2, 0.3, -0.2, 0.4))

    def match(self, *words, code=0):
        return json.loads(self.run_cli("match", "moving.xyz", "fixed.xyz", "--json", "-", *words, code=code).stdout)


class Nominal(CliTest):
    """Points taken on the facets of a coarse mesh, without noise: only if the facets of the file are the surface is the
    scale found to be 1."""

    def mesh(self):
        n, side = 13, 2.0
        numbers = random.Random(5)
        places = [(side * (i + 0.3 * j), side * j) for i in range(n) for j in range(n)]  # leaning: one diagonal is Delaunay's
        corners = [(x, y, waves(x, y)) for x, y in places]
        faces, samples = [], []
        for i in range(n - 1):
            for j in range(n - 1):
                a, b, c, d = n * i + j, n * (i + 1) + j, n * (i + 1) + j + 1, n * i + j + 1
                for triangle in ((a, b, d), (b, c, d)):
                    faces.append("3 %d %d %d" % triangle)
                    for _ in range(12):
                        u, v = sorted((numbers.random(), numbers.random()))
                        shares = (u, v - u, 1 - v)
                        samples.append(tuple(sum(w * corners[k][axis] for w, k in zip(shares, triangle)) for axis in range(3)))
        head = ["ply", "format ascii 1.0", f"element vertex {len(corners)}", "property double x", "property double y",
                "property double z", f"element face {len(faces)}", "property list uchar int vertex_indices", "end_header"]
        self.write("mesh.ply", head + ["%r %r %r" % p for p in corners] + faces)
        self.write("points.xyz", samples)

    def test_its_facets_are_the_surface(self):
        self.mesh()
        free = ("--freedom", "x,y,z,turn-x,turn-y,turn-z,scale")
        found = self.result("match", "points.xyz", "mesh.ply", "--pose-only", *free)
        self.assertEqual(found["nominal"], {"moving": False, "fixed": True})
        matrix = found["pose"]["matrix"]
        self.assertAlmostEqual(math.hypot(*(row[0] for row in matrix[:3])), 1, delta=1e-6)
        self.assertIn("nominal mesh", self.run_cli("match", "points.xyz", "mesh.ply", "--pose-only").stdout)


class Output(MatchCli):
    def test_text(self):
        run = self.run_cli("match", "moving.xyz", "fixed.xyz")
        for word in ["moving.xyz on fixed.xyz", "before", "after", "rotation", "converged", "pose"]:
            self.assertIn(word, run.stdout)
        self.assertEqual({p.name for p in self.folder.iterdir()}, {"fixed.xyz", "moving.xyz"})

    def test_folder_and_round_trip(self):
        self.run_cli("match", "moving.xyz", "fixed.xyz", "-o", "out", "--json", "copy.json", "--pose-out", "p.txt")
        files = {p.name for p in self.path("out").iterdir()}
        self.assertEqual(files, {"result.json", "report.html", "pose.txt", "moved.ply", "agreement.png", "before.png",
                                 "after.png"})
        result = json.loads(self.path("out/result.json").read_text())
        self.assertEqual(set(result["outputs"]), files)
        self.assertEqual(self.path("copy.json").read_text(), self.path("out/result.json").read_text())
        self.assertEqual(self.path("p.txt").read_text(), self.path("out/pose.txt").read_text())
        rows = [[float(w) for w in line.split()] for line in self.path("out/pose.txt").read_text().splitlines()]
        self.assertEqual(rows, result["pose"]["matrix"])
        # The pose, applied to MOVING, gives the reported measure; so does compare --pose.
        self.run_cli("convert", "moving.xyz", "moved.ply", "--pose", "out/pose.txt")
        for words in [("moved.ply",), ("moving.xyz", "--pose", "out/pose.txt")]:
            again = self.result("compare", "fixed.xyz", *words)
            self.assertEqual(again["measure"]["rho"], result["after"]["rho"])
        self.assertIn("stable", self.result("info", "out/moved.ply")["files"][0]["attributes"])
        self.assertLess(abs(rows[0][3] + 0.3), 0.1)

    def test_pose_only_and_maps(self):
        plain = self.match()
        quick = self.match("--pose-only", "-o", "quick")
        self.assertEqual(quick["pose"], plain["pose"])
        self.assertEqual(quick["before"], {"rho": None, "rms": None, "coverage": None})
        self.assertTrue(quick["parameters"]["pose_only"])
        self.assertFalse({"before.png", "after.png"} & set(quick["outputs"]))
        self.assertNotIn("before.png", self.match("--no-map", "-o", "bare")["outputs"])
        self.assertIn("moving.xyz on fixed.xyz\n", self.run_cli("match", "moving.xyz", "fixed.xyz", "--pose-only").stdout)

    def test_threads(self):
        texts = {without_timing(json.dumps(self.match("--threads", n))) for n in "123"}
        self.assertEqual(len(texts), 1)


class CompareMatch(MatchCli):
    def test_is_match_and_compare(self):
        one = self.result("compare", "fixed.xyz", "moving.xyz", "--match")
        two = self.match()
        self.assertEqual(one["pose"]["matrix"], two["pose"]["matrix"])
        self.assertEqual(one["measure"]["rho"], two["after"]["rho"])
        for words in [("--freedom", "x,y,z"), ("--overlap", "1"), ("--weight", "x > 12")]:
            one = self.result("compare", "fixed.xyz", "moving.xyz", "--match", *words)
            self.assertEqual(one["pose"]["matrix"], self.match(*words)["pose"]["matrix"], words)
            self.assertNotEqual(one["pose"]["matrix"], two["pose"]["matrix"], words)
        for words in [("--freedom", "x"), ("--overlap", "1"), ("--max-iterations", "7"), ("--tolerance", "1e-3")]:
            self.assertIn(words[0], self.run_cli("compare", "fixed.xyz", "moving.xyz", *words, code=2).stderr)
        self.write("far.xyz", [(x, y, math.sin(7 * x * y)) for x, y, _ in scan(2, 500.0)])  # of another surface
        self.assertIn(self.run_cli("compare", "fixed.xyz", "far.xyz", "--match", code=None).returncode, (4, 5))


class Options(MatchCli):
    def test_they_act(self):
        plain = self.match()
        self.assertTrue(plain["converged"])
        self.assertEqual(self.match("--overlap", "1")["overlap"], 1)
        self.assertEqual(self.match("--freedom", "x,y,z")["pose"]["angle_deg"], 0)
        self.assertNotEqual(self.match("--freedom", "x,y,z,turn-x,turn-y,turn-z,scale")["pose"]["scale"], 1)
        self.assertNotEqual(self.match("--border", "hull")["before"]["coverage"], plain["before"]["coverage"])
        self.assertNotEqual(self.match("--max-edge", "2")["pose"], plain["pose"])
        steps = [len(self.match("--tolerance", share)["history"]) for share in ("1e-3", "1e-12")]
        self.assertLess(steps[0], steps[1])
        self.write("start.txt", ["1 0 0 -0.3", "0 1 0 0.2", "0 0 1 -0.4", "0 0 0 1"])
        near = self.match("--start", "start.txt")
        self.assertLess(near["before"]["rho"], 0.5 * plain["before"]["rho"])
        self.assertAlmostEqual(near["pose"]["matrix"][0][3], plain["pose"]["matrix"][0][3], delta=0.01)

    def test_currents(self):
        plain, m = self.match(), self.match("--objective", "currents")
        self.assertEqual([plain["objective"], m["objective"]], ["measure", "currents"])
        self.assertTrue(m["converged"])
        self.assertAlmostEqual(m["pose"]["matrix"][0][3], plain["pose"]["matrix"][0][3], delta=0.3)
        self.assertLess(m["after"]["rho"], 0.5 * m["before"]["rho"])
        self.assertIsNone(m["history"][0]["rms"])
        wide = self.match("--objective", "currents", "--sigma", "3")
        self.assertEqual(wide["parameters"]["sigma"], 3)
        self.assertNotEqual(wide["pose"], m["pose"])
        for words in [("--sigma", "3"), ("--objective", "currents", "--sigma", "0")]:
            self.assertIn("--sigma", self.run_cli("match", "moving.xyz", "fixed.xyz", *words, code=2).stderr)
        for words in [("--objective", "guess"), ("--objective", "currents", "--overlap", "0.5"),
                      ("--objective", "currents", "--freedom", "x,scale")]:
            self.assertIn(words[-2], self.run_cli("match", "moving.xyz", "fixed.xyz", *words, code=2).stderr)

    def test_wrong_ones_are_named(self):
        for words, option in [
            (("--overlap", "2"), "--overlap"),
            (("--overlap", "most"), "--overlap"),
            (("--freedom", "x,up"), "--freedom"),
            (("--max-iterations", "0"), "--max-iterations"),
            (("--tolerance", "-1"), "--tolerance"),
            (("--weight", "x +"), "--weight"),
            (("--weight", "x", "--objective", "icp-plane"), "--weight"),
        ]:
            self.assertIn(option, self.run_cli("match", "moving.xyz", "fixed.xyz", *words, code=2).stderr)
        self.assertIn("--start", self.run_cli("match", "moving.xyz", "fixed.xyz", "--start", "none.txt", code=3).stderr)

    def test_objectives(self):
        measure = self.match()
        self.assertEqual(measure["objective"], "measure")
        self.assertIsNone(measure["parameters"]["pairs"])
        for objective in ["icp-point", "icp-plane", "icp-gicp"]:
            m = self.match("--objective", objective)
            self.assertEqual(m["objective"], objective)
            self.assertTrue(m["converged"])
            self.assertAlmostEqual(m["pose"]["matrix"][0][3], measure["pose"]["matrix"][0][3], delta=0.3)
            self.assertIsNone(m["history"][0]["rho"])
            self.assertLess(m["history"][-1]["rms"], m["history"][0]["rms"])
        run = self.run_cli("match", "moving.xyz", "fixed.xyz", "--objective", "guess", code=2)
        self.assertIn("--objective", run.stderr)

    def test_options_of_pairs_act(self):
        icp = ("--objective", "icp-plane")
        plain = self.match(*icp)
        for words, name, value in [
            (("--reject-distance", "2x"), "reject_distance", "2x"),
            (("--reject-distance", "0.3"), "reject_distance", 0.3),
            (("--reject-distance", "none"), "reject_distance", None),
            (("--reject-normal", "10"), "reject_normal_deg", 10),
            (("--reject-normal", "none"), "reject_normal_deg", None),
            (("--reject-boundary", "off"), "reject_boundary", False),
            (("--pair-weights", "uniform"), "weights", "uniform"),
            (("--one-to-one",), "one_to_one", True),
            (("--symmetric",), "symmetric", True),
        ]:
            m = self.match(*icp, *words)
            self.assertEqual(m["parameters"]["pairs"][name], value)
            if words[-1] != "none":  # what is never rejected cannot be loosened
                self.assertNotEqual(m["history"], plain["history"], words)

    def test_wrong_options_of_pairs_are_named(self):
        for words in [
            ("--reject-distance", "-1"),
            ("--reject-distance", "0x"),
            ("--reject-normal", "95"),
            ("--reject-boundary", "maybe"),
            ("--pair-weights", "some"),
        ]:
            run = self.run_cli("match", "moving.xyz", "fixed.xyz", "--objective", "icp-plane", *words, code=2)
            self.assertIn(words[0], run.stderr)
        run = self.run_cli("match", "moving.xyz", "fixed.xyz", "--symmetric", code=2)
        self.assertIn("--symmetric", run.stderr)

    def test_coarse(self):
        turned = [(40 - y, x + 70, z) for x, y, z in scan(3, n=4000)]
        self.write("turned.xyz", turned)
        self.write("dense.xyz", scan(4, n=4000))
        # The waves look the same after half a turn: a rival, between which the scans cannot decide.
        refused = self.run_cli("match", "turned.xyz", "dense.xyz", "--coarse", "--json", "-", code=5)
        self.assertEqual(json.loads(refused.stdout)["verdict"]["grade"], "rival")
        self.assertIn("180", refused.stderr)
        run = self.run_cli("match", "turned.xyz", "dense.xyz", "--coarse", "--accept-doubt", "--json", "-")
        m = json.loads(run.stdout)
        self.assertTrue(m["parameters"]["coarse"])
        self.assertAlmostEqual(m["pose"]["angle_deg"], 90, delta=0.5)
        self.assertLess(m["after"]["rho"], 0.02)
        self.assertEqual(m["parameters"]["start"][3], [0, 0, 0, 1])
        self.write("start.txt", ["1 0 0 0", "0 1 0 0", "0 0 1 0", "0 0 0 1"])
        both = self.run_cli("match", "turned.xyz", "dense.xyz", "--coarse", "--start", "start.txt", code=2)
        self.assertIn("--start and --coarse", both.stderr)

    def test_exit_codes(self):
        self.write("far.xyz", scan(2, 500.0))
        run = self.run_cli("match", "far.xyz", "fixed.xyz", "--freedom", "x,y,z", code=4)  # no coarse search then
        self.assertIn("overlap", run.stderr)
        run = self.run_cli("match", "moving.xyz", "fixed.xyz", "--max-iterations", "1", "-o", "out", code=5)
        self.assertIn("--max-iterations", run.stderr)
        self.assertTrue(self.path("out/pose.txt").exists())


if __name__ == "__main__":
    unittest.main()
