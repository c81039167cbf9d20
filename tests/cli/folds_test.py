"""Folds (several layers along the direction) do not rule headlines. Truth by construction: both scans of a pair are
random points of one surface with noise along its normal, so all that is found beyond the noise is an artefact."""

import json
import math
import random
import re
import unittest

from support import SHARED, CliTest


def mushroom(seed, n, noise):
    """A plate of 60 x 40 with a ball of radius 8 on a stalk: the ball covers 8.4 % of the plate."""
    r = random.Random(seed)
    plate, ball, stalk = 60 * 40, 4 * math.pi * 64, 2 * math.pi * 2 * 6
    found = []
    for _ in range(n):
        pick, e = r.uniform(0, plate + ball + stalk), r.gauss(0, noise)
        turn = r.uniform(0, 2 * math.pi)
        if pick < plate:
            found.append((r.uniform(0, 60), r.uniform(0, 40), e))
        elif pick < plate + ball:
            z = r.uniform(-1, 1)
            rho = math.sqrt(1 - z * z)
            found.append((30 + (8 + e) * rho * math.cos(turn), 20 + (8 + e) * rho * math.sin(turn), 13 + (8 + e) * z))
        else:
            found.append((30 + (2 + e) * math.cos(turn), 20 + (2 + e) * math.sin(turn), r.uniform(0, 6)))
    return found


def read_obj(path):
    points, faces = [], []
    for line in path.read_text().splitlines():
        words = line.split()
        if words[:1] == ["v"]:
            points.append(tuple(map(float, words[1:4])))
        elif words[:1] == ["f"]:
            faces.append(tuple(int(w.split("/")[0]) - 1 for w in words[1:4]))
    return points, faces


def read_ply(path):
    lines = path.read_text().splitlines()
    number = {w[1]: int(w[2]) for w in map(str.split, lines) if w[:1] == ["element"]}
    body = lines[lines.index("end_header") + 1:]
    points = [tuple(map(float, line.split()[:3])) for line in body[:number["vertex"]]]
    return points, [tuple(map(int, line.split()[1:4])) for line in body[number["vertex"]:][:number["face"]]]


def sampled(mesh, seed, n, noise):
    """n points of the mesh, evenly by area, each with noise along the normal of its face."""
    points, faces = mesh
    r = random.Random(seed)
    normals, areas = [], []
    for a, b, c in faces:
        u, v = ([points[k][i] - points[a][i] for i in range(3)] for k in (b, c))
        w = (u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0])
        size = math.sqrt(sum(x * x for x in w))
        normals.append(tuple(x / size if size > 0 else 0 for x in w))
        areas.append(size / 2)
    found = []
    for k in r.choices(range(len(faces)), areas, k=n):
        s, t = r.random(), r.random()
        if s + t > 1:
            s, t = 1 - s, 1 - t
        a, b, c = (points[i] for i in faces[k])
        e = r.gauss(0, noise)
        found.append(tuple((1 - s - t) * a[i] + s * b[i] + t * c[i] + e * normals[k][i] for i in range(3)))
    return found


class FoldsTest(CliTest):
    def pair(self, make):
        return self.write("a.xyz", make(1)), self.write("b.xyz", make(2))

    def headline_rms(self, *words):
        first = self.run_cli("accuracy", *words).stdout.splitlines()[0]
        return float(re.search(r"rms ([-+.e0-9]+)", first).group(1))


