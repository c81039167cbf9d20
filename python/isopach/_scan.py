"""Scans: of files, of arrays, and of what other libraries hold. None of these is imported unless it was passed."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from . import _core
from ._check import box_of, path_of, shown, text_of
from ._errors import InputError, UsageError, error_of
from ._progress import listener


class _Attributes(Mapping[str, np.ndarray]):
    """Values by point, by name; read-only views."""

    def __init__(self, core: Any) -> None:
        self._core = core
        self._names = tuple(core.attributes)

    def __getitem__(self, name: str) -> np.ndarray:
        if name not in self._names:
            raise KeyError(name)
        return _read_only(self._core.attribute(name))

    def __iter__(self) -> Iterator[str]:
        return iter(self._names)

    def __len__(self) -> int:
        return len(self._names)

    def __repr__(self) -> str:
        return f"<attributes: {', '.join(self._names) or 'none'}>"


class Scan:
    """Points of a scan with what is known of them. Immutable; made by `read` and `scan`.

    Arrays are read-only views: of the memory of the scan, or of the array that was passed, which must not change as
    long as the scan is used.
    """

    __slots__ = ("_core", "_epoch")
    _core: Any
    _epoch: float | None

    def __init__(self, core: Any, epoch: float | None = None) -> None:
        object.__setattr__(self, "_core", core)
        object.__setattr__(self, "_epoch", epoch)

    def __setattr__(self, name: str, value: Any) -> None:
        raise AttributeError(f"a Scan cannot be changed: make another one, isopach.scan(..., {name}=...)")

    @property
    def points(self) -> np.ndarray:
        """(n, 3) float64: x, y, z, in the coordinates of the input; NaN where the input has them."""
        return _read_only(self._core.points)

    @property
    def attributes(self) -> Mapping[str, np.ndarray]:
        """Values by point, (n,) float64 each, by name in lower case: "classification", "intensity", …"""
        return _Attributes(self._core)

    @property
    def faces(self) -> np.ndarray | None:
        """(m, 3) int32 triangles, three indices of points each; None without."""
        faces = self._core.faces
        return None if faces is None else _read_only(faces)

    @property
    def unit(self) -> str:
        """Of x and y: "m", "mm", "ft", …, or "unknown", which is never taken for metres."""
        return str(self._core.unit)

    @property
    def vertical_unit(self) -> str:
        """Of z."""
        return str(self._core.vertical_unit)

    @property
    def crs(self) -> str | None:
        """Well-known text or "EPSG:n"; None if there is none."""
        return self._core.crs or None

    @property
    def epoch(self) -> float | None:
        """The year that the coordinates are of, as it was passed."""
        return self._epoch

    @property
    def path(self) -> Path | None:
        """Where it was read from; None if it was made in memory."""
        return Path(self._core.path) if self._core.format else None

    @property
    def name(self) -> str:
        """What messages and results call it; empty: by the argument that it is passed as."""
        return str(self._core.path)

    @property
    def notes(self) -> tuple[str, ...]:
        """Remarks of the reader, a line each."""
        return tuple(self._core.notes)

    def write(self, path: str | os.PathLike[str]) -> None:
        """Writes the scan in the format of the ending: .ply .xyz .csv .las .laz .obj .stl .pcd .npy."""
        _guarded(self._core.write, path_of(path, "path"))

    def __len__(self) -> int:
        return int(self._core.points.shape[0])

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> np.ndarray:
        points = self.points
        return np.array(points, dtype=dtype) if copy or (dtype is not None and dtype != points.dtype) else points

    def __isopach_scan__(self) -> Scan:
        return self

    def __repr__(self) -> str:
        return f"Scan of {len(self):,} points{f', {len(self.faces):,} faces' if self.faces is not None else ''}" \
               f"{', ' + self.name if self.name else ''}\n  {_box(self.points)}\n  unit {self.unit}" \
               f"{'' if self.vertical_unit == self.unit else f', heights {self.vertical_unit}'}, CRS {_short(self.crs)}" \
               f"\n  attributes: {', '.join(self.attributes) or 'none'}"

    def __reduce__(self) -> tuple[Any, ...]:
        values = {name: np.array(array) for name, array in self.attributes.items()}
        faces = None if self.faces is None else np.array(self.faces)
        return _restored, (np.array(self.points), values, faces, self.unit, self.vertical_unit, self.crs, self.epoch,
                           self.name)


def _restored(points: Any, attributes: Any, faces: Any, unit: str, vertical_unit: str, crs: str | None,
              epoch: float | None, name: str) -> Scan:
    return scan(points, attributes=attributes, faces=faces, unit=unit, vertical_unit=vertical_unit, crs=crs,
                epoch=epoch, name=name)


def _box(points: np.ndarray) -> str:
    finite = points[np.isfinite(points).all(axis=1)]
    if not len(finite):
        return "no finite point"
    low, high = finite.min(axis=0), finite.max(axis=0)
    return ", ".join(f"{axis} {a:.10g} to {b:.10g}" for axis, a, b in zip("xyz", low, high, strict=True))


def _short(crs: str | None) -> str:
    return "none" if not crs else crs.split('"')[1] if '"' in crs else crs


def _read_only(array: Any) -> np.ndarray:
    view = np.asarray(array).view()
    view.flags.writeable = False
    return view


def _guarded(function: Any, *words: Any) -> Any:
    """The core's failures as errors of this package."""
    from ._spell import spell
    try:
        return function(*words)
    except _core.Failure as failure:
        code, message = failure.args
    raise error_of(code, spell(message)) from None


