"""What the docstrings of the verbs say beside the options, which are the command line's."""

from __future__ import annotations

SUMMARY = {
    "compare": """How much and where scan B differs from scan A: d = B − A, positive where B lies above.

Both scans are triangulated, laid over each other, and d is integrated in closed form, cell by cell. Lengths are in the
unit of the scans, areas and volumes in its square and cube. Method: docs/method/method.md.""",
    "match": """The pose of one scan on another: the matrix that takes coordinates of `moving` to those of `fixed`.

Method: docs/method/matching.md.""",
    "distance": """Distances in space between two scans or meshes, both ways; positive where B lies above A.

To the nearest point, to the surface, along normal and direction, the Hausdorff distance with a proven bound, M3C2.""",
    "roughness": """How rough a surface is once its form and its waviness are removed (ISO 25178-2), and its wrinkles.

With a second scan, `after`, also what changed.""",
    "accuracy": """How well a reconstruction agrees with a reference: alignment, bias, scatter, deviation, completeness.""",
    "scanners": """Two scanners on one object: noise and bias of each against a reference, and which detail each resolves.""",
    "asymmetry": """How the two sides of a face differ: its plane of symmetry, an index, and which side stands out where.

`face` is a scan in any position. For other objects that are nearly symmetric, give `direction`.""",
    "sequence": """What of a sequence of scans stays and what moves, and the motion in every frame.

`frames`: scans in the order of time (paths, arrays, …), or the path of a folder of them.""",
    "combine": """Two scans that share no surface in one model, by a `reference` object that is seen in both.""",
    "info": """What files and scans hold: points, bounds, unit, CRS, attributes, duplicates, layers, spacing.""",
    "simulate": """Scans of a simulated scene, as scanners would sample it, and what is true of them.""",
    "convert": """Reads `src`, a file or a scan, and writes `dst` in the format of its ending.""",
}

EXAMPLE = {
    "compare": """>>> import isopach
>>> scene = isopach.simulate("plane", points=2000)
>>> c = isopach.compare(scene.a, scene.b)
>>> abs(c.volume.net - scene.volume.net) < 1e-6 * scene.volume.net
True
>>> c.points_b.dz_signed.shape == (len(scene.b),)
True""",
    "match": """>>> import isopach, numpy as np
>>> scene = isopach.simulate("face", points=5000, noise=0.05)
>>> moved = scene.a.points + [1.0, -0.5, 0.25]
>>> m = isopach.match(moved, scene.a, unit="mm")
>>> bool(np.abs(m.apply(moved) - scene.a.points).max() < 0.05)
True""",
    "distance": """>>> import isopach
>>> scene = isopach.simulate("plane", points=1000)
>>> d = isopach.distance(scene.a, scene.b, measure=["vertical"])
>>> d.points_b.vertical.shape == (len(scene.b),)
True""",
    "roughness": """>>> import isopach
>>> scene = isopach.simulate("skin", points=20000)
>>> r = isopach.roughness(scene.a, l_filter=8)
>>> bool(r.scan.parameters.sq > 0)
True""",
    "accuracy": """>>> import isopach
>>> scene = isopach.simulate("accuracy", points=5000)
>>> a = isopach.accuracy(scene.reconstruction, scene.reference, align="none", unit="mm")
>>> a.completeness is not None
True""",
    "scanners": """>>> import isopach
>>> scene = isopach.simulate("scanners", points=5000)
>>> s = isopach.scanners(scene.a, scene.b, scene.reference, align="none")
>>> len(s.scanners)
2""",
    "asymmetry": """>>> import isopach
>>> scene = isopach.simulate("face", points=20000)
>>> isopach.asymmetry(scene.a, direction="z").index.percent >= 0
True""",
    "sequence": """>>> import isopach
>>> scene = isopach.simulate("chewing", frames=12, points=4000)
>>> s = isopach.sequence(scene.scans.values())
>>> len(s.frames)
12""",
    "combine": """>>> import isopach
>>> scene = isopach.simulate("combine", points=8000)
>>> c = isopach.combine(scene.face, scene.jaw, reference=scene.reference)
>>> c.matrix.shape
(4, 4)""",
    "info": """>>> import isopach, numpy as np
>>> isopach.info(np.array([[0.0, 0, 1], [1, 0, 2], [0, 1, 3]])).files[0].points
3""",
    "simulate": """>>> import isopach
>>> scene = isopach.simulate("terrain", points=3000, seed=7)
>>> sorted(scene.scans), scene.unit
(['a', 'b'], 'm')""",
    "convert": """>>> import isopach, pathlib, tempfile
>>> scene = isopach.simulate("plane", points=500)
>>> isopach.convert(scene.a, pathlib.Path(tempfile.mkdtemp(), "a.las"))""",
}
