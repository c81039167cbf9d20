#!/usr/bin/env python3
"""Matching against small_gicp, Open3D and CloudCompare in one run: simulated and real pairs with known poses; writes a
page.

    python3 -B bench/rivals/matching.py --isopach build/release/bin/isopach [--data DIR] [--points N] [--page FILE]

Makes a virtual environment in build/rivals with what PyPI has for this Python (numpy, scipy, small_gicp, open3d-cpu);
CloudCompare is that of the system. A rival that cannot be had is left out and named. Times of the tables are CPU
seconds on one thread, the least of the repeats: of a rival thinning, normals and search, without reading; of isopach
and CloudCompare the whole process. The part `speed` has its own rules, told there.
"""

import argparse
import importlib.metadata
import json
import math
import os
import pathlib
import resource
import shutil
import subprocess
import sys
import tempfile
import time
import venv

ROOT = pathlib.Path(__file__).resolve().parents[2]
RIVALS = ["small_gicp", "open3d-cpu"]
PARTS = ["speed", "face", "relief", "street", "bunny", "strips", "basin"]


def enter_environment():
    """Runs this script again by the Python of the environment, made on first use."""
    home = ROOT / "build" / "rivals"
    python = home / "bin" / "python3"
    if pathlib.Path(sys.prefix).resolve() == home.resolve():
        return
    if not python.exists():
        venv.create(home, with_pip=True)
        for package in ["numpy", "scipy", *RIVALS]:
            done = subprocess.run([python, "-m", "pip", "install", "--quiet", package])
            if done.returncode != 0 and package in ("numpy", "scipy"):
                sys.exit(f"{package} cannot be installed: without it there is no bench")
    os.environ.setdefault("OMP_NUM_THREADS", "1")  # two in the process of the part speed
    os.environ.update(OPENBLAS_NUM_THREADS="1", QT_QPA_PLATFORM="offscreen")
    os.execv(python, [str(python), "-B", *sys.argv])


# --- poses -----------------------------------------------------------------------------------------------------------


def turn(axis, degrees, centre, shift):
    """Rotation about an axis through `centre`, then a shift: a 4x4 matrix."""
    u = np.asarray(axis, float) / np.linalg.norm(axis)
    k = np.array([[0, -u[2], u[1]], [u[2], 0, -u[0]], [-u[1], u[0], 0]])
    angle = math.radians(degrees)
    pose = np.eye(4)
    pose[:3, :3] = np.eye(3) + math.sin(angle) * k + (1 - math.cos(angle)) * k @ k
    pose[:3, 3] = centre - pose[:3, :3] @ centre + shift
    return pose


def moved(points, pose):
    return points @ pose[:3, :3].T + pose[:3, 3]


def error(found, truth, points):
    """Degrees, and how far the middle of the moving scan is from where the truth takes it."""
    r = found[:3, :3] @ truth[:3, :3].T
    sine = np.linalg.norm([r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1]]) / 2
    middle = points.mean(axis=0)
    off = found[:3, :3] @ middle + found[:3, 3] - truth[:3, :3] @ middle - truth[:3, 3]
    return math.degrees(math.atan2(sine, (np.trace(r) - 1) / 2)), float(np.linalg.norm(off))


def off_points(found, truth, points):
    """RMS distance of the moving points from where the truth takes them: turn and shift in one number."""
    d = moved(points, found) - moved(points, truth)
    return float(np.sqrt((d * d).sum(axis=1).mean()))


# --- files -----------------------------------------------------------------------------------------------------------


def write_ply(path, points):
    head = f"ply\nformat binary_little_endian 1.0\nelement vertex {len(points)}\n"
    head += "".join(f"property double {axis}\n" for axis in "xyz") + "end_header\n"
    path.write_bytes(head.encode() + np.ascontiguousarray(points, "<f8").tobytes())


def read_points(path, tool, folder):
    """Through `isopach convert`, so that all tools get the same points."""
    copy = folder / (path.stem + "-points.xyz")
    tool("convert", path, copy)
    return np.loadtxt(copy, usecols=(0, 1, 2), comments=["#", "//"])


