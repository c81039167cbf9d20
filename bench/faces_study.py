#!/usr/bin/env python3
"""How well `isopach asymmetry` finds faces in any pose: the table of docs/use/asymmetry.md.

    faces_study.py PROGRAM SHARED [--turns N] [--damage-turns M]

PROGRAM is the built isopach, SHARED the folder of the shared data. Every face is turned at random N times (and M times
for each damage); right is a plane within 1 degree of the one found as the file lies, with up and left on their own side
within 15 degrees. Faces with a star are held out: neither the mean face nor a threshold was chosen by them, but for that
of the warning of a swelling. Needs numpy.
"""

import argparse
import json
import subprocess
import tempfile
from pathlib import Path

import numpy as np

FACES = {  # name: file, roughly up and left in the file
    "face-x": ("probreg/face-x.txt", (-1, 0, 0), (0, -0.95, 0.3)),
    "face-y": ("probreg/face-y.txt", (-1, 0, 0), (0, -0.95, 0.3)),
    "james": ("menpo-face/james.obj", (0, 1, 0), (1, 0, 0)),
    "LeePerrySmith": ("leeperrysmith/LeePerrySmith.obj", (0, 1, 0), (1, 0, 0)),
    "neutral*": ("goast-faces/neutral.ply", (-1, 0, 0), (0, -0.95, 0.3)),
    "smile*": ("goast-faces/smile.ply", (-1, 0, 0), (0, -0.95, 0.3)),
    "surprise*": ("goast-faces/surprise.ply", (-1, 0, 0), (0, -0.95, 0.3)),
    "humfaceClean*": ("rvcg-face/humfaceClean.obj", (-0.17, 0.97, 0.15), (1, 0.17, 0)),
    "fran*": ("vtk-fran/fran_cut.vtk", (0, 1, 0), (-0.59, 0, -0.81)),
    "Zaghetto*": ("zaghetto/Zaghetto.pcd", (0, -1, 0.2), (1, 0, 0)),
}


def read_points(program, path, scratch):
    """Any format isopach reads, and the points of legacy VTK."""
    if path.suffix == ".vtk":
        words = path.read_text().split()
        at = words.index("POINTS")
        n = int(words[at + 1])
        return np.array(words[at + 3:at + 3 + 3 * n], float).reshape(-1, 3)
    out = scratch / "points.xyz"
    subprocess.run([program, "convert", str(path), str(out)], check=True, capture_output=True)
    points = np.loadtxt(out, comments="#")[:, :3]
    return points[np.isfinite(points).all(1)]


