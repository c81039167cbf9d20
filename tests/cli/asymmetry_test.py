"""isopach asymmetry: outputs, and that each option acts and is named when it is wrong."""

import json
import math
import random
import unittest

from support import CliTest, without_timing


def face(seed=1, n=2500, bump=0.0, noise=0.02, turn=5.0):
    """A nose, two eyes and a round head, symmetric about x = 0, a bump on the right; then turned about z."""
    numbers = random.Random(seed)
    c, s = math.cos(math.radians(turn)), math.sin(math.radians(turn))
    found = []
    while len(found) < n:
        x, y = numbers.uniform(-8, 8), numbers.uniform(-10, 10)
        if (x / 8) ** 2 + (y / 10) ** 2 > 1:
            continue
        z = 6 * math.sqrt(1.3 - (x / 10) ** 2 - (y / 13) ** 2) + 2 * math.exp(-(x ** 2) - (y / 2.5) ** 2)
        z -= sum(math.exp(-((x - e) / 1.5) ** 2 - ((y - 3.5) / 1.2) ** 2) for e in (-3.5, 3.5))
        z += bump * math.exp(-((x - 4) / 1.5) ** 2 - ((y + 4) / 1.5) ** 2) + numbers.gauss(0, noise)
        found.append((c * x - s * y, s * x + c * y, z))
    return found


def cropped(seed=0, n=6000, turn=0.13, crop=45):
    """A round face of 150 by 190 mm turned about y by `turn`, that ends `crop` mm from its plane on one side."""
    numbers = random.Random(seed)
    c, s = math.cos(turn), math.sin(turn)
    found = []
    for _ in range(n):
        x, y = numbers.uniform(-75, crop), numbers.uniform(-95, 95)
        z = 75 * math.sqrt(max(0.02, 1 - (x / 92) ** 2 - (y / 128) ** 2))
        for at, up, wide, tall, size in ((0, 8, 10, 18, 21), (33, 33, 14, 9, -8), (0, -35, 21, 8, 5), (0, -70, 18, 12, 8),
                                         (43, -4, 17, 15, 5)):
            z += size * math.exp(-(((abs(x) - at) / wide) ** 2 + ((y - up) / tall) ** 2) / 2)
        z += numbers.gauss(0, 0.15)
        found.append((c * x + s * z, y, c * z - s * x))
    return found


class AsymmetryCli(CliTest):
    def setUp(self):
        super().setUp()
        self.write("face.xyz", face(bump=1.0))

    def seen(self, words):
        """These shapes are no faces: the direction is given."""
        return words if "--direction" in words else ("--direction", "z", *words)

    def told(self, *words, name="face.xyz"):
        return self.result("asymmetry", name, *self.seen(words))