def cpu_of_children():
    """CPU seconds of all processes that were started and have ended."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


class Isopach:
    def __init__(self, binary):
        self.binary = str(pathlib.Path(binary).resolve())

    def __call__(self, *words, codes=(0,)):
        run = subprocess.run([self.binary, *map(str, words)], capture_output=True, text=True)
        if run.returncode not in codes:
            raise RuntimeError(f"{' '.join(map(str, words))}: {run.stderr.strip()}")
        return run

    def match(self, folder, moving, fixed, *words):
        before = cpu_of_children()
        run = self("match", moving, fixed, "--json", "-", "--threads", 1, *words, codes=(0, 4, 5))
        seconds = cpu_of_children() - before
        return (np.array(json.loads(run.stdout)["pose"]["matrix"]) if run.stdout else None), seconds

    def search(self, moving, fixed, threads, *words):
        """Pose, and the wall seconds of all stages but reading and writing."""
        run = self("match", moving, fixed, "--json", "-", "--pose-only", "--threads", threads, *words, codes=(0, 5))
        told = json.loads(run.stdout)
        timing = told["timing_s"]
        return np.array(told["pose"]["matrix"]), timing["total"] - timing["read"] - timing["write"]


# --- rivals ----------------------------------------------------------------------------------------------------------


class Pair:
    """`moving` on `fixed`; `truth` is the pose that does it. Rivals get both less the mean of `fixed`."""

    def __init__(self, name, moving, fixed, truth, reaches, voxel, extent):
        self.name, self.moving, self.fixed, self.truth = name, moving, fixed, truth
        self.unmoved = None  # MOVING before it was moved, where the scans' own coordinates are not the truth
        self.planes = None   # where the given pose is a registration itself: what judges it and the methods
        self.reaches, self.voxel, self.extent = reaches, voxel, extent

    def centred(self):
        return self.moving - self.fixed.mean(axis=0), self.fixed - self.fixed.mean(axis=0)

    def uncentred(self, pose):
        back = np.eye(4)
        back[:3, 3] = self.fixed.mean(axis=0)
        return back @ pose @ np.linalg.inv(back)


def by_small_gicp(kind, voxel_share, threads=1, last=None):
    """`last`: one more stage, with this longest pair."""
    def run(pair):
        moving, fixed = pair.centred()
        pose = np.eye(4)
        start, wall = time.process_time(), time.perf_counter()
        voxel = pair.voxel * voxel_share
        how = {"num_neighbors": 20, "num_threads": threads}
        if voxel > 0:
            how["downsampling_resolution"] = voxel
            target, tree = small_gicp.preprocess_points(fixed, **how)
            source, _ = small_gicp.preprocess_points(moving, **how)
        else:
            target, source = small_gicp.PointCloud(fixed), small_gicp.PointCloud(moving)
            tree = small_gicp.KdTree(target, num_threads=threads)
            small_gicp.estimate_normals_covariances(target, tree, **how)
            small_gicp.estimate_normals_covariances(source, small_gicp.KdTree(source, num_threads=threads), **how)
        for reach in (*pair.reaches, last) if last else pair.reaches:
            found = small_gicp.align(target, source, tree, init_T_target_source=pose, registration_type=kind,
                                     max_correspondence_distance=reach, num_threads=threads, max_iterations=50)
            pose = found.T_target_source
        pair.wall = time.perf_counter() - wall
        return pair.uncentred(pose), time.process_time() - start

    return run


def open3d_cloud(points, voxel):
    cloud = open3d.geometry.PointCloud(open3d.utility.Vector3dVector(points))
    if voxel > 0:
        cloud = cloud.voxel_down_sample(voxel)
    cloud.estimate_normals(open3d.geometry.KDTreeSearchParamKNN(20))
    return cloud


def open3d_refine(source, target, pose, reaches, tukey=None):
    """`tukey`: the last stage once more with Tukey's weights of this width."""
    r = open3d.pipelines.registration
    plane = r.TransformationEstimationPointToPlane
    stages = [(reach, plane()) for reach in reaches] + ([(reaches[-1], plane(r.TukeyLoss(tukey)))] if tukey else [])
    for reach, objective in stages:
        pose = r.registration_icp(source, target, reach, pose, objective,
                                  r.ICPConvergenceCriteria(1e-9, 1e-9, 50)).transformation
    return pose