def read(path: str | os.PathLike[str], *, classes: Any = None, crop: Any = None, unit: str | None = None,
         threads: int | None = None, progress: Any = None) -> Scan:
    """Reads a file: points, all attributes, faces, unit and CRS as far as it has them.

    XYZ, CSV, PTS, PTX, PLY, LAS, LAZ, COPC, OBJ, STL, PCD, and, where GDAL is installed, rasters. Raises `InputError`.
    `classes`: only points of these LAS classes, 2 or [2, 8]. `crop`: only points within (xmin, ymin, xmax, ymax).
    `unit`: where the file does not say it or says it wrongly. What is selected from is a copy, without faces.

    >>> import isopach, tempfile, pathlib
    >>> file = pathlib.Path(tempfile.mkdtemp(), "three.xyz")
    >>> _ = file.write_text("0 0 1\\n1 0 2\\n0 1 3\\n")
    >>> isopach.read(file).points[2].tolist()
    [0.0, 1.0, 3.0]
    """
    _units(unit, None)
    with listener(progress) as told:
        whole = Scan(_guarded(_core.read, path_of(path, "path"), _threads(threads), told))
    if classes is None and crop is None:
        return whole if unit is None else _selected(whole, slice(None), unit, whole.faces)
    kept = np.ones(len(whole), dtype=bool)
    if classes is not None:
        if "classification" not in whole.attributes:
            raise InputError(f"{os.fsdecode(path)}: classes are asked for, and its points have none")
        kept &= np.isin(whole.attributes["classification"], _numbers(np.atleast_1d(classes), "they", "classes"))
    if crop is not None:
        box = box_of(crop, "crop")
        kept &= ((whole.points[:, :2] >= box[:2]) & (whole.points[:, :2] <= box[2:])).all(axis=1)
    if not kept.any():
        raise InputError(f"{os.fsdecode(path)}: no point is left by {'crop' if classes is None else 'classes'}")
    return _selected(whole, kept, unit, None)


def _selected(whole: Scan, kept: Any, unit: str | None, faces: Any) -> Scan:
    return _scan_of(whole.points[kept], attributes={name: values[kept] for name, values in whole.attributes.items()},
                    faces=faces, unit=unit or whole.unit, vertical_unit=unit or whole.vertical_unit, crs=whole.crs,
                    name=whole.name, argument="path")


def scan(points: Any, *, attributes: Mapping[str, Any] | None = None, faces: Any = None, unit: str | None = None,
         vertical_unit: str | None = None, crs: str | None = None, epoch: float | None = None,
         name: str | None = None) -> Scan:
    """A scan of an (n, 3) array of x, y, z: any order, type and stride.

    float64 is used where it lies, whatever its strides, and must not change while the scan is used; other types are
    copied once. `attributes`: (n,) values by name, such as "classification". `faces`: (m, 3) indices of points.
    `unit` of x and y, `vertical_unit` of z (default: as `unit`): m, mm, cm, um, km, ft, us-ft, in. `crs`: well-known
    text or "EPSG:n". `name`: what messages and results call it.

    >>> import numpy as np
    >>> isopach.scan(np.zeros((4, 3), dtype=np.float32), unit="mm").unit
    'mm'
    """
    return _scan_of(points, attributes=attributes, faces=faces, unit=unit, vertical_unit=vertical_unit, crs=crs,
                    epoch=epoch, name="" if name is None else name, argument="points")


