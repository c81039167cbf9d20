"""Calls of verbs: what is passed becomes the words of a command line, with scans in memory where these name files."""

from __future__ import annotations

import contextlib
import difflib
import logging
import os
import warnings
from collections.abc import Iterable, Iterator, Mapping
from typing import Any

import numpy as np

from . import _core
from ._check import float_of, path_of, shown
from ._errors import Error, ScanWarning, UsageError, error_of
from ._progress import listener
from ._scan import Scan, _scan_of, _threads, as_scan
from ._spell import spell
from ._table import keywords

log = logging.getLogger("isopach")
log.addHandler(logging.NullHandler())

#: Keywords that take a scan, a pose, polygons.
SCANS = frozenset({"core_points", "reference"})
POSES = frozenset({"pose", "start", "start_face", "start_jaw"})
POLYGONS = frozenset({"include", "exclude", "budget"})


class Call:
    """The words of one call, and what some of them name."""

    def __init__(self, verb: str) -> None:
        self.verb = verb
        self.words: list[bytes] = []
        self.given = _core.Given()
        self.kept: dict[str, Scan] = {}  # by argument
        self.count = 0

    def token(self) -> str:
        self.count += 1
        return f"\x1f{self.count}"  # no name of a file begins so

    def put(self, *words: str | bytes) -> None:
        self.words += [word if isinstance(word, bytes) else path_of(word, self.verb) for word in words]

    def scan_word(self, thing: Any, argument: str) -> str:
        found = as_scan(thing, argument)
        if not isinstance(found, Scan):
            return os.fsdecode(found)
        self.kept[argument] = found
        word = self.token()
        self.given.add_scan(word, _named(found, argument)._core)
        return word


def _named(scan: Scan, argument: str) -> Scan:
    """A scan without a name of its own is called by its argument."""
    if scan.name:
        return scan
    core = scan._core
    values = [(name, core.attribute(name)) for name in core.attributes]
    return Scan(_core.scan(core.points, core.points, values, core.faces, core.unit, core.vertical_unit, core.crs,
                           os.fsencode(argument)), scan.epoch)


def number_word(value: Any, keyword: str) -> str:
    """The shortest text that is the same number."""
    if isinstance(value, (bool, np.bool_)):
        raise UsageError(f"{keyword}: {value} is not a number")
    if isinstance(value, (int, np.integer)):
        return str(int(value))
    return repr(float_of(value, keyword))


def plain_word(value: Any, keyword: str) -> str:
    """Text, a number, or several of them with commas between."""
    if isinstance(value, (str, os.PathLike)):
        return os.fsdecode(value)
    if isinstance(value, Mapping):
        return ",".join(f"{name}={number_word(limit, keyword)}" for name, limit in value.items())
    if isinstance(value, (bool, np.bool_)):
        raise UsageError(f"{keyword}: {value} is neither a number nor a word that it takes")
    if isinstance(value, (int, float, np.integer, np.floating)):
        return number_word(value, keyword)
    if isinstance(value, np.ndarray) and value.ndim == 0:
        return plain_word(value.item(), keyword)
    if isinstance(value, Iterable):
        return ",".join(plain_word(part, keyword) for part in value)
    raise UsageError(f"{keyword}: {type(value).__name__} is nothing that it takes")


def _pose_word(call: Call, value: Any, keyword: str) -> str:
    if isinstance(value, (str, os.PathLike)):
        return os.fsdecode(value)
    matrix = np.asarray(getattr(value, "matrix", value))
    if matrix.shape != (4, 4) or matrix.dtype.kind not in "fiu":
        raise UsageError(f"{keyword}: needed is a (4, 4) array, the result of isopach.match, or a file")
    if not np.isfinite(matrix).all():
        raise UsageError(f"{keyword}: the matrix has numbers that are not finite")
    word = call.token()
    call.given.add_pose(word, [float(v) for v in matrix.ravel()])
    return word


