"""What pulls.py repeats: scans with a truth of their own, the program run on them, the error and the precision stated."""

import dataclasses
import json
import subprocess

import numpy as np
from scipy import spatial

from trust import geometry, objects, starts


@dataclasses.dataclass
class Pull:
    """One simulation. `why`: no precision was stated, in a word; else errors, their stated standard deviations, and the
    squared errors in all of the covariance (chi square) with its degrees of freedom."""
    why: str = ""
    error: object = None
    sigma: object = None
    chi: float = 0.0
    freedom: int = 6


def told(program, folder, *words):
    run = subprocess.run([program, *map(str, words), "--json", "-"], cwd=folder, capture_output=True, text=True)
    return run.returncode, json.loads(run.stdout) if run.stdout.startswith("{") else None


def twist(found, truth, centre):
    """Turn (rad) and shift about `centre` that lead from the true place to the found one, in coordinates of FIXED."""
    rest = found @ geometry.inverse(truth)
    r = rest[:3, :3]
    turn = np.array([r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1]]) / 2
    return np.r_[turn, geometry.moved(centre, rest) - centre]


def by_covariance(error, covariance):
    if covariance is None or any(v is None for row in covariance for v in row):
        return Pull("not stated")
    c = np.array(covariance)
    if not np.linalg.eigvalsh(c / np.sqrt(np.outer(np.diag(c), np.diag(c)) + 1e-300))[0] > 1e-12:
        return Pull("motions held")
    return Pull("", error, np.sqrt(np.diag(c)), float(error @ np.linalg.solve(c, error)))


def small_motion(random, points, degrees=1.0, share=0.01):
    axis, way = random.normal(size=3), random.normal(size=3)
    return geometry.turn(axis, degrees * random.uniform(-1, 1), points.mean(axis=0),
                         share * geometry.extent(points) * way)


# --- poses -------------------------------------------------------------------------------------------------------------------


def strips(random, x, width=0.04):
    """Each strip of a scanner that drifts has an offset of its own."""
    return random.normal(size=60)[np.floor(x / width).astype(int) + 10]


@dataclasses.dataclass
class PoseKind:
    """`isopach match` of two scans of hills over a unit square, drawn anew each time; noise along z."""
    words: str
    options: tuple = ()
    counts: tuple = (3000, 3000)    # MOVING, FIXED
    sides: tuple = ((0, 1), (0, 1))  # what they show along x
    noise: float = 0.004
    common_noise: str = ""          # strips, field: as much again that is alike at neighbouring points
    mound: bool = False             # in MOVING, over a tenth of the area
    longest: float = 1.0            # wavelength of the hills

    def scan(self, random, side, hills):
        x, y = random.uniform(*self.sides[side], self.counts[side]), random.uniform(0, 1, self.counts[side])
        z = 0.05 * hills(x, y) + random.normal(0, self.noise, len(x))
        if self.common_noise == "strips":
            z += 0.75 * self.noise * strips(random, x)
        if self.common_noise == "field":
            z += 0.75 * self.noise * objects.Noise(random, 2, 0.15, 0.05)(x, y)
        if self.mound and side == 0:
            far = np.minimum(1, ((x - 0.65) ** 2 + (y - 0.4) ** 2) / 0.178 ** 2)
            z += 0.03 * (1 - far) ** 2
        return np.c_[x, y, z]

    def pull(self, program, folder, seed):
        random = np.random.default_rng([17, seed])
        hills = objects.Noise(random, 2, self.longest, 0.2, 1.6, 60)
        moving, fixed = self.scan(random, 0, hills), self.scan(random, 1, hills)
        return match(program, folder, random, moving, fixed, self.options)


@dataclasses.dataclass
class SolidKind:
    """`isopach match` of two samples of a boulder, all around; noise in all directions."""
    words: str
    options: tuple = ("--objective", "icp-plane")
    counts: tuple = (3000, 3000)
    noise: float = 0.4

    def pull(self, program, folder, seed):
        random = np.random.default_rng([18, seed])
        corners, faces = objects.boulder(seed % 5)
        scans = [geometry.sample(corners, faces, n, random)[0] for n in self.counts]
        moving, fixed = (s + random.normal(0, self.noise, s.shape) for s in scans)
        return match(program, folder, random, moving, fixed, self.options)


