"""What goes in: arrays of any kind, objects of other libraries, and wrong things, which get one clear line."""

from __future__ import annotations

import pathlib
import subprocess
import types
from collections.abc import Callable
from typing import Any

import isopach
import numpy as np
import pytest
from conftest import without_timing

pytestmark = pytest.mark.filterwarnings("ignore::isopach.ScanWarning")


def rho(a: Any, b: Any, **options: Any) -> Any:
    return isopach.compare(a, b, **options).measure.rho


@pytest.mark.parametrize("change", [
    lambda p: np.asfortranarray(p),
    lambda p: p[::-1],
    lambda p: np.hstack([p, p])[:, :3],
    lambda p: np.hstack([p, p])[:, 3:],
    lambda p: np.repeat(p, 2, axis=0)[::2],
    lambda p: p.T.copy().T,
    lambda p: p.astype(">f8"),
    lambda p: p.tolist(),
    lambda p: tuple(map(tuple, p)),
    lambda p: p.astype(object),
    lambda p: np.ma.masked_array(p),
    lambda p: np.rec.fromarrays(list(p.T), dtype=[(axis, "f8") for axis in "xyz"]),
    lambda p: np.frombuffer(b"\0" + p.tobytes(), dtype=np.uint8)[1:].view(np.float64).reshape(-1, 3),
], ids=["Fortran", "reversed", "columns", "other columns", "rows", "transposed", "big-endian", "list", "tuples",
        "objects", "masked", "record", "unaligned"])
def test_order_type_and_stride_do_not_matter(plane: isopach.Scene, change: Callable[..., Any]) -> None:
    a, b = np.array(plane.a.points), np.array(plane.b.points)
    assert rho(change(a), change(b)) == rho(a, b)


@pytest.mark.parametrize("kind", [np.float32, np.int32, np.uint16, np.int64])
def test_other_types_are_the_doubles_of_them(plane: isopach.Scene, kind: Any) -> None:
    a, b = (np.round(np.abs(s.points * 100)).astype(kind) for s in (plane.a, plane.b))
    assert rho(a, b, duplicates="mean") == rho(a.astype(float), b.astype(float), duplicates="mean")


def test_masked_points_are_left_out(plane: isopach.Scene) -> None:
    a = np.ma.masked_array(np.array(plane.a.points), mask=False)
    a[5, 2] = np.ma.masked
    assert np.isnan(isopach.compare(a, plane.b).points_a.dz_signed[5])


def test_a_double_array_is_used_where_it_lies(plane: isopach.Scene) -> None:
    a = np.array(plane.a.points)
    scan = isopach.scan(a)
    assert np.shares_memory(scan.points, a)
    assert not scan.points.flags.writeable
    assert a.flags.writeable
    fortran = np.asfortranarray(a)
    assert np.shares_memory(isopach.scan(fortran).points, fortran)
    assert not np.shares_memory(isopach.scan(a.astype(np.float32)).points, a)


def test_attributes_and_units(plane: isopach.Scene) -> None:
    n = len(plane.a)
    scan = isopach.scan(np.array(plane.a.points), attributes={"classification": np.full(n, 2, np.uint8)}, unit="mm",
                        name="left")
    assert scan.attributes["classification"].dtype == np.float64
    with pytest.raises(ValueError, match="read-only"):
        scan.attributes["classification"][0] = 1
    c = isopach.compare(scan, scan, classes=2)
    assert (c.unit, c.inputs[0].path) == ("mm", "left")
    with pytest.raises(isopach.InputError):
        isopach.compare(scan, scan, classes=[6])


def test_arrays_are_called_by_their_argument(plane: isopach.Scene) -> None:
    c = isopach.compare(np.array(plane.a.points), np.array(plane.b.points))
    assert [i.path for i in c.inputs] == ["a", "b"]


def test_sigma_by_point(plane: isopach.Scene) -> None:
    a = np.array(plane.a.points)
    constant = isopach.compare(a, plane.b, sigma1=0.05, sigma2=0.05)
    by_point = isopach.compare(a, plane.b, sigma1=np.full(len(a), 0.05), sigma2=np.full(len(plane.b), 0.05))
    assert by_point.uncertainty.sigma_net == pytest.approx(constant.uncertainty.sigma_net)
    with pytest.raises(isopach.UsageError, match="^sigma1: 3 values for the"):
        isopach.compare(a, plane.b, sigma1=np.ones(3), sigma2=0.05)


