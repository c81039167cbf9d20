"""isopach.tiles: the numbers of compare, by whatever has submit()."""

from __future__ import annotations

import concurrent.futures
import os
import pathlib
import shutil
from typing import Any

import pytest

import isopach

ROOT = pathlib.Path(__file__).resolve().parents[2]


@pytest.fixture(autouse=True)
def program(monkeypatch: pytest.MonkeyPatch) -> None:
    found = os.environ.get("ISOPACH_BIN") or shutil.which("isopach") or str(ROOT / "build/release/bin/isopach")
    if not os.path.exists(found):
        pytest.skip("the program isopach is not there")
    monkeypatch.setenv("ISOPACH_PROGRAM", found)


@pytest.fixture
def scans(tmp_path: pathlib.Path) -> tuple[pathlib.Path, pathlib.Path]:
    scene = isopach.simulate("terrain", points=5000, seed=1)
    a, b = tmp_path / "a.ply", tmp_path / "b.ply"
    scene.a.write(a)
    scene.b.write(b)
    return a, b


def numbers(result: Any) -> Any:
    found = {key: result[key] for key in ("domain", "measure", "volume", "difference", "border", "folds", "triangulations",
                                          "inputs", "warnings", "parameters")}
    return found


def test_tiles_are_the_whole(scans: tuple[pathlib.Path, pathlib.Path], tmp_path: pathlib.Path) -> None:
    whole = isopach.compare(*scans, border="hull")
    job = isopach.tiles.plan(*scans, tmp_path / "job", tile_points=2000, border="hull")
    assert job.status.done == 0 and len(job.missing()) == job.status.tiles > 4
    heard: list[tuple[int, int]] = []
    job.run(progress=lambda done, of: heard.append((done, of)))
    status = job.status
    assert heard[-1] == (status.tiles, status.tiles)
    assert (status.done, status.failed, status.missing, status.seconds_left) == (status.tiles, 0, 0, 0)
    assert all(tile.seconds > 0 and tile.host and tile.state == "done" for tile in status.each)
    assert numbers(job.reduce(tmp_path / "out", points=True)) == numbers(whole)
    assert len(list((tmp_path / "out").glob("points_a_*.laz"))) == job.status.tiles
    assert (tmp_path / "out/result.json").exists()
    assert "tiles" in repr(job)
    looks = job.reduce(tmp_path / "looks", title="Hang", report="short", svg=True, map_width=500,
                       extent=(412200, 5236300, 412700, 5236800))
    assert numbers(looks) == numbers(whole)
    assert {"difference.png", "difference.svg", "report.html"} <= {path.name for path in (tmp_path / "looks").iterdir()}
    assert "<h1>Hang</h1>" in (tmp_path / "looks/report.html").read_text()
    with pytest.raises(TypeError, match=r"reduce\(\) got an unexpected keyword argument 'border'"):
        job.reduce(border="hull")
    with pytest.raises(isopach.UsageError, match="outlines"):
        job.reduce(tmp_path / "none", outlines=True)


def test_scripts(scans: tuple[pathlib.Path, pathlib.Path], tmp_path: pathlib.Path) -> None:
    """Those of the command line, whose words they take."""
    job = isopach.tiles.plan(*scans, tmp_path / "job", tile_points=1000)
    assert "--array=0-" in job.script()
    text = job.script("slurm", tiles_each=5, at_once=3, program="/opt/isopach")
    assert f"--array=0-{(job.status.tiles - 1) // 5}%3\n" in text and "exec /opt/isopach tile run" in text
    assert "--jobs 2 " in job.script("parallel", at_once=2)
    with pytest.raises(isopach.UsageError, match="at-once"):
        job.script("snakemake", at_once=2)


def test_a_broken_file_is_named(scans: tuple[pathlib.Path, pathlib.Path], tmp_path: pathlib.Path) -> None:
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts/0.ply").write_bytes(scans[1].read_bytes())
    (tmp_path / "parts/1.ply").write_text("ply\nnothing\n")
    with pytest.warns(isopach.ScanWarning, match="left out: .*1.ply"):
        job = isopach.tiles.plan(scans[0], tmp_path / "parts", tmp_path / "job", tile_points=3000)
    assert [file.scan for file in job.status.broken] == ["B"]
    job.run()
    with pytest.raises(isopach.InputError, match="1.ply"):
        job.reduce()
    result = job.reduce(allow_missing=True)
    assert any("1.ply" in warning for warning in result.warnings)
    assert result.volume.net == isopach.compare(*scans).volume.net


def test_the_line_of_progress(scans: tuple[pathlib.Path, pathlib.Path], tmp_path: pathlib.Path,
                              capfd: pytest.CaptureFixture[str]) -> None:
    isopach.tiles.plan(*scans, tmp_path / "job", tile_points=3000).run(progress=True)
    said = capfd.readouterr().err
    assert " left" in said and said.count("\n") == 1 and said.rstrip().endswith("tiles")


def test_executors_share_a_job(scans: tuple[pathlib.Path, pathlib.Path], tmp_path: pathlib.Path) -> None:
    whole = isopach.compare(*scans)
    job = isopach.tiles.plan(*scans, tmp_path / "job", tile_points=1000)
    with concurrent.futures.ProcessPoolExecutor(2) as pool:
        assert numbers(job.run(pool).reduce()) == numbers(whole)


class Unreliable:
    """Two of three calls end with an exception of the engine's own."""

    def __init__(self) -> None:
        self.calls = 0

    def submit(self, function: Any, *arguments: Any) -> concurrent.futures.Future[Any]:
        self.calls += 1
        future: concurrent.futures.Future[Any] = concurrent.futures.Future()
        if self.calls % 3 != 0:
            future.set_exception(OSError("the worker is gone"))
        else:
            future.set_result(function(*arguments))
        return future


def test_workers_that_die_are_tried_again(scans: tuple[pathlib.Path, pathlib.Path], tmp_path: pathlib.Path) -> None:
    job = isopach.tiles.plan(*scans, tmp_path / "job", tile_points=3000)
    job.run(Unreliable(), retries=9)
    assert job.missing() == []
    other = isopach.tiles.plan(*scans, tmp_path / "other", tile_points=3000)
    with pytest.raises(isopach.InputError, match="the worker is gone"):
        other.run(Unreliable(), retries=0)


def test_one_line_of_what_is_wrong(scans: tuple[pathlib.Path, pathlib.Path], tmp_path: pathlib.Path) -> None:
    with pytest.raises(isopach.UsageError, match="noise-floor"):
        isopach.tiles.plan(*scans, tmp_path / "job", noise_floor=True)
    with pytest.raises(TypeError, match="'colour'"):
        isopach.tiles.plan(*scans, tmp_path / "job", colour=1)
    with pytest.raises(isopach.UsageError, match="no job"):
        isopach.tiles.Job(tmp_path / "nothing")
    with pytest.raises(isopach.InputError, match="nothing.ply"):
        isopach.tiles.plan(tmp_path / "nothing.ply", scans[1], tmp_path / "job")
    job = isopach.tiles.plan(*scans, tmp_path / "fine", tile_points=3000)
    with pytest.raises(isopach.InputError, match="--missing"):
        job.reduce()
