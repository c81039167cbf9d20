"""Trials of `isopach combine` and `isopach sequence` on scans that this script makes (not `isopach simulate`).

    python3 bench/parts_study.py ISOPACH pulls [RUNS]       error / sigma of combine's pose, by kind of scans
    python3 bench/parts_study.py ISOPACH density            error of combine against the density of the reference
    python3 bench/parts_study.py ISOPACH wrong              objects that cannot be told, or are not there: never exit 0
    python3 bench/parts_study.py ISOPACH jaw [RUNS]         sequence: a part of a third of the area that opens 8 degrees
    python3 bench/parts_study.py ISOPACH nonsense           sequence: frames that do not follow one another

Each prints a table of Markdown: those of docs/use/combine.md and docs/use/sequence.md. Needs numpy.
"""

import json
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

rng = np.random.default_rng


def write_ply(path, points):
    with open(path, "wb") as out:
        out.write((f"ply\nformat binary_little_endian 1.0\ncomment unit mm\nelement vertex {len(points)}\n"
                   "property double x\nproperty double y\nproperty double z\nend_header\n").encode())
        out.write(np.ascontiguousarray(points, dtype="<f8").tobytes())


def turn(vector):
    """Rotation by a vector (Rodrigues)."""
    angle = np.linalg.norm(vector)
    if angle == 0:
        return np.eye(3)
    x, y, z = np.asarray(vector) / angle
    k = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * k + (1 - np.cos(angle)) * k @ k


def pose(r, t):
    m = np.eye(4)
    m[:3, :3], m[:3, 3] = r, t
    return m


def moved(m, p):
    return p @ m[:3, :3].T + m[:3, 3]


def any_pose(random, far=100):
    q = random.normal(size=4)
    w, x, y, z = q / np.linalg.norm(q)
    r = np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                  [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                  [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])
    return pose(r, random.uniform(-far, far, 3))


# ------------------------------------------------------------------ combine


def fork(x, y):
    """Relief of a bite fork of 64 by 40 mm: a bent tongue with ribs and three marks of different size."""
    z = 0.006 * x * x - 0.004 * x * y + 1.2 * np.sin(x / 9 + 0.4) * np.cos(y / 7)
    for cx, cy, w, h in ((-18, 6, 6, 5.0), (10, -8, 5, -3.5), (20, 9, 7, 4.0), (-5, -12, 4.5, 2.5)):
        z = z + h * np.exp(-((x - cx) ** 2 + (y - cy) ** 2) / (2 * w * w))
    return z


def sampled(random, surface, half, count, noise, keep=None):
    """Random points of the surface over a rectangle, noise along z."""
    p = random.uniform([-half[0], -half[1]], half, (count, 2))
    if keep is not None:
        p = p[keep(p[:, 0], p[:, 1])]
    z = surface(p[:, 0], p[:, 1]) + noise * random.normal(size=len(p))
    return np.column_stack([p, z])


HALF = (32.0, 20.0)


def scan_with_object(random, per_object, noise, hidden, behind, surface=fork, half=HALF):
    """The object before a background; `hidden`: share of the object that something else covers."""
    angle = random.uniform(0, 2 * np.pi)
    reach = np.array([np.cos(angle) * half[0], np.sin(angle) * half[1]])
    limit = (1 - 2 * hidden) * np.linalg.norm(reach)
    seen = lambda x, y: (x * np.cos(angle) + y * np.sin(angle)) < limit
    on = sampled(random, surface, half, per_object, noise, seen)
    wide = (65.0, 55.0)
    share = wide[0] * wide[1] / (half[0] * half[1])
    beside = lambda x, y: (np.abs(x) > half[0]) | (np.abs(y) > half[1])
    around = sampled(random, behind, wide, int(per_object * share), noise, beside)
    return np.vstack([on, around])


def face_behind(x, y):
    return -14 + 0.004 * (x * x - y * y) + 3 * np.sin(x / 11) * np.cos(y / 13 + 1)