def test_poses(plane: isopach.Scene) -> None:
    matrix = np.eye(4)
    matrix[2, 3] = 0.5
    moved = isopach.compare(plane.a, plane.b, pose=matrix)
    assert moved.difference.mean == pytest.approx(isopach.compare(plane.a, plane.b).difference.mean + 0.5)
    for wrong, says in ((np.eye(3), "pose: needed is a .4, 4. array"), (matrix.T, "pose: the last row"),
                        (matrix * np.nan, "pose: the matrix has numbers")):
        with pytest.raises(ValueError, match=says):
            isopach.compare(plane.a, plane.b, pose=wrong)


def test_a_matching_is_a_pose_and_a_registration_error(face: isopach.Scene) -> None:
    m = isopach.match(face.b, face.a)
    assert m.matrix.shape == (4, 4)
    c = isopach.compare(face.a, face.b, pose=m, sigma1=0.1, sigma2=0.1, uncertainty_model="registration",
                        registration_error=m)
    assert c.pose.matrix == m.pose.matrix
    assert c.uncertainty.sigma_net > 0


def test_polygons(terrain: isopach.Scene, tmp_path: pathlib.Path) -> None:
    low, high = (terrain.a.points[:, :2].mean(axis=0) + shift for shift in (-100, 100))
    ring = np.array([low, [high[0], low[1]], high, [low[0], high[1]]])
    as_geojson = {"type": "Feature", "properties": {"name": "square"},
                  "geometry": {"type": "Polygon", "coordinates": [[*ring.tolist(), ring[0].tolist()]]}}
    of_array = isopach.compare(terrain.a, terrain.b, include=ring)
    of_dict = isopach.compare(terrain.a, terrain.b, include=as_geojson)
    of_object = isopach.compare(terrain.a, terrain.b, include=types.SimpleNamespace(__geo_interface__=as_geojson))
    assert of_array.volume == of_dict.volume == of_object.volume
    assert of_array.domain.area == pytest.approx(200 * 200)
    assert of_dict.budget[0].name == "square"
    with pytest.raises(isopach.UsageError, match="^exclude: .*LineString"):
        isopach.compare(terrain.a, terrain.b, exclude={"type": "LineString", "coordinates": [[0, 0], [1, 1]]})


@pytest.mark.parametrize("broken", [
    {"type": "Polygon", "coordinates": None}, {"type": "Polygon"}, {"type": "Polygon", "coordinates": [[["x", 0]]]},
    {"type": "Feature"}, {"type": "Feature", "geometry": None}, {"type": "FeatureCollection", "features": [None]},
    {"type": "FeatureCollection"}, {"type": "GeometryCollection", "geometries": [7]},
    {"type": "Polygon", "coordinates": [[[0, 0], [1], [1, 1]]]}])
def test_geojson_with_a_part_missing_is_one_line(terrain: isopach.Scene, broken: dict[str, Any]) -> None:
    with pytest.raises(isopach.UsageError, match="^include: .*GeoJSON of polygons"):
        isopach.compare(terrain.a, terrain.b, include=broken)


def test_a_folder_is_read_as_one_scan(terrain: isopach.Scene, tmp_path: pathlib.Path) -> None:
    points = np.array(terrain.a.points)
    for k in range(3):
        isopach.scan(points[k::3]).write(tmp_path / f"part-{k}.ply")
    whole = isopach.read(tmp_path)
    assert len(whole) == len(points)
    assert isopach.compare(whole, terrain.b).volume == isopach.compare(terrain.a, terrain.b).volume


def test_a_ragged_pose_is_one_line(terrain: isopach.Scene) -> None:
    with pytest.raises(isopach.UsageError, match="^start: ") as told:
        isopach.match(terrain.a, terrain.b, start=[np.zeros((0, 2)), np.zeros((1, 2))])
    assert "\n" not in str(told.value)


# --- objects of other libraries --------------------------------------------------------------------------------------


def test_protocol(plane: isopach.Scene) -> None:
    class Held:
        def __isopach_scan__(self) -> Any:
            return plane.a

    assert rho(Held(), plane.b) == rho(plane.a, plane.b)

    class Wrong:
        def __isopach_scan__(self) -> Any:
            return 7

    with pytest.raises(isopach.UsageError, match="^a: __isopach_scan__ of Wrong"):
        isopach.compare(Wrong(), plane.b)


def test_laspy(plane: isopach.Scene, tmp_path: pathlib.Path) -> None:
    laspy = pytest.importorskip("laspy")
    isopach.convert(plane.a, tmp_path / "a.las")
    las = laspy.read(tmp_path / "a.las")
    np.testing.assert_array_equal(isopach.compare(las, plane.b).points_a.dz_signed,
                                  isopach.compare(tmp_path / "a.las", plane.b).points_a.dz_signed)
    assert "classification" in isopach.info(las).files[0].attributes


