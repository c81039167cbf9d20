"""The command line and Python give the same JSON, less timing, and the same arrays."""

from __future__ import annotations

import json
import pathlib
import subprocess
from collections.abc import Iterable
from typing import Any

import isopach
import numpy as np
import pytest
from conftest import Cli, without_timing


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Any:
    """Scans of every kind of scene, with polygons, a pose, and classes."""
    place = tmp_path_factory.mktemp("scans")
    sizes: dict[str, dict[str, Any]] = {
        "plane": {"points": 800}, "terrain": {"points": 2500}, "face": {"points": 4000}, "skin": {"points": 6000},
        "accuracy": {"points": 3000, "points_b": 6000}, "scanners": {"points": 3000, "points_b": 1000},
        "combine": {"points": 8000}, "chewing": {"frames": 10, "points": 4000}}
    for name, options in sizes.items():
        isopach.simulate(name, seed=4, **options).save(place / name)
    low, high = (isopach.read(place / "terrain/a.ply").points[:, :2].mean(axis=0) + shift for shift in (-150, 150))
    ring = [[low[0], low[1]], [high[0], low[1]], [high[0], high[1]], [low[0], high[1]], [low[0], low[1]]]
    (place / "square.geojson").write_text(json.dumps({"type": "FeatureCollection", "features": [
        {"type": "Feature", "properties": {"name": "square"}, "geometry": {"type": "Polygon", "coordinates": [ring]}}]}))
    (place / "pose.txt").write_text("1 0 0 0.25\n0 1 0 -0.125\n0 0 1 0.5\n0 0 0 1\n")
    return place


PLANE, TERRAIN, FACE = (f"{name}/a.ply {name}/b.ply" for name in ("plane", "terrain", "face"))
CASES: list[tuple[str, str, str, dict[str, Any]]] = [
    ("compare", PLANE, "", {}),
    ("compare", PLANE, "--surface overlay", {"surface": "overlay"}),
    ("compare", PLANE, "--surface both --locate tree", {"surface": "both", "locate": "tree"}),
    ("compare", PLANE, "--interpolation cubic --border hull", {"interpolation": "cubic", "border": "hull"}),
    ("compare", PLANE, "--measure currents --sigma 2.5", {"measure": "currents", "sigma": 2.5}),
    ("compare", PLANE, "--weight x+1 --fail-above max=1e6 --fail-above p97.5=1e6",
     {"weight": "x+1", "fail_above": ["max=1e6", "p97.5=1e6"]}),
    ("compare", PLANE, "--pose pose.txt --duplicates max", {"pose": "pose.txt", "duplicates": "max"}),
    ("compare", TERRAIN, "--sigma1 0.05 --sigma2 0.08 --uncertainty-model correlated --correlation-range 20",
     {"sigma1": 0.05, "sigma2": 0.08, "uncertainty_model": "correlated", "correlation_range": 20}),
    ("compare", TERRAIN, "--include square.geojson --lod 0.1", {"include": "square.geojson", "lod": 0.1}),
    ("compare", TERRAIN, "--budget square.geojson --exclude square.geojson",
     {"budget": ["square.geojson"], "exclude": ["square.geojson"]}),
    ("compare", TERRAIN, "--noise-floor --max-edge 60 --alpha 80", {"noise_floor": True, "max_edge": 60, "alpha": 80}),
    ("compare", FACE, "--direction 0.1,0,1 --unit mm --domain hull",
     {"direction": (0.1, 0, 1), "unit": "mm", "domain": "hull"}),
    ("compare", FACE, "--match --freedom x,y,z", {"match": True, "freedom": ["x", "y", "z"]}),
    ("match", FACE, "", {}),
    ("match", FACE, "--objective icp-plane --reject-distance 4x --symmetric",
     {"objective": "icp-plane", "reject_distance": "4x", "symmetric": True}),
    ("match", FACE, "--pose-only --overlap 0.8 --max-iterations 40",
     {"pose_only": True, "overlap": 0.8, "max_iterations": 40}),
    ("distance", PLANE, "", {}),
    ("distance", PLANE, "--measure c2c,surface,m3c2 --normal-scale 4 --projection-scale 3 --max-depth 5 --samples 4",
     {"measure": ["c2c", "surface", "m3c2"], "normal_scale": 4, "projection_scale": 3, "max_depth": 5, "samples": 4}),
    ("roughness", "skin/a.ply", "--l-filter 8 --form polynomial --degree 3",
     {"l_filter": 8, "form": "polynomial", "degree": 3}),
    ("roughness", "skin/a.ply skin/b.ply", "--l-filter 8 --filter robust", {"l_filter": 8, "filter": "robust"}),
    ("accuracy", "accuracy/reconstruction.ply accuracy/reference.ply",
     "--align none --within 0.1 --fail-below completeness=0.1",
     {"align": "none", "within": 0.1, "fail_below": {"completeness": 0.1}}),
    ("scanners", "scanners/a.ply scanners/b.ply scanners/reference.ply", "--align none --reference-sigma 0.01",
     {"align": "none", "reference_sigma": 0.01}),
    ("asymmetry", "face/a.ply", "--direction z --rim 2 --regions halves",
     {"direction": "z", "rim": 2, "regions": "halves"}),
    ("sequence", "chewing", "--rate 15 --smooth 1", {"rate": 15, "smooth": 1}),
    ("combine", "combine/face.ply combine/jaw.ply", "--reference combine/reference.ply",
     {"reference": "combine/reference.ply"}),
    ("info", "plane/a.ply terrain/b.ply", "--direction x", {"direction": "x"}),
]