def by_open3d(voxel_share, tukey=None):
    def run(pair):
        moving, fixed = pair.centred()
        start, wall = time.process_time(), time.perf_counter()
        source, target = (open3d_cloud(p, pair.voxel * voxel_share) for p in (moving, fixed))
        pose = pair.uncentred(open3d_refine(source, target, np.eye(4), pair.reaches, tukey))
        pair.wall = time.perf_counter() - wall
        return pose, time.process_time() - start

    return run


def by_open3d_features(pair):
    """FPFH and RANSAC on thinned scans, by the values of its manual, then point-to-plane."""
    r = open3d.pipelines.registration
    moving, fixed = pair.centred()
    start = time.process_time()
    voxel = 0.02 * pair.extent
    thin = [open3d_cloud(p, voxel) for p in (moving, fixed)]
    features = [r.compute_fpfh_feature(c, open3d.geometry.KDTreeSearchParamHybrid(5 * voxel, 100)) for c in thin]
    open3d.utility.random.seed(1)
    pose = r.registration_ransac_based_on_feature_matching(
        thin[0], thin[1], features[0], features[1], True, 1.5 * voxel, r.TransformationEstimationPointToPoint(False), 3,
        [r.CorrespondenceCheckerBasedOnEdgeLength(0.9), r.CorrespondenceCheckerBasedOnDistance(1.5 * voxel)],
        r.RANSACConvergenceCriteria(100000, 0.999)).transformation
    source, target = (open3d_cloud(p, pair.voxel) for p in (moving, fixed))
    pose = open3d_refine(source, target, pose, pair.reaches)
    return pair.uncentred(pose), time.process_time() - start


def by_cloudcompare(folder):
    """Its ICP (point to point) as it is, told the share in common; its random sample is that of its default, 50000."""
    def run(pair):
        moving, fixed = pair.centred()
        with tempfile.TemporaryDirectory(dir=folder) as name:
            place = pathlib.Path(name)
            write_ply(place / "moving.ply", moving)
            write_ply(place / "fixed.ply", fixed)
            before = cpu_of_children()
            words = "-SILENT -AUTO_SAVE OFF -O moving.ply -O fixed.ply -ICP -OVERLAP 70"
            subprocess.run(["CloudCompare", *words.split()], cwd=place, capture_output=True)
            seconds = cpu_of_children() - before
            found = list(place.glob("moving_REGISTRATION_MATRIX*"))
            return (pair.uncentred(np.loadtxt(found[0])) if found else None), seconds

    return run


def by_isopach(tool, folder, *words):
    def run(pair):
        moving, fixed = folder / "moving.ply", folder / "fixed.ply"
        write_ply(moving, pair.moving)
        write_ply(fixed, pair.fixed)
        return tool.match(folder, moving, fixed, *words)

    return run


def methods(tool, folder, whole):
    """Name, what runs it, whether it looks for a start of its own."""
    found = [(f"isopach {' '.join(w)}", by_isopach(tool, folder, *w), "--coarse" in w)
             for w in [("--objective", "measure"), ("--objective", "icp-plane"), ("--objective", "icp-gicp"), ("--objective", "icp-point"),
                       ("--objective", "measure", "--coarse"), ("--objective", "icp-plane", "--coarse")]]
    if small_gicp:
        found += [("small_gicp GICP", by_small_gicp("GICP", 1), False),
                  ("small_gicp point-to-plane", by_small_gicp("PLANE_ICP", 1), False)]
    if shutil.which("CloudCompare"):
        found += [("CloudCompare ICP, 70 % in common", by_cloudcompare(folder), False)]
    if open3d:
        found += [("Open3D point-to-plane", by_open3d(1), False),
                  ("Open3D FPFH + RANSAC, then point-to-plane", by_open3d_features, True)]
        if whole:
            found += [("Open3D point-to-plane, all points", by_open3d(0), False)]
    return found