def test_geopandas(plane: isopach.Scene) -> None:
    geopandas = pytest.importorskip("geopandas")
    x, y, z = np.array(plane.a.points).T
    frame = geopandas.GeoDataFrame({"quality": np.arange(len(x))}, geometry=geopandas.points_from_xy(x, y, z),
                                   crs="EPSG:25832")
    c = isopach.compare(frame, frame)
    assert (c.unit, c.measure.rho) == ("m", 0)
    with pytest.raises(isopach.UsageError, match="^a: its geometries must all be points with a z"):
        isopach.compare(geopandas.GeoSeries(geopandas.points_from_xy(x, y)), plane.b)


def test_pandas(plane: isopach.Scene) -> None:
    pandas = pytest.importorskip("pandas")
    table = pandas.DataFrame(np.array(plane.a.points), columns=["X", "Y", "Z"])
    assert rho(table, plane.b) == rho(plane.a, plane.b)


def test_pyvista(plane: isopach.Scene) -> None:
    pyvista = pytest.importorskip("pyvista")
    mesh = isopach.compare(plane.a, plane.b).to_pyvista()
    back = isopach.info(pyvista.PolyData(mesh)).files[0]
    assert back.faces == mesh.n_cells


def test_trimesh(face: isopach.Scene) -> None:
    trimesh = pytest.importorskip("trimesh")
    cells = isopach.compare(face.a, face.b).cells
    mesh = trimesh.Trimesh(cells.points("a"), cells.triangles, process=False)
    assert isopach.info(mesh).files[0].faces == len(cells)


def test_xarray() -> None:
    xarray = pytest.importorskip("xarray")
    heights = np.add.outer(np.arange(20.0), np.arange(30.0))
    heights[3, 4] = np.nan
    raster = xarray.DataArray(heights, {"y": np.arange(20)[::-1] + 0.5, "x": np.arange(30) + 0.5}, ("y", "x"))
    assert isopach.info(raster).files[0].points == 599
    assert isopach.compare(raster, raster + 2).volume.net == pytest.approx(2 * 29 * 19, rel=0.01)


# --- wrong things ----------------------------------------------------------------------------------------------------

GOOD = np.random.default_rng(1).uniform(0, 10, (50, 3))


@pytest.mark.parametrize(("wrong", "kind", "says"), [
    (GOOD[:, :2], isopach.UsageError, r"^a: an array of shape \(50, 2\): a scan is \(n, 3\)"),
    (GOOD[0], isopach.UsageError, r"^a: an array of shape \(3,\)"),
    (GOOD[None], isopach.UsageError, r"^a: an array of shape \(1, 50, 3\)"),
    (GOOD.astype(str), isopach.UsageError, "^a: its values are of type <U32, not numbers"),
    (GOOD + 1j, isopach.UsageError, "^a: its values are of type complex128"),
    (np.array([["x", None, 3]], dtype=object), isopach.UsageError, "^a: its values are no numbers"),
    ([[1, 2, 3], [1, 2]], isopach.UsageError, "^a: cannot be read as an array"),
    (np.zeros((0, 3)), isopach.InputError, "^a: no points"),
    (np.full((50, 3), np.nan), isopach.InputError, "^a"),
    (np.full((50, 3), np.inf), isopach.InputError, "^a"),
    (GOOD * 1e300, isopach.InputError, "a"),
    (np.zeros((50, 3)), isopach.Error, "a"),
    (7, isopach.UsageError, "^a: int is nothing that looks like a scan"),
    (None, isopach.UsageError, "^a: None is no scan"),
    ({}, isopach.UsageError, "^a: dict is nothing that looks like a scan"),
    ("", isopach.UsageError, "^a: the path is empty"),
    ("no/such/file.ply", isopach.InputError, "^no/such/file.ply"),
    (np.zeros(5, dtype=[("x", "f8"), ("y", "f8")]), isopach.UsageError, "^a: a structured array needs"),
], ids=lambda value: None if isinstance(value, np.ndarray) else str(value)[:30])
def test_wrong_scans_get_one_line(wrong: Any, kind: Any, says: str) -> None:
    with pytest.raises(kind, match=says) as caught:
        isopach.compare(wrong, GOOD)
    assert "\n" not in str(caught.value)
    assert caught.value.exit_code > 0