class Folds(FoldsTest):
    def test_mushroom_compared_with_itself(self):
        pair = self.pair(lambda seed: mushroom(seed, 12000, 0.03))
        told = self.result("compare", *pair)
        self.assertLess(told["measure"]["rho"], 0.06)
        self.assertLess(abs(told["difference"]["mean"]), 0.02)
        self.assertAlmostEqual(told["folds"]["share"], math.pi * 64 / 2400, delta=0.03)
        self.assertAlmostEqual(told["folds"]["area"] / (told["domain"]["area"] + told["folds"]["area"]),
                               told["folds"]["share"], places=9)
        self.assertLess(told["domain"]["coverage"], 0.94)
        kept = self.result("compare", *pair, "--folds", "keep")
        self.assertGreater(kept["measure"]["rho"], 5 * told["measure"]["rho"])
        self.assertEqual(kept["folds"]["area"], told["folds"]["area"])
        self.assertEqual(kept["folds"]["rule"], "keep")
        for part in ("above", "below"):
            self.assertAlmostEqual(kept["volume"][part], told["volume"][part] + told["folds"][part], delta=1e-9 * 2400)
        unasked = self.result("compare", *pair, "--no-layer-check")
        self.assertEqual(unasked["volume"], kept["volume"])
        self.assertFalse(unasked["folds"]["looked_for"])
        self.assertIn("several layers", self.run_cli("compare", *pair).stdout)

    def test_accuracy_of_a_mushroom_is_its_noise(self):
        rms = self.headline_rms(*self.pair(lambda seed: mushroom(seed, 12000, 0.03)), "--align", "none")
        self.assertLess(rms, 1.2 * 0.03)

    def test_roughness_of_a_mushroom_has_no_wrinkle(self):
        scan = self.write("a.xyz", mushroom(1, 12000, 0.03))
        told = self.result("roughness", scan, "--l-filter", 8, "--wrinkle-depth", 0.3)
        self.assertEqual([w for w in told["scan"]["wrinkles"]["list"] if w["depth"] > 1], [])

    def test_nothing_is_left_of_two_sheets(self):
        r = random.Random(3)
        self.pair(lambda seed: [(r.uniform(0, 30), r.uniform(0, 30), r.choice((0, 5))) for _ in range(3000)])
        self.fails(4, "compare", "a.xyz", "b.xyz", says=("several layers", "--folds keep", "--direction"))
        self.run_cli("compare", "a.xyz", "b.xyz", "--folds", "keep")

    def test_without_folds_the_option_changes_nothing(self):
        self.scans()
        words = ("compare", "a.xyz", "b.xyz")
        left_out, kept = (self.result(*words, "--folds", rule) for rule in ("leave-out", "keep"))
        self.assertEqual(left_out["folds"]["area"], 0)
        for key in ("domain", "measure", "volume", "difference", "border"):
            self.assertEqual(left_out[key], kept[key], key)
        self.assertNotIn("folds", self.run_cli(*words).stdout)
        self.fails(2, *words, "--folds", "cut", says=("--folds", "leave-out|keep"))

    def plates(self, name, lift):
        """20 by 20 with a plate of 9 by 9 five above it, as a mesh."""
        vertices, faces = [], []
        for n, start, side, z in ((41, 0, 20, 0), (19, 4.25, 9, 5)):
            first = len(vertices) + 1
            vertices += [(start + side * i / (n - 1), start + side * j / (n - 1), z + lift)
                         for i in range(n) for j in range(n)]
            for i in range(n - 1):
                for j in range(n - 1):
                    a = first + i * n + j
                    faces += [(a, a + n, a + 1), (a + n, a + n + 1, a + 1)]
        return self.write(name, ["v %r %r %r" % v for v in vertices] + ["f %d %d %d" % f for f in faces])

    def test_visible(self):
        a, b = self.plates("a.obj", 0), self.plates("b.obj", 0.25)
        seen = self.result("compare", a, b, "--visible")
        self.assertEqual(seen["folds"]["area"], 0)
        self.assertAlmostEqual(seen["volume"]["net"], 100, delta=1)
        self.assertEqual(seen["inputs"][0]["points"], 41 * 41 + 19 * 19 - 18 * 18)
        self.assertTrue(any("--visible" in w for w in seen["warnings"]))
        told = self.result("accuracy", b, a, "--align", "none", "--visible")
        self.assertAlmostEqual(told["normal"]["bias"], 0.25, delta=0.02)  # less on the walls
        self.assertEqual(told["folds"]["area"], 0)
        for verb in ("match", "roughness", "scanners"):
            # Flat plates hold no shift: the pose is not what is looked at here.
            scans = {"match": (b, a, "--accept-doubt"), "roughness": (a,),
                     "scanners": (b, b, a, "--accept-doubt")}[verb]
            found = self.result(verb, *scans, "--visible")
            self.assertTrue(any("--visible" in w for w in found["warnings"]), verb)
        self.scans()
        self.fails(2, "compare", "a.xyz", "b.xyz", "--visible", says=("--visible", "faces"))


class FoldsOfSharedData(FoldsTest):
    def data(self, name):
        path = SHARED / "data" / name
        if not path.exists():
            self.skipTest(f"shared data absent: {name} (set ISOPACH_SHARED to the folder of the data)")
        return path

    def test_accuracy_of_perfect_samples_of_a_nose_is_their_noise(self):
        mesh = read_obj(self.data("morpho-nose/shortnose.mesh.obj"))
        rms = self.headline_rms(*self.pair(lambda seed: sampled(mesh, seed, 20000, 0.03)), "--unit", "mm")
        self.assertGreater(rms, 0.8 * 0.03)
        self.assertLess(rms, 1.2 * 0.03)

    def test_faces_sampled_twice_differ_by_their_noise(self):
        for name, read in (("goast-faces/neutral.ply", read_ply), ("rvcg-face/humfaceClean.obj", read_obj)):
            mesh = read(self.data(name))
            pair = self.pair(lambda seed: sampled(mesh, seed, 20000, 0.1))
            told = self.result("compare", *pair, "--unit", "mm")
            self.assertLess(told["measure"]["rho"], 0.4, name)
            self.assertGreater(told["folds"]["share"], 0.01, name)


if __name__ == "__main__":
    unittest.main()
