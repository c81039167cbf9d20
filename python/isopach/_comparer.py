"""Comparer: many comparisons, one after another."""

from __future__ import annotations

from types import TracebackType
from typing import Any

from . import _core
from ._errors import UsageError
from ._results import Comparison
from ._verbs import ScanLike, compare


class Comparer:
    """Compares pair after pair with the same options, each on memory that the one before it gave back.

    The results are those of :func:`isopach.compare`, bit for bit, and stay valid after the end. Between calls it holds
    at most the memory that a comparison takes. Keywords are those of :func:`isopach.compare`.

    >>> import isopach
    >>> scenes = [isopach.simulate("plane", points=1000, seed=seed) for seed in (1, 2)]
    >>> with isopach.Comparer(border="hull") as comparer:
    ...     nets = [comparer.compare(scene.a, scene.b).volume.net for scene in scenes]
    >>> len(nets)
    2
    """

    def __init__(self, **options: Any) -> None:
        self._options = options
        self._kept: _core.KeptMemory | None = _core.KeptMemory()

    def compare(self, a: ScanLike, b: ScanLike, **options: Any) -> Comparison:
        """As :func:`isopach.compare`; a keyword given here takes the place of one given to the Comparer."""
        if self._kept is None:
            raise UsageError("Comparer: it was closed: make a new one")
        return compare(a, b, **{**self._options, **options})

    def close(self) -> None:
        """Gives the memory back to the system. Closing twice does nothing."""
        self._kept = None

    def __enter__(self) -> Comparer:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self.close()
