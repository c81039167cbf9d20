"""Failures and warnings of isopach."""

from __future__ import annotations

import re
from typing import Any


class Error(RuntimeError):
    """A run that ended without what was asked for. Its text is one line: what, in which scan or argument, what to do.

    ``exit_code`` is that of the command line, ``keyword`` the argument that the line begins with, or None, and
    ``result`` what was found all the same (a pose that did not converge, a result above a tolerance), or None.
    """

    exit_code: int = 1

    def __init__(self, message: str, result: Any = None) -> None:
        super().__init__(message)
        self.result = result
        found = re.match(r"([a-z]\w*): ", message)
        self.keyword: str | None = found.group(1) if found else None

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (str(self), self.result)


class UsageError(Error, ValueError):
    """An argument that makes no sense."""

    exit_code = 2


class InputError(Error, ValueError):
    """A scan or a file that cannot be read or is invalid."""

    exit_code = 3


class OverlapError(Error):
    """The scans do not overlap, or less than `min_coverage`."""

    exit_code = 4


class ConvergenceError(Error):
    """A pose or a plane that did not converge, or is not trusted. ``result`` holds what was found."""

    exit_code = 5


class ToleranceError(Error):
    """A limit of `fail_above` or `fail_below` is exceeded. ``result`` holds the whole result."""

    exit_code = 6


class ScanWarning(UserWarning):
    """What a run has to say of its scans and of its result."""


def error_of(code: int, message: str, result: Any = None) -> Error:
    for kind in (UsageError, InputError, OverlapError, ConvergenceError, ToleranceError):
        if kind.exit_code == code:
            return kind(message, result)
    return Error(message, result)
