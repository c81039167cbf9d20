"""Surfaces that the program's own simulator does not know. Height fields are functions of x and y, solids are meshes
(corners, faces); all are made from a seed."""

import math

import numpy as np


class Noise:
    """Fractal noise: a sum of waves in all directions, wavelengths from `longest` to `shortest`, amplitudes by their
    power `roughness`; its r.m.s. is about 1."""

    def __init__(self, random, dimensions, longest, shortest, roughness=1.0, waves=160):
        lengths = longest * (shortest / longest) ** random.uniform(size=waves)
        directions = random.normal(size=(waves, dimensions))
        directions /= np.linalg.norm(directions, axis=1)[:, None]
        self.waves = 2 * math.pi * directions / lengths[:, None]
        self.phases = random.uniform(0, 2 * math.pi, waves)
        self.heights = lengths ** roughness
        self.heights *= math.sqrt(2) / np.linalg.norm(self.heights)

    def __call__(self, *coordinates):
        return np.cos(np.stack(coordinates, axis=-1) @ self.waves.T + self.phases) @ self.heights


def field(height, width, depth, count, noise, random):
    """A scan of a height field over [0, width] x [0, depth]."""
    x, y = random.uniform(0, width, count), random.uniform(0, depth, count)
    return np.c_[x, y, height(x, y)] + random.normal(0, noise, (count, 3))


def grid(rows, columns):
    """Triangles of a grid of corners."""
    at = np.arange(rows * columns).reshape(rows, columns)
    a, b, c, d = (v.ravel() for v in (at[:-1, :-1], at[1:, :-1], at[1:, 1:], at[:-1, 1:]))
    return np.r_[np.c_[a, b, c], np.c_[a, c, d]]


def joined(*meshes):
    corners, faces, start = [], [], 0
    for c, f in meshes:
        corners.append(c)
        faces.append(f + start)
        start += len(c)
    return np.vstack(corners), np.vstack(faces)


def ball(radius, rows=120, columns=240):
    """A mesh over the directions of space; `radius` is a function of unit vectors. Normals point outwards."""
    polar, around = np.meshgrid(np.linspace(0.001, math.pi - 0.001, rows), np.linspace(0, 2 * math.pi, columns),
                                indexing="ij")
    u = np.stack([np.sin(polar) * np.cos(around), np.sin(polar) * np.sin(around), np.cos(polar)], axis=-1)
    u = u.reshape(-1, 3)
    return u * radius(u)[:, None], grid(rows, columns)


# --- height fields -------------------------------------------------------------------------------------------------------


def carved_slab(seed):
    """A slab of 300 by 200 mm with strokes cut into it, as of an inscription that weathered."""
    random = np.random.default_rng(seed)
    ends = random.uniform([10, 10], [290, 190], (45, 2))
    arms = random.uniform(-45, 45, (45, 2))
    depths, widths = random.uniform(1, 4, 45), random.uniform(2, 5, 45)
    worn = Noise(random, 2, 120, 8, 1.2)

    def height(x, y):
        z = 0.8 * worn(x, y)
        for end, arm, depth, width in zip(ends, arms, depths, widths):
            along = np.clip(((x - end[0]) * arm[0] + (y - end[1]) * arm[1]) / (arm @ arm), 0, 1)
            off = np.hypot(x - end[0] - along * arm[0], y - end[1] - along * arm[1])
            z = z - depth * np.exp(-(off / width) ** 2)
        return z

    return height


def outcrop(seed):
    """Ridges of rock, 60 by 60 m."""
    random = np.random.default_rng(seed)
    shape, folds, rough = Noise(random, 2, 60, 15), Noise(random, 2, 30, 6), Noise(random, 2, 6, 1.2, 0.8)
    return lambda x, y: 3 * shape(x, y) + 2.5 * (1 - np.abs(folds(x, y))) + 0.35 * rough(x, y)


def quarry(seed):
    """Terraces with a ramp and heaps, 400 by 300 m."""
    random = np.random.default_rng(seed)
    shape, rough = Noise(random, 2, 400, 90), Noise(random, 2, 30, 4, 0.8)
    heaps = np.c_[random.uniform(0, 400, 14), random.uniform(0, 300, 14), random.uniform(6, 18, 14)]

    def height(x, y):
        pit = 0.12 * np.hypot(x - 170, 1.3 * (y - 140)) + 9 * shape(x, y)
        step = np.floor(pit / 12)
        z = 12 * (step + np.clip((pit / 12 - step - 0.75) / 0.25, 0, 1)) + 0.4 * rough(x, y)
        for u, v, size in heaps:
            z = z + np.maximum(0, 0.6 * (size - np.hypot(x - u, y - v)))
        return z

    return height