class Output(AsymmetryCli):
    def test_text(self):
        run = self.run_cli("asymmetry", "face.xyz", "--unit", "mm", "--direction", "z")
        for word in ["face.xyz: asymmetry index", "side on the right of the picture stands out", "plane", "upper third", "mm"]:
            self.assertIn(word, run.stdout)
        self.assertEqual({p.name for p in self.folder.iterdir()}, {"face.xyz"})

    def test_numbers(self):
        told = self.told()
        normal = told["plane"]["normal"]
        self.assertAlmostEqual(math.degrees(math.atan2(normal[1], normal[0])), 5, delta=0.3)
        self.assertAlmostEqual(told["regions"][0]["volume"]["net"], math.pi * 1.5 ** 2, delta=0.3)
        self.write("plain.xyz", face(seed=2))
        plain = self.told(name="plain.xyz")
        self.assertLess(plain["index"]["percent"], plain["index"]["floor"])
        self.assertGreater(told["index"]["percent"], 3 * told["index"]["floor"])

    def test_a_plane_far_from_the_middle_of_the_scan(self):
        # Turns and shifts of the plane through the middle alone led to one that is 30 degrees off, in a third of such scans.
        self.write("cropped.xyz", cropped())
        told = self.told("--unit", "mm", name="cropped.xyz")
        normal = told["plane"]["normal"]
        off = math.degrees(math.acos(min(1, abs(normal[0] * math.cos(0.13) - normal[2] * math.sin(0.13)))))
        self.assertLess(off, 0.1)
        self.assertLess(told["index"]["percent"], told["index"]["floor"])

    def test_a_crop_just_beyond_the_plane(self):
        # One side and the nose: a cheek lies over its own mirror image better than the nose does. It was exit 0, some 30
        # degrees off. Where the plane is not found it must be refused.
        wrong = refused = 0
        for seed in range(3):
            self.write("half.xyz", cropped(seed, crop=8))
            run = self.run_cli("asymmetry", "half.xyz", "--direction", "z", "--json", "-", code=None)
            self.assertIn(run.returncode, (0, 5), run.stderr)
            if run.returncode == 5:
                refused += 1
                self.assertIn("half.xyz: the plane that was found is not one of symmetry", run.stderr)
                self.assertIn("--accept-doubt", run.stderr)
                taken = self.told("--accept-doubt", name="half.xyz")
                self.assertTrue(any("not one of symmetry" in w for w in taken["warnings"]))
                continue
            normal = json.loads(run.stdout)["plane"]["normal"]
            wrong += abs(normal[0] * math.cos(0.13) - normal[2] * math.sin(0.13)) < math.cos(math.radians(3))
        self.assertEqual(wrong, 0)

    def test_any_turn_of_the_picture(self):
        # Few points and a head as round as this one: of the turn about the direction, little more than noise is known.
        for turn in (0, 2, 8, 20):
            self.write("turned.xyz", face(n=1500, turn=turn))
            normal = self.told(name="turned.xyz")["plane"]["normal"]
            self.assertAlmostEqual(math.degrees(math.atan2(normal[1], normal[0])), turn, delta=0.3)

    def test_folder(self):
        self.run_cli("asymmetry", "face.xyz", "--direction", "z", "-o", "out", "--json", "copy.json", "--title", "Who <it> is")
        files = {p.name for p in self.path("out").iterdir()}
        self.assertEqual(files, {"result.json", "report.html", "asymmetry.png", "points.ply", "pose.txt"})
        result = json.loads(self.path("out/result.json").read_text())
        self.assertEqual(set(result["outputs"]), files)
        self.assertEqual(self.path("copy.json").read_text(), self.path("out/result.json").read_text())
        self.assertIn("asymmetry", self.result("info", "out/points.ply")["files"][0]["attributes"])
        page = self.path("out/report.html").read_text()
        self.assertIn("Who &lt;it&gt; is", page)
        self.assertIn("data:image/png;base64,", page)
        # In face coordinates the plane is x = 0.
        self.run_cli("convert", "face.xyz", "upright.xyz", "--pose", "out/pose.txt")
        upright = self.told(name="upright.xyz")
        self.assertAlmostEqual(upright["plane"]["normal"][0], 1, delta=1e-5)
        self.assertAlmostEqual(upright["plane"]["offset"], 0, delta=4e-3)  # of the noise of 0.02 on 2500 points

    def test_threads(self):
        self.assertEqual(len({without_timing(json.dumps(self.told("--threads", n))) for n in "12"}), 1)