# --- pairs -----------------------------------------------------------------------------------------------------------


def simulated(tool, folder, scene, words, points, extent, cut, away, seed):
    tool("simulate", scene, "-o", folder / scene, "--points", points, "--points-b", points, "--format", "ply", "--seed",
         seed, *words)
    scans = [read_points(folder / scene / f"{name}.ply", tool, folder) for name in "ab"]
    if cut > 0:
        low, high = scans[0][:, 1].min(), scans[0][:, 1].max()
        share = cut / 2 * (high - low)
        scans = [scans[0][scans[0][:, 1] < high - share], scans[1][scans[1][:, 1] > low + share]]
    fixed, moving = scans
    pose = away(moving.mean(axis=0))
    return moved(moving, pose), fixed, np.linalg.inv(pose), extent


def face(tool, folder, points, degrees, axis=(1, 2, 3), shift=0.03, seed=1):
    parts = simulated(tool, folder, "face", ["--noise", 0.05, "--noise-b", 0.05], points, 220, 0.3,
                      lambda c: turn(axis, degrees, c, np.array([1, -1, 1]) * shift * 220 / math.sqrt(3)), seed)
    return Pair(f"face, {points} points, 30 % unmatched, swollen cheek", *parts[:3], (22, 2.2), 1.0, 220)


def relief(tool, folder, points, degrees, axis=(1, 2, 3), seed=1):
    parts = simulated(tool, folder, "relief", ["--variant", "rough"], points, 1000, 0,
                      lambda c: turn(axis, degrees, c, np.array([1, -1, 1]) * 50 / math.sqrt(3)), seed)
    name = f"rough relief, {points} points, a mound and a pit between the scans"
    return Pair(name, *parts[:3], (200, 50, 10), 5.0, 1000)


def street(tool, folder, data):
    d = data / "small-gicp"
    moving, fixed = (read_points(d / f"{n}.ply", tool, folder) for n in ("source", "target"))
    truth = np.loadtxt(d / "T_target_source.txt")
    pair = Pair("street, two scans of a vehicle (`small-gicp`), from no motion", moving, fixed, truth, (2.0, 0.5), 0.25,
                float(np.linalg.norm(np.ptp(fixed, axis=0))))
    pair.planes = Planes(fixed[np.any(fixed != 0, axis=1)], 0.6, 0.02)  # zeros: rays without an echo
    return pair


def bunny(tool, folder, data, near):
    d = data / "stanford-bunny-range"
    moving, fixed = (read_points(d / f"{n}.ply", tool, folder) for n in ("bun045", "bun000"))
    truth = None
    for line in (d / "bun.conf").read_text().splitlines():
        words = line.split()
        if words[:2] == ["bmesh", "bun045.ply"]:
            x, y, z, w = map(float, words[5:9])
            r = np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                          [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                          [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])
            truth = np.eye(4)
            truth[:3, :3], truth[:3, 3] = r.T, list(map(float, words[2:5]))
    name = "bunny, views from 0 and 45 degrees (`stanford-bunny-range`)"
    planes = Planes(fixed, 0.0025, 0.0002)
    if near:
        start = turn((1, 2, 3), 5, moved(moving, truth).mean(axis=0), 0.003) @ truth
        pair = Pair(name + ", 5 degrees off", moved(moving, start), fixed, truth @ np.linalg.inv(start), (0.01, 0.002),
                    0.001, 0.15)
    else:
        pair = Pair(name + ", as scanned: 34 degrees off", moving, fixed, truth, (0.03, 0.01, 0.002), 0.001, 0.15)
    pair.planes = planes
    return pair


