"""Progress of a run: a bar, or a function of the caller."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any


class _Line:
    """A line on stderr that is written over and over."""

    def __init__(self) -> None:
        self.width = 0

    def __call__(self, stage: str, fraction: float) -> None:
        line = f"{100 * fraction:3.0f} %  {stage}"
        sys.stderr.write("\r" + line.ljust(self.width))
        sys.stderr.flush()
        self.width = len(line)

    def close(self) -> None:
        if self.width:
            sys.stderr.write("\r" + " " * self.width + "\r")


class _Bar:
    """tqdm's bar, in a notebook as a widget."""

    def __init__(self, tqdm: Any) -> None:
        self.bar = tqdm(total=1.0, bar_format="{percentage:3.0f} % |{bar}| {desc} [{elapsed}]", leave=False)

    def __call__(self, stage: str, fraction: float) -> None:
        self.bar.set_description_str(stage)
        self.bar.n = fraction
        self.bar.refresh()

    def close(self) -> None:
        self.bar.close()


@contextmanager
def listener(progress: Any) -> Iterator[Callable[[str, float], Any] | None]:
    """What is told of progress: nobody, the caller's function, or a bar, which is taken away at the end."""
    if progress is None or progress is False:
        yield None
        return
    if callable(progress):
        yield progress
        return
    if progress is not True:
        from ._errors import UsageError
        raise UsageError("progress: neither True nor a function of (stage, fraction)")
    bar: _Bar | _Line
    try:
        from tqdm.auto import tqdm  # type: ignore[import-untyped,unused-ignore]
        bar = _Bar(tqdm)
    except ImportError:
        bar = _Line()
    try:
        yield bar
    finally:
        bar.close()
