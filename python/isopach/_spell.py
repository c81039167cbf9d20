"""Messages of the library name options as the command line does, --max-edge; here they are keywords, max_edge."""

from __future__ import annotations

import functools
import re

from . import _core
from ._table import keyword_of, rows


@functools.cache
def _options() -> dict[str, tuple[bool, frozenset[str]]]:
    """By name: whether it is a flag, and the words that it takes."""
    found: dict[str, tuple[bool, frozenset[str]]] = {}
    for verb in _core.verbs():
        for row in rows(verb):
            for name in row["names"]:
                flag, words = found.get(name, (True, frozenset()))
                found[name] = (flag and row["flag"], words | frozenset(row["type"].split("|")))
    return found


def spell(message: str) -> str:
    """`message` in one line with keywords for options: "--surface common" becomes surface="common", --match match=True."""
    return " ".join(spell_lines(message).split("\n")).strip()


def spell_lines(message: str) -> str:
    """The same with its lines as they are."""
    def replaced(match: re.Match[str]) -> str:
        name, rest, word = match.group(1), match.group(2) or "", match.group(3) or ""
        if name not in _options():
            return match.group(0)
        flag, words = _options()[name]
        keyword = keyword_of(name)
        if flag:
            follows = message[match.end(1):match.end(1) + 1]
            leads = match.start() == 0 and follows in (":", " ")
            return f"{keyword}{'' if leads and follows == ':' else '=True'}{rest}"
        if word and word in words:
            return f'{keyword}="{word}"'
        return keyword + rest

    return re.sub(r"(?<![\w'\"/.@-])--([a-z][a-z0-9]*(?:-[a-z0-9]+)*)( (\w[\w.-]*))?", replaced, message)
