#!/usr/bin/env python3
"""Matching against small_gicp and Open3D in one run: simulated and real pairs with known poses; writes a page.

    python3 -B bench/rivals/matching.py --isopach build/release/bin/isopach [--data DIR] [--points N] [--page FILE]

Makes a virtual environment in build/rivals with what PyPI has for this Python (numpy, small_gicp, open3d-cpu); a rival
that cannot be had is left out and named. Times are CPU seconds on one thread, the least of the repeats: of a rival
thinning, normals and search, without reading; of isopach the whole process, reading and both comparisons included.
"""

import argparse
import importlib.metadata
import json
import math
import os
import pathlib
import resource
import subprocess
import sys
import tempfile
import time
import venv

ROOT = pathlib.Path(__file__).resolve().parents[2]
RIVALS = ["small_gicp", "open3d-cpu"]
PARTS = ["face", "relief", "street", "bunny", "strips", "basin"]


def enter_environment():
    """Runs this script again by the Python of the environment, made on first use."""
    home = ROOT / "build" / "rivals"
    python = home / "bin" / "python3"
    if pathlib.Path(sys.prefix).resolve() == home.resolve():
        return
    if not python.exists():
        venv.create(home, with_pip=True)
        for package in ["numpy", *RIVALS]:
            done = subprocess.run([python, "-m", "pip", "install", "--quiet", package])
            if done.returncode != 0 and package == "numpy":
                sys.exit("numpy cannot be installed: without it there is no bench")
    os.environ.update({name: "1" for name in ["OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"]})
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


class Isopach:
    def __init__(self, binary):
        self.binary = str(pathlib.Path(binary).resolve())

    def __call__(self, *words, codes=(0,)):
        run = subprocess.run([self.binary, *map(str, words)], capture_output=True, text=True)
        if run.returncode not in codes:
            raise RuntimeError(f"{' '.join(map(str, words))}: {run.stderr.strip()}")
        return run

    def match(self, folder, moving, fixed, *words):
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        run = self("match", moving, fixed, "--json", "-", "--threads", 1, *words, codes=(0, 4, 5))
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        seconds = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
        return (np.array(json.loads(run.stdout)["pose"]["matrix"]) if run.stdout else None), seconds


# --- rivals ----------------------------------------------------------------------------------------------------------


class Pair:
    """`moving` on `fixed`; `truth` is the pose that does it. Rivals get both less the mean of `fixed`."""

    def __init__(self, name, moving, fixed, truth, reaches, voxel, extent):
        self.name, self.moving, self.fixed, self.truth = name, moving, fixed, truth
        self.unmoved = None  # MOVING before it was moved, where the scans' own coordinates are not the truth
        self.reaches, self.voxel, self.extent = reaches, voxel, extent

    def centred(self):
        return self.moving - self.fixed.mean(axis=0), self.fixed - self.fixed.mean(axis=0)

    def uncentred(self, pose):
        back = np.eye(4)
        back[:3, 3] = self.fixed.mean(axis=0)
        return back @ pose @ np.linalg.inv(back)


def by_small_gicp(kind, voxel_share):
    def run(pair):
        moving, fixed = pair.centred()
        pose = np.eye(4)
        start = time.process_time()
        voxel = pair.voxel * voxel_share
        how = {"downsampling_resolution": voxel, "num_neighbors": 20, "num_threads": 1}
        target, tree = small_gicp.preprocess_points(fixed, **how)
        source, _ = small_gicp.preprocess_points(moving, **how)
        for reach in pair.reaches:
            found = small_gicp.align(target, source, tree, init_T_target_source=pose, registration_type=kind,
                                     max_correspondence_distance=reach, num_threads=1, max_iterations=50)
            pose = found.T_target_source
        return pair.uncentred(pose), time.process_time() - start

    return run


def open3d_cloud(points, voxel):
    cloud = open3d.geometry.PointCloud(open3d.utility.Vector3dVector(points))
    if voxel > 0:
        cloud = cloud.voxel_down_sample(voxel)
    cloud.estimate_normals(open3d.geometry.KDTreeSearchParamKNN(20))
    return cloud