def _threads(threads: Any) -> int:
    name, wanted = "threads", threads
    if threads is None:
        name, wanted = "ISOPACH_THREADS", os.environ.get("ISOPACH_THREADS", "0")
    whole = wanted.isdecimal() if isinstance(wanted, str) and threads is None else (
        isinstance(wanted, (int, float, np.integer, np.floating)) and not isinstance(wanted, bool) and wanted == wanted // 1)
    if not whole or not 0 <= int(wanted) <= 4096:
        raise UsageError(f"{name}: {shown(wanted)} is not a whole number from 0 to 4096")
    return int(wanted)


def _numbers(values: Any, what: str, argument: str) -> np.ndarray:
    """As float64 that the core can use where it lies; copied once where it is anything else."""
    if isinstance(values, np.ma.MaskedArray) and values.dtype.kind in "fiub":
        values = np.ma.filled(values.astype(np.float64), np.nan)
    try:
        array = np.asarray(values)
    except Exception as cause:
        raise UsageError(f"{argument}: cannot be read as an array: {cause}".replace("\n", " ")) from None
    if array.dtype == object:
        try:
            array = array.astype(np.float64)
        except (TypeError, ValueError):
            raise UsageError(f"{argument}: {what} are no numbers") from None
    if array.dtype.kind not in "fiu" and array.dtype.kind != "b":
        raise UsageError(f"{argument}: {what} are of type {array.dtype}, not numbers")
    if array.dtype != np.float64 or not array.dtype.isnative or any(step % 8 for step in array.strides) \
            or not array.flags.aligned:
        array = array.astype(np.float64, order="C")
    return array


def _columns(array: np.ndarray) -> np.ndarray | None:
    """A structured array with fields x, y, z."""
    names = {name.lower(): name for name in array.dtype.names or ()}
    if not {"x", "y", "z"} <= names.keys():
        return None
    return np.stack([array[names[axis]].astype(np.float64) for axis in "xyz"], axis=-1)


def _scan_of(points: Any, *, attributes: Mapping[str, Any] | None = None, faces: Any = None, unit: str | None = None,
             vertical_unit: str | None = None, crs: str | None = None, epoch: float | None = None, name: str = "",
             argument: str) -> Scan:
    if isinstance(points, np.ndarray) and points.dtype.names is not None:
        points = _columns(points)
        if points is None:
            raise UsageError(f"{argument}: a structured array needs the fields x, y and z")
    array = _numbers(points, "its values", argument)
    if array.ndim != 2 or array.shape[1] != 3:
        raise UsageError(f"{argument}: an array of shape {array.shape}: a scan is (n, 3), a row x, y, z for each point")
    if not len(array):
        raise InputError(f"{argument}: no points")
    values = []
    if attributes is not None and not isinstance(attributes, Mapping):
        raise UsageError(f"attributes: {shown(attributes)} is no mapping of names to arrays")
    for title, given in (attributes or {}).items():
        of_points = _numbers(given, "its values", f"attributes[{title!r}]")
        if of_points.shape != (len(array),):
            raise UsageError(f"attributes: {title!r} has the shape {of_points.shape}, for {len(array)} points")
        values.append((text_of(str(title), "attributes"), of_points))
    return Scan(_core.scan(array, array, values, _faces(faces, len(array)), *_units(unit, vertical_unit),
                           text_of(crs, "crs"), path_of(name, "name")), epoch)


def _units(unit: str | None, vertical_unit: str | None) -> tuple[str, str]:
    known = ("m", "mm", "cm", "um", "km", "ft", "us-ft", "in", "deg", "unknown")
    for keyword, word in (("unit", unit), ("vertical_unit", vertical_unit)):
        if word is not None and (not isinstance(word, str) or word not in known):
            raise UsageError(f"{keyword}: {shown(word)} is not one of {', '.join(known[:-2])}")
    across = unit or "unknown"
    return across, vertical_unit or ("unknown" if across == "deg" else across)


def _faces(faces: Any, points: int) -> np.ndarray | None:
    if faces is None:
        return None
    try:
        array = np.asarray(faces)
    except Exception:
        raise UsageError("faces: cannot be read as an array") from None
    if array.size == 0:
        return None
    if array.ndim != 2 or array.shape[1] != 3 or array.dtype.kind not in "iu":
        raise UsageError(f"faces: an array of shape {array.shape} and type {array.dtype}: needed are (m, 3) whole numbers")
    if array.min() < 0 or array.max() >= points:
        raise UsageError(f"faces: a corner is none of the {points} points")
    return np.ascontiguousarray(array, dtype=np.int32)


# --- what other libraries hold ---------------------------------------------------------------------------------------


def _is_of(thing: Any, library: str) -> bool:
    return any(kind.__module__.split(".")[0] == library for kind in type(thing).__mro__)


def _of_laspy(las: Any, argument: str) -> Scan:
    names = list(las.point_format.dimension_names)
    values = {name.lower(): np.asarray(las[name]) for name in names
              if name not in ("X", "Y", "Z") and np.asarray(las[name]).ndim == 1}
    return _scan_of(las.xyz, attributes=values, argument=argument, **_crs_words(_laspy_crs(las)))


def _laspy_crs(las: Any) -> Any:
    try:
        return las.header.parse_crs()
    except Exception:  # pyproj is not installed, or the file's CRS is not understood: the scan has none
        return None


def _crs_words(crs: Any) -> dict[str, Any]:
    """crs, unit and vertical unit of a pyproj CRS; of its axes, never assumed."""
    if crs is None:
        return {}
    names = {"metre": "m", "meter": "m", "foot": "ft", "US survey foot": "us-ft", "degree": "deg"}
    axes = [names.get(axis.unit_name, "unknown") for axis in getattr(crs, "axis_info", ())]
    words: dict[str, Any] = {"crs": crs.to_wkt()}
    if len(axes) >= 2:
        words["unit"] = axes[0]
        words["vertical_unit"] = axes[2] if len(axes) > 2 else "unknown"
    return words


def _of_geopandas(frame: Any, argument: str) -> Scan:
    geometry = getattr(frame, "geometry", frame)
    if not (geometry.geom_type == "Point").all() or not geometry.has_z.all():
        raise UsageError(f"{argument}: its geometries must all be points with a z")
    places = geometry.get_coordinates(include_z=True).to_numpy()
    values = {}
    for name in getattr(frame, "columns", ()):
        column = frame[name]
        if name != geometry.name and column.dtype.kind in "fiub":
            values[str(name)] = column.to_numpy()
    return _scan_of(places, attributes=values, argument=argument, **_crs_words(frame.crs))


def _of_open3d(thing: Any, argument: str) -> Scan:
    if hasattr(thing, "point") and hasattr(thing.point, "positions"):  # the tensor classes
        faces = thing.triangle.indices.numpy() if hasattr(thing, "triangle") and "indices" in thing.triangle else None
        return _scan_of(thing.point.positions.numpy(), faces=faces, argument=argument)
    if hasattr(thing, "vertices"):
        return _scan_of(np.asarray(thing.vertices), faces=np.asarray(thing.triangles), argument=argument)
    return _scan_of(np.asarray(thing.points), argument=argument)


def _of_pyvista(mesh: Any, argument: str) -> Scan:
    faces = None
    if getattr(mesh, "n_cells", 0) and hasattr(mesh, "faces") and len(mesh.faces):
        surface = mesh if mesh.is_all_triangles else mesh.triangulate()
        faces = np.asarray(surface.faces).reshape(-1, 4)[:, 1:]
    values = {str(name): mesh.point_data[name] for name in mesh.point_data if np.ndim(mesh.point_data[name]) == 1
              and np.asarray(mesh.point_data[name]).dtype.kind in "fiub"}
    points = np.asarray(mesh.points, dtype=np.float64)
    if "origin" in getattr(mesh, "field_data", {}):  # as Result.to_pyvista puts it there
        points = points + np.asarray(mesh.field_data["origin"], dtype=np.float64)
    return _scan_of(points, attributes=values, faces=faces, argument=argument)


def _of_trimesh(mesh: Any, argument: str) -> Scan:
    return _scan_of(np.asarray(mesh.vertices), faces=getattr(mesh, "faces", None), argument=argument)


def _of_xarray(array: Any, argument: str) -> Scan:
    if not hasattr(array, "dims") or hasattr(array, "data_vars"):
        raise UsageError(f"{argument}: a Dataset has several variables: pass one of them, a DataArray")
    array = array.squeeze(drop=True)
    if array.ndim != 2:
        raise UsageError(f"{argument}: a raster of the dimensions {array.dims}: needed are two, y and x")
    down, across = array.dims
    for dimension in (down, across):
        if dimension not in array.coords:
            raise UsageError(f"{argument}: the raster has no coordinates along {dimension}")
    heights = np.asarray(array.values, dtype=np.float64)
    x, y = np.meshgrid(np.asarray(array[across].values, dtype=np.float64),
                       np.asarray(array[down].values, dtype=np.float64))
    nodata = array.attrs.get("_FillValue", array.attrs.get("nodata"))
    known = np.isfinite(heights) & (True if nodata is None else heights != nodata)
    crs = array.rio.crs if hasattr(array, "rio") else None
    return _scan_of(np.column_stack([x[known], y[known], heights[known]]), argument=argument,
                    crs=None if crs is None else crs.to_wkt())


def _of_rasterio(dataset: Any, argument: str) -> Scan:
    band = dataset.read(1, masked=True)
    rows, columns = np.nonzero(~np.ma.getmaskarray(band))
    t = dataset.transform
    x = t.c + (columns + 0.5) * t.a + (rows + 0.5) * t.b
    y = t.f + (columns + 0.5) * t.d + (rows + 0.5) * t.e
    return _scan_of(np.column_stack([x, y, np.asarray(band.data[rows, columns], dtype=np.float64)]), argument=argument,
                    crs=None if dataset.crs is None else dataset.crs.to_wkt())


def _of_table(table: Any, argument: str) -> Scan:
    names = {str(name).lower(): name for name in table.columns}
    if not {"x", "y", "z"} <= names.keys():
        raise UsageError(f"{argument}: a table needs the columns x, y and z")
    values = {low: np.asarray(table[name]) for low, name in names.items()
              if low not in ("x", "y", "z") and np.asarray(table[name]).dtype.kind in "fiub"}
    return _scan_of(np.column_stack([np.asarray(table[names[axis]]) for axis in "xyz"]), attributes=values,
                    argument=argument)


_LIBRARIES = {"laspy": _of_laspy, "geopandas": _of_geopandas, "open3d": _of_open3d, "pyvista": _of_pyvista,
              "trimesh": _of_trimesh, "xarray": _of_xarray, "rasterio": _of_rasterio, "pandas": _of_table,
              "polars": _of_table}


def as_scan(thing: Any, argument: str) -> Scan | str | os.PathLike[str]:
    """What was passed for a scan: a path as it is, all else as a Scan; `argument` names it in errors."""
    if isinstance(thing, Scan):
        return thing
    if isinstance(thing, (str, bytes, os.PathLike)):
        if not os.fspath(thing):
            raise UsageError(f"{argument}: the path is empty")
        return os.fsdecode(thing)
    if hasattr(thing, "__isopach_scan__"):
        made = thing.__isopach_scan__()
        if not isinstance(made, Scan):
            raise UsageError(f"{argument}: __isopach_scan__ of {type(thing).__name__} returned no isopach.Scan")
        return made
    for library, convert in _LIBRARIES.items():
        if _is_of(thing, library):
            return convert(thing, argument)
    if isinstance(thing, (np.ndarray, list, tuple)) or hasattr(thing, "__array__") or hasattr(thing, "__array_interface__"):
        return _scan_of(thing, argument=argument)
    raise UsageError(f"{argument}: {type(thing).__name__} is nothing that looks like a scan: pass a path, an (n, 3) array, "
                     "an isopach.Scan, or an object with __isopach_scan__()")
