"""Results of the verbs."""

from __future__ import annotations

import base64
import html
import json
import os
import pathlib
import tempfile
from collections.abc import Iterator, Mapping
from types import SimpleNamespace
from typing import Any, ClassVar

import numpy as np

from . import _core
from ._errors import Error, UsageError
from ._progress import listener
from ._record import Record
from ._run import plain_word
from ._scan import Scan, _guarded, _numbers, _read_only
from ._spell import spell, spell_lines


def needed(module: str, extra: str) -> Any:
    """An optional package, or one line on how to get it."""
    import importlib
    try:
        return importlib.import_module(module)
    except ImportError:
        raise Error(f"{module} is not installed: pip install 'isopach[{extra}]'") from None


class Fields:
    """Arrays by point of a scan, in the order of the input; attributes and items, read-only views.

    NaN where a point was dropped or the other surface is not known under it. The views keep the result alive.
    """

    __slots__ = ("_arrays", "_room")

    def __init__(self, room: str, arrays: Mapping[str, np.ndarray]) -> None:
        object.__setattr__(self, "_room", room)
        object.__setattr__(self, "_arrays", dict(arrays))

    def __getattr__(self, name: str) -> np.ndarray:
        if name.startswith("_"):
            raise AttributeError(name)
        arrays: dict[str, np.ndarray] = object.__getattribute__(self, "_arrays")
        if name not in arrays:
            raise AttributeError(f"{self._room} has no {name!r}: it has {', '.join(arrays) or 'nothing'}")
        return arrays[name]

    def __setattr__(self, name: str, value: Any) -> None:
        raise AttributeError(f"{self._room} cannot be changed")

    def __getitem__(self, name: str) -> np.ndarray:
        return self._arrays[name]

    def __contains__(self, name: str) -> bool:
        return name in self._arrays

    def __iter__(self) -> Iterator[str]:
        return iter(self._arrays)

    def __len__(self) -> int:
        return len(self._arrays)

    def keys(self) -> tuple[str, ...]:
        return tuple(self._arrays)

    def __dir__(self) -> list[str]:
        return sorted({*super().__dir__(), *self._arrays})

    def __repr__(self) -> str:
        return f"<{self._room}: {', '.join(f'{name} {array.shape}' for name, array in self._arrays.items())}>"


class Cells:
    """The measured cells as a mesh of triangles with both surfaces at its corners. Read-only arrays.

    Coordinates are those of the projection: for the direction z, the default, x and y are those of the input and z_a, z_b
    heights; for others u, v across and w along the direction, ``axes`` (3, 3) · input.
    """

    __slots__ = ("_data",)

    def __init__(self, data: Mapping[str, Any]) -> None:
        object.__setattr__(self, "_data", dict(data))

    def __setattr__(self, name: str, value: Any) -> None:
        raise AttributeError("Cells cannot be changed")

    @property
    def xy(self) -> np.ndarray:
        """(n, 2) float64."""
        return _read_only(self._local_xy + np.asarray(self._data["offset"])[:2])

    @property
    def z_a(self) -> np.ndarray:
        """(n,) float64: height of A."""
        return _read_only(np.asarray(self._data["z_a"]) + self._data["offset"][2])

    @property
    def z_b(self) -> np.ndarray:
        """(n,) float64: height of B."""
        return _read_only(np.asarray(self._data["z_b"]) + self._data["offset"][2])

    @property
    def dz(self) -> np.ndarray:
        """(n,) float64: B − A."""
        return _read_only(np.asarray(self._data["z_b"]) - np.asarray(self._data["z_a"]))

    @property
    def lod(self) -> np.ndarray | None:
        """(n,) float64: level of detection; None where there is none."""
        return None if self._data["lod"] is None else _read_only(self._data["lod"])

    @property
    def triangles(self) -> np.ndarray:
        """(m, 3) int32, counter-clockwise."""
        return _read_only(self._data["triangles"])

    @property
    def axes(self) -> np.ndarray:
        """(3, 3): rows u, v, w in the coordinates of the input."""
        return _read_only(np.asarray(self._data["axes"]).reshape(3, 3))

    def points(self, surface: str = "b") -> np.ndarray:
        """(n, 3) corners on the surface "a" or "b", in the coordinates of the input."""
        if surface not in ("a", "b"):
            raise UsageError(f"surface: {surface!r} is not 'a' or 'b'")
        z = self.z_a if surface == "a" else self.z_b
        along = np.column_stack([self.xy, z])
        return along if np.array_equal(self.axes, np.eye(3)) else along @ self.axes

    @property
    def _local_xy(self) -> np.ndarray:
        return np.asarray(self._data["xy"])

    @property
    def _mesh(self) -> tuple[Any, Any, Any, Any]:
        return self._data["xy"], self._data["z_a"], self._data["z_b"], self._data["triangles"]

    def __len__(self) -> int:
        return int(self._data["triangles"].shape[0])

    def __repr__(self) -> str:
        return f"<Cells: {len(self):,} triangles, {len(self._data['z_a']):,} corners>"