def match(program, folder, random, moving, fixed, options):
    away = small_motion(random, moving)
    starts.write_ply(folder / "moving.ply", geometry.moved(moving, away))
    starts.write_ply(folder / "fixed.ply", fixed)
    code, found = told(program, folder, "match", "moving.ply", "fixed.ply", "--pose-only", "--threads", 1, *options)
    if code != 0:
        return Pull("refused" if code in (4, 5) else f"exit {code}")
    error = twist(np.array(found["pose"]["matrix"]), geometry.inverse(away), np.array(found["centre"]))
    return by_covariance(error, found["covariance"])


# --- symmetry planes ---------------------------------------------------------------------------------------------------------------


def half_face(x, y):
    """Heights of a face that is the same on both sides of x = 0; mm, 150 wide, 200 high."""
    a = np.abs(x)
    z = 75 * np.sqrt(np.maximum(0.02, 1 - (a / 92) ** 2 - (y / 128) ** 2))
    for at, up, wide, tall, size in ((0, 8, 10, 18, 21), (33, 33, 14, 9, -8), (0, -35, 21, 8, 5), (0, -70, 18, 12, 8),
                                     (43, -4, 17, 15, 5), (12, -8, 7, 6, 4), (30, 48, 20, 6, 3)):
        z = z + size * np.exp(-((a - at) / wide) ** 2 / 2 - ((y - up) / tall) ** 2 / 2)
    return z


@dataclasses.dataclass
class PlaneKind:
    """`isopach asymmetry` of an analytic face. Of the plane's direction one number is stated, for both of its errors."""
    words: str
    count: int = 6000
    noise: float = 0.15
    crop: float = 75.0       # the positive side ends here
    swelling: float = 0.0    # mm, on one cheek

    def scan(self, random):
        x, y = random.uniform(-75, self.crop, self.count), random.uniform(-95, 95, self.count)
        z = half_face(x, y) + random.normal(0, self.noise, self.count)
        z += self.swelling * np.exp(-((x - 42) ** 2 + (y + 10) ** 2) / (2 * 14 ** 2))
        return np.c_[x, y, z]

    def pull(self, program, folder, seed):
        random = np.random.default_rng([19, seed])
        away = geometry.turn((0, 0, 1), random.uniform(-8, 8)) @ geometry.turn((0, 1, 0), random.uniform(-8, 8))
        away[:3, 3] = random.uniform(-20, 20, 3)
        starts.write_ply(folder / "face.ply", geometry.moved(self.scan(random), away))
        code, found = told(program, folder, "asymmetry", "face.ply", "--unit", "mm", "--direction", "z", "--threads", 1)
        if code != 0 or found is None:
            return Pull("refused" if code in (4, 5) else f"exit {code}")
        plane, normal = found["plane"], np.array(found["plane"]["normal"])
        if plane["sigma_angle_deg"] is None or plane["sigma_offset"] is None:
            return Pull("not stated")
        truth = away[:3, 0] * np.sign(away[:3, 0] @ normal)
        aslant = np.degrees(normal - truth)  # two of the three are free
        rotated = [aslant @ away[:3, 1], aslant @ away[:3, 2]]
        off = truth @ (np.array(plane["point"]) - away[:3, 3])
        sigma = np.array([plane["sigma_angle_deg"] / np.sqrt(2)] * 2 + [plane["sigma_offset"]])
        error = np.array([*rotated, off])
        return Pull("", error, sigma, float(((error / sigma) ** 2).sum()), 3)


# --- scale of samples of a nominal mesh -----------------------------------------------------------------------------------------------


