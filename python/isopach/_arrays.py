"""Arrays of results: by point of a scan, and by cell."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from ._check import shown
from ._errors import UsageError
from ._scan import _read_only


class Fields:
    """Arrays by point of a scan, in the order of the input; attributes and items, read-only views.

    NaN where a point was dropped or the other surface is not known under it. The views keep the result alive.
    """

    __slots__ = ("_arrays", "_room")
    _arrays: dict[str, np.ndarray]
    _room: str

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
    _data: dict[str, Any]

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
        if not isinstance(surface, str) or surface not in ("a", "b"):
            raise UsageError(f"surface: {shown(surface)} is not 'a' or 'b'")
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
