"""From where the study starts: turns, shifts, shares in common and objectives, all from the name of the pair."""

import dataclasses
import zlib

import numpy as np

from trust import geometry

STARTS = 25
TURNS = [(0, 10)] * 6 + [(10, 30)] * 6 + [(30, 60)] * 5 + [(60, 180)] * 8
SHARES = [1.0] * 11 + [0.8] * 3 + [0.6] * 3 + [0.4] * 3 + [0.2] * 2 + [0.1, 0.05, 0.0]
FLAT = ["measure"] * 16 + ["icp-plane"] * 6 + ["icp-point"] * 2 + ["currents"]
ROUND = ["measure"] * 8 + ["icp-plane"] * 13 + ["icp-point"] * 4


@dataclasses.dataclass
class Start:
    index: int
    turn: float       # degrees
    vertical: bool    # about z, else about any axis
    shift: float      # share of the extent
    share: float      # of the area that the cuts leave in common, where the scans are of the same area
    objective: str

    @property
    def good(self):
        return self.turn < 10


def starts_of(pair):
    random = np.random.default_rng([zlib.crc32(pair.name.encode()), 1])
    turns, shares, words = (random.permutation(len(v)) for v in (TURNS, SHARES, FLAT))
    found = []
    for k in range(STARTS):
        low, high = TURNS[turns[k]]
        found.append(Start(k, random.uniform(low, high), bool(random.integers(2)),
                           random.uniform(0, 0.1) if low == 0 else 0.5 * random.uniform() ** 1.5, SHARES[shares[k]],
                           (FLAT if pair.flat else ROUND)[words[k]]))
    return found


def scans_of(pair, start, moving, fixed):
    """MOVING away from its place, FIXED, the pose that brings it back, and the share in common."""
    random = np.random.default_rng([zlib.crc32(pair.name.encode()), 2, start.index])
    moving, fixed = geometry.cut(moving, fixed, start.share, random)
    size = geometry.extent(moving)
    common = geometry.common(moving, fixed, pair.tolerance * size) if pair.kind != "other" else 0.0
    axis = (0, 0, 1 if random.integers(2) else -1) if start.vertical else random.normal(size=3)
    way = random.normal(size=3)
    away = geometry.turn(axis, start.turn, moving.mean(axis=0), start.shift * size * way / np.linalg.norm(way))
    return geometry.moved(moving, away), fixed, geometry.inverse(away), common


def write_ply(path, points):
    head = f"ply\nformat binary_little_endian 1.0\nelement vertex {len(points)}\n"
    head += "".join(f"property double {axis}\n" for axis in "xyz") + "end_header\n"
    path.write_bytes(head.encode() + np.ascontiguousarray(points, "<f8").tobytes())