@dataclasses.dataclass
class ScaleKind:
    """`isopach match` with scale of samples of a mesh of 200 corners on hills, taken on its facets, without noise."""
    words: str
    corners: int = 200
    count: int = 3000

    def off(self, program, folder, seed):
        """Scale less 1, or None where the pose was refused."""
        random = np.random.default_rng([21, seed])
        hills = objects.Noise(random, 2, 80, 30, 1.6, 60)
        xy = np.vstack([random.uniform(0, 100, (self.corners, 2)), [(0, 0), (100, 0), (0, 100), (100, 100)]])
        corners = np.c_[xy, 6 * hills(*xy.T)]
        faces = spatial.Delaunay(xy).simplices
        write_mesh(folder / "fixed.ply", corners, faces)
        starts.write_ply(folder / "moving.ply", geometry.sample(corners, faces, self.count, random)[0])
        code, found = told(program, folder, "match", "moving.ply", "fixed.ply", "--freedom", "x,y,z,turn-x,turn-y,turn-z,scale", "--pose-only",
                           "--threads", 1)
        return np.cbrt(np.linalg.det(np.array(found["pose"]["matrix"])[:3, :3])) - 1 if code == 0 else None


def write_mesh(path, corners, faces):
    head = f"ply\nformat ascii 1.0\nelement vertex {len(corners)}\n"
    head += "".join(f"property double {axis}\n" for axis in "xyz")
    head += f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n"
    with open(path, "w") as out:
        out.write(head)
        np.savetxt(out, corners, fmt="%.17g")
        np.savetxt(out, np.c_[np.full(len(faces), 3), faces], fmt="%d")


# --- parts of a model ------------------------------------------------------------------------------------------------------------------


@dataclasses.dataclass
class PartsKind:
    """`isopach combine`: an object of 64 by 40 mm with relief before a face and before a jaw, both turned any way, and a
    scan of the object alone. The starts are a degree off."""
    words: str
    counts: tuple = (2500, 2500, 2500)  # on the object: face, jaw, reference
    noise: tuple = (0.05, 0.05, 0.05)
    hidden: float = 0.15                # share of the object that is covered in the scans

    def scan(self, random, tag, relief, behind, which):
        half, wide = (32.0, 20.0), (60.0, 50.0)
        at = random.uniform([-half[0], -half[1]], half, (self.counts[which], 2))
        if tag != "reference":
            angle = random.uniform(0, 2 * np.pi)
            along = at @ [np.cos(angle), np.sin(angle)]
            at = at[along < np.quantile(along, 1 - self.hidden)]
        p = np.c_[at, relief(*at.T)]
        if tag != "reference":
            around = random.uniform([-wide[0], -wide[1]], wide, (int(2 * self.counts[which]), 2))
            around = around[(np.abs(around[:, 0]) > half[0]) | (np.abs(around[:, 1]) > half[1])]
            p = np.vstack([p, np.c_[around, behind(*around.T) - 12]])
        p[:, 2] += random.normal(0, self.noise[which], len(p))
        return p

    def pull(self, program, folder, seed):
        random = np.random.default_rng([20, seed])
        bent, marks = objects.Noise(random, 2, 60, 12, 1.0, 40), objects.Noise(random, 2, 20, 9, 1.0, 40)
        relief = lambda x, y: 1.6 * bent(x, y) + 0.8 * marks(x, y)
        poses, scans = {}, {}
        for which, tag in enumerate(("face", "jaw", "reference")):
            behind = objects.Noise(random, 2, 60, 15, 1.0, 40)
            poses[tag] = geometry.turn(random.normal(size=3), random.uniform(0, 180), shift=random.uniform(-80, 80, 3))
            scans[tag] = self.scan(random, tag, relief, lambda x, y: 3 * behind(x, y), which)
            starts.write_ply(folder / f"{tag}.ply", geometry.moved(scans[tag], poses[tag]))
        words = ["combine", "face.ply", "jaw.ply", "--reference", "reference.ply", "--threads", 1]
        for tag in ("face", "jaw"):
            near = small_motion(random, scans["reference"], 1, 0.003)
            np.savetxt(folder / f"{tag}.txt", poses[tag] @ near @ geometry.inverse(poses["reference"]), fmt="%.17g")
            words += [f"--start-{tag}", f"{tag}.txt"]
        code, found = told(program, folder, *words)
        if code != 0 or found is None:
            return Pull("refused" if code in (4, 5) else f"exit {code}")
        said = found["uncertainty"]
        truth = poses["face"] @ geometry.inverse(poses["jaw"])
        error = twist(np.array(found["pose"]["matrix"]), truth, np.array(said["centre"]))
        return by_covariance(error, said["covariance"])


