"""The surface of the package: signatures, docstrings, stubs, pages."""

from __future__ import annotations

import doctest
import inspect
import os
import pathlib
import re
import subprocess
import sys
from typing import Any

import isopach
import pytest
from conftest import Cli
from notebooks_test import BOOKS, code_cells

ROOT = pathlib.Path(__file__).resolve().parents[2]
VERBS = ("compare", "match", "distance", "roughness", "accuracy", "scanners", "asymmetry", "sequence", "combine", "info",
         "simulate", "convert")
pytestmark = pytest.mark.filterwarnings("ignore::isopach.ScanWarning")


def of_help(cli: Cli, verb: str, tmp_path: pathlib.Path) -> Any:
    return set(re.findall(r"^ +(?:-\w )?--([a-z0-9-]+)", cli(verb, "--help", cwd=tmp_path).stdout, re.MULTILINE))


@pytest.mark.parametrize("verb", VERBS)
def test_keywords_are_the_options(cli: Cli, tmp_path: pathlib.Path, verb: str) -> None:
    named = {p.name for p in inspect.signature(getattr(isopach, verb)).parameters.values() if p.kind is p.KEYWORD_ONLY}
    options = of_help(cli, verb, tmp_path)
    left_out = {"help", "version", "config", "json", "output", "quiet", "verbose", "max-input", "palette",
                "flip-palette", "title", "map-width", "report-vertices", "no-map", "no-cells", "no-points", "format",
                "pose-out", "raster", "contours", "profile", "outlines", "vectors", "vtu", "range", "extent", "author", "logo",
                "svg", "report", "pdf",  # of save()
                    "max-memory"}  # isopach.tiles
    assert named == {{"class": "classes"}.get(o, o.replace("-", "_")) for o in options - left_out}


@pytest.mark.parametrize("verb", VERBS)
def test_docstring(verb: str) -> None:
    text = getattr(isopach, verb).__doc__
    assert "--" not in re.sub(r"-{5,}", "", text)
    for keyword in inspect.signature(getattr(isopach, verb)).parameters.values():
        if keyword.kind is keyword.KEYWORD_ONLY:
            assert f"{keyword.name} :" in text


def test_defaults_are_shown() -> None:
    parameters = inspect.signature(isopach.compare).parameters
    assert parameters["surface"].default == "common"
    assert parameters["confidence"].default == 0.95
    assert parameters["match"].default is False
    assert parameters["sigma1"].default is None


def test_doctests() -> None:
    runner = doctest.DocTestRunner()
    count = 0
    for name in isopach.__all__:
        thing = getattr(isopach, name)
        if not callable(thing) or not thing.__doc__:
            continue
        test = doctest.DocTestParser().get_doctest(thing.__doc__, {"isopach": isopach}, name, None, 0)
        count += len(test.examples)
        runner.run(test)
    assert runner.failures == 0
    assert count >= 30


def test_stubs_are_those_of_the_options() -> None:
    run = subprocess.run([sys.executable, ROOT / "scripts/python_stubs", "--check"], capture_output=True, text=True)
    assert run.returncode == 0, run.stderr


PAGES = sorted((ROOT / "docs").glob("**/*.md")) + [ROOT / "README.md"]


@pytest.mark.parametrize("page", [p for p in PAGES if "```python" in p.read_text()], ids=lambda p: p.name)
def test_code_of_pages_runs(page: pathlib.Path, tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    if "ISOPACH_BIN" in os.environ:
        monkeypatch.setenv("ISOPACH_PROGRAM", os.environ["ISOPACH_BIN"])
    blocks = re.findall(r"```python\n(.*?)```", page.read_text(), re.DOTALL)
    room: dict[str, Any] = {}
    for block in blocks:
        if (absent := re.search(r"# needs (\w+)", block)) and not _has(absent.group(1)):
            continue
        exec(compile(block, str(page), "exec"), room)


def _has(module: str) -> Any:
    import importlib.util
    return importlib.util.find_spec(module) is not None


def test_stubs_fit_the_module() -> None:
    pytest.importorskip("mypy")
    run = subprocess.run([sys.executable, "-m", "mypy.stubtest", "isopach._verbs", "--ignore-missing-stub"],
                         capture_output=True, text=True, cwd=ROOT,
                         env={**os.environ, "MYPYPATH": str(pathlib.Path(isopach.__file__).parents[1])})
    assert run.returncode == 0, run.stdout + run.stderr


def test_mypy(tmp_path: pathlib.Path) -> None:
    """Of code as users write it: typed.py, these tests, and the notebooks."""
    pytest.importorskip("mypy")
    notebooks = []
    for book in BOOKS:
        notebooks.append(tmp_path / f"notebook_{book.stem}.py")
        notebooks[-1].write_text("\n".join(code for code, _, _ in code_cells(book)))
    here = pathlib.Path(__file__).parent
    path = os.pathsep.join([str(pathlib.Path(isopach.__file__).parents[1]), str(here)])
    run = subprocess.run([sys.executable, "-m", "mypy", "--strict", "--follow-imports=silent", "--ignore-missing-imports",
                          "--no-error-summary", "--cache-dir", tmp_path / "cache", *sorted(here.glob("*.py")), *notebooks],
                         capture_output=True, text=True, cwd=tmp_path, env={**os.environ, "MYPYPATH": path})
    assert run.returncode == 0, run.stdout + run.stderr
