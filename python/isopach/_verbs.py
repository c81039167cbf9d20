"""The verbs as functions. Their keywords, defaults and descriptions are the table of the command line's options."""

from __future__ import annotations

import inspect
import os
import textwrap
from collections.abc import Callable
from typing import Any

from . import _results
from ._docs import EXAMPLE, SUMMARY
from ._errors import UsageError
from ._run import Word, plain_word, run, unknown_keyword
from ._spell import spell
from ._table import keywords

#: For annotations: a path, an (n, 3) array, a Scan, or an object of another library that holds one.
ScanLike = Any

#: What stands in front of the keywords; a default makes an argument optional.
ARGUMENTS: dict[str, tuple[str, ...]] = {
    "compare": ("a", "b"), "match": ("moving", "fixed"), "distance": ("a", "b"), "roughness": ("scan", "after"),
    "accuracy": ("reconstruction", "reference"), "scanners": ("a", "b", "reference"), "asymmetry": ("face",),
    "sequence": ("frames",), "combine": ("face", "jaw"), "info": ("files",), "simulate": ("scene",),
    "convert": ("src", "dst"),
}
OPTIONAL = {("roughness", "after")}

RESULTS: dict[str, Any] = {
    "compare": _results.Comparison, "match": _results.Matching, "distance": _results.Distances,
    "roughness": _results.Roughness, "accuracy": _results.Accuracy, "scanners": _results.Scanners,
    "asymmetry": _results.Asymmetry, "sequence": _results.Sequence, "combine": _results.Combination,
    "info": _results.Info, "simulate": _results.Scene, "convert": None,
}


def default_of(row: dict[str, Any]) -> Any:
    """As it is shown; an option that was not passed is not said, so that the verb itself decides."""
    if row["flag"]:
        return False
    text = row["value"]
    if text in ("", "none"):
        return None
    for kind in (int, float):
        try:
            return kind(text)
        except ValueError:
            pass
    return text == "on" if row["type"] == "on|off" else text


def signature_of(verb: str) -> inspect.Signature:
    kinds = inspect.Parameter
    positional = []
    for name in ARGUMENTS[verb]:
        kind = kinds.VAR_POSITIONAL if verb == "info" else kinds.POSITIONAL_OR_KEYWORD
        default = None if (verb, name) in OPTIONAL else kinds.empty
        positional.append(kinds(name, kind, default=default))
    named = [kinds(keyword, kinds.KEYWORD_ONLY, default=kinds.empty if row["required"] else default_of(row))
             for keyword, row in keywords(verb).items()]
    for keyword in ("threads", "progress"):
        named.append(kinds(keyword, kinds.KEYWORD_ONLY, default=None))
    return inspect.Signature(positional + sorted(named, key=lambda p: p.default is not kinds.empty))


def docstring_of(verb: str) -> str:
    text = SUMMARY[verb] + "\n\nParameters\n----------\n"
    heading = None
    for keyword, row in keywords(verb).items():
        if row["heading"] != heading:
            heading = row["heading"]
            text += f"\n*{heading}*\n\n"
        shown = "flag" if row["flag"] else row["type"]
        default = default_of(row)
        said = spell(row["description"]) + ("" if row["flag"] or default is None else f" (default {default!r})")
        text += f"{keyword} : {shown}\n" + textwrap.fill(said, 110, initial_indent="    ", subsequent_indent="    ") + "\n"
    text += ("\n*Run*\n\nthreads : N\n    Most threads; 0: all cores. Default: ISOPACH_THREADS, else all. The result does not "
             "depend on it.\nprogress : True or a function of (stage, fraction)\n    A bar, or what is called, about 50 "
             "times a second at most.\n")
    result = RESULTS[verb]
    if result is not None:
        text += f"\nReturns\n-------\n{result.__name__}\n    Attributes are the keys of result.json, docs/start/files.md.\n"
    text += ("\nRaises\n------\nUsageError, InputError, OverlapError, ConvergenceError, ToleranceError\n    One line each; "
             "``exit_code`` is that of the command line.\n\nExamples\n--------\n" + EXAMPLE[verb] + "\n")
    return text


def _positional(verb: str, bound: inspect.BoundArguments) -> list[tuple[str, Any]]:
    given = [(name, bound.arguments[name]) for name in ARGUMENTS[verb] if bound.arguments.get(name) is not None]
    if verb == "info":
        files = bound.arguments.get("files", ())
        if not files:
            raise UsageError("files: none was passed")
        return [(f"files[{k}]" if len(files) > 1 else "files", file) for k, file in enumerate(files)]
    if verb == "sequence":
        frames = bound.arguments["frames"]
        if isinstance(frames, (str, os.PathLike)):
            return [("frames", frames)]
        if hasattr(frames, "ndim") and frames.ndim == 2:
            raise UsageError("frames: one array: needed are several scans, a list of arrays or paths")
        try:
            several = list(frames)
        except TypeError:
            raise UsageError(f"frames: {type(frames).__name__} is no list of scans and no folder") from None
        if not several:
            raise UsageError("frames: no scans")
        return [(f"frames[{k}]", frame) for k, frame in enumerate(several)]
    if verb == "simulate":
        return [("scene", Word(plain_word(bound.arguments["scene"], "scene")))]
    if verb == "convert":
        return [given[0], ("dst", Word(plain_word(bound.arguments["dst"], "dst")))]
    return given


def _make(verb: str) -> Callable[..., Any]:
    signature = signature_of(verb)
    known = [p.name for p in signature.parameters.values() if p.kind is not inspect.Parameter.VAR_POSITIONAL]

    def function(*arguments: Any, **options: Any) -> Any:
        for keyword in options:
            if keyword not in known:
                raise TypeError(unknown_keyword(verb, keyword, known))
        try:
            bound = signature.bind(*arguments, **options)
        except TypeError as wrong:
            raise TypeError(f"{verb}() {wrong}") from None
        named = {name: value for name, value in bound.arguments.items() if name not in ARGUMENTS[verb]}
        missing = [name for name in ARGUMENTS[verb]
                   if bound.arguments.get(name) is None and (verb, name) not in OPTIONAL and verb != "info"]
        if missing:
            raise UsageError(f"{missing[0]}: None is no scan")
        if verb == "convert":
            run(verb, _positional(verb, bound), named)
            return None
        return run(verb, _positional(verb, bound), named, RESULTS[verb])

    function.__name__ = function.__qualname__ = verb
    function.__module__ = "isopach"
    function.__doc__ = docstring_of(verb)
    function.__signature__ = signature  # type: ignore[attr-defined]
    return function


compare = _make("compare")
match = _make("match")
distance = _make("distance")
roughness = _make("roughness")
accuracy = _make("accuracy")
scanners = _make("scanners")
asymmetry = _make("asymmetry")
sequence = _make("sequence")
combine = _make("combine")
info = _make("info")
simulate = _make("simulate")
convert = _make("convert")
