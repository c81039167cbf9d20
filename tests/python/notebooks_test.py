"""The notebooks of docs/notebooks run, print what they keep, and pass a strict check of types."""

from __future__ import annotations

import ast
import contextlib
import importlib.util
import io
import json
import os
import pathlib
import re
from typing import Any

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
BOOKS = sorted((ROOT / "docs/notebooks").glob("*.ipynb"))
pytestmark = pytest.mark.filterwarnings("ignore")


def code_cells(path: pathlib.Path) -> list[tuple[str, list[str], str]]:
    """Of each: the code, its tags, and what it prints as it is kept."""
    cells = []
    for cell in json.loads(path.read_text())["cells"]:
        if cell["cell_type"] == "code":
            printed = "".join("".join(output["text"]) for output in cell["outputs"] if output.get("name") == "stdout")
            cells.append(("".join(cell["source"]), cell["metadata"].get("tags", []), printed))
    return cells


def absent(names: Any) -> str | None:
    return next((name for name in names if importlib.util.find_spec(name) is None), None)


def imported(code: str) -> set[str]:
    found = set()
    for node in ast.walk(ast.parse(code)):
        if isinstance(node, ast.Import):
            found |= {alias.name.split(".")[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            found.add(node.module.split(".")[0])
    return found


def run_as_shown(code: str, room: dict[str, Any]) -> None:
    """The last line is shown, as by a notebook."""
    body = ast.parse(code)
    last = body.body.pop() if isinstance(body.body[-1], ast.Expr) else None
    exec(compile(body, "cell", "exec"), room)
    if isinstance(last, ast.Expr):
        shown = eval(compile(ast.Expression(last.value), "cell", "eval"), room)
        if hasattr(shown, "_repr_html_"):
            assert shown._repr_html_()


@pytest.mark.parametrize("book", BOOKS, ids=lambda book: book.stem)
def test_notebook(book: pathlib.Path, monkeypatch: pytest.MonkeyPatch, tmp_path: pathlib.Path) -> None:
    cells = code_cells(book)
    if missing := absent(sorted(imported("\n".join(code for code, _, _ in cells)))):
        pytest.skip(f"{missing} is not there")
    monkeypatch.setenv("MPLBACKEND", "Agg")
    monkeypatch.setenv("MPLCONFIGDIR", os.environ.get("MPLCONFIGDIR", str(tmp_path)))
    monkeypatch.chdir(tmp_path)
    room: dict[str, Any] = {"__name__": "__main__"}
    for code, tags, kept in cells:
        if absent(tag.removeprefix("needs ") for tag in tags if tag.startswith("needs ")):
            continue
        said = io.StringIO()
        with contextlib.redirect_stdout(said):
            run_as_shown(code, room)
        if "varies" not in tags:
            assert said.getvalue() == kept, f"the cell that begins with {code.splitlines()[0]!r}"
    if "plt" in room:
        room["plt"].close("all")


@pytest.mark.parametrize("book", BOOKS, ids=lambda book: book.stem)
def test_notebook_is_kept_whole(book: pathlib.Path) -> None:
    text = book.read_text()
    assert not re.search(r'"ename"|Traceback', text)
    assert any(output for cell in json.loads(text)["cells"] for output in cell.get("outputs", []))
    for picture in re.findall(r'"image/png": "([^"]+)', text):
        assert len(picture) * 3 / 4 < 150_000
