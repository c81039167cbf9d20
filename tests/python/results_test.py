"""What comes out: frozen trees, arrays that outlive their result, rasters that add up, sections, pickles, files."""

from __future__ import annotations

import gc
import json
import pathlib
import pickle
import re
from typing import Any

import isopach
import numpy as np
import pytest

pytestmark = pytest.mark.filterwarnings("ignore::isopach.ScanWarning")


@pytest.fixture(scope="module")
def result(terrain: isopach.Scene) -> Any:
    return isopach.compare(terrain.a, terrain.b, sigma1=0.1, sigma2=0.1)


def test_attributes_are_the_keys(result: isopach.Comparison) -> None:
    data = json.loads(result.to_json())
    for key, value in data.items():
        shown = getattr(result, key)
        assert (shown.to_dict() if isinstance(shown, isopach.Record) else result.to_dict()[key]) == value
    assert result.volume.net == data["volume"]["net"]
    assert result.difference.abs_percentiles[95] == data["difference"]["abs_percentiles"]["95"]
    assert result["volume"]["net"] == result.volume.net
    assert set(result) == set(data)


def test_every_verb_has_no_method_that_hides_a_key() -> None:
    import pathlib
    schemas = pathlib.Path(__file__).resolve().parents[2] / "docs/schema"
    for kind in (isopach.Comparison, isopach.Matching, isopach.Distances, isopach.Accuracy, isopach.Scanners,
                 isopach.Asymmetry, isopach.Roughness, isopach.Sequence, isopach.Combination):
        keys = json.loads((schemas / f"{kind._verb}-1.json").read_text())["properties"]
        hidden = [key for key in keys if hasattr(kind, key)]
        assert hidden in ([], ["points"]), (kind, hidden)


def test_frozen(result: isopach.Comparison) -> None:
    with pytest.raises(AttributeError):
        result.volume = 1
    with pytest.raises(AttributeError):
        result.volume.net = 1
    with pytest.raises(AttributeError):
        del result.volume
    with pytest.raises(TypeError):
        result["volume"] = 1
    with pytest.raises(ValueError, match="read-only"):
        result.points_a.dz_signed[0] = 1
    with pytest.raises(ValueError, match="read-only"):
        result.cells.triangles[0] = 1
    with pytest.raises(AttributeError, match="has no 'volumes': it has"):
        _ = result.volumes
    copy = result.to_dict()
    copy["volume"]["net"] = 0
    assert result.volume.net != 0


def test_arrays_outlive_their_result(terrain: isopach.Scene) -> None:
    c = isopach.compare(terrain.a, terrain.b)
    dz, triangles = c.points_b.dz_signed, c.cells.triangles
    wanted = dz.copy(), triangles.copy()
    del c
    gc.collect()
    rubbish = [np.ones(len(dz)) for _ in range(50)]
    np.testing.assert_array_equal(dz, wanted[0])
    np.testing.assert_array_equal(triangles, wanted[1])
    assert len(rubbish) == 50


def test_arrays_are_no_copies(result: isopach.Comparison) -> None:
    first, second = result.points_a.dz_signed, result.points_a.dz_signed
    assert np.shares_memory(first, second)
    assert first.shape == (result.inputs[0].points,)


def test_cells_integrate_to_the_volume(result: isopach.Comparison) -> None:
    cells = result.cells
    p = cells.xy[cells.triangles]
    (ux, uy), (vx, vy) = (p[:, 1] - p[:, 0]).T, (p[:, 2] - p[:, 0]).T
    area = 0.5 * (ux * vy - uy * vx)
    assert area.sum() == pytest.approx(result.domain.area, rel=1e-9)
    assert (area * cells.dz[cells.triangles].mean(axis=1)).sum() == pytest.approx(result.volume.net, rel=1e-9)


