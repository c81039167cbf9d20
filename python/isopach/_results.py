"""Results of the verbs."""

from __future__ import annotations

import os
import pathlib
from typing import Any

import numpy as np

from ._area import Profile, WithCells
from ._arrays import Cells, Fields
from ._errors import UsageError
from ._result import Result, _number
from ._scan import Scan, _numbers, _read_only

__all__ = ["Accuracy", "Asymmetry", "Cells", "Combination", "Comparison", "Distances", "Fields", "Info", "Matching", "Profile",
           "Result", "Roughness", "Scanners", "Scene", "Sequence"]


class Comparison(WithCells):
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
        return np.asarray(array @ m[:3, :3].T + m[:3, 3])

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


class Accuracy(WithCells):
    """How well a reconstruction (B) agrees with a reference (A)."""

    __slots__ = ()
    _verb = "accuracy"

    @property
    def points_reference(self) -> Fields:
        return self._fields("points_reference")

    @property
    def points_reconstruction(self) -> Fields:
        return self._fields("points_reconstruction")


class Scanners(WithCells):
    """Two scanners on one object, A and B, both where the reference put them."""

    __slots__ = ()
    _verb = "scanners"

    @property
    def points_a(self) -> Fields:
        return self._fields("points_a")

    @property
    def points_b(self) -> Fields:
        return self._fields("points_b")


class Asymmetry(WithCells):
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
