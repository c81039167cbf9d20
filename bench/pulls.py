#!/usr/bin/env python3
"""How often what `isopach match` says of the precision of its pose is true.

Scans are made here, not by `isopach simulate`: two random samples of one analytic surface, each with errors of its own,
the moving one turned and shifted by a known motion. The error of the pose found, in its own covariance, should have
squares of mean 1, lie within 1.96 standard deviations in 95 of 100 cases for each of the six motions, and have a chi
square of six degrees of freedom below 12.59 in as many.

    bench/pulls.py build/release/bin/isopach                       # all kinds, 200 simulations each
    bench/pulls.py build/release/bin/isopach --kinds full,mound --count 400
"""
import argparse
import json
import pathlib
import subprocess
import tempfile

import numpy as np

CHI2_95 = 12.592


def surface(x, y):
    """Hills on a unit square; slopes of some 0.3."""
    return (0.05 * np.sin(11 * x) * np.cos(9 * y) + 0.03 * np.sin(5 * x + 7 * y + 1)
            + 0.02 * np.sin(17 * x - 8 * y + 2) + 0.01 * np.sin(4 * x + 23 * y))


def stripes(x, rng, width=0.04):
    """Heights that are constant along y: each strip of a scanner that drifts has an offset of its own."""
    edges = np.floor(x / width).astype(int) + 5
    return rng.normal(size=int(edges.max()) + 6)[edges]


def smooth_field(x, y, rng, length=0.04):
    """A normal field of variance 1 whose correlation falls to 1/e within sqrt(2) * `length`."""
    waves = 200
    k = rng.normal(size=(waves, 2)) / length
    phase = rng.uniform(0, 2 * np.pi, waves)
    return np.sqrt(2 / waves) * np.cos(np.outer(x, k[:, 0]) + np.outer(y, k[:, 1]) + phase).sum(1)


def rotation(w):
    t = np.linalg.norm(w)
    k = np.array([[0, -w[2], w[1]], [w[2], 0, -w[0]], [-w[1], w[0], 0]])
    if t == 0:
        return np.eye(3)
    return np.eye(3) + np.sin(t) / t * k + (1 - np.cos(t)) / t**2 * k @ k


class Kind:
    def __init__(self, words, options=(), n=(3000, 3000), x=((0, 1), (0, 1)), noise=0.004, field=None, change=None,
                 shape=surface):
        self.words, self.options, self.n, self.x = words, list(options), n, x
        self.noise, self.field, self.change, self.shape = noise, field, change, shape


def mound(x, y):
    """A mound of five times the noise over a tenth of the area."""
    d2 = ((x - 0.65)**2 + (y - 0.4)**2) / 0.178**2
    return np.where(d2 < 1, 0.02 * (1 - np.minimum(d2, 1))**2 * 1.5, 0)


SEVEN = ((0, 1), (0.3, 1.3))
KINDS = {
    "full": Kind("the same area"),
    "overlap70": Kind("70 % in common", x=SEVEN),
    "trim90": Kind("--overlap 0.9", ["--overlap", "0.9"]),
    "trim70": Kind("--overlap 0.7", ["--overlap", "0.7"]),
    "all": Kind("--overlap 1", ["--overlap", "1"]),
    "dense4": Kind("FIXED 4 times denser", n=(2000, 8000)),
    "sparse4": Kind("MOVING 4 times denser", n=(8000, 2000)),
    "dense10": Kind("FIXED 10 times denser", n=(1500, 15000)),
    "sparse10": Kind("MOVING 10 times denser", n=(15000, 1500)),
    "stripes": Kind("half of the variance in strips", field=lambda x, y, r: 0.003 * stripes(x, r)),
    "field": Kind("half of the variance correlated", field=lambda x, y, r: 0.003 * smooth_field(x, y, r)),
    "mound": Kind("a mound over 10 % of MOVING", change=mound),
    "plane-full": Kind("icp-plane", ["--objective", "icp-plane"]),
    "plane-70": Kind("icp-plane, 70 % in common", ["--objective", "icp-plane"], x=SEVEN),
    "plane-sparse4": Kind("icp-plane, MOVING 4 times denser", ["--objective", "icp-plane"], n=(8000, 2000)),
    "plane-dense4": Kind("icp-plane, FIXED 4 times denser", ["--objective", "icp-plane"], n=(2000, 8000)),
    "plane-mound": Kind("icp-plane, a mound", ["--objective", "icp-plane"], change=mound),
    "plane-field": Kind("icp-plane, correlated", ["--objective", "icp-plane"],
                        field=lambda x, y, r: 0.003 * smooth_field(x, y, r)),
    "point-full": Kind("icp-point", ["--objective", "icp-point"]),
    "point-70": Kind("icp-point, 70 % in common", ["--objective", "icp-point"], x=SEVEN),
    "currents-full": Kind("currents", ["--objective", "currents"], n=(2000, 2000)),
    "currents-70": Kind("currents, 70 % in common", ["--objective", "currents"], n=(2000, 2000), x=SEVEN),
}