@pytest.mark.parametrize("options", [{}, {"surface": "overlay"}, {"direction": (0.2, 0.1, 1)}, "polygon"], ids=str)
@pytest.mark.parametrize("resolution", [7.3, 25, 200])
def test_pixels_add_up_to_the_net_volume(terrain: isopach.Scene, options: Any, resolution: float) -> None:
    if options == "polygon":
        middle = terrain.a.points[:, :2].mean(axis=0)
        options = {"include": middle + 200 * np.array([[-1, -1], [1.1, -0.8], [0.9, 1], [-0.7, 0.6]])}
    c = isopach.compare(terrain.a, terrain.b, **options)
    x, y, layers = c._raster(resolution, True, None)
    gross = c.volume.absolute
    assert abs(np.nansum(layers["dz"]) * resolution**2 - c.volume.net) < 1e-12 * gross
    assert layers["covered"].sum() * resolution**2 == pytest.approx(c.domain.area, rel=1e-11)
    assert layers["covered"].max() < 1 + 1e-9
    assert np.allclose(np.mod(x, resolution), resolution / 2)
    assert y[0] > y[-1]
    known = layers["covered"] > 1e-6
    np.testing.assert_allclose((layers["z_b"] - layers["z_a"])[known], (layers["dz"] / layers["covered"])[known],
                               atol=1e-6)


def test_pixels_of_a_part_and_samples(result: isopach.Comparison, terrain: isopach.Scene) -> None:
    low = terrain.a.points[:, :2].mean(axis=0)
    x, y, layers = result._raster(10, True, (*low, *(low + 45)))
    whole_x, whole_y, whole = result._raster(10, True, None)
    i, j = np.flatnonzero(whole_x == x[0])[0], np.flatnonzero(whole_y == y[0])[0]
    np.testing.assert_allclose(layers["dz"], whole["dz"][j:j + len(y), i:i + len(x)], rtol=1e-9, atol=1e-9)
    _, _, samples = result._raster(10, False, (*low, *(low + 45)))
    np.testing.assert_allclose(samples["dz"][1:-1, 1:-1].ravel(),
                               result.at(np.column_stack([v.ravel() for v in np.meshgrid(x[1:-1], y[1:-1])])))


def test_values_at_places(result: isopach.Comparison) -> None:
    cells = result.cells
    np.testing.assert_allclose(result.at(cells.xy[cells.triangles].mean(axis=1)),
                               cells.dz[cells.triangles].mean(axis=1), atol=1e-7)
    corners = np.unique(cells.triangles)
    np.testing.assert_allclose(result.at(cells.xy[corners]), cells.dz[corners], atol=1e-7)
    assert np.isnan(result.at((0.0, 0.0)))
    assert isinstance(result.at(cells.xy[cells.triangles[0]].mean(axis=0)), float)


def test_profile_is_exact(result: isopach.Comparison) -> None:
    low, high = result.cells.xy.min(axis=0), result.cells.xy.max(axis=0)
    line = np.array([low + 0.2 * (high - low), low + [0.5, 0.3] * (high - low), low + 0.8 * (high - low)])
    section = result.profile(line)
    assert (np.diff(section.s) >= 0).all()
    length = np.hypot(*np.diff(line, axis=0).T).sum()
    assert 0 <= section.s[0] <= section.s[-1] <= length + 1e-6
    inside = np.isfinite(section.dz)

    def middle(v: Any) -> Any:
        return (v[:-1] + v[1:])[inside[:-1] & inside[1:]] / 2

    at = result.at(np.column_stack([middle(section.x), middle(section.y)]))
    np.testing.assert_allclose(at, middle(section.dz), atol=1e-6)
    denser = result.profile(line, step=5)
    assert len(denser.s) > len(section.s)
    known = np.isfinite(denser.dz)
    np.testing.assert_allclose(np.interp(denser.s[known], section.s[inside], section.dz[inside]), denser.dz[known],
                               atol=1e-6)


