"""Results over an area: places, sections, rasters, meshes and plots."""

from __future__ import annotations

import os
from types import SimpleNamespace
from typing import Any

import numpy as np

from . import _core
from ._arrays import Cells
from ._check import above_zero, box_of, shown
from ._errors import UsageError
from ._result import Result, needed
from ._scan import _guarded, _numbers


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


class WithCells(Result):
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
        step = above_zero(step, "step")
        ways = np.concatenate([[0], np.cumsum(np.hypot(*np.diff(chain, axis=0).T))])
        if ways[-1] / step > 2**31:
            raise UsageError(f"step: {step} makes too many places: choose a larger one")
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
        step = above_zero(resolution, "resolution")
        cells = self.cells
        offset = np.asarray(cells._data["offset"])
        xy = cells._local_xy[np.unique(cells.triangles)] + offset[:2] if len(cells) else np.zeros((1, 2))
        box = np.concatenate([xy.min(axis=0), xy.max(axis=0)]) if bounds is None else box_of(bounds, "bounds")
        low, high = box[:2], box[2:]
        first, last = np.floor(low / step), np.maximum(np.ceil(high / step), np.floor(low / step) + 1)
        if not (last - first).prod() <= 2**31 or not (last - first).max() <= 2**31:
            raise UsageError("resolution: {:.4g} x {:.4g} pixels are too many: choose a coarser one".format(*(last - first)))
        columns, rows = (int(v) for v in last - first)
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
            raise UsageError(f"what: {shown(what)} is not 'cells'")
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