def open3d_refine(source, target, pose, reaches):
    r = open3d.pipelines.registration
    for reach in reaches:
        pose = r.registration_icp(source, target, reach, pose, r.TransformationEstimationPointToPlane(),
                                  r.ICPConvergenceCriteria(1e-9, 1e-9, 50)).transformation
    return pose


def by_open3d(voxel_share):
    def run(pair):
        moving, fixed = pair.centred()
        start = time.process_time()
        source, target = (open3d_cloud(p, pair.voxel * voxel_share) for p in (moving, fixed))
        return pair.uncentred(open3d_refine(source, target, np.eye(4), pair.reaches)), time.process_time() - start

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
             for w in [("--objective", "measure"), ("--objective", "icp-plane"), ("--objective", "icp-point"),
                       ("--objective", "measure", "--coarse"), ("--objective", "icp-plane", "--coarse")]]
    if small_gicp:
        found += [("small_gicp GICP", by_small_gicp("GICP", 1), False),
                  ("small_gicp point-to-plane", by_small_gicp("PLANE_ICP", 1), False)]
    if open3d:
        found += [("Open3D point-to-plane", by_open3d(1), False),
                  ("Open3D FPFH + RANSAC, then point-to-plane", by_open3d_features, True)]
        if whole:
            found += [("Open3D point-to-plane, all points", by_open3d(0), False)]
    return found


# --- pairs -----------------------------------------------------------------------------------------------------------


def simulated(tool, folder, scene, words, points, extent, cut, away):
    tool("simulate", scene, "-o", folder / scene, "--points", points, "--points-b", points, "--format", "ply", *words)
    scans = [read_points(folder / scene / f"{name}.ply", tool, folder) for name in "ab"]
    if cut > 0:
        low, high = scans[0][:, 1].min(), scans[0][:, 1].max()
        share = cut / 2 * (high - low)
        scans = [scans[0][scans[0][:, 1] < high - share], scans[1][scans[1][:, 1] > low + share]]
    fixed, moving = scans
    pose = away(moving.mean(axis=0))
    return moved(moving, pose), fixed, np.linalg.inv(pose), extent


def face(tool, folder, points, degrees, axis=(1, 2, 3), shift=0.03):
    parts = simulated(tool, folder, "face", ["--noise", 0.05, "--noise-b", 0.05], points, 220, 0.3,
                      lambda c: turn(axis, degrees, c, np.array([1, -1, 1]) * shift * 220 / math.sqrt(3)))
    return Pair(f"face, {points} points, 30 % unmatched, swollen cheek", *parts[:3], (22, 2.2), 1.0, 220)


def relief(tool, folder, points, degrees, axis=(1, 2, 3)):
    parts = simulated(tool, folder, "relief", ["--variant", "rough"], points, 1000, 0,
                      lambda c: turn(axis, degrees, c, np.array([1, -1, 1]) * 50 / math.sqrt(3)))
    name = f"rough relief, {points} points, a mound and a pit between the scans"
    return Pair(name, *parts[:3], (200, 50, 10), 5.0, 1000)


def street(tool, folder, data):
    d = data / "small-gicp"
    moving, fixed = (read_points(d / f"{n}.ply", tool, folder) for n in ("source", "target"))
    truth = np.loadtxt(d / "T_target_source.txt")
    return Pair("street, two scans of a vehicle (`small-gicp`), from no motion", moving, fixed, truth, (2.0, 0.5), 0.25,
                float(np.linalg.norm(np.ptp(fixed, axis=0))))


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
    if near:
        start = turn((1, 2, 3), 5, moved(moving, truth).mean(axis=0), 0.003) @ truth
        return Pair(name + ", 5 degrees off", moved(moving, start), fixed, truth @ np.linalg.inv(start), (0.01, 0.002),
                    0.001, 0.15)
    return Pair(name + ", as scanned: 34 degrees off", moving, fixed, truth, (0.03, 0.01, 0.002), 0.001, 0.15)


