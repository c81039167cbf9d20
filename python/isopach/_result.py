"""What all results have."""

from __future__ import annotations

import base64
import html
import json
import os
import pathlib
import tempfile
from typing import Any, ClassVar

import numpy as np

from ._arrays import Cells, Fields
from ._check import path_of
from ._errors import Error, UsageError
from ._progress import listener
from ._record import Record
from ._run import plain_word
from ._scan import Scan, _guarded, _numbers, _read_only
from ._spell import spell, spell_lines


def _line(places: Any) -> str:
    """A line of places, (n, 2), as the command line says it."""
    array = _numbers(places, "its values", "profile")
    if array.ndim != 2 or array.shape[1] != 2 or len(array) < 2:
        raise UsageError(f"profile: an array of shape {array.shape}: needed are two places or more, (n, 2)")
    return ";".join(f"{float(x)!r},{float(y)!r}" for x, y in array)


def needed(module: str, extra: str) -> Any:
    """An optional package, or one line on how to get it."""
    import importlib
    try:
        return importlib.import_module(module)
    except ImportError:
        raise Error(f"{module} is not installed: pip install 'isopach[{extra}]'") from None


def _number(value: float | None, digits: int = 4) -> str:
    if value is None:
        return "not known"
    return f"{value:,.{digits}g}" if abs(value) < 1e4 or value != value else f"{value:,.0f}".replace(",", " ")