class Profile(SimpleNamespace):
    """A section: ``s`` (way along the line), ``x``, ``y``, ``z_a``, ``z_b``, ``dz``, one value a corner.

    Between two corners everything is linear. NaN in the heights where the line leaves the cells.
    """

    def plot(self, ax: Any = None) -> Any:
        """Both surfaces over the way; returns matplotlib's axes."""
        if ax is None:
            ax = needed("matplotlib.pyplot", "plot").subplots()[1]
        ax.plot(self.s, self.z_a, label="A", color="0.4")
        ax.plot(self.s, self.z_b, label="B", color="tab:red")
        ax.set_xlabel("way along the line" + self._of(self.unit))
        ax.set_ylabel("height" + self._of(self.unit))
        ax.legend()
        return ax

    @staticmethod
    def _of(unit: str) -> str:
        return "" if unit == "unknown" else f" ({unit})"


def _number(value: float | None, digits: int = 4) -> str:
    if value is None:
        return "not known"
    return f"{value:,.{digits}g}" if abs(value) < 1e4 or value != value else f"{value:,.0f}".replace(",", " ")


class Result(Record):
    """What all results have: attributes as the JSON's keys, arrays, and ways to show and keep them."""

    __slots__ = ("_arrays", "_cells", "_found", "_json", "_scans", "_text", "__weakref__")
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

        `options` are those of the heading "Output" of ``isopach <verb> --help``: palette, title, map_width, no_map,
        no_cells, no_points, format, as far as the verb has them. All files appear together, or none. Returns the
        folder.
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
            option = "--" + known[keyword]
            words.append(os.fsencode(option if value is True else f"{option}={plain_word(value, keyword)}"))
        with listener(progress) as told:
            _guarded(self._found.save, os.fsencode(folder), words, told)
        return pathlib.Path(folder)

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