def test_profile_ends_where_the_cells_end(result: isopach.Comparison) -> None:
    low, high = result.cells.xy.min(axis=0), result.cells.xy.max(axis=0)
    section = result.profile([low - 500, high + 500])
    assert section.s[0] > 500
    with pytest.raises(isopach.UsageError, match="^line: "):
        result.profile([[0, 0]])


def test_pickle(result: isopach.Comparison) -> None:
    again = pickle.loads(pickle.dumps(result))
    assert again == result
    assert again.to_json() == result.to_json()
    np.testing.assert_array_equal(again.points_b.dz_signed, result.points_b.dz_signed)
    place = result.cells.xy[result.cells.triangles[7]].mean(axis=0)
    assert again.at(place) == result.at(place)
    assert repr(again) == repr(result)
    with pytest.raises(isopach.UsageError, match="comes from a pickle"):
        again.report("nowhere.html")


def test_pickle_of_scans(terrain: isopach.Scene) -> None:
    again = pickle.loads(pickle.dumps(terrain.a))
    np.testing.assert_array_equal(again.points, terrain.a.points)
    assert (again.unit, again.name) == (terrain.a.unit, terrain.a.name)
    assert pickle.loads(pickle.dumps(isopach.ToleranceError("x: y", 7))).result == 7


def test_repr_is_four_lines_with_units(result: isopach.Comparison, terrain: isopach.Scene, face: isopach.Scene) -> None:
    m = isopach.match(face.b, face.a)
    for thing, unit in ((result, "m³"), (m, "mm"), (terrain.a, "unit m"), (terrain, "unit m"),
                        (isopach.distance(terrain.a, terrain.b, measure="c2c"), " m")):
        lines = repr(thing).split("\n")
        assert len(lines) <= 4
        assert unit in repr(thing), repr(thing)
    unknown = isopach.compare(np.array(terrain.a.points), np.array(terrain.b.points))
    assert "unit unknown" in repr(unknown)
    assert " m³" not in repr(unknown)


def test_html_has_the_map(result: isopach.Comparison) -> None:
    page = result._repr_html_()
    assert "data:image/png;base64,iVBOR" in page
    assert "<script" not in page


def test_save_and_report(result: isopach.Comparison, tmp_path: pathlib.Path) -> None:
    folder = result.save(tmp_path / "out", no_points=True, map_width=500)
    assert {path.name for path in folder.iterdir()} >= {"result.json", "report.html", "difference.png", "difference.ply"}
    assert not (folder / "points_a.ply").exists()
    page = result.report(tmp_path / "report.html")
    assert page.read_text().startswith("<!DOCTYPE html>")
    assert [path.name for path in tmp_path.iterdir() if path.name.startswith(".")] == []
    with pytest.raises(TypeError, match="unexpected keyword argument 'size'"):
        result.save(tmp_path / "out", size=1)
    with pytest.raises(isopach.UsageError, match="profile"):
        result.save(tmp_path / "out", profile=[[1, 2]])
    with pytest.raises(isopach.UsageError, match="^map_width: "):
        result.save(tmp_path / "out", map_width=3)
    folder = result.save(tmp_path / "two", no_points=True, no_cells=True, range=2.5, report="short", pdf=tmp_path / "report.pdf", svg=True,
                         extent=[*np.asarray(result.cells.xy).min(axis=0), *np.asarray(result.cells.xy).max(axis=0)])
    assert (tmp_path / "report.pdf").read_bytes().startswith(b"%PDF")
    assert "+2.5" in (folder / "difference.svg").read_text()
    with pytest.raises(isopach.UsageError, match="^extent .*do not reach"):
        result.save(tmp_path / "two", extent=(0, 0, 1, 1))
    (tmp_path / "file").write_text("")
    with pytest.raises(isopach.UsageError, match="is a file, not a folder"):
        result.save(tmp_path / "file")