def strips(tool, folder, data):
    d = data / "santacruz"
    moving, fixed = (read_points(d / f"blanca_strip{n}_120m.las", tool, folder) for n in (8707, 8706))
    pose = turn((0.1, -0.2, 1), 4, moving.mean(axis=0), np.array([3, -2, 1.5]))
    pair = Pair("two flight strips (`santacruz`), the second moved by 4 degrees and 3.9 m", moved(moving, pose), fixed,
                np.linalg.inv(pose), (10, 2), 1.0, 120)
    pair.unmoved = Pair(pair.name, moving, fixed, np.eye(4), pair.reaches, pair.voxel, pair.extent)
    return pair


class Planes:
    """Planes through all points of FIXED around a place, where they are flat: what a pose can be judged by without a
    truth and without nearest points, which rings and sampling enter."""

    def __init__(self, fixed, radius, flat):
        tree = cKDTree(fixed)
        self.radius, self.flat = radius, flat
        places, normals = [], []
        for i in np.random.default_rng(1).permutation(len(fixed))[:12000]:
            near = fixed[tree.query_ball_point(fixed[i], radius)]
            if len(near) < 20:
                continue
            middle = near.mean(axis=0)
            sizes, axes = np.linalg.eigh((near - middle).T @ (near - middle) / len(near))
            if sizes[0] < flat ** 2 and sizes[1] > 0.3 * sizes[2]:
                places.append(middle)
                normals.append(axes[:, 0])
        self.places, self.normals = np.array(places), np.array(normals)
        self.tree = cKDTree(self.places)

    def residuals(self, pose, points):
        """Where the points are, their plane and their distance from it, and which of them are near it."""
        at = moved(points, pose)
        far, plane = self.tree.query(at)
        normals = self.normals[plane]
        off = ((at - self.places[plane]) * normals).sum(axis=1)
        beside = np.sqrt(np.maximum(0, far * far - off * off))
        return at, normals, off, (beside < 0.4 * self.radius) & (np.abs(off) < 6 * self.flat)

    def middle(self, pose, points):
        _, _, off, near = self.residuals(pose, points)
        return float(np.median(np.abs(off[near])))

    def fit(self, pose, points, counts=None):
        """Least squares with Tukey's weights from `pose` on; `counts`: how often each point counts."""
        centre = moved(points, pose).mean(axis=0)
        for _ in range(40):
            at, normals, off, near = self.residuals(pose, points)
            weight = np.where(near, np.clip(1 - (off / (2.5 * self.flat)) ** 2, 0, 1) ** 2, 0)
            if counts is not None:
                weight = weight * counts
            rows = np.hstack([np.cross(at - centre, normals), normals])
            x = np.linalg.solve((rows.T * weight) @ rows, -(rows.T * weight) @ off)
            angle = np.linalg.norm(x[:3])
            pose = turn(x[:3] if angle > 0 else (0, 0, 1), math.degrees(angle), centre, x[3:]) @ pose
            if angle < 1e-9:
                break
        return pose

    def told(self, pair):
        """The given pose against a fit to the planes, and how far that goes when cubes of surface are drawn anew."""
        points = pair.moving[np.any(pair.moving != 0, axis=1)]
        own = self.fit(pair.truth, points)
        _, cube = np.unique(np.floor(moved(points, pair.truth) / (6 * self.radius)).astype(int), axis=0,
                            return_inverse=True)
        cube = cube.ravel()
        draws = np.random.default_rng(1)
        off = []
        for _ in range(20):
            counts = np.bincount(draws.integers(0, cube.max() + 1, cube.max() + 1), minlength=cube.max() + 1)
            off.append(error(self.fit(own, points, counts[cube]), own, points))
        degrees, shift = error(own, pair.truth, points)
        spread = np.sqrt((np.array(off) ** 2).mean(axis=0))
        before, after = self.middle(pair.truth, points), self.middle(own, points)
        return (f"The given pose is a registration itself. At it the points of MOVING are {before:.3g} from planes of "
                f"FIXED (median; planes through all points within {self.radius:g} where these are flat). A fit to "
                f"these planes and nothing else brings this to {after:.3g}; it is {degrees:.2g} degrees and "
                f"{shift:.2g} from the given pose, and moves by {spread[0]:.2g} degrees and {spread[1]:.2g} when cubes "
                "of the surface are drawn anew (RMS of 20 draws): errors below these numbers tell nothing.")