def jaw_behind(x, y):
    return -10 + 2.5 * np.sin(x / 6) * np.sin(y / 8 + 0.7) + 0.05 * x


def isopach(program, *words):
    run = subprocess.run([program, *map(str, words)], capture_output=True, text=True)
    return run.returncode, run.stdout, run.stderr


def write_pose(path, m):
    Path(path).write_text("\n".join(" ".join(repr(float(v)) for v in row) for row in m) + "\n")


def combine(program, folder, scans, starts=None):
    for name, points in scans.items():
        write_ply(folder / f"{name}.ply", points)
    words = ["combine", folder / "face.ply", folder / "jaw.ply", "--reference", folder / "reference.ply", "--json", "-"]
    if starts:
        for name, m in starts.items():
            write_pose(folder / f"{name}.txt", m)
            words += [f"--start-{name}", folder / f"{name}.txt"]
    code, out, err = isopach(program, *words)
    return code, json.loads(out) if code == 0 else None, err.strip().splitlines()[-1:] or [""]


def twist(found, true, centre):
    """Turn and shift, about `centre` (coordinates of the target), that take the true pose to the found one."""
    d = found @ np.linalg.inv(true)
    r = d[:3, :3]
    w = np.array([r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1]]) / 2
    return np.concatenate([w, moved(d, centre) - centre])


class Setting:
    """Face, jaw and reference with their true poses."""

    def __init__(self, seed, face=2500, jaw=2500, reference=2500, noise=(0.05, 0.05, 0.05), hidden=(0.15, 0.15)):
        random = rng(seed)
        self.poses = {k: any_pose(random) for k in ("face", "jaw", "reference")}
        local = {"face": scan_with_object(random, face, noise[0], hidden[0], face_behind),
                 "jaw": scan_with_object(random, jaw, noise[1], hidden[1], jaw_behind),
                 "reference": sampled(random, fork, HALF, reference, noise[2])}
        self.scans = {k: moved(self.poses[k], p) for k, p in local.items()}
        back = np.linalg.inv(self.poses["reference"])
        self.true = {k: self.poses[k] @ back for k in ("face", "jaw")}
        self.true_chain = self.true["face"] @ np.linalg.inv(self.true["jaw"])
        self.near = {k: pose(turn(random.normal(size=3) * 0.01), [0, 0, 0]) for k in ("face", "jaw")}

    def starts(self):
        """The truth, about a degree and some tenths of a millimetre off at the object."""
        result = {}
        for k in ("face", "jaw"):
            centre = self.poses[k][:3, 3]
            about = pose(np.eye(3), centre) @ self.near[k] @ pose(np.eye(3), -centre)
            result[k] = about @ self.true[k]
        return result


KINDS = {
    "equal": dict(face=2500, jaw=2500, reference=2500),
    "dense reference": dict(face=1500, jaw=1500, reference=20000),
    "sparse reference": dict(face=12000, jaw=12000, reference=1500),
    "dense, noisy reference": dict(face=1500, jaw=1500, reference=20000, noise=(0.05, 0.05, 0.15)),
    "half hidden": dict(face=3000, jaw=3000, reference=6000, hidden=(0.5, 0.4)),
}


def errors(setting, result):
    """chi² and pulls of the whole pose, error of the turn (degrees) and of the object's middle (mm), what was said."""
    centre = np.array(result["uncertainty"]["centre"])
    d = twist(np.array(result["pose"]["matrix"]), setting.true_chain, centre)
    c = np.array(result["uncertainty"]["covariance"])
    return (float(d @ np.linalg.solve(c, d)), d / np.sqrt(np.diag(c)), np.degrees(np.linalg.norm(d[:3])),
            np.linalg.norm(d[3:]), np.degrees(np.sqrt(np.trace(c[:3, :3]))), np.sqrt(np.trace(c[3:, 3:])))