def test_a_file_that_is_none(tmp_path: pathlib.Path) -> None:
    (tmp_path / "noise.las").write_bytes(bytes(range(256)) * 4)
    with pytest.raises(isopach.InputError, match="noise.las"):
        isopach.compare(tmp_path / "noise.las", GOOD)


@pytest.mark.parametrize(("options", "says"), [
    ({"sigma1": -1}, "^sigma1: -1"),
    ({"sigma1": "high"}, "^sigma1: 'high' is neither"),
    ({"surface": "other"}, "^surface: 'other' is not one of common"),
    ({"max_edge": 0}, "^max_edge: "),
    ({"max_edge": "long"}, "^max_edge: "),
    ({"confidence": 2}, "^confidence: "),
    ({"crop": (1, 2, 3)}, "^crop: "),
    ({"direction": (0, 0, 0)}, "^direction: "),
    ({"classes": "ground"}, "^classes: 'ground' is not a number"),
    ({"match": "yes"}, "^match: 'yes' is not True or False"),
    ({"max_iterations": 2.5, "match": True}, "^max_iterations: '2.5' is not a whole number"),
    ({"objective": "icp-plane"}, "^objective: it says how to match: give it with match=True"),
    ({"fail_above": {"beauty": 1}}, "^fail_above: unknown statistic 'beauty'"),
    ({"include": 7}, "^include: int: needed is"),
    ({"include": "none.geojson"}, "none.geojson"),
    ({"threads": -1}, "^threads: "),
    ({"progress": "often"}, "^progress: "),
    ({"weight": "x +"}, "^weight"),
    ({"unit": "parsec"}, "^unit: 'parsec' is not one of m"),
    ({"max_edge": True}, "^max_edge: True is neither"),
], ids=str)
def test_wrong_options_name_the_keyword(options: Any, says: str) -> None:
    with pytest.raises(isopach.Error, match=says) as caught:
        isopach.compare(GOOD, GOOD, **options)
    text = str(caught.value)
    assert "--" not in text
    assert "\n" not in text
    assert isinstance(caught.value, ValueError)


def test_unknown_keywords_are_type_errors() -> None:
    with pytest.raises(TypeError, match=r"compare\(\) got an unexpected keyword argument 'max_edgs' \(did you mean 'max_edge'"):
        isopach.compare(GOOD, GOOD, max_edgs=1)  # type: ignore[call-arg]
    with pytest.raises(TypeError, match="missing a required"):
        isopach.compare(GOOD)  # type: ignore[call-arg]
    with pytest.raises(TypeError, match="reference"):
        isopach.combine(GOOD, GOOD)  # type: ignore[call-arg]


def test_failures_carry_exit_code_and_result(plane: isopach.Scene) -> None:
    far = np.array(plane.b.points) + [1e4, 0, 0]
    with pytest.raises(isopach.OverlapError) as apart:
        isopach.compare(plane.a, far)
    assert (apart.value.exit_code, isinstance(apart.value, RuntimeError)) == (4, True)
    with pytest.raises(isopach.ToleranceError, match="^fail_above: rho is") as above:
        isopach.compare(plane.a, plane.b, fail_above={"rho": 1e-9})
    assert (above.value.exit_code, above.value.keyword) == (6, "fail_above")
    assert above.value.result.measure.rho > 1e-9


def test_nothing_is_imported_but_numpy() -> None:
    import subprocess
    import sys
    code = ("import sys; sys.path[:0] = %r; import isopach; s = isopach.simulate('plane', points=200);"
            "isopach.compare(s.a, s.b).to_json();"
            "print([m for m in ('laspy','geopandas','pandas','xarray','matplotlib','pyvista','rasterio','tqdm') if m in sys.modules])")
    told = subprocess.run([sys.executable, "-c", code % sys.path[:2]], capture_output=True, text=True, check=True)
    assert told.stdout.strip() == "[]"


def test_paths_that_begin_with_a_dash(plane: isopach.Scene, tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    plane.a.write("-a.xyz")
    assert isopach.compare("-a.xyz", plane.a).measure.rho == 0


def test_same_scan_from_file_and_array(plane: isopach.Scene, tmp_path: pathlib.Path) -> None:
    plane.a.write(tmp_path / "a.ply")
    of_file = isopach.read(tmp_path / "a.ply")
    assert of_file.path == tmp_path / "a.ply"
    assert without_timing(isopach.compare(of_file, plane.b).to_json()) == \
        without_timing(isopach.compare(str(tmp_path / "a.ply"), plane.b).to_json())