# --- speed -----------------------------------------------------------------------------------------------------------


def speed(tool, folder, size, repeats, say):
    """Time to the same accuracy, two threads each."""
    say("\n## Speed at the same accuracy, two threads each\n")
    say(f"Face of {size} points a scan, relief of {size // 2}. Wall-clock seconds; preprocessing counted, reading not. "
        "Errors are the RMS over three pairs of other seeds: rotation, and distance of the points from their "
        "true places (turn and shift in one). Of each rival first many settings: voxels, a last stage with a short "
        "longest pair, Tukey's weights; their lengths are chosen by hand, knowing the noise. In bold the quickest "
        "that is as accurate as isopach's measure, else the most accurate one; their times are medians of "
        f"{repeats} runs, in turns, on the first pair (more than 12 s: one run).")
    for make, count, shares, short, tukey in ((face, size, (0.5, 1, 2), (0.5, 0.25), 0.2),
                                              (relief, size // 2, (0.4, 1, 2), (2.5, 1), 0.5)):
        seeds = [make(tool, folder, count, 5, seed=seed) for seed in (1, 2, 3)]
        speed_table(tool, folder, seeds, (shares, short, tukey), repeats, say)


def speed_table(tool, folder, pairs, settings_of_rivals, repeats, say):
    shares, short, tukey = settings_of_rivals
    for k, pair in enumerate(pairs):
        write_ply(folder / f"moving{k}.ply", pair.moving)
        write_ply(folder / f"fixed{k}.ply", pair.fixed)

    def by_own(*words):
        def run(pair):
            k = pairs.index(pair)
            pose, pair.wall = tool.search(folder / f"moving{k}.ply", folder / f"fixed{k}.ply", 2, *words)
            return pose, 0
        return run

    families = [("isopach --objective measure", [("", by_own("--objective", "measure"))]),
                ("isopach --objective icp-plane", [("", by_own("--objective", "icp-plane"))]),
                ("isopach --objective icp-gicp", [("", by_own("--objective", "icp-gicp"))])]

    def label(share, more=""):
        return (f", voxel {share * pairs[0].voxel:g}" if share else ", all points") + more

    if small_gicp:
        families += [("small_gicp GICP", [(label(v), by_small_gicp("GICP", v, 2)) for v in (0, *shares)]
                      + [(label(v, f", last within {r:g}"), by_small_gicp("GICP", v, 2, r))
                         for v in shares for r in short])]
    if open3d:
        families += [("Open3D point-to-plane", [(label(v), by_open3d(v)) for v in shares[1:]]
                      + [(label(v, f", Tukey {tukey:g}"), by_open3d(v, tukey)) for v in shares])]
    rows = []
    for family, settings in families:
        for setting, run in settings:
            walls, off = [], []
            for pair in pairs:
                pose, _ = run(pair)
                walls.append(pair.wall)
                off.append((error(pose, pair.truth, pair.moving)[0], off_points(pose, pair.truth, pair.moving)))
                if walls[0] > 12:  # one pair will do
                    break
            degrees, far = np.sqrt((np.array(off) ** 2).mean(axis=0))
            rows.append({"family": family, "name": family + setting, "run": run, "degrees": degrees, "far": far,
                         "once": float(np.median(walls)), "pairs": len(walls), "walls": []})
    own = rows[0]
    chosen = [own, rows[1], rows[2]]
    for family, _ in families[3:]:
        of = [r for r in rows if r["family"] == family]
        equal = [r for r in of if r["far"] <= own["far"]]
        chosen.append(min(equal, key=lambda r: r["once"]) if equal else min(of, key=lambda r: r["far"]))
    for _ in range(repeats):
        for r in chosen:
            if r["once"] < 12:
                r["run"](pairs[0])
                r["walls"].append(pairs[0].wall)
    seconds = lambda r: float(np.median(r["walls"])) if r["walls"] else r["once"]
    say(f"\n{pairs[0].name[0].upper()}{pairs[0].name[1:]}:\n")
    say("| method | rotation error, degrees | points off, unit | s | times isopach's measure |")
    say("|---|---|---|---|---|")
    for r in rows:
        bold = "**" if any(r is c for c in chosen) else ""
        few = "" if r["pairs"] == len(pairs) else " (one pair)"
        say(f"| {bold}{r['name']}{bold}{few} | {r['degrees']:.2g} | {r['far']:.2g} | {seconds(r):.2f} | "
            f"{seconds(r) / seconds(own):.1f} |")
    equal = [r for r in rows[3:] if r["far"] <= own["far"]]
    if equal:
        best = min(equal, key=seconds)
        say(f"\nThe fastest rival as accurate, {best['name']}, takes {seconds(best) / seconds(own):.1f} times as long.")
    elif len(rows) > 3:
        best = min(rows[3:], key=lambda r: r["far"])
        say(f"\nNo setting of a rival is as accurate as isopach's measure. The most accurate, {best['name']}, ends "
            f"{best['far'] / own['far']:.1f} times as far off and takes {seconds(best) / seconds(own):.1f} times as "
            "long.")


# --- the page --------------------------------------------------------------------------------------------------------


def row(name, run, pair, repeats):
    best = None
    for _ in range(repeats):
        pose, seconds = run(pair)
        if pose is None:
            rest = " |" if pair.planes else " | |" if pair.unmoved else ""
            return f"| {name} | no pose | | | {seconds:.2f} |" + rest
        best = min(best or seconds, seconds)
    degrees, off = error(pose, pair.truth, pair.moving)
    line = f"| {name} | {degrees:.2g} | {off:.2g} | {off / pair.extent:.1e} | {best:.2f} |"
    if pair.unmoved:
        own, _ = run(pair.unmoved)
        degrees, off = error(pose, own @ pair.truth, pair.moving)
        line += f" {degrees:.2g} | {off:.2g} |"
    if pair.planes:
        line += f" {pair.planes.middle(pose, pair.moving):.3g} |"
    return line


def table(pair, all_methods, repeats, say):
    say(f"\n## {pair.name[0].upper()}{pair.name[1:]}\n")
    say("| method | rotation error, degrees | shift error, unit | over the extent | CPU, s |"
        + (" from its answer without the move: degrees | unit |" if pair.unmoved else "")
        + (" from planes of FIXED, unit |" if pair.planes else ""))
    say("|---|---|---|---|---|" + ("---|---|" if pair.unmoved else "") + ("---|" if pair.planes else ""))
    for name, run, _ in all_methods:
        say(row(name, run, pair, repeats))
    if pair.planes:
        say("\n" + pair.planes.told(pair))


def basin(make, angles, all_methods, say):
    say("\n| method | " + " | ".join(map(str, angles)) + " |")
    say("|---" * (len(angles) + 1) + "|")
    pairs = [make(a) for a in angles]
    for name, run, _ in all_methods:
        cells = []
        for pair in pairs:
            pose, _ = run(pair)
            cells.append("no pose" if pose is None else f"{error(pose, pair.truth, pair.moving)[0]:.2g}")
        say(f"| {name} | " + " | ".join(cells) + " |")


def basins(tool, folder, say):
    say("\n## Basin: rotation error in degrees after starts so many degrees off\n")
    say("3 % (face) or 5 % (relief) of the extent beside; 10 000 points each.")
    some = [m for m in methods(tool, folder, False) if "icp-point" not in m[0] and "CloudCompare" not in m[0]]
    for words, make in [("Face, about the axis of projection", lambda a: face(tool, folder, 10000, a, (0, 0, 1))),
                        ("Rough relief, about the axis", lambda a: relief(tool, folder, 10000, a, (0, 0, 1)))]:
        say(f"\n{words}:")
        basin(make, [30, 60, 120, 180], some, say)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--isopach", default=str(ROOT / "build/release/bin/isopach"))
    parser.add_argument("--data", type=pathlib.Path, help="folder of the real pairs; without it they are left out")
    parser.add_argument("--page", type=pathlib.Path, help="file to write (default: stdout alone)")
    parser.add_argument("--points", type=int, default=20000, help="of each scan of the face; half of it of the relief")
    parser.add_argument("--speed-points", type=int, default=200000, help="the same of the part speed")
    parser.add_argument("--only", default=",".join(PARTS), help="parts of the page (default %(default)s)")
    parser.add_argument("--repeats", type=int, default=1, help="runs of each method; the least time counts")
    parser.add_argument("--speed-repeats", type=int, default=3, help="of the part speed; the median counts")
    options = parser.parse_args()
    parts = options.only.split(",")
    if not set(parts) <= set(PARTS):
        parser.error(f"--only: '{options.only}' is no list of {', '.join(PARTS)}")
    tool = Isopach(options.isopach)
    if parts == ["speed"] and os.environ["OMP_NUM_THREADS"] == "2":
        with tempfile.TemporaryDirectory() as name:
            speed(tool, pathlib.Path(name), options.speed_points, options.speed_repeats, lambda t: print(t, flush=True))
        return
    lines = []

    def say(text):
        print(text, flush=True)
        lines.append(text)

    versions = [f"{n} {importlib.metadata.version(n)}" for n, m in zip(RIVALS, (small_gicp, open3d)) if m]
    missing = [n for n, m in (("small_gicp", small_gicp), ("Open3D", open3d)) if not m]
    size, repeats = options.points, options.repeats
    say("# Matching: isopach and its rivals\n")
    command = f"bench/rivals/matching.py --points {size} --repeats {repeats} --only {options.only} --data DIR"
    own_cpu = " and CloudCompare" if shutil.which("CloudCompare") else ""
    say(f"Written by `{command}`: all methods on the same points in one run. In all tables but those of speed one "
        f"thread each and CPU seconds, the least of {repeats} runs: of a rival thinning, normals and search, without "
        f"reading; of isopach{own_cpu} the whole process, reading and isopach's comparisons before and after included. "
        "Rivals: "
        + ", ".join(versions) + " (from PyPI)" + (", CloudCompare (from Debian)" if own_cpu else "")
        + (f"; not to be had for this Python: {', '.join(missing)}" if missing else "") + ". Their longest pair "
        "shrinks in stages of at most 50 steps; normals and covariances from 20 neighbours; they are given both scans "
        "less the mean of FIXED, thinned to voxels where it does not say all points. isopach has its defaults and all "
        "points, in input coordinates.")
    if "speed" in parts:  # a process of its own: Open3D asks for its number of threads once
        words = f"--only speed --speed-points {options.speed_points} --speed-repeats {options.speed_repeats}".split()
        run = subprocess.run([sys.executable, "-B", __file__, "--isopach", options.isopach, *words],
                             env={**os.environ, "OMP_NUM_THREADS": "2"}, stdout=subprocess.PIPE, text=True, check=True)
        say(run.stdout.rstrip())
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        own = methods(tool, folder, True)
        fine = [m for m in own if not m[2]]
        if "face" in parts:
            table(face(tool, folder, size, 5), fine, repeats, say)
        if "relief" in parts:
            table(relief(tool, folder, size // 2, 5), fine, repeats, say)
        if options.data and "street" in parts:  # no height field
            table(street(tool, folder, options.data), [m for m in fine if "measure" not in m[0]], repeats, say)
        if options.data and "bunny" in parts:
            table(bunny(tool, folder, options.data, True), fine, repeats, say)
            table(bunny(tool, folder, options.data, False), own, repeats, say)
        if options.data and "strips" in parts:
            table(strips(tool, folder, options.data), fine, repeats, say)
        if "basin" in parts:
            basins(tool, folder, say)
    if options.page:
        options.page.write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    enter_environment()
    import importlib

    import numpy as np
    from scipy.spatial import cKDTree

    def rival(name):
        try:
            return importlib.import_module(name)
        except ImportError:
            return None

    small_gicp, open3d = rival("small_gicp"), rival("open3d")
    main()