SEVEN_TENTHS = ((0, 1), (0.3, 1.3))
PLANE, POINT, CURRENTS = (("--objective", word) for word in ("icp-plane", "icp-point", "currents"))
POSES = {
    "full": PoseKind("the same area"),
    "overlap70": PoseKind("70 % in common", sides=SEVEN_TENTHS),
    "overlap70-faint": PoseKind("70 % in common, gentle hills, noise", sides=SEVEN_TENTHS, counts=(4000, 4000),
                                noise=0.012, longest=0.6),
    "trim90": PoseKind("--overlap 0.9", ("--overlap", 0.9)),
    "trim70": PoseKind("--overlap 0.7", ("--overlap", 0.7)),
    "all": PoseKind("--overlap 1", ("--overlap", 1)),
    "dense2": PoseKind("FIXED 2 times denser", counts=(2500, 5000)),
    "dense4": PoseKind("FIXED 4 times denser", counts=(2000, 8000)),
    "sparse4": PoseKind("MOVING 4 times denser", counts=(8000, 2000)),
    "dense10": PoseKind("FIXED 10 times denser", counts=(1500, 15000)),
    "sparse10": PoseKind("MOVING 10 times denser", counts=(15000, 1500)),
    "stripes": PoseKind("strips that drift", common_noise="strips"),
    "field": PoseKind("noise alike at neighbours", common_noise="field"),
    "mound": PoseKind("a mound over 10 % of MOVING", mound=True),
    "plane-full": PoseKind("icp-plane", PLANE),
    "plane-70": PoseKind("icp-plane, 70 % in common", PLANE, sides=SEVEN_TENTHS),
    "plane-dense4": PoseKind("icp-plane, FIXED 4 times denser", PLANE, counts=(2000, 8000)),
    "plane-sparse4": PoseKind("icp-plane, MOVING 4 times denser", PLANE, counts=(8000, 2000)),
    "plane-mound": PoseKind("icp-plane, a mound", PLANE, mound=True),
    "plane-field": PoseKind("icp-plane, noise alike at neighbours", PLANE, common_noise="field"),
    "plane-solid": SolidKind("icp-plane, a boulder all around"),
    "point-full": PoseKind("icp-point", POINT),
    "point-70": PoseKind("icp-point, 70 % in common", POINT, sides=SEVEN_TENTHS),
    "currents-full": PoseKind("currents", CURRENTS, counts=(2000, 2000)),
    "currents-70": PoseKind("currents, 70 % in common", CURRENTS, counts=(2000, 2000), sides=SEVEN_TENTHS),
}
PLANES = {
    "symmetry-full": PlaneKind("face"),
    "symmetry-noisy": PlaneKind("face, 3000 points, noise 0.5 mm", 3000, 0.5),
    "symmetry-cropped": PlaneKind("face, one side cropped at 45 mm", crop=45),
    "symmetry-swollen": PlaneKind("face, a cheek swollen by 4 mm", swelling=4),
}
SCALES = {"scale-nominal": ScaleKind("samples of a nominal mesh, 200 corners, no noise")}
PARTS = {
    "parts-equal": PartsKind("equal scans"),
    "parts-dense": PartsKind("reference 13 times denser", (1500, 1500, 20000)),
    "parts-sparse": PartsKind("reference 8 times sparser", (12000, 12000, 1500)),
    "parts-noisy": PartsKind("reference 13 times denser, thrice the noise", (1500, 1500, 20000), (0.05, 0.05, 0.15)),
    "parts-hidden": PartsKind("half of the object hidden", (3000, 3000, 6000), hidden=0.45),
}