def _rings(geometry: Mapping[str, Any], keyword: str) -> list[list[tuple[float, float]]]:
    kind = geometry.get("type")
    if kind == "Polygon":
        parts = [geometry["coordinates"]]
    elif kind == "MultiPolygon":
        parts = list(geometry["coordinates"])
    elif kind == "GeometryCollection":
        return [ring for part in geometry["geometries"] for ring in _rings(part, keyword)]
    else:
        raise UsageError(f"{keyword}: a geometry of the type {kind}: needed are polygons")
    rings = []
    for part in parts:
        for ring in part:
            places = [(float(p[0]), float(p[1])) for p in ring]
            if len(places) > 1 and places[0] == places[-1]:
                places.pop()
            if len(places) < 3:
                raise UsageError(f"{keyword}: a ring of fewer than three points")
            if not np.isfinite(places).all():
                raise UsageError(f"{keyword}: a coordinate that is no finite number")
            rings.append(places)
    return rings


def _features(value: Any, keyword: str) -> list[tuple[str, list[list[tuple[float, float]]]]]:
    geo = value if isinstance(value, Mapping) else getattr(value, "__geo_interface__", None)
    if geo is None and isinstance(value, np.ndarray) and value.ndim == 2 and value.shape[1] == 2:
        geo = {"type": "Polygon", "coordinates": [value.tolist()]}
    if geo is None:
        raise UsageError(f"{keyword}: {type(value).__name__}: needed is a file of polygons, a GeoDataFrame, an object with "
                         "__geo_interface__, GeoJSON as a dict, or an (n, 2) array")
    try:
        return _features_of(geo, keyword)
    except Error:
        raise
    except (ArithmeticError, AttributeError, LookupError, RecursionError, TypeError, ValueError):
        raise UsageError(f"{keyword}: this is not GeoJSON of polygons: a part of it is missing, or of another type than "
                         "GeoJSON has there") from None


def _features_of(geo: Mapping[str, Any], keyword: str) -> list[tuple[str, list[list[tuple[float, float]]]]]:
    if geo.get("type") == "FeatureCollection":
        features = list(geo["features"])
    elif geo.get("type") == "Feature":
        features = [geo]
    else:
        features = [{"geometry": geo, "properties": {}}]
    found = []
    for number, feature in enumerate(features, 1):
        properties = feature.get("properties") or {}
        names = [properties.get(key) for key in ("name", "id", "label", "title")] + [feature.get("id")]
        name = next((str(n) for n in names if n not in (None, "")), str(number))
        found.append((name, _rings(feature["geometry"], keyword)))
    return found


def _polygons_words(call: Call, value: Any, keyword: str) -> list[str]:
    if isinstance(value, (str, os.PathLike)):
        return [os.fsdecode(value)]
    if isinstance(value, (list, tuple)):
        return [word for part in value for word in _polygons_words(call, part, keyword)]
    crs: Any = getattr(value, "crs", None)
    text = crs.to_wkt() if hasattr(crs, "to_wkt") else ""
    word = call.token()
    call.given.add_polygons(word, keyword, text, _features(value, keyword))
    return [word]


def _registration_word(call: Call, value: Any, keyword: str) -> str:
    if not hasattr(value, "to_json"):
        return plain_word(value, keyword)
    word = call.token()
    call.given.add_matching(word, value.to_json())
    return word


def _with_sigma(thing: Any, values: Any, argument: str, keyword: str) -> tuple[Any, Any]:
    """Standard deviations by point as an attribute of the scan, and the word that names it."""
    if not isinstance(values, (np.ndarray, list, tuple)) or np.ndim(values) != 1:
        return thing, values
    scan = as_scan(thing, argument)
    if not isinstance(scan, Scan):
        raise UsageError(f"{keyword}: values by point need {argument} as an array or an isopach.Scan, not as a file")
    given = np.asarray(values)
    if given.shape != (len(scan),):
        raise UsageError(f"{keyword}: {len(given)} values for the {len(scan)} points of {argument}")
    made = _scan_of(scan.points, attributes={**scan.attributes, keyword: given}, faces=scan.faces,
                    unit=scan.unit, vertical_unit=scan.vertical_unit, crs=scan.crs, epoch=scan.epoch, name=scan.name,
                    argument=argument)
    return made, "@" + keyword