class _WithCells(Result):
    """Results over an area: where it differs, and by how much."""

    __slots__ = ()

    @property
    def cells(self) -> Cells:
        """The measured cells, a copy that is made when it is first asked for."""
        found = self._cells_of()
        assert found is not None
        return found

    def at(self, xy: Any) -> Any:
        """B − A at places, (n, 2) or one (x, y); NaN where it was not measured."""
        places = _numbers(xy, "its values", "xy")
        single = places.ndim == 1
        if places.ndim not in (1, 2) or places.shape[-1] != 2:
            raise UsageError(f"xy: an array of shape {places.shape}: needed is (n, 2), or one place (x, y)")
        z_a, z_b = self._heights(places.reshape(-1, 2))
        return float(z_b[0] - z_a[0]) if single else z_b - z_a

    def _heights(self, places: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        cells = self.cells
        offset = np.asarray(cells._data["offset"])
        z_a, z_b = _guarded(_core.values_at, *cells._mesh, np.ascontiguousarray(places - offset[:2]))
        return np.asarray(z_a) + offset[2], np.asarray(z_b) + offset[2]

    def profile(self, line: Any, step: float | None = None) -> Profile:
        """The section along a line of places, (n, 2): where it crosses cells, exactly; with `step` also every so far."""
        chain = _numbers(line, "its values", "line")
        if chain.ndim != 2 or chain.shape[1] != 2 or len(chain) < 2:
            raise UsageError(f"line: an array of shape {chain.shape}: needed are two places or more, (n, 2)")
        if not np.isfinite(chain).all():
            raise UsageError("line: a coordinate that is no finite number")
        cells = self.cells
        offset = np.asarray(cells._data["offset"])
        s, x, y, z_a, z_b = (np.array(part) for part in
                             _guarded(_core.section, *cells._mesh, np.ascontiguousarray(chain - offset[:2])))
        x, y, z_a, z_b = x + offset[0], y + offset[1], z_a + offset[2], z_b + offset[2]
        if step is not None:
            s, x, y, z_a, z_b = self._sampled(chain, step, s, x, y, z_a, z_b)
        return Profile(s=s, x=x, y=y, z_a=z_a, z_b=z_b, dz=z_b - z_a, unit=self.unit)

    def _sampled(self, chain: np.ndarray, step: float, *corners: np.ndarray) -> Any:
        if not step > 0:
            raise UsageError(f"step: {step} is not a number above 0")
        ways = np.concatenate([[0], np.cumsum(np.hypot(*np.diff(chain, axis=0).T))])
        s = np.arange(0, ways[-1], step)
        x, y = np.interp(s, ways, chain[:, 0]), np.interp(s, ways, chain[:, 1])
        z_a, z_b = self._heights(np.column_stack([x, y]))
        inside = np.isfinite(z_a)
        added = [part[inside] for part in (s, x, y, z_a, z_b)]
        order = np.argsort(np.concatenate([corners[0], added[0]]), kind="stable")
        return [np.concatenate([old, new])[order] for old, new in zip(corners, added, strict=True)]

    def to_xarray(self, resolution: float, average: bool = True, bounds: tuple[float, float, float, float] | None = None
                  ) -> Any:
        """A raster as an xarray.Dataset: dz, z_a, z_b, covered, and lod where it is known.

        A pixel of ``dz`` is the integral of B − A over it, divided by the area of the pixel, in closed form: whatever
        the resolution, ``ds.dz.sum() * resolution**2`` is the net volume, to rounding. ``covered`` is the share of the
        pixel that was measured, so that ``dz / covered`` is the mean over that. ``z_a``, ``z_b`` and ``lod`` are means
        over the measured part; NaN where there is none. Without `average`, all are values at the middle of the pixel.

        Sides of pixels lie at multiples of `resolution`. `bounds`: (xmin, ymin, xmax, ymax), widened to whole pixels;
        by default all that was measured.
        """
        xarray = needed("xarray", "xarray")
        x, y, layers = self._raster(resolution, average, bounds)
        names = {"dz": "B - A", "z_a": "height of A", "z_b": "height of B", "covered": "measured share of the pixel",
                 "lod": "level of detection"}
        data = {name: (("y", "x"), values, {"long_name": names[name], "units": "1" if name == "covered" else self.unit})
                for name, values in layers.items()}
        crs = (self._data.get("inputs") or [{}])[0].get("crs")
        return xarray.Dataset(data, {"x": x, "y": y}, {"resolution": resolution, "unit": self.unit, "crs": crs or ""})

    def _raster(self, resolution: float, average: bool, bounds: Any) -> tuple[np.ndarray, np.ndarray, dict[str, np.ndarray]]:
        step = float(resolution)
        if not (step > 0 and np.isfinite(step)):
            raise UsageError(f"resolution: {resolution} is not a number above 0")
        cells = self.cells
        offset = np.asarray(cells._data["offset"])
        xy = cells._local_xy[np.unique(cells.triangles)] + offset[:2] if len(cells) else np.zeros((1, 2))
        low, high = (xy.min(axis=0), xy.max(axis=0)) if bounds is None else (np.array(bounds[:2], float),
                                                                             np.array(bounds[2:], float))
        first, last = np.floor(low / step), np.maximum(np.ceil(high / step), np.floor(low / step) + 1)
        columns, rows = (int(v) for v in last - first)
        if columns * rows > 2**31:
            raise UsageError(f"resolution: {columns} x {rows} pixels are too many: choose a coarser one")
        corner = first * step
        x = corner[0] + (np.arange(columns) + 0.5) * step
        y = corner[1] + (np.arange(rows) + 0.5) * step
        layers = (self._averages if average else self._samples)(cells, offset, corner, step, x, y)
        return x, y[::-1], {name: values.reshape(rows, columns)[::-1] for name, values in layers.items()}

    def _averages(self, cells: Cells, offset: Any, corner: Any, step: float, x: Any, y: Any) -> dict[str, np.ndarray]:
        grid = (corner[0] - offset[0], corner[1] - offset[1], step, len(x), len(y))
        area, z_a, z_b, d = (np.asarray(part) for part in _guarded(_core.pixels, *cells._mesh, *grid))
        known = area > 0
        layers = {"dz": np.where(known, d / step**2, np.nan)}
        with np.errstate(invalid="ignore", divide="ignore"):
            layers["z_a"] = np.where(known, z_a / area + offset[2], np.nan)
            layers["z_b"] = np.where(known, z_b / area + offset[2], np.nan)
            layers["covered"] = area / step**2
            if cells.lod is not None:
                xy, _, _, triangles = cells._mesh
                levels = np.where(np.isfinite(cells.lod), cells.lod, 0)
                _, lod, _, _ = _guarded(_core.pixels, xy, levels, levels, triangles, *grid)
                layers["lod"] = np.where(known, np.asarray(lod) / area, np.nan)
        return layers

    def _samples(self, cells: Cells, offset: Any, corner: Any, step: float, x: Any, y: Any) -> dict[str, np.ndarray]:
        places = np.column_stack([part.ravel() for part in np.meshgrid(x, y)])
        z_a, z_b = self._heights(places)
        return {"dz": z_b - z_a, "z_a": z_a, "z_b": z_b, "covered": np.isfinite(z_a).astype(float)}

    def to_geotiff(self, path: str | os.PathLike[str], resolution: float, average: bool = True, cog: bool = True) -> None:
        """The raster of `to_xarray` as a GeoTIFF with bands dz, covered, z_a, z_b; needs rasterio."""
        rasterio = needed("rasterio", "geo")
        x, y, layers = self._raster(resolution, average, None)
        crs = (self._data.get("inputs") or [{}])[0].get("crs")
        bands = [name for name in ("dz", "covered", "z_a", "z_b", "lod") if name in layers]
        transform = rasterio.transform.from_origin(x[0] - resolution / 2, y[0] + resolution / 2, resolution, resolution)
        with rasterio.open(path, "w", driver="COG" if cog else "GTiff", width=len(x), height=len(y), count=len(bands),
                           dtype="float64", crs=crs, transform=transform, nodata=float("nan"), compress="deflate") as out:
            for number, name in enumerate(bands, 1):
                out.write(layers[name], number)
                out.set_band_description(number, name)

    def to_geopandas(self, what: str = "cells") -> Any:
        """A GeoDataFrame: "cells", a triangle each with its mean dz, z_a, z_b and area; needs geopandas."""
        if what != "cells":
            raise UsageError(f"what: {what!r} is not 'cells'")
        geopandas = needed("geopandas", "geo")
        shapely = needed("shapely", "geo")
        cells = self.cells
        corners = cells.xy[cells.triangles]
        rings = np.concatenate([corners, corners[:, :1]], axis=1)
        shapes = shapely.polygons(rings)
        mean = {name: getattr(cells, name)[cells.triangles].mean(axis=1) for name in ("dz", "z_a", "z_b")}
        crs = (self._data.get("inputs") or [{}])[0].get("crs")
        return geopandas.GeoDataFrame({**mean, "area": shapely.area(shapes)}, geometry=shapes, crs=crs)

    def to_pyvista(self, surface: str = "b") -> Any:
        """The cells on surface "a" or "b" as a pyvista.PolyData with dz, z_a, z_b at its points.

        Its points are float32: they are relative to ``field_data["origin"]``.
        """
        pyvista = needed("pyvista", "pyvista")
        cells = self.cells
        points = cells.points(surface)
        origin = np.round(points.mean(axis=0))
        faces = np.column_stack([np.full(len(cells), 3), cells.triangles]).ravel()
        mesh = pyvista.PolyData((points - origin).astype(np.float32), faces)
        for name in ("dz", "z_a", "z_b"):
            mesh.point_data[name] = getattr(cells, name)
        mesh.field_data["origin"] = origin
        return mesh

    def plot(self, ax: Any = None, palette: str = "RdBu_r", limit: float | None = None) -> Any:
        """The map of B − A by matplotlib: colours centred on 0, up to `limit` (default: 99 % of the area)."""
        pyplot = needed("matplotlib.pyplot", "plot")
        if ax is None:
            ax = pyplot.subplots()[1]
        cells = self.cells
        most = limit or self._data["difference"].get("abs_percentiles", {}).get("99") or np.abs(cells.dz).max() or 1.0
        origin = np.round(cells.xy.mean(axis=0))
        x, y = (cells.xy - origin).T
        picture = ax.tripcolor(x, y, cells.triangles, cells.dz, shading="gouraud", cmap=palette, vmin=-most, vmax=most)
        ax.set_aspect("equal")
        unit = "" if self.unit == "unknown" else f" ({self.unit})"
        ax.set_xlabel(f"x − {origin[0]:.0f}{unit}")
        ax.set_ylabel(f"y − {origin[1]:.0f}{unit}")
        ax.figure.colorbar(picture, ax=ax, label="B − A" + unit, extend="both")
        return ax

    def hist(self, ax: Any = None) -> Any:
        """The areas by B − A, by matplotlib, from the JSON's histogram."""
        pyplot = needed("matplotlib.pyplot", "plot")
        if ax is None:
            ax = pyplot.subplots()[1]
        histogram = self._data["difference"]["histogram"]
        ax.stairs(histogram["areas"], histogram["edges"], fill=True, color="0.5")
        unit = "" if self.unit == "unknown" else f" ({self.unit})"
        ax.set_xlabel("B − A" + unit)
        ax.set_ylabel("area" + ("" if self.unit == "unknown" else f" ({self.unit}²)"))
        return ax


class Comparison(_WithCells):
    """How much, and where, B differs from A: d = B − A, positive where B lies above."""

    __slots__ = ()
    _verb = "compare"

    @property
    def points_a(self) -> Fields:
        """By point of A: ``dz_signed`` (the other surface − own height), and with sigmas ``lod``."""
        return self._fields("points_a")

    @property
    def points_b(self) -> Fields:
        """By point of B: ``dz_signed`` (own height − the other surface), and with sigmas ``lod``."""
        return self._fields("points_b")

    def _lines(self) -> list[str]:
        volume, domain, d = self._data["volume"], self._data["domain"], self._data["difference"]
        interval = (self._data.get("uncertainty") or {}).get("interval_net")
        net = f"{volume['net']:+,.6g}".replace(",", " ")
        if interval:
            net += f" ± {_number((interval[1] - interval[0]) / 2)}"
        return [f"Comparison: net {net}{self._u(3)}, gained {_number(volume['above'])}, lost "
                f"{_number(volume['below'])}{self._u(3)}",
                f"  over {_number(domain['area'])}{self._u(2)}, {100 * domain['coverage']:.1f} % of what either scan covers",
                f"  rho {_number(self._data['measure']['rho'])}, rms {_number(d['rms'])}, nmad {_number(d['nmad'])}, "
                f"95 % of the area below {_number(d['abs_percentiles']['95'])}{self._u()}",
                f"  unit {self.unit}; {self._warned()}"]


class Matching(Result):
    """The pose of one scan on another. ``apply`` moves points; `compare` takes it as ``pose``."""

    __slots__ = ()
    _verb = "match"

    @property
    def matrix(self) -> np.ndarray:
        """(4, 4) float64: takes coordinates of the moving scan to those of the fixed one."""
        return _read_only(np.array(self._data["pose"]["matrix"], dtype=np.float64))

    @property
    def points_moving(self) -> Fields:
        """By point of the moving scan: ``stable`` (1: took part), ``agreement`` (0 not in view, 1 agrees, 2 in front,
        3 behind)."""
        return self._fields("points_moving")

    def apply(self, points: Any) -> np.ndarray:
        """(n, 3) points moved by the pose."""
        array = _numbers(points, "its values", "points")
        if array.shape[-1:] != (3,):
            raise UsageError(f"points: an array of shape {array.shape}: needed is (n, 3)")
        m = self.matrix
        return array @ m[:3, :3].T + m[:3, 3]

    def _lines(self) -> list[str]:
        m = self.matrix
        scale = np.cbrt(np.linalg.det(m[:3, :3]))
        turn = np.degrees(np.arccos(np.clip((np.trace(m[:3, :3]) / scale - 1) / 2, -1, 1)))
        centre = np.array(self._data["centre"] or [0, 0, 0], dtype=np.float64)
        shift = np.linalg.norm(m[:3, :3] @ centre + m[:3, 3] - centre)
        before, after = self._data["before"], self._data["after"]
        state = "converged" if self._data["converged"] else "not converged"
        verdict = self._data.get("verdict") or {}
        rho = ""
        if before and after and before.get("rho") is not None and after.get("rho") is not None:
            rho = f", rho {_number(before['rho'])} → {_number(after['rho'])}{self._u()}"
        lines = [f"Matching: moved by {_number(float(shift))}{self._u()}, turned by {_number(float(turn))}°{rho}",
                 f"  {state} ({self._data['iterations']} steps, objective {self._data['objective']})"]
        if verdict.get("grade"):
            lines.append(f"  verdict: {verdict['grade']}")
        return [*lines, f"  unit {self.unit}; {self._warned()}"]


class Distances(Result):
    """Distances in space between two scans, both ways."""

    __slots__ = ()
    _verb = "distance"

    @property
    def points_a(self) -> Fields:
        """By point of A: ``c2c``, ``c2s``, ``normal``, ``vertical``, as far as measured."""
        return self._fields("points_a")

    @property
    def points_b(self) -> Fields:
        """By point of B, as points_a."""
        return self._fields("points_b")

    @property
    def core_points(self) -> Fields:
        """Of M3C2, by core point: ``xyz``, ``distance``, ``lod``, ``significant``, ``sigma1``, ``sigma2``, ``n1``,
        ``n2``, ``normal``."""
        return self._fields("core_points")


class Accuracy(_WithCells):
    """How well a reconstruction (B) agrees with a reference (A)."""

    __slots__ = ()
    _verb = "accuracy"

    @property
    def points_reference(self) -> Fields:
        return self._fields("points_reference")

    @property
    def points_reconstruction(self) -> Fields:
        return self._fields("points_reconstruction")


class Scanners(_WithCells):
    """Two scanners on one object, A and B, both where the reference put them."""

    __slots__ = ()
    _verb = "scanners"

    @property
    def points_a(self) -> Fields:
        return self._fields("points_a")

    @property
    def points_b(self) -> Fields:
        return self._fields("points_b")


class Asymmetry(_WithCells):
    """How the two sides of a face differ. Cells are in coordinates of the face: x from the plane of symmetry."""

    __slots__ = ()
    _verb = "asymmetry"

    @property
    def points(self) -> Fields:
        """By point of the face: ``asymmetry``, its height above the mirrored other side."""
        return self._fields("points")


class Roughness(Result):
    """How rough a surface is once its form and its waviness are removed."""

    __slots__ = ()
    _verb = "roughness"

    @property
    def points(self) -> Fields:
        """By point: ``waviness``, ``roughness``, ``valley``, ``wrinkle``."""
        return self._fields("points")

    @property
    def points_after(self) -> Fields:
        """The same of the scan after, where there is one."""
        return self._fields("points_after")

    @property
    def cells(self) -> Cells:
        """z_a: what was removed with the roughness in it, dz: the roughness at the corners."""
        found = self._cells_of()
        assert found is not None
        return found


class Sequence(Result):
    """What of a sequence of scans stays and what moves."""

    __slots__ = ()
    _verb = "sequence"

    @property
    def points(self) -> Fields:
        """Of the reference frame: ``xyz``, ``id`` (of the input), ``blend`` (0 stays, 1 moves), ``part`` (0, 1, 2)."""
        return self._fields("points")


class Combination(Result):
    """Two scans in one model, by a reference object that both saw."""

    __slots__ = ()
    _verb = "combine"

    @property
    def matrix(self) -> np.ndarray:
        """(4, 4): takes coordinates of the jaw to those of the face."""
        return _read_only(np.array(self._data["pose"]["matrix"], dtype=np.float64))

    @property
    def points(self) -> Fields:
        """The model, in coordinates of the face: ``xyz``, ``part`` (0 face, 1 jaw, 2 and 3 the object in them)."""
        return self._fields("points")


class Info(Result):
    """What files hold: ``files``, a Record each."""

    __slots__ = ()
    _verb = "info"

    def _lines(self) -> list[str]:
        return [f"Info of {len(self._data['files'])} file{'s' if len(self._data['files']) != 1 else ''}",
                *(f"  {file['path']}: {file['points']:,} points, {file['format'] or 'array'}, unit {file['unit']}"
                  for file in self._data["files"][:3])]


class Scene(Result):
    """A simulated scene: its scans, as attributes and by name in ``scans``, and what is true of them."""

    __slots__ = ()
    _verb = "simulate"

    @classmethod
    def _of(cls, found: Any, scans: dict[str, Scan]) -> Any:
        made = {name: Scan(core) for name, core in found.scans()}
        return cls._made(found.json(), "", None, {}, {}, made)

    @property
    def scans(self) -> dict[str, Scan]:
        """By name: "a" and "b"; "face", "jaw" and "reference"; "frame_000", …"""
        return dict(self._scans)

    def __getattr__(self, name: str) -> Any:
        if not name.startswith("_") and name in (found := object.__getattribute__(self, "_scans")):
            return found[name]
        return super().__getattr__(name)

    def save(self, folder: str | os.PathLike[str], *, progress: Any = None, **options: Any) -> pathlib.Path:
        """Writes the scans as PLY files and truth.json."""
        if options:
            raise TypeError(f"save() got an unexpected keyword argument {next(iter(options))!r}")
        target = pathlib.Path(folder)
        target.mkdir(parents=True, exist_ok=True)
        for name, scan in self._scans.items():
            scan.write(target / f"{name}.ply")
        (target / "truth.json").write_text(self._json)
        return target

    def __reduce__(self) -> tuple[Any, ...]:
        return _scene_restored, (self._json, self._scans)

    def _lines(self) -> list[str]:
        return [f"Scene {self._data['scene']}: {self._data.get('description', '')}"[:200],
                "  " + ", ".join(f"{name} {len(scan):,} points" for name, scan in list(self._scans.items())[:4]),
                f"  unit {self._data.get('unit', 'unknown')}"]


def _scene_restored(text: str, scans: Any) -> Any:
    return Scene._made(text, "", None, {}, {}, scans)
