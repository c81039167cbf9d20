"""What arguments are, or one line that says what they are not."""

from __future__ import annotations

import os
from typing import Any

import numpy as np

from ._errors import UsageError


def shown(value: Any, most: int = 40) -> str:
    """In one short line, whatever it is."""
    if isinstance(value, np.ndarray):
        return f"an array of shape {value.shape}"
    if not isinstance(value, (str, bytes, bool, int, float, complex, type(None), list, tuple, dict)):
        return f"a {type(value).__name__}"
    text = " ".join(repr(value).split())
    return text if len(text) <= most else text[:most - 1] + "…"


def path_of(value: Any, argument: str) -> bytes:
    """The name of a file as the system has it."""
    try:
        path = os.fsencode(value)
    except (TypeError, ValueError):
        raise UsageError(f"{argument}: {shown(value)} is not a path") from None
    if b"\0" in path:
        raise UsageError(f"{argument}: a path with a character NUL")
    return path


def text_of(value: Any, argument: str) -> str:
    """Text that can be written to a file: "" for None."""
    if value is None:
        return ""
    if not isinstance(value, str):
        raise UsageError(f"{argument}: {shown(value)} is not a text")
    try:
        value.encode()
    except UnicodeEncodeError:
        raise UsageError(f"{argument}: a text with characters that no text has") from None
    return value


def float_of(value: Any, argument: str) -> float:
    if isinstance(value, (str, bytes)):
        raise UsageError(f"{argument}: {shown(value)} is not a number")
    try:
        return float(value)
    except (TypeError, ValueError, OverflowError):
        raise UsageError(f"{argument}: {shown(value)} is not a number") from None


def above_zero(value: Any, argument: str) -> float:
    number = float_of(value, argument)
    if not 1e-100 < number < 1e100:  # whose square is a number, too
        raise UsageError(f"{argument}: {shown(value)} is not a number above 0, of the size of a length")
    return number


def box_of(value: Any, argument: str) -> np.ndarray:
    """(xmin, ymin, xmax, ymax)."""
    wrong = UsageError(f"{argument}: needed is (xmin, ymin, xmax, ymax) with min not above max")
    if isinstance(value, (str, bytes)):
        raise wrong
    try:
        box = np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        raise wrong from None
    if box.shape != (4,) or not np.isfinite(box).all() or not (box[:2] <= box[2:]).all():
        raise wrong
    return box