def _option(call: Call, keyword: str, row: Mapping[str, Any], value: Any) -> None:
    option = "--" + row["names"][0]
    if row["flag"]:
        if not isinstance(value, (bool, np.bool_)):
            raise UsageError(f"{keyword}: {shown(value)} is not True or False")
        if value:
            call.put(option)
        return
    if keyword in POSES:
        words: list[str] = [_pose_word(call, value, keyword)]
    elif keyword in POLYGONS or (keyword == "regions" and not isinstance(value, str)):
        words = _polygons_words(call, value, keyword)
    elif keyword in SCANS and row["type"] == "FILE":
        words = [call.scan_word(value, keyword)]
    elif keyword == "registration_error":
        words = [_registration_word(call, value, keyword)]
    elif row["list"] and isinstance(value, (list, tuple)):
        words = [plain_word(part, keyword) for part in value]
    elif row["type"] in ("on|off",) and isinstance(value, (bool, np.bool_)):
        words = ["on" if value else "off"]
    elif row["type"] == "N" or "PIXELS" in row["type"]:
        whole = isinstance(value, (float, np.floating)) and float(value).is_integer()
        words = [str(int(value)) if whole else plain_word(value, keyword)]
    else:
        words = [plain_word(value, keyword)]
    for word in words:
        if "\x00" in word:
            raise UsageError(f"{keyword}: a text with a character NUL")
        call.put(option, word) if not word.startswith("-") else call.put(f"{option}={word}")


def unknown_keyword(verb: str, keyword: str, known: Iterable[str]) -> str:
    near = difflib.get_close_matches(keyword, list(known), 1)
    hint = f" (did you mean {near[0]!r}?)" if near else ""
    return f"{verb}() got an unexpected keyword argument {keyword!r}{hint}"


@contextlib.contextmanager
def _taken_as(keyword: str) -> Iterator[None]:
    """What a value that is none of those it may be raises on the way is told of its keyword."""
    try:
        yield
    except Error:
        raise
    except (ArithmeticError, AttributeError, LookupError, RecursionError, TypeError, ValueError) as error:
        reason = " ".join(str(error).split()) or type(error).__name__
        raise UsageError(f"{keyword}: {reason[:200]}") from error


def run(verb: str, positional: list[tuple[str, Any]], options: dict[str, Any], result_class: Any = None) -> Any:
    """Runs a verb. `positional`: (argument, scan or text). Returns the result, or raises what the run ends with."""
    threads, progress = options.pop("threads", None), options.pop("progress", None)
    table = keywords(verb)
    given = {keyword: value for keyword, value in options.items() if value is not None}
    call = Call(verb)
    scans = dict(positional)
    for argument, keyword in (("a", "sigma1"), ("b", "sigma2")):
        if keyword in given and argument in scans:
            scans[argument], given[keyword] = _with_sigma(scans[argument], given[keyword], argument, keyword)
    for argument, thing in scans.items():
        word = thing.text if isinstance(thing, Word) else call.scan_word(thing, argument)
        if word.startswith("-"):
            word = "./" + word
        call.put(word)
    for keyword, value in given.items():
        with _taken_as(keyword):
            _option(call, keyword, table[keyword], value)
    wanted = _threads(threads)
    if wanted:
        call.put(f"--threads={wanted}")

    found = _execute(call, progress)
    if result_class is None:
        return found
    result = result_class._of(found, call.kept) if hasattr(result_class, "_of") else result_class(found)
    for warning in found.warnings:
        warnings.warn(spell(warning), ScanWarning, stacklevel=3)
    if found.failure is not None:
        code, message = found.failure
        raise error_of(code, spell(message), result)
    return result


class Word:
    """A positional argument that is no scan."""

    def __init__(self, text: str) -> None:
        self.text = text


def _execute(call: Call, progress: Any) -> Any:
    log.debug("%s: begins", call.verb)
    with listener(progress) as told:
        def stage(name: str, fraction: float) -> None:
            if log.isEnabledFor(logging.DEBUG):
                log.debug("%s: %s %.0f %%", call.verb, name, 100 * fraction)
            if told is not None:
                told(name, fraction)

        heard: list[str] = []
        try:
            wants = told is not None or log.isEnabledFor(logging.DEBUG)
            found = _core.run(call.verb, call.words, call.given, stage if wants else None, heard.append)
        except _core.Failure as failure:
            code, message = failure.args
            log.info("%s: ended: %s", call.verb, spell(message))
            raise error_of(code, spell(message)) from None
        finally:
            for warning in heard:
                warnings.warn(spell(warning), ScanWarning, stacklevel=4)
    log.info("%s: done", call.verb)
    return found