def write_ply(path, p):
    with open(path, "wb") as f:
        f.write(b"ply\nformat binary_little_endian 1.0\nelement vertex %d\nproperty double x\nproperty double y\n"
                b"property double z\nend_header\n" % len(p))
        f.write(np.ascontiguousarray(p, "<f8").tobytes())


def scan(kind, side, rng):
    n = kind.n[side]
    x, y = rng.uniform(*kind.x[side], n), rng.uniform(0, 1, n)
    z = kind.shape(x, y) + kind.noise * rng.normal(size=n)
    if kind.field:
        z += kind.field(x, y, rng)
    if kind.change and side == 0:
        z += kind.change(x, y)
    return np.c_[x, y, z]


def match(binary, folder, moving, fixed, options):
    write_ply(folder / "m.ply", moving)
    write_ply(folder / "f.ply", fixed)
    command = [binary, "match", folder / "m.ply", folder / "f.ply", "--json", "-", "--quiet", "--pose-only",
               "--threads", "1"]
    done = subprocess.run([str(c) for c in command + options], capture_output=True, text=True)
    if done.returncode not in (0, 5):
        raise RuntimeError(done.stderr)
    return done.returncode, json.loads(done.stdout) if done.stdout else None


def pull(kind, binary, folder, seed):
    """Errors (turn, shift) of one pair and the covariance stated; the covariance None where it is not stated."""
    rng = np.random.default_rng(seed)
    fixed, moving = scan(kind, 1, rng), scan(kind, 0, rng)
    w, t = 0.005 * rng.normal(size=3), 0.005 * rng.normal(size=3)
    r, middle = rotation(w), np.array([0.5, 0.5, 0])
    away = (moving - middle) @ r.T + middle + t  # what the pose must undo
    code, found = match(binary, folder, away, fixed, kind.options)
    if found is None:
        return None, None
    pose = np.array(found["pose"]["matrix"])
    turn = pose[:3, :3] @ r
    centre = np.array(found["centre"])
    where = pose[:3, :3] @ (r @ (centre - middle) + middle + t) + pose[:3, 3]
    twist = np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]]) / 2
    error = np.r_[twist, where - centre]
    covariance = found["covariance"]
    if code != 0 or covariance is None or any(v is None for row in covariance for v in row):
        return error, None
    return error, np.array(covariance)


def summary(pulls):
    z, chi, said, errors, silent = [], [], [], [], 0
    for error, c in pulls:
        if error is not None:
            errors.append(error)
        if c is None or not (np.linalg.eigvalsh(c)[0] > 0):
            silent += 1
            continue
        s = np.sqrt(np.diag(c))
        z.append(error / s)
        said.append(s)
        chi.append(error @ np.linalg.solve(c, error))
    errors = np.array(errors)
    if not z:
        return dict(silent=silent, rms_error=np.sqrt((errors**2).mean(0)))
    z, chi = np.array(z), np.array(chi)
    return dict(silent=silent, rms=np.sqrt((z**2).mean()), each=np.sqrt((z**2).mean(0)), robust=np.median(np.abs(z)) / 0.6745,
                within=(np.abs(z) < 1.96).mean(), jointly=(chi < CHI2_95).mean(), worst=np.abs(z).max(),
                mean=z.mean(0), rms_error=np.sqrt((errors**2).mean(0)), said=np.median(said, 0))


def main():
    a = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    a.add_argument("isopach")
    a.add_argument("--kinds", default=",".join(KINDS))
    a.add_argument("--count", type=int, default=200)
    a.add_argument("--detail", action="store_true", help="also by motion: rms and mean of the pulls, errors, stated")
    o = a.parse_args()
    print("| scans | rms pull | within 1.96 | jointly (chi square) | not stated | worst |\n|---|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as folder:
        for name in o.kinds.split(","):
            kind = KINDS[name]
            s = summary([pull(kind, o.isopach, pathlib.Path(folder), 1000 + k) for k in range(o.count)])
            if "rms" not in s:
                print(f"| {kind.words} | – | – | – | {s['silent']} of {o.count} | – |", flush=True)
                continue
            print(f"| {kind.words} | {s['rms']:.2f} | {100 * s['within']:.1f} % | {100 * s['jointly']:.1f} % | "
                  f"{s['silent']} of {o.count} | {s['worst']:.1f} |", flush=True)
            if o.detail:
                for key in ("each", "mean", "rms_error", "said"):
                    print(f"    {name} {key}: " + " ".join(f"{v:.3g}" for v in s[key]))


if __name__ == "__main__":
    main()