def damaged(kind, points, frame, width, rng):
    """frame: rows left, up, front, and the origin between the eyes, in file coordinates."""
    axes, origin = frame
    x, y, z = ((points - origin) @ axes.T / width).T
    if kind == "half of the forehead missing":
        return points[~((y > 0.3) & (x > 0))]
    if kind == "one cheek missing":
        return points[~((y < 0.15) & (y > -0.4) & (x > 0.15))]
    if kind == "5 % of the points":
        return points[rng.permutation(len(points))[:max(300, len(points) // 20)]]
    if kind == "noise of 0.3 % of the width":
        return points + rng.normal(size=points.shape) * 0.003 * width
    if kind == "six holes":
        for i in rng.permutation(len(points))[:6]:
            points = points[np.linalg.norm(points - points[i], axis=1) > 0.09 * width] if i < len(points) else points
        return points
    if kind == "swelling of 8 % of the width":
        bell = 0.08 * width * np.exp(-((x - 0.28) ** 2 + (y + 0.17) ** 2) / (2 * 0.13 ** 2)) * (z > -0.6)
        return points + bell[:, None] * (0.8 * axes[2] + 0.6 * axes[0])
    if kind == "cropped to eyes, nose, mouth":
        return points[(abs(x) < 0.35) & (y > -0.3) & (y < 0.35) & (z > -0.4)]
    return points


DAMAGES = ["half of the forehead missing", "one cheek missing", "5 % of the points", "noise of 0.3 % of the width",
           "six holes", "swelling of 8 % of the width", "cropped to eyes, nose, mouth"]


def non_faces(program, shared, scratch):
    rng = np.random.default_rng(0)
    for name in ("bun000", "bun045", "bun270", "bun315"):
        path = shared / "stanford-bunny-range" / f"{name}.ply"
        if path.exists():
            yield name, read_points(program, path, scratch)
    for name, path in (("nose alone", "morpho-nose/shortnose.mesh.obj"), ("volcano (St Helens)", "msh-dome/msh_2004-10-04.xyz")):
        if (shared / path).exists():
            yield name, read_points(program, shared / path, scratch)
    cube = rng.uniform(-1, 1, (6000, 3))
    side = rng.integers(0, 3, 6000)
    cube[np.arange(6000), side] = np.sign(cube[np.arange(6000), side])
    yield "cube", cube
    ball = rng.normal(size=(9000, 3))
    ball /= np.linalg.norm(ball, axis=1)[:, None]
    yield "sphere", ball
    yield "half ellipsoid", ball[ball[:, 2] > 0] * [75, 100, 90]
    turn, high = rng.uniform(0, 2 * np.pi, 6000), rng.uniform(0, 1, 6000)
    radius = 0.3 + 0.15 * np.sin(5 * high)
    yield "vase", np.c_[radius * np.cos(turn), radius * np.sin(turn), high]
    head = shared / "leeperrysmith" / "LeePerrySmith.obj"
    if head.exists():
        points = read_points(program, head, scratch)
        x, y, z = points[:, 0] + 0.1, points[:, 1], points[:, 2]
        tip = points[np.argmax(z)]
        yield "back of a head", points[z < tip[2] - 2.5]
        yield "neck and shoulders", points[y < tip[1] - 1.75]
        yield "half a face", points[(x > 0) & (z > tip[2] - 1.7) & (y > tip[1] - 1.7) & (y < tip[1] + 1.8)]
    james = shared / "menpo-face" / "james.obj"
    if james.exists():
        points = read_points(program, james, scratch)
        yield "half a head", points[points[:, 0] > -12]


def run(program, points, scratch):
    path = scratch / "scan.xyz"
    np.savetxt(path, points, fmt="%.9g")
    done = subprocess.run([program, "asymmetry", str(path), "--json", "-"], capture_output=True, text=True)
    if done.returncode == 0:
        return json.loads(done.stdout)
    if done.returncode not in (4, 5):
        raise SystemExit(f"exit {done.returncode}: {done.stderr}")
    return None


def any_turn(rng):
    q, r = np.linalg.qr(rng.normal(size=(3, 3)))
    q = q * np.sign(np.diag(r))
    return q * np.sign(np.linalg.det(q))


def angle(a, b):
    return np.degrees(np.arccos(np.clip(a @ b / np.linalg.norm(a) / np.linalg.norm(b), -1, 1)))


class Tally:
    def __init__(self, index=None):
        self.reference_index = index
        self.runs = self.accepted = self.one = self.two = self.sides = 0
        self.worst_plane = self.worst_front = 0.0
        self.index = []

    def add(self, told, turn, reference):
        self.runs += 1
        if told is None:
            return
        self.accepted += 1
        back = lambda v: turn.T @ np.array(v)  # noqa: E731
        plane = angle(back(told["plane"]["normal"]), reference["left"])
        front = angle(back(told["pose"]["front"]), reference["front"])
        up = angle(back(told["pose"]["up"]), reference["up"])
        self.one += plane < 1
        self.two += plane < 2
        self.sides += plane < 15 and up < 15
        self.worst_plane, self.worst_front = max(self.worst_plane, plane), max(self.worst_front, front)
        self.index.append(told["index"]["percent"])

    def row(self, name):
        off = spread = ""
        if self.index and min(self.index) > 0 and self.reference_index:
            off = f"{100 * max(abs(i / self.reference_index - 1) for i in self.index):.1f} %"
            spread = f"{100 * (max(self.index) / min(self.index) - 1):.1f} %"
        return (f"| {name} | {self.runs} | {self.accepted} | {self.one} | {self.two} | {self.sides} | "
                f"{self.accepted - self.sides} | {self.worst_plane:.2f}° | {self.worst_front:.1f}° | {off} | {spread} |")


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("program")
    parser.add_argument("shared", type=Path)
    parser.add_argument("--turns", type=int, default=30)
    parser.add_argument("--damage-turns", type=int, default=5)
    options = parser.parse_args()
    rng = np.random.default_rng(13)
    print("| scan | runs | accepted | plane < 1° | < 2° | up, R and L right | wrong | worst plane | worst front | "
          "index, farthest from that as it lies | its spread |")
    print("|---|---|---|---|---|---|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as folder:
        scratch = Path(folder)
        damages = {kind: Tally() for kind in DAMAGES}
        for name, (file, up, left) in FACES.items():
            if not (options.shared / file).exists():
                continue
            points = read_points(options.program, options.shared / file, scratch)
            told = run(options.program, points, scratch)
            if told is None:
                print(f"| {name} | refused as it lies |")
                continue
            pose = told["pose"]
            reference = {k: np.array(pose[k]) for k in ("front", "up")}
            reference["left"] = np.array(told["plane"]["normal"])
            if angle(reference["up"], np.array(up, float)) > 25 or angle(reference["left"], np.array(left, float)) > 25:
                print(f"| {name} | WRONG as it lies |")
                continue
            tally = Tally(told["index"]["percent"])
            for _ in range(options.turns):
                turn = any_turn(rng)
                shift = rng.normal(size=3) * np.ptp(points)
                tally.add(run(options.program, points @ turn.T + shift, scratch), turn, reference)
            print(tally.row(name), flush=True)
            matrix = np.array(pose["matrix"])
            axes = np.array([pose["left"], pose["up"], pose["front"]])
            middle = -matrix[:3, :3].T @ matrix[:3, 3]
            frame = (axes, middle + 0.25 * pose["width"] * axes[2])
            for kind, tally in damages.items():
                for _ in range(options.damage_turns):
                    turn = any_turn(rng)
                    scan = damaged(kind, points, frame, pose["width"], rng)
                    tally.add(run(options.program, scan @ turn.T, scratch), turn, reference)
        for kind, tally in damages.items():
            print(tally.row(kind), flush=True)
        for name, points in non_faces(options.program, options.shared, scratch):
            accepted = sum(run(options.program, points @ any_turn(rng).T, scratch) is not None
                           for _ in range(max(options.damage_turns, 1)))
            print(f"| {name} (no face) | {max(options.damage_turns, 1)} | {accepted} |", flush=True)


if __name__ == "__main__":
    main()
