"""Poses, their errors, cuts and overlaps, samples of meshes. Poses are 4x4 matrices that act on column vectors."""

import math

import numpy as np
from scipy.spatial import cKDTree


def turn(axis, degrees, centre=(0, 0, 0), shift=(0, 0, 0)):
    """Rotation about an axis through `centre`, then a shift."""
    u = np.asarray(axis, float) / np.linalg.norm(axis)
    k = np.array([[0, -u[2], u[1]], [u[2], 0, -u[0]], [-u[1], u[0], 0]])
    angle = math.radians(degrees)
    pose = np.eye(4)
    pose[:3, :3] = np.eye(3) + math.sin(angle) * k + (1 - math.cos(angle)) * k @ k
    pose[:3, 3] = np.asarray(centre) - pose[:3, :3] @ np.asarray(centre) + np.asarray(shift)
    return pose


def moved(points, pose):
    return points @ pose[:3, :3].T + pose[:3, 3]


def inverse(pose):
    """Of a rigid motion."""
    back = np.eye(4)
    back[:3, :3] = pose[:3, :3].T
    back[:3, 3] = -pose[:3, :3].T @ pose[:3, 3]
    return back


def by_quaternion(shift, x, y, z, w):
    """Pose of a unit quaternion."""
    pose = np.eye(4)
    pose[:3, :3] = [[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                    [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                    [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]]
    pose[:3, 3] = shift
    return pose


def degrees_between(found, truth):
    """Angle of the rotation from one pose to the other. Both are divided by their scale."""
    a, b = (pose[:3, :3] / np.cbrt(np.linalg.det(pose[:3, :3])) for pose in (found, truth))
    r = a @ b.T
    sine = np.linalg.norm([r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1]]) / 2
    return math.degrees(math.atan2(sine, (np.trace(r) - 1) / 2))


def extent(points):
    """Diagonal of the box that holds 98 % of each coordinate: an echo far off does not make a scan larger."""
    return float(np.linalg.norm(np.percentile(points, 99, axis=0) - np.percentile(points, 1, axis=0)))


def error(found, truth, points):
    """Degrees, and how far the middle of the moving scan is off, as a share of its extent."""
    middle = points.mean(axis=0)
    off = moved(middle, found) - moved(middle, truth)
    return degrees_between(found, truth), float(np.linalg.norm(off)) / extent(points)


def class_of(degrees, share):
    if degrees < 0.5 and share < 0.01:
        return "right"
    return "wrong" if degrees > 3 or share > 0.03 else "between"


def common(moving, fixed, tolerance=0.0):
    """Share of the points that have the other scan near them, of the scan that has more of them. Near: two distances
    of the sixth neighbours there, or `tolerance`."""
    shares = []
    for own, other in ((moving, fixed), (fixed, moving)):
        tree = cKDTree(other)
        spacing = tree.query(other, 7)[0][:, 6]
        away, at = tree.query(own)
        shares.append(float((away < np.maximum(2 * np.maximum(spacing[at], np.median(spacing)), tolerance)).mean()))
    return max(shares)


def cut(moving, fixed, share, random):
    """Both scans without what lies beyond two parallel planes, so that of scans of the same area `share` is left in
    common. The planes stand on one of the two long axes or between them. Scans that do not lie in one place, in other
    units for instance, of which nothing would be left, stay whole."""
    if share >= 1:
        return moving, fixed
    middle = fixed.mean(axis=0)
    axes = np.linalg.svd(fixed - middle, full_matrices=False)[2][:2]
    angle = random.uniform(0, 2 * math.pi)
    along = math.cos(angle) * axes[0] + math.sin(angle) * axes[1]
    kept = 1 / (2 - share)
    a, b = ((p - middle) @ along for p in (moving, fixed))
    low, high = np.quantile(b, 1 - kept), np.quantile(b, kept)
    if share <= 0:
        gap = 0.02 * (b.max() - b.min())
        low, high = low + gap, high - gap
    left_of_moving, left_of_fixed = moving[a >= low], fixed[b <= high]
    return (left_of_moving, left_of_fixed) if len(left_of_moving) and len(left_of_fixed) else (moving, fixed)


# --- surfaces ----------------------------------------------------------------------------------------------------------


def sample(corners, faces, count, random):
    """Points spread evenly over the area of a mesh, and the normals of their faces."""
    a, b, c = (corners[faces[:, k]] for k in range(3))
    normals = np.cross(b - a, c - a)
    areas = np.linalg.norm(normals, axis=1)
    face = random.choice(len(faces), count, p=areas / areas.sum())
    u = random.uniform(size=(count, 2))
    u[u.sum(axis=1) > 1] = 1 - u[u.sum(axis=1) > 1]
    points = a[face] + u[:, :1] * (b[face] - a[face]) + u[:, 1:] * (c[face] - a[face])
    return points, normals[face] / areas[face][:, None]


def visible(points, normals, towards):
    """What a viewer far off in this direction sees: points of faces not too aslant that have nothing in front."""
    towards = np.asarray(towards, float) / np.linalg.norm(towards)
    side = np.cross(towards, [1, 0, 0] if abs(towards[0]) < 0.8 else [0, 1, 0])
    side /= np.linalg.norm(side)
    flat = np.c_[points @ side, points @ np.cross(towards, side)]
    depth = points @ towards
    spacing = np.median(cKDTree(points).query(points, 7)[0][:, 6])
    a, b = cKDTree(flat).query_pairs(1.2 * spacing, output_type="ndarray").T
    front = depth.copy()
    np.maximum.at(front, a, depth[b])
    np.maximum.at(front, b, depth[a])
    return (np.abs(normals @ towards) > 0.15) & (depth > front - 4 * spacing)


def seen(corners, faces, towards, count, noise, random):
    """A scan of a mesh from one side: about `count` points with noise."""
    points, normals = sample(corners, faces, 6 * count, random)
    points = points[visible(points, normals, towards)]
    points = points[random.permutation(len(points))[:count]]
    return points + random.normal(0, noise, points.shape)


def best_motion(moving, fixed):
    """The rigid motion of corresponding points that fits the half that moved least (Kabsch, trimmed)."""
    chosen = np.ones(len(moving), bool)
    for _ in range(60):
        a, b = moving[chosen], fixed[chosen]
        u, _, v = np.linalg.svd((a - a.mean(axis=0)).T @ (b - b.mean(axis=0)))
        pose = np.eye(4)
        pose[:3, :3] = v.T @ np.diag([1, 1, np.sign(np.linalg.det(v.T @ u.T))]) @ u.T
        pose[:3, 3] = b.mean(axis=0) - pose[:3, :3] @ a.mean(axis=0)
        off = np.linalg.norm(moved(moving, pose) - fixed, axis=1)
        chosen = off <= np.median(off)
    return pose