def succeeded(told: subprocess.CompletedProcess[str]) -> None:
    if "needs GDAL" in told.stderr:
        pytest.skip("built without GDAL, as portable wheels are: no polygons of files")
    assert told.returncode == 0, told.stderr


@pytest.mark.filterwarnings("ignore::isopach.ScanWarning")
@pytest.mark.parametrize(("verb", "scans", "words", "keywords"), CASES, ids=lambda value: str(value)[:60])
def test_command_line_and_python_say_the_same(folder: pathlib.Path, cli: Cli, monkeypatch: pytest.MonkeyPatch, verb: str, scans: str, words: str, keywords: dict[str, Any]) -> None:
    told = cli(verb, *scans.split(), *words.split(), "--json", "-", cwd=folder)
    succeeded(told)
    monkeypatch.chdir(folder)
    of_paths = getattr(isopach, verb)(*scans.split(), **keywords)
    assert without_timing(of_paths.to_json()) == without_timing(told.stdout)
    if verb in ("sequence", "info"):
        return
    of_scans = getattr(isopach, verb)(*(isopach.read(path) for path in scans.split()), **keywords)
    assert without_timing(of_scans.to_json()) == without_timing(told.stdout)


def _vertices(path: pathlib.Path, fields: Iterable[str]) -> Any:
    """Columns of a binary PLY of doubles, as this program writes it."""
    data = pathlib.Path(path).read_bytes()
    head, body = data.split(b"end_header\n", 1)
    lines = head.decode().split("\n")
    count = next(int(line.split()[2]) for line in lines if line.startswith("element vertex"))
    types = {"double": "<f8", "float": "<f4", "uchar": "u1", "int": "<i4", "uint": "<u4", "ushort": "<u2"}
    table = []
    for line in lines[lines.index(next(x for x in lines if x.startswith("element vertex"))) + 1:]:
        if not line.startswith("property") or line.startswith("property list"):
            break
        _, kind, name = line.split()
        table.append((name, types[kind]))
    rows = np.frombuffer(body, dtype=table, count=count)
    return [rows[name] for name in fields]


def test_arrays_are_those_of_the_files(folder: pathlib.Path, cli: Cli, tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(folder)
    told = cli("compare", *TERRAIN.split(), "--sigma1", 0.05, "--sigma2", 0.05, "-o", tmp_path / "out", cwd=folder)
    assert told.returncode == 0, told.stderr
    c = isopach.compare(*TERRAIN.split(), sigma1=0.05, sigma2=0.05)
    for room, name in ((c.points_a, "points_a"), (c.points_b, "points_b")):
        dz, = _vertices(tmp_path / f"out/{name}.ply", ["dz_signed"])
        np.testing.assert_array_equal(room.dz_signed, dz)
    x, y, z = _vertices(tmp_path / "out/difference.ply", "xyz")
    found = {tuple(row) for row in c.cells.points("b")}
    assert {tuple(row) for row in np.column_stack([x, y, z])} <= found


@pytest.mark.filterwarnings("ignore::isopach.ScanWarning")
@pytest.mark.parametrize(("verb", "scans", "words", "keywords"), [case for case in CASES if case[0] != "info"],
                         ids=lambda value: str(value)[:60])
def test_files_are_those_of_the_command_line(folder: pathlib.Path, cli: Cli, tmp_path: pathlib.Path,
                                             monkeypatch: pytest.MonkeyPatch, verb: str, scans: str, words: str,
                                             keywords: dict[str, Any]) -> None:
    monkeypatch.chdir(folder)
    shell, python = tmp_path / "shell", tmp_path / "python"
    told = cli(verb, *scans.split(), *words.split(), "-o", shell, "--quiet", cwd=folder)
    succeeded(told)
    getattr(isopach, verb)(*scans.split(), **keywords).save(python)
    names = sorted(path.name for path in shell.iterdir())
    assert sorted(path.name for path in python.iterdir()) == names
    for name in names:
        mine, theirs = (python / name).read_bytes(), (shell / name).read_bytes()
        if name == "result.json":
            assert without_timing(mine) == without_timing(theirs)
        elif name != "report.html":  # which shows times
            assert mine == theirs, name


def test_simulated_scans_are_those_of_the_command_line(cli: Cli, tmp_path: pathlib.Path) -> None:
    assert cli("simulate", "terrain", "-o", "t", "--points", 500, "--seed", 9, cwd=tmp_path).returncode == 0
    scene = isopach.simulate("terrain", points=500, seed=9)
    np.testing.assert_array_equal(isopach.read(tmp_path / "t/a.ply").points, scene.a.points)
    truth = json.loads((tmp_path / "t/truth.json").read_text())
    truth.pop("outputs")
    assert truth == scene.to_dict()
