"""The options of the verbs, as the command line declares them: one table serves both."""

from __future__ import annotations

import functools
from typing import Any

from . import _core

#: Keywords that are not the option's name with underscores.
_KEYWORDS = {"class": "classes"}

#: Options of the command line that are something else here: methods of results, Python's own ways.
_NOT_KEYWORDS = frozenset({"help", "version", "config", "json", "output", "quiet", "verbose", "max-input",
                           "max-memory"})

#: Headings of the options that say what is written: those of `save`.
_WRITES = frozenset({"Output", "Layers"})

#: Options under these headings that change what is computed, not what is written.
_COMPUTES = frozenset({"pose-only"})


def keyword_of(option: str) -> str:
    return _KEYWORDS.get(option, option.replace("-", "_"))


@functools.cache
def rows(verb: str) -> tuple[dict[str, Any], ...]:
    return tuple(_core.options(verb))


@functools.cache
def arguments(verb: str) -> tuple[dict[str, Any], ...]:
    """What stands in front of the keywords: the scans."""
    return tuple(row for row in rows(verb) if row["positional"])


@functools.cache
def writing(verb: str) -> dict[str, dict[str, Any]]:
    """By keyword: the options that say what is written, and how."""
    return {keyword_of(row["names"][0]): row for row in rows(verb)
            if row["heading"] in _WRITES and row["names"][0] not in _NOT_KEYWORDS | _COMPUTES}


@functools.cache
def keywords(verb: str) -> dict[str, dict[str, Any]]:
    """By keyword: what the verb's function takes; how results are written is asked of the result."""
    found = {}
    for row in rows(verb):
        if row["positional"]:
            continue
        name = row["names"][0]
        if name in _NOT_KEYWORDS or (row["heading"] in _WRITES and name not in _COMPUTES):
            continue
        if name in ("threads", "progress"):
            continue
        found[keyword_of(name)] = row
    return found