def dunes(seed):
    """Long slopes to windward, steep ones to lee, crests that wander: 500 by 400 m."""
    random = np.random.default_rng(seed)
    wander, size, ripple = Noise(random, 2, 500, 120), Noise(random, 2, 400, 120), Noise(random, 2, 40, 8)

    def height(x, y):
        phase = (x + 0.2 * y) / 75 + 0.35 * wander(x, y)
        part = phase - np.floor(phase)
        slope = np.where(part < 0.75, part / 0.75, (1 - part) / 0.25)
        return 7 * (1 + 0.35 * size(x, y)) * slope ** 1.3 + 0.25 * ripple(x, y)

    return height


def town(seed):
    """Roofs seen from the air, 220 by 220 m: gables and flat roofs of many sizes on ground that falls."""
    random = np.random.default_rng(seed)
    places = [(20 + 40 * (k % 5) + random.uniform(-5, 5), 20 + 40 * (k // 5) + random.uniform(-5, 5),
               random.uniform(8, 17), random.uniform(6, 12), random.uniform(0, math.pi), random.uniform(4, 14),
               random.uniform(0, 0.8)) for k in range(25)]
    ground = Noise(random, 2, 220, 40)

    def height(x, y):
        z = 1.5 * ground(x, y) + 0.02 * x
        for u, v, length, width, angle, top, pitch in places:
            a = (x - u) * math.cos(angle) + (y - v) * math.sin(angle)
            b = (y - v) * math.cos(angle) - (x - u) * math.sin(angle)
            z = np.where((np.abs(a) < length) & (np.abs(b) < width), top + pitch * (width - np.abs(b)) + 0.02 * u, z)
        return z

    return height


def waves(seed):
    """A pattern that repeats, 100 by 100."""
    return lambda x, y: 1.5 * np.sin(2 * math.pi * x / 20) * np.sin(2 * math.pi * y / 20)


def furrows(seed):
    """A ploughed field, 100 by 100 m: the same along the furrows, and the next one like the last."""
    gentle = Noise(np.random.default_rng(seed), 2, 300, 150)
    return lambda x, y: 0.15 * np.cos(2 * math.pi * x / 2.5) + 0.2 * gentle(x, y)


# --- solids ----------------------------------------------------------------------------------------------------------------


def boulder(seed):
    random = np.random.default_rng(seed)
    shape, rough = Noise(random, 3, 2.5, 0.8), Noise(random, 3, 0.6, 0.15)
    return ball(lambda u: 100 * (1 + 0.16 * shape(*u.T) + 0.03 * rough(*u.T)) * (1 - 0.25 * u[:, 2] ** 2))


def shell(seed):
    """A snail: a tube that winds outwards and down, with ribs."""
    random = np.random.default_rng(seed)
    ribs = Noise(random, 1, 3, 0.5)
    a, b = np.meshgrid(np.linspace(0, 5.6 * math.pi, 420), np.linspace(0, 2 * math.pi, 60), indexing="ij")
    size = np.exp(0.115 * a)
    tube = size * (0.62 + 0.03 * ribs(a) + 0.03 * np.cos(12 * a))
    out = size + tube * np.cos(b)
    corners = np.stack([out * np.cos(a), out * np.sin(a), -1.9 * size - tube * np.sin(b)], axis=-1)
    return 8 * corners.reshape(-1, 3), grid(420, 60)


def machined(seed):
    """A cam with teeth of different sizes, bosses and a slanted step on its top."""
    random = np.random.default_rng(seed)
    teeth = [(random.uniform(0, 2 * math.pi), random.uniform(2, 9), random.uniform(0.08, 0.3)) for _ in range(9)]
    bosses = [(*random.uniform(-32, 32, 2), random.uniform(3, 9), random.uniform(-6, 8)) for _ in range(7)]

    def edge(around):
        r = 50 + 4 * np.cos(around) + 2.5 * np.cos(2 * around + 1)
        for at, tall, wide in teeth:
            off = np.abs((around - at + math.pi) % (2 * math.pi) - math.pi)
            r = r + tall * np.clip(1.5 - off / wide, 0, 1)
        return r

    share, around = np.meshgrid(np.linspace(0.001, 1, 90), np.linspace(0, 2 * math.pi, 361), indexing="ij")
    x, y = share * edge(around) * np.cos(around), share * edge(around) * np.sin(around)
    top = 20 + np.where(0.4 * x + y > 10, 5 + 0.1 * x, 0)
    for u, v, size, tall in bosses:
        top = top + tall * np.clip((size + 1 - np.hypot(x - u, y - v)) / 1, 0, 1)
    flat = np.stack([x, y, top], axis=-1)
    fall = np.linspace(0, 1, 20)[:, None, None]
    wall = np.stack([flat[-1][None, :, k] + 0 * fall[:, :, 0] for k in range(2)] + [flat[-1][None, :, 2] *
                    (1 - fall[:, :, 0])], axis=-1)
    return joined((flat.reshape(-1, 3), grid(90, 361)), (wall.reshape(-1, 3), grid(20, 361)))


def torso(seed):
    """Shoulders, chest, belly and stumps of arms, unlike on both sides, 500 mm high."""
    random = np.random.default_rng(seed)
    skin = Noise(random, 2, 2.5, 0.6)
    height, around = np.meshgrid(np.linspace(0, 1, 160), np.linspace(0, 2 * math.pi, 260), indexing="ij")
    wide = np.interp(height, [0, 0.25, 0.5, 0.78, 0.86, 0.93, 1], [170, 150, 165, 205, 190, 80, 60])
    deep = np.interp(height, [0, 0.25, 0.5, 0.78, 0.86, 0.93, 1], [115, 100, 110, 115, 90, 65, 58])
    x, y = wide * np.cos(around), deep * np.sin(around)
    bulge = 1 + 0.012 * skin(np.cos(around) + 3 * height, np.sin(around) - 2 * height)
    for at, level, tall, size in ((1.15, 0.62, 0.28, 0.035), (1.95, 0.60, 0.24, 0.032), (1.57, 0.3, 0.1, 0.06),
                                  (0.05, 0.8, 0.18, 0.03), (3.2, 0.78, 0.22, 0.03), (4.4, 0.66, 0.12, 0.03)):
        bulge = bulge + tall * np.exp(-((around - at) / 0.33) ** 2 - (height - level) ** 2 / size ** 1.5)
    spine = 1 - 0.1 * np.exp(-((around - 4.71) / 0.12) ** 2)
    corners = np.stack([x * bulge, y * bulge * spine, 500 * height], axis=-1)
    return corners.reshape(-1, 3), grid(160, 260)


def tube(points, radii, sides=24):
    """A bent pipe around a line."""
    along = np.gradient(points, axis=0)
    along /= np.linalg.norm(along, axis=1)[:, None]
    across = np.cross(along, [0.31, 0.17, 0.93])
    across /= np.linalg.norm(across, axis=1)[:, None]
    up = np.cross(along, across)
    b = np.linspace(0, 2 * math.pi, sides)[:, None]
    corners = np.stack([p + r * (np.cos(b) * a + np.sin(b) * c) for p, r, a, c in zip(points, radii, across, up)])
    return corners.reshape(-1, 3), grid(len(points), sides)


def branches(seed):
    """A root: pipes that part and bend."""
    random = np.random.default_rng(seed)
    pipes = []
    for k in range(9):
        start = np.array([0, 0, 0.0]) if k < 4 else pipes[random.integers(4)][0][random.integers(20, 50)]
        steps = random.normal(size=3) + np.cumsum(random.normal(0, 0.14, (70, 3)), axis=0)
        steps /= np.linalg.norm(steps, axis=1)[:, None]
        line = start + np.cumsum(steps * (2.2 if k < 4 else 1.4), axis=0)
        pipes.append((line, np.linspace(11 if k < 4 else 6, 2.5, 70)))
    return joined(*(tube(line, radii) for line, radii in pipes))


def plain_ball(seed):
    return ball(lambda u: np.full(len(u), 50.0))


def bumped_ball(seed):
    return ball(lambda u: 50 * (1 + 0.03 * np.exp(-((u - [0, 0, 1]) ** 2).sum(axis=1) / 0.2)))


def cylinder(seed):
    a, z = np.meshgrid(np.linspace(0, 2 * math.pi, 200), np.linspace(0, 120, 60), indexing="ij")
    return np.stack([40 * np.cos(a), 40 * np.sin(a), z], axis=-1).reshape(-1, 3), grid(200, 60)


def cone(seed):
    a, z = np.meshgrid(np.linspace(0, 2 * math.pi, 200), np.linspace(0.02, 1, 60), indexing="ij")
    return np.stack([50 * z * np.cos(a), 50 * z * np.sin(a), -80 * z], axis=-1).reshape(-1, 3), grid(200, 60)


def cog(seed):
    """A wheel of 12 teeth, all alike."""
    share, a = np.meshgrid(np.linspace(0.3, 1, 50), np.linspace(0, 2 * math.pi, 481), indexing="ij")
    r = share * (50 + 6 * np.clip(2 * np.cos(12 * a), -1, 1))
    z = np.where(share < 0.5, 14, 8) + 1.0 * np.cos(12 * a) * share
    return np.stack([r * np.cos(a), r * np.sin(a), z], axis=-1).reshape(-1, 3), grid(50, 481)