def pulls(program, runs):
    print("| kind | runs | refused | error, degrees: rms (stated) | mm: rms (stated) | pulls within 1.96 | rms pull | "
          "chi² of 6: mean, share below 95 % |\n|---|---|---|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as name:
        for kind, how in KINDS.items():
            rows, refused = [], 0
            for seed in range(runs):
                s = Setting(seed + 1000, **how)
                code, result, _ = combine(program, Path(name), s.scans, s.starts())
                if code:
                    refused += 1
                else:
                    rows.append(errors(s, result))
            if not rows:
                print(f"| {kind} | {runs} | {refused} |")
                continue
            chi, pull = np.array([r[0] for r in rows]), np.array([r[1] for r in rows])
            rms = lambda k: np.sqrt(np.mean([r[k] ** 2 for r in rows]))
            print(f"| {kind} | {runs} | {refused} | {rms(2):.4f} ({rms(4):.4f}) | {rms(3):.4f} ({rms(5):.4f}) | "
                  f"{100 * np.mean(np.abs(pull) < 1.96):.1f} % | {np.sqrt(np.mean(pull ** 2)):.2f} | "
                  f"{chi.mean():.2f}, {100 * np.mean(chi < 12.592):.1f} % |", flush=True)


def density(program, seeds=8):
    print("| points of the reference | error, degrees: rms (stated) | mm: rms (stated) |\n|---|---|---|")
    with tempfile.TemporaryDirectory() as name:
        for count in (800, 1600, 3200, 10000, 30000, 100000):
            rows = []
            for seed in range(seeds):
                s = Setting(seed + 50, face=1500, jaw=1500, reference=count)
                code, result, said = combine(program, Path(name), s.scans, s.starts())
                if code == 0:
                    rows.append(errors(s, result))
                else:
                    print(f"| {count} | {said[0]} |")
            if rows:
                rms = lambda k: np.sqrt(np.mean([r[k] ** 2 for r in rows]))
                print(f"| {count} | {rms(2):.4f} ({rms(4):.4f}) | {rms(3):.4f} ({rms(5):.4f}) |", flush=True)


# ------------------------------------------------------------------ sequence


def head(x, y):
    """A face of 150 by 200 mm, made of bumps."""
    z = 70 * np.sqrt(np.maximum(0.05, 1 - (x / 95) ** 2 - (y / 130) ** 2))
    for cx, cy, wx, wy, h in ((0, 8, 9, 17, 20), (-32, 32, 13, 9, -7), (32, 32, 13, 9, -7), (0, -34, 20, 7, 5),
                              (0, -68, 17, 12, 7), (-40, -5, 16, 14, 5), (42, -7, 15, 15, 4.5), (3, 70, 40, 14, 3)):
        z = z + h * np.exp(-((x - cx) / wx) ** 2 / 2 - ((y - cy) / wy) ** 2 / 2)
    return z


class Jaw:
    """Frames of a head whose lower part opens about an axis from ear to ear."""

    def __init__(self, seed, angles, points=8000, noise=0.08, share=0.316, zone=5.0, hinge=(0, 10, 0), sway=0.3,
                 upright=None):
        self.random, self.seed, self.angles, self.points, self.noise = rng(seed), seed, list(angles), points, noise
        self.half = (70.0, 95.0)
        self.line = -self.half[1] + 2 * self.half[1] * share
        self.zone, self.hinge, self.sway = zone, np.array(hinge, float), sway
        self.upright = np.eye(4) if upright is None else upright

    def blend(self, x, y):
        t = np.clip((self.line - y) / self.zone + 0.5, 0, 1)
        return t * t * (3 - 2 * t)

    def jaw(self, k):
        r = turn(np.radians(self.angles[k]) * np.array([1.0, 0.02, 0.01]))
        return pose(r, self.hinge - r @ self.hinge)

    def head(self, k):
        random = rng((self.seed, 77))
        steps = self.sway * random.normal(size=(len(self.angles), 6))
        s = steps[: k + 1].sum(axis=0) if k else np.zeros(6)
        return pose(turn(np.radians(0.5 * s[:3])), s[3:] * 0.5)

    def frame(self, k, points=None, crop=None):
        random = rng((self.seed, k))
        xy = random.uniform([-self.half[0], -self.half[1]], self.half, (points or self.points, 2))
        if crop is not None:
            xy = xy[crop(xy[:, 0], xy[:, 1])]
        p = np.column_stack([xy, head(xy[:, 0], xy[:, 1])])
        b = self.blend(xy[:, 0], xy[:, 1])[:, None]
        q = (1 - b) * p + b * moved(self.jaw(k), p)
        q = moved(self.head(k), q)
        q[:, 2] += self.noise * random.normal(size=len(q))
        return moved(self.upright, q)

    def motion(self, k, reference=0):
        """True motion of the jaw relative to the head, coordinates of frame `reference` (at rest: angle 0)."""
        assert self.angles[reference] == 0 and np.allclose(self.head(reference), np.eye(4))
        return self.upright @ self.jaw(k) @ np.linalg.inv(self.upright)


def sequence(program, folder, frames, *words):
    for old in folder.glob("frame*.ply"):
        old.unlink()
    names = []
    for k, points in enumerate(frames):
        names.append(folder / f"frame{k:03d}.ply")
        write_ply(names[-1], points)
    code, out, err = isopach(program, "sequence", *names, "--json", "-", *words)
    return code, json.loads(out) if code == 0 else None, (err.strip().splitlines() or [""])[-1]


def motion_errors(s, result):
    """Worst error of the motion: degrees, and mm at the followed point; frames that were skipped."""
    chin = np.array(result["point"]["place"] if isinstance(result["point"], dict) else result["point"])
    worst, skipped = np.zeros(2), 0
    for f in result["frames"]:
        if f.get("skipped"):
            skipped += 1
            continue
        d = twist(np.array(f["motion"]), s.motion(f["index"]), chin)
        worst = np.maximum(worst, [np.degrees(np.linalg.norm(d[:3])), np.linalg.norm(d[3:])])
    return worst, skipped


def jaw(program, runs):
    print("| opening | frames | points | runs | refused | worst error: degrees | mm at the chin | skipped |\n"
          "|---|---|---|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as name:
        for title, angles in (("8 degrees in 4 steps and back", [0, 2, 4, 6, 8, 6, 4, 2, 0]),
                              ("8 degrees in steps of 1", range(9)), ("2 degrees in steps of 0.5", [0, .5, 1, 1.5, 2])):
            for points in (3000, 8000):
                refused, worst, skipped, said = 0, np.zeros(2), 0, ""
                for seed in range(runs):
                    s = Jaw(seed, angles, points)
                    code, result, err = sequence(program, Path(name), [s.frame(k) for k in range(len(s.angles))])
                    if code:
                        refused, said = refused + 1, err
                        continue
                    w, n = motion_errors(s, result)
                    worst, skipped = np.maximum(worst, w), skipped + n
                print(f"| {title} | {len(s.angles)} | {points} | {runs} | {refused} | {worst[0]:.3f} | {worst[1]:.3f} | "
                      f"{skipped} |", flush=True)
                if said:
                    print(said)


# ------------------------------------------------------------------ what must not end with exit 0 and a wrong answer


def other_head(x, y):
    z = 62 * np.sqrt(np.maximum(0.05, 1 - (x / 90) ** 2 - (y / 140) ** 2))
    for cx, cy, wx, wy, h in ((0, 2, 13, 22, 13), (-36, 38, 15, 8, -5), (36, 38, 15, 8, -5), (0, -44, 26, 6, 7),
                              (0, -80, 13, 10, 9), (0, 60, 50, 20, 5)):
        z = z + h * np.exp(-((x - cx) / wx) ** 2 / 2 - ((y - cy) / wy) ** 2 / 2)
    return z


def stranger(seed, points=8000, noise=0.08):
    random = rng((seed, 4711))
    xy = random.uniform([-70, -95], [70, 95], (points, 2))
    return np.column_stack([xy, other_head(xy[:, 0], xy[:, 1]) + noise * random.normal(size=points)])


def nonsense(program, seeds):
    """Frames: a jaw that opens to 8 degrees, and what was done to it; wrong: a used frame off by 1.5 degrees or mm."""
    angles = [0, 2, 4, 6, 8, 6, 4]
    upside = pose(turn([0, 0, np.pi]), [0, 0, 0])
    side = pose(turn([0, 0, np.pi / 2]), [30, -10, 5]) @ pose(turn([0.2, 0.1, 0]), [0, 0, 0])

    def plain(s):
        return [s.frame(k) for k in range(len(s.angles))]

    def with_frame(s, k, change):
        frames = plain(s)
        frames[k] = change(frames[k])
        return frames

    mirror = np.diag([-1.0, 1, 1, 1])
    cases = [
        ("as it is", {}, plain),
        ("one frame of another face", {}, lambda s: with_frame(s, 3, lambda f: stranger(s.seed))),
        ("all frames but the first of another face", {},
         lambda s: [s.frame(0)] + [stranger(s.seed + k) for k in range(1, 7)]),
        ("every second frame of another face", {},
         lambda s: [f if k % 2 == 0 else stranger(s.seed + k) for k, f in enumerate(plain(s))]),
        ("one frame turned upside down", {}, lambda s: with_frame(s, 2, lambda f: moved(upside, f))),
        ("all frames but the first upside down", {},
         lambda s: [f if k == 0 else moved(upside, f) for k, f in enumerate(plain(s))]),
        ("one frame mirrored", {}, lambda s: with_frame(s, 4, lambda f: moved(mirror, f))),
        ("one frame 60 mm away", {}, lambda s: with_frame(s, 4, lambda f: f + [0, 60, 0])),
        ("a plane instead of a frame", {},
         lambda s: with_frame(s, 3, lambda f: np.column_stack([f[:, :2], 20 + 0.05 * rng(1).normal(size=len(f))]))),
        ("order 0, 4, 1, 5, 2", {"angles": [0, 8, 2, 6, 4, 6, 4]}, plain),
        ("closed, then 8 degrees at once", {"angles": [0, 8]}, plain),
        ("closed, then 15 degrees at once", {"angles": [0, 15]}, plain),
        ("2 frames, 2 degrees", {"angles": [0, 2]}, plain),
        ("3 frames, 1.5 degrees", {"angles": [0, 1, 1.5]}, plain),
        ("noise of 0.3 mm", {"noise": 0.3}, plain),
        ("lying on its side", {"upright": side}, plain),
        ("frames of 3000 to 24 000 points", {},
         lambda s: [s.frame(k, (8000, 3000, 24000, 6000, 12000, 4000, 9000)[k]) for k in range(7)]),
        ("frames cropped at one side", {},
         lambda s: [s.frame(k, crop=(lambda x, y: x < 20) if k in (2, 3) else None) for k in range(7)]),
        ("a frame without the jaw", {}, lambda s: [s.frame(k, crop=(lambda x, y: y > -30) if k == 3 else None)
                                                   for k in range(7)]),
        ("frames 2 and 3 lost", {"angles": [0, 2, 8, 6, 4]}, plain),
    ]
    print("| frames | runs | refused | frames used | frames skipped | wrong | worst error: degrees | mm at the chin |\n"
          "|---|---|---|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as name:
        for title, how, make in cases:
            refused, used, skipped, wrong, worst, said = 0, 0, 0, 0, np.zeros(2), set()
            for seed in range(seeds):
                s = Jaw(seed, **{"angles": angles, **how})
                code, result, err = sequence(program, Path(name), make(s))
                if code:
                    refused += 1
                    said.add(err)
                    continue
                w, n = motion_errors(s, result)
                wrong += bool(w.max() > 1.5)
                used, skipped, worst = used + len(result["frames"]) - n, skipped + n, np.maximum(worst, w)
                said.update(result["warnings"])
            print(f"| {title} | {seeds} | {refused} | {used} | {skipped} | {wrong} | {worst[0]:.2f} | {worst[1]:.2f} |",
                  flush=True)
            if "-v" in sys.argv:
                for line in sorted(said):
                    print("    ", line)


def wrong(program, seeds):
    """Objects that no scan can tell, or that are not there: the exit code of each, and how far off exit 0 was."""
    def disc(x, y):
        return 0.0 * x

    def ball(x, y):
        return np.sqrt(np.maximum(1, 40 ** 2 - x * x - y * y))

    def ridge(x, y):
        return 3 * np.sin(x / 5)

    def even(x, y):
        return 4 * np.exp(-(np.abs(x) - 15) ** 2 / 40 - y * y / 60)

    def faint(x, y):
        return even(x, y) + 1.0 * np.exp(-((x - 5) ** 2 + (y - 9) ** 2) / 8)

    def other(x, y):
        return fork(-x, y) + 2 * np.sin(y / 5)

    cases = [("fork", fork, fork, 0.15), ("fork, 70 % hidden", fork, fork, 0.7), ("fork, 85 % hidden", fork, fork, 0.85),
             ("plain plate", disc, disc, 0.1), ("ball", ball, ball, 0.1), ("straight ridges", ridge, ridge, 0.1),
             ("two equal hills (half turn)", even, even, 0.1), ("the same with a faint mark", faint, faint, 0.1),
             ("scans of another fork", fork, other, 0.1), ("mirrored fork", fork, lambda x, y: fork(-x, y), 0.1),
             ("no object in the scans", fork, None, 0.1)]
    print("| object | runs | exit 0 | 4 | 5 | wrong with exit 0 | worst error with exit 0: degrees, mm |\n"
          "|---|---|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as name:
        for title, of_reference, of_scans, hidden in cases:
            codes, bad, worst, said = [], 0, np.zeros(2), set()
            for seed in range(seeds):
                random = rng((seed, 99))
                poses = {k: any_pose(random) for k in ("face", "jaw", "reference")}
                scans = {"reference": sampled(random, of_reference, HALF, 4000, 0.05)}
                for k, behind in (("face", face_behind), ("jaw", jaw_behind)):
                    if of_scans is None:
                        scans[k] = sampled(random, behind, (65.0, 55.0), 9000, 0.05)
                    else:
                        scans[k] = scan_with_object(random, 2500, 0.05, hidden, behind, of_scans)
                scans = {k: moved(poses[k], p) for k, p in scans.items()}
                code, result, err = combine(program, Path(name), scans)
                codes.append(code)
                if code:
                    said.add(err[0])
                    continue
                true = poses["face"] @ np.linalg.inv(poses["jaw"])
                d = twist(np.array(result["pose"]["matrix"]), true, np.array(result["uncertainty"]["centre"]))
                w = np.array([np.degrees(np.arccos(np.clip((np.trace((np.array(result["pose"]["matrix"])
                              @ np.linalg.inv(true))[:3, :3]) - 1) / 2, -1, 1))), np.linalg.norm(d[3:])])
                bad += bool(w.max() > 1 or of_scans is not of_reference)
                worst = np.maximum(worst, w)
            count = lambda c: sum(1 for x in codes if x == c)
            print(f"| {title} | {seeds} | {count(0)} | {count(4)} | {count(5)} | {bad} | {worst[0]:.2f}, {worst[1]:.2f} |",
                  flush=True)
            if "-v" in sys.argv:
                for line in sorted(said)[:3]:
                    print("    ", line)


if __name__ == "__main__":
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    runs = int(sys.argv[3]) if len(sys.argv) > 3 else None
    what = {"pulls": lambda p: pulls(p, runs or 200), "density": lambda p: density(p, runs or 8),
            "jaw": lambda p: jaw(p, runs or 30), "wrong": lambda p: wrong(p, runs or 5),
            "nonsense": lambda p: nonsense(p, runs or 3)}
    what[sys.argv[2]](sys.argv[1])