class Options(AsymmetryCli):
    def test_they_act(self):
        plain = self.told()
        self.assertLess(self.told("--rim", "1")["domain"]["area"], 0.9 * plain["domain"]["area"])
        self.assertLess(self.told("--depth", "3")["input"]["used"], 0.9 * plain["input"]["used"])
        self.assertEqual([r["name"] for r in self.told("--regions", "halves")["regions"]],
                         ["whole", "upper half", "lower half"])
        self.assertLess(self.told("--across", "-1,0,0")["plane"]["normal"][0], -0.9)
        self.assertEqual(self.told("--overlap", "1")["fit"]["overlap"], 1)
        self.assertLess(self.told("--crop", "-8,-6,8,6")["input"]["used"], plain["input"]["used"])
        self.assertNotEqual(self.told("--border", "hull")["domain"], plain["domain"])
        self.assertNotEqual(self.told("--max-edge", "0.8")["domain"], plain["domain"])
        self.assertEqual(self.told("--unit", "mm")["parameters"]["unit"], "mm")
        self.assertNotEqual(self.told("--direction", "0,0.2,1")["domain"], plain["domain"])
        self.write("twice.xyz", [p for x, y, z in face(n=1500) for p in ((x, y, z), (x, y, z + 0.1))])
        self.assertNotEqual(self.told("--duplicates", "max", name="twice.xyz")["plane"],
                            self.told("--duplicates", "min", name="twice.xyz")["plane"])

    def test_visible(self):
        # A plate before the lower part of the face hides the points behind it, one behind the face none.
        points = face(n=1500)
        used = {}
        for z in (-50, 12):
            plate = [(-9, -12, z), (9, -12, z), (9, -7, z), (-9, -7, z)]
            n = len(points)
            self.write("plate.obj", ["v %r %r %r" % p for p in points + plate] +
                       [f"f {n + 1} {n + 2} {n + 3}", f"f {n + 1} {n + 3} {n + 4}"])
            used[z] = self.told("--visible", name="plate.obj")["input"]["used"]
        self.assertEqual(used[-50], 1504)
        self.assertEqual(used[12], 1504 - sum(1 for x, y, _ in points if -9 <= x <= 9 and y <= -7))

    def test_polygons(self):
        # Of a bump on one side, drawn there or where its mirror image is; the face is turned by 5 degrees.
        def ring(x, y, radius=4.0):
            c, s = math.cos(math.radians(5)), math.sin(math.radians(5))
            at = [(x + radius * math.cos(a / 12 * math.pi), y + radius * math.sin(a / 12 * math.pi)) for a in range(25)]
            return [[c * x - s * y, s * x + c * y] for x, y in at]

        def polygons(path, *named):
            self.path(path).write_text(json.dumps({"type": "FeatureCollection", "features": [
                {"type": "Feature", "properties": {"name": name}, "geometry": {"type": "Polygon", "coordinates": [r]}}
                for name, r in named]}))
            return path

        file = polygons("parts.geojson", ("right cheek", ring(4, -4)), ("left cheek", ring(-4, -4)),
                        ("forehead", ring(0, 7, 2)), ("beside", ring(40, 0)))
        told = self.told("--regions", file)
        rows = {r["name"]: r for r in told["regions"]}
        self.assertEqual(list(rows), ["whole", "right cheek", "left cheek", "forehead", "beside"])
        self.assertEqual(told["parameters"]["regions"], file)
        for side in ["right", "left"]:
            self.assertAlmostEqual(rows[side + " cheek"]["volume"]["net"], math.pi * 1.5 ** 2, delta=0.3)
        self.assertLess(abs(rows["forehead"]["directional"]), 0.1)
        self.assertAlmostEqual(rows["forehead"]["area"], math.pi * 2 ** 2 / 2, delta=0.1)
        self.assertIn("'beside' holds no place", "".join(told["warnings"]))
        self.assertEqual(rows["whole"], self.told()["regions"][0])
        for words, code, says in [(("face.xyz",), 3, "face.xyz"),
                                  ((polygons("far.geojson", ("far", ring(99, 99))),), 3, "none of its polygons")]:
            self.assertIn(says, self.run_cli("asymmetry", "face.xyz", *self.seen(("--regions", *words)), code=code).stderr)

    def test_polygons_in_any_direction(self):
        """The same face looking along y and along x: polygons are drawn in the coordinates across that axis."""
        ring = [[4 + 4 * math.cos(a / 12 * math.pi), -4 + 4 * math.sin(a / 12 * math.pi)] for a in range(25)]
        self.path("cheek.geojson").write_text(json.dumps({"type": "FeatureCollection", "features": [
            {"type": "Feature", "properties": {"name": "cheek"}, "geometry": {"type": "Polygon", "coordinates": [ring]}}]}))
        points = face(n=1500, bump=1.0, turn=0.0)
        self.write("z.xyz", points)
        self.write("y.xyz", [(x, 7 + z, y) for x, y, z in points])
        self.write("x.xyz", [(z - 3, x, y) for x, y, z in points])
        told = {}
        for name, words in [("z", ()), ("y", ("--direction", "y", "--across", "x")), ("x", ("--direction", "x", "--across", "y")),
                            ("y", ("--direction", "0.1,1,0.1", "--across", "x"))]:
            row = self.told("--regions", "cheek.geojson", *words, name=name + ".xyz")["regions"][1]
            self.assertEqual(row["name"], "cheek")
            told[words] = row["volume"]["net"]
            self.assertAlmostEqual(row["volume"]["net"], told[()], delta=0.05 * abs(told[()]), msg=words)
        self.assertGreater(abs(told[()]), 5)

    def test_wrong_ones_are_named(self):
        for words in [("--rim", "-1"), ("--rim", "100"), ("--depth", "0"), ("--regions", "quarters"), ("--across", "left"),
                      ("--across", "0,0,0"), ("--across", "z"), ("--overlap", "2"), ("--max-iterations", "0"),
                      ("--direction", "up"), ("--stable", "ears"), ("--stable", "nose"), ("--unit", "mile"), ("--crop", "1"), ("--max-edge", "0"),
                      ("--duplicates", "many"), ("--border", "none"), ("--palette", "grey"), ("--map-width", "9"),
                      ("--class", "2"), ("--visible",), ("--output", ""), ("--json", "")]:
            code = 3 if words in [("--rim", "100"), ("--class", "2")] else 2
            self.assertIn(words[0] if words[0] != "--class" else "class",
                          self.run_cli("asymmetry", "face.xyz", *self.seen(words), code=code).stderr)

    def test_what_is_no_face_is_refused_with_what_to_give(self):
        vase = []
        numbers = random.Random(3)
        for _ in range(2500):
            t, h = numbers.uniform(0, 2 * math.pi), numbers.uniform(0, 1)
            r = 0.3 + 0.15 * math.sin(5 * h)
            vase.append((r * math.cos(t), r * math.sin(t), h))
        self.write("vase.xyz", vase)
        run = self.run_cli("asymmetry", "vase.xyz", code=4)
        for word in ["vase.xyz", "no face is", "--direction"]:
            self.assertIn(word, run.stderr)
        self.assertEqual(run.stdout, "")

    def test_not_converged(self):
        run = self.run_cli("asymmetry", "face.xyz", "--direction", "z", "--max-iterations", "1", code=5)
        self.assertIn("--max-iterations", run.stderr)


if __name__ == "__main__":
    unittest.main()