def strips(tool, folder, data):
    d = data / "santacruz"
    moving, fixed = (read_points(d / f"blanca_strip{n}_120m.las", tool, folder) for n in (8707, 8706))
    pose = turn((0.1, -0.2, 1), 4, moving.mean(axis=0), np.array([3, -2, 1.5]))
    pair = Pair("two flight strips (`santacruz`), the second moved by 4 degrees and 3.9 m", moved(moving, pose), fixed,
                np.linalg.inv(pose), (10, 2), 1.0, 120)
    pair.unmoved = Pair(pair.name, moving, fixed, np.eye(4), pair.reaches, pair.voxel, pair.extent)
    return pair


# --- the page --------------------------------------------------------------------------------------------------------


def row(name, run, pair, repeats):
    best = None
    for _ in range(repeats):
        pose, seconds = run(pair)
        if pose is None:
            return f"| {name} | no pose | | {seconds:.2f} |"
        best = min(best or seconds, seconds)
    degrees, off = error(pose, pair.truth, pair.moving)
    line = f"| {name} | {degrees:.2g} | {off:.2g} | {off / pair.extent:.1e} | {best:.2f} |"
    if pair.unmoved:
        own, _ = run(pair.unmoved)
        degrees, off = error(pose, own @ pair.truth, pair.moving)
        line += f" {degrees:.2g} | {off:.2g} |"
    return line


def table(pair, all_methods, repeats, say):
    say(f"\n## {pair.name[0].upper()}{pair.name[1:]}\n")
    say("| method | rotation error, degrees | shift error, unit | over the extent | CPU, s |"
        + (" from its answer without the move: degrees | unit |" if pair.unmoved else ""))
    say("|---|---|---|---|---|" + ("---|---|" if pair.unmoved else ""))
    for name, run, _ in all_methods:
        say(row(name, run, pair, repeats))


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
    some = [m for m in methods(tool, folder, False) if "icp-point" not in m[0]]
    for words, make in [("Face, about the axis of projection", lambda a: face(tool, folder, 10000, a, (0, 0, 1))),
                        ("Rough relief, about the axis", lambda a: relief(tool, folder, 10000, a, (0, 0, 1)))]:
        say(f"\n{words}:")
        basin(make, [30, 60, 120, 180], some, say)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--isopach", default=str(ROOT / "build/release/bin/isopach"))
    parser.add_argument("--data", type=pathlib.Path, help="folder of the real pairs; without it they are left out")
    parser.add_argument("--page", type=pathlib.Path, help="file to write (default: stdout alone)")
    parser.add_argument("--points", type=int, default=200000, help="of each scan of the face; half of it of the relief")
    parser.add_argument("--only", default=",".join(PARTS), help="parts of the page (default %(default)s)")
    parser.add_argument("--repeats", type=int, default=1, help="runs of each method; the least time counts")
    options = parser.parse_args()
    parts = options.only.split(",")
    if not set(parts) <= set(PARTS):
        parser.error(f"--only: '{options.only}' is no list of {', '.join(PARTS)}")
    tool = Isopach(options.isopach)
    lines = []

    def say(text):
        print(text, flush=True)
        lines.append(text)

    versions = [f"{n} {importlib.metadata.version(n)}" for n, m in zip(RIVALS, (small_gicp, open3d)) if m]
    missing = [n for n, m in (("small_gicp", small_gicp), ("Open3D", open3d)) if not m]
    size, repeats = options.points, options.repeats
    say("# Matching: isopach and its rivals\n")
    command = f"bench/rivals/matching.py --points {size} --repeats {repeats} --only {options.only}"
    say(f"Written by `{command}`: all methods on the same points in one run, on one thread each. CPU seconds, the "
        f"least of {repeats} runs: of a rival thinning, normals and search, without reading; of isopach the whole "
        "process, reading and the comparisons before and after included. Rivals: " + ", ".join(versions) + " (from PyPI)"
        + (f"; not to be had for this Python: {', '.join(missing)}" if missing else "") + ". Their longest pair "
        "shrinks in stages of at most 50 steps; normals and covariances from 20 neighbours; they are given both scans "
        "less the mean of FIXED, thinned to voxels where it does not say all points. isopach has its defaults and all "
        "points, in input coordinates.")
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

    def rival(name):
        try:
            return importlib.import_module(name)
        except ImportError:
            return None

    small_gicp, open3d = rival("small_gicp"), rival("open3d")
    main()
