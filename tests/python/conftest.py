"""Fixtures of the tests of the Python module. They need pytest and NumPy; other packages are skipped where absent."""

from __future__ import annotations

import importlib.util
import json
import os
import pathlib
import subprocess
import sys
from collections.abc import Callable
from typing import Any

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
if importlib.util.find_spec("isopach") is None:  # neither installed nor on PYTHONPATH
    for built in sorted((ROOT / "build").glob("*/python/isopach/_core*.so")):
        sys.path.insert(0, str(built.parents[1]))
        break

isopach = pytest.importorskip("isopach", reason="the module is not built: make python")

Cli = Callable[..., "subprocess.CompletedProcess[str]"]  # words of a command line, cwd=folder


@pytest.fixture(scope="session")
def cli() -> Cli:
    """Runs the program in a folder; returns the finished run."""
    binary = os.environ.get("ISOPACH_BIN") or str(ROOT / "build/release/bin/isopach")

    def run(*words: Any, cwd: pathlib.Path) -> subprocess.CompletedProcess[str]:
        return subprocess.run([binary, *map(str, words)], cwd=cwd, capture_output=True, text=True, timeout=120)

    return run


@pytest.fixture(scope="session")
def plane() -> Any:
    return isopach.simulate("plane", points=1500, seed=3)


@pytest.fixture(scope="session")
def terrain() -> Any:
    return isopach.simulate("terrain", points=3000, seed=5)


@pytest.fixture(scope="session")
def face() -> Any:
    return isopach.simulate("face", points=5000, seed=2)


def without_timing(text: str | bytes) -> str:
    data = json.loads(text)
    data.pop("timing_s", None)
    return json.dumps(data)