class Result(Record):
    """What all results have: attributes as the JSON's keys, arrays, and ways to show and keep them."""

    __slots__ = ("_arrays", "_cells", "_found", "_json", "_scans", "_text", "__weakref__")
    _arrays: dict[str, np.ndarray]
    _cells: dict[str, Any]
    _found: Any
    _json: str
    _scans: dict[str, Scan]
    _text: str
    _verb: ClassVar[str] = ""
    _rooms: ClassVar[tuple[str, ...]] = ()

    @classmethod
    def _of(cls, found: Any, scans: dict[str, Scan]) -> Any:
        return cls._made(found.json(), spell_lines(found.text()), found, found.arrays(), {}, scans)

    @classmethod
    def _made(cls, text: str, words: str, found: Any, arrays: Any, cells: Any, scans: Any) -> Any:
        result = cls(json.loads(text))
        for name, value in (("_json", text), ("_text", words), ("_found", found), ("_arrays", arrays),
                            ("_cells", cells), ("_scans", scans)):
            object.__setattr__(result, name, value)
        return result

    def __reduce__(self) -> tuple[Any, ...]:
        arrays = {name: np.array(array) for name, array in self._arrays.items()}
        cells = {}
        for which in ("", "after"):
            if (found := self._cells_of(which)) is not None:
                cells[which] = {key: np.array(value) if isinstance(value, np.ndarray) else value
                                for key, value in found._data.items()}
        return _restored, (type(self), self._json, self._text, arrays, cells)

    def _fields(self, room: str) -> Fields:
        start = room + "."
        return Fields(room, {name[len(start):]: _read_only(array) for name, array in self._arrays.items()
                             if name.startswith(start)})

    def _cells_of(self, which: str = "") -> Cells | None:
        if which not in self._cells:
            data = None if self._found is None else self._found.cells(which)
            self._cells[which] = data
        data = self._cells[which]
        return None if data is None else Cells(data)

    @property
    def unit(self) -> str:
        """Of lengths; areas and volumes are in its square and cube. "unknown" is never taken for metres."""
        unit = self._data.get("parameters", {}).get("unit") or self._data.get("unit")
        if not unit:
            inputs = self._data.get("inputs") or [self._data.get("input") or {}]
            unit = inputs[0].get("unit", "unknown")
        return str(unit)

    def _u(self, power: int = 1) -> str:
        if self.unit == "unknown":
            return "" if power == 1 else f" unit{'²³'[power - 2]}"
        return f" {self.unit}{['', '', '²', '³'][power]}"

    def to_json(self) -> str:
        """The text of result.json: that which the command line writes for the same scans and options."""
        return self._json

    def save(self, folder: str | os.PathLike[str], *, progress: Any = None, **options: Any) -> pathlib.Path:
        """Writes what the command line writes with --output: JSON, report, map, point clouds with their fields.

        `options` are those of the headings "Output" and "Layers" of ``isopach <verb> --help``: palette, range, extent
        (four numbers), title, author, logo, map_width, svg, report ("short"), pdf, report_vertices, no_map, no_cells,
        no_points, format, raster, contours, profile (a file, text, or an (n, 2) array), outlines, vectors, vtu, as far as
        the verb has them. All files appear together, or none. Returns
        the folder.
        """
        if self._found is None:
            raise UsageError(f"this {type(self).__name__} comes from a pickle, which holds numbers and arrays alone: call "
                             "save() and report() where it was made")
        known = {name.replace("-", "_"): name for name in self._found.output_options() if name not in ("output", "json")}
        words: list[bytes] = []
        for keyword, value in options.items():
            if keyword not in known:
                raise TypeError(f"save() got an unexpected keyword argument {keyword!r}: it takes {', '.join(known)}")
            if value is None or value is False:
                continue
            if keyword == "profile" and not isinstance(value, (str, os.PathLike)):
                value = _line(value)
            option = "--" + known[keyword]
            words.append(os.fsencode(option if value is True else f"{option}={plain_word(value, keyword)}"))
        with listener(progress) as told:
            _guarded(self._found.save, path_of(folder, "folder"), words, told)
        return pathlib.Path(os.fsdecode(folder))

    def report(self, path: str | os.PathLike[str], **options: Any) -> pathlib.Path:
        """Writes the report alone: one HTML file that opens from disk, without a network. `options` as of save."""
        with tempfile.TemporaryDirectory() as folder:
            skipped = {name: True for name in ("no_cells", "no_points") if self._found is not None
                       and name.replace("_", "-") in self._found.output_options()}
            self.save(folder, **{**skipped, **options})
            page = pathlib.Path(folder, "report.html")
            if not page.exists():
                raise UsageError(f"the verb {self._verb} has no report: use save()")
            target = pathlib.Path(path)
            beside = target.with_name(f".{target.name}.{os.getpid()}.part")
            beside.write_bytes(page.read_bytes())
            beside.replace(target)
        return target

    def show(self) -> Any:
        """The report within a notebook."""
        display = needed("IPython.display", "plot")
        with tempfile.TemporaryDirectory() as folder:
            text = self.report(pathlib.Path(folder, "report.html")).read_text()
        return display.HTML(f'<iframe srcdoc="{html.escape(text)}" width="100%" height="800"></iframe>')

    def _map(self, width: int = 900) -> bytes | None:
        """The map as PNG; None where there is none."""
        if self._found is None:
            return None
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder, "map.png")
            drawn = _guarded(self._found.draw, os.fsencode(path), width)
            return path.read_bytes() if drawn else None

    def _lines(self) -> list[str]:
        """What repr shows: four lines at most."""
        lines = [line.strip() for line in self._text.split("\n") if line.strip()][:3]
        return [f"{type(self).__name__}: {lines[0]}" if lines else type(self).__name__,
                *("  " + line for line in lines[1:]), f"  unit {self.unit}; {self._warned()}"]

    def __repr__(self) -> str:
        return "\n".join(self._lines())

    def __str__(self) -> str:
        return self._text

    def _repr_html_(self) -> str:
        rows = "".join(f"<tr><td style='text-align:left'>{html.escape(line.strip())}</td></tr>" for line in self._lines())
        picture = self._map()
        if picture is not None:
            rows += f"<tr><td><img src='data:image/png;base64,{base64.b64encode(picture).decode()}'/></td></tr>"
        return f"<table>{rows}</table>"

    def _warned(self) -> str:
        said = self._data.get("warnings") or []
        return f"{len(said)} warning{'s' if len(said) != 1 else ''}: {spell(said[0])[:90]}" if said else "no warnings"


def _restored(kind: Any, text: str, words: str, arrays: Any, cells: Any) -> Any:
    return kind._made(text, words, None, arrays, cells, {})