def test_save_writes_layers(result: isopach.Comparison, tmp_path: pathlib.Path) -> None:
    low, high = np.asarray(result.cells.xy).min(axis=0), np.asarray(result.cells.xy).max(axis=0)
    try:
        folder = result.save(tmp_path / "out", no_points=True, no_map=True, raster=50, contours=5, outlines=True, vtu=True,
                             vectors="fgb", profile=[low, high])
    except isopach.InputError as error:
        if "needs GDAL" not in str(error):
            raise
        pytest.skip("built without GDAL, as portable wheels are: no rasters")
    written = {path.name for path in folder.iterdir()}
    assert written >= {"difference.tif", "difference.qml", "contours.fgb", "outlines.fgb", "cells.vtu", "profile.csv",
                       "profile.svg"}
    table = np.genfromtxt(folder / "profile.csv", delimiter=",", names=True)
    section = result.profile([low, high])
    assert np.allclose(table["d"], section.dz, equal_nan=True)
    assert np.allclose(table["s"], section.s)


def test_to_xarray(result: isopach.Comparison) -> None:
    xarray = pytest.importorskip("xarray")
    ds = result.to_xarray(25)
    assert isinstance(ds, xarray.Dataset)
    assert float(ds.dz.sum()) * 25**2 == pytest.approx(result.volume.net, rel=1e-9)
    assert {"dz", "z_a", "z_b", "covered", "lod"} == set(ds.data_vars)


def test_to_geotiff(result: isopach.Comparison, tmp_path: pathlib.Path) -> None:
    rasterio = pytest.importorskip("rasterio")
    result.to_geotiff(tmp_path / "dod.tif", 25)
    with rasterio.open(tmp_path / "dod.tif") as file:
        assert np.nansum(file.read(1)) * 25**2 == pytest.approx(result.volume.net, rel=1e-9)


def test_to_geopandas(result: isopach.Comparison) -> None:
    pytest.importorskip("geopandas")
    frame = result.to_geopandas()
    assert (frame.dz * frame.area).sum() == pytest.approx(result.volume.net, rel=1e-6)


def test_to_pyvista(result: isopach.Comparison) -> None:
    pytest.importorskip("pyvista")
    mesh = result.to_pyvista()
    assert mesh.n_cells == len(result.cells)
    assert np.abs(mesh.points).max() < 1e4


def test_plots(result: isopach.Comparison) -> None:
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    assert "B − A" in result.hist().get_xlabel()
    assert result.plot().get_aspect() in ("equal", 1.0)
    low, high = result.cells.xy.min(axis=0), result.cells.xy.max(axis=0)
    assert result.profile([low, high]).plot().get_legend() is not None


def test_matching_applies_to_points(face: isopach.Scene) -> None:
    m = isopach.match(face.b, face.a)
    moved = m.apply(face.b.points)
    np.testing.assert_allclose(moved, face.b.points @ m.matrix[:3, :3].T + m.matrix[:3, 3])
    assert m.points_moving.stable.shape == (len(face.b),)
    assert set(np.unique(m.points_moving.stable)) <= {0, 1}


def test_missing_package_is_named_in_one_line(result: isopach.Comparison, monkeypatch: pytest.MonkeyPatch) -> Any:
    import builtins
    real = builtins.__import__

    def refuse(name: str, *rest: Any) -> Any:
        if name.split(".")[0] == "xarray":
            raise ImportError(name)
        return real(name, *rest)

    monkeypatch.setattr(builtins, "__import__", refuse)
    monkeypatch.delitem(__import__("sys").modules, "xarray", raising=False)
    with pytest.raises(isopach.Error, match=re.escape("pip install 'isopach[xarray]'")):
        result.to_xarray(10)


@pytest.mark.parametrize("wrong", [0, -1, np.nan, np.inf, 1.34e154, 1e-300, "x", None, [1, 2]], ids=str)
def test_resolutions_that_are_none(result: isopach.Comparison, wrong: Any) -> None:
    with pytest.raises(isopach.UsageError, match="^resolution: "):
        result._raster(wrong, True, None)
