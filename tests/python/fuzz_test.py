"""Anything passed for anything: one line that names what is wrong, or a result; nothing else, and no crash.

    ISOPACH_FUZZ=2000 pytest tests/python/fuzz_test.py         more examples of each test (default 25)
    python -X faulthandler tests/python/fuzz_test.py SECONDS   other examples each time round, until the time is up

The second way prints what it did as JSON on its last line.
"""

from __future__ import annotations

import collections
import contextlib
import functools
import inspect
import json
import os
import pathlib
import re
import sys
import tempfile
import time
import warnings
from collections.abc import Callable, Iterator
from typing import Any

import pytest

pytest.importorskip("hypothesis", reason="hypothesis is not there")

import isopach  # noqa: E402
import numpy as np  # noqa: E402
from hypothesis import HealthCheck, given, seed, settings  # noqa: E402
from hypothesis import strategies as st  # noqa: E402

pytestmark = pytest.mark.filterwarnings("ignore")
EXAMPLES = int(os.environ.get("ISOPACH_FUZZ", "25"))
COUNT: collections.Counter[str] = collections.Counter()
common = settings(max_examples=EXAMPLES, deadline=None, derandomize=True, database=None,
                  suppress_health_check=list(HealthCheck))

# --- what is passed --------------------------------------------------------------------------------------------------

NUMBERS = st.one_of(st.floats(), st.sampled_from([0.0, -0.0, 1.0, -1.0, 1e-310, 1e300, 1e22, float("nan"), float("inf")]),
                    st.integers(-3, 60), st.sampled_from([2**31, -2**63, 10**30]))
# No word reaches beyond the folder of the test, and none is the name of a device.
TEXTS = st.one_of(st.text(st.characters(exclude_characters="/"), max_size=12),
                  st.sampled_from(["", " ", "-", "@", "@x", "nan", "1,2", "a\x00b", "\udcff", "a\nb", "auto", "x",
                                   "on", "1e400", "0x10", "scan.ply", "noise.las", "p95=1", "."]))
SCALARS = st.one_of(st.none(), st.booleans(), NUMBERS, TEXTS, st.binary(max_size=4), st.complex_numbers(),
                    st.just(object()), st.just(len))
KINDS = ["f8", "f4", "f2", ">f8", "i4", "u2", "i8", "u1", "?", "c16", "U3", "S2", "M8[s]", "O", "V8", "g"]


@st.composite
def arrays(draw: Callable[..., Any], shapes: Any = None) -> Any:
    """Any type, shape, order and stride; most of them nearly scans."""
    shape = draw(shapes if shapes is not None else st.one_of(st.tuples(st.integers(0, 40), st.just(3)), st.tuples(st.integers(0, 4), st.integers(0, 4)),
                                     st.lists(st.integers(0, 5), max_size=4).map(tuple)))
    numbers = np.random.default_rng(draw(st.integers(0, 50)))
    made: Any = numbers.uniform(0, 10, shape) * draw(st.sampled_from([1, 1, 1, 1e-300, 1e150, 1e300]))
    made = np.asarray(np.floor(made) if draw(st.booleans()) else made)
    if made.size and draw(st.booleans()):
        made.flat[draw(st.integers(0, made.size - 1))] = draw(st.sampled_from([np.nan, np.inf, -np.inf, 1e308, 0]))
    with warnings.catch_warnings(), contextlib.suppress(TypeError, ValueError), np.errstate(all="ignore"):
        warnings.simplefilter("ignore")
        made = made.astype(draw(st.sampled_from(["f8"] * 8 + KINDS)))
    how = draw(st.sampled_from(["as it is"] * 4 + ["Fortran", "reversed", "steps", "broadcast", "unaligned", "masked", "read-only"]))
    if how == "Fortran":
        made = np.asfortranarray(made)
    elif how == "reversed":
        made = made[::-1] if made.ndim else made
    elif how == "steps":
        made = made[..., ::-1] if made.ndim else made
    elif how == "broadcast" and made.ndim:
        made = np.broadcast_to(made[:1], made.shape) if len(made) else made
    elif how == "unaligned" and made.dtype.kind == "f" and made.dtype.itemsize == 8:
        made = np.frombuffer(b"\0" + made.tobytes(), np.uint8)[1:].view(made.dtype).reshape(made.shape)
    elif how == "masked":
        made = np.ma.masked_array(made, mask=numbers.uniform(size=shape) < 0.2)
    elif how == "read-only" and isinstance(made, np.ndarray):
        made.flags.writeable = False
    return made


def of_rows(columns: int) -> Any:
    return arrays(st.tuples(st.integers(0, 6), st.just(columns)))


THINGS = st.one_of(SCALARS, arrays(), st.lists(SCALARS, max_size=4), st.dictionaries(TEXTS, SCALARS, max_size=3),
                   st.lists(of_rows(2), max_size=2),
                   st.sampled_from([{"type": "Polygon", "coordinates": [[[0, 0], [9, 0], [9, 9], [0, 0]]]},
                                    {"type": "Polygon", "coordinates": [[[0, 0], [float("nan"), 0], [9, 9]]]},
                                    {"type": "Polygon", "coordinates": None}, {"type": "Feature"}, {"type": 7},
                                    {"type": "FeatureCollection", "features": [None]}, np.eye(4), np.zeros((4, 4))]))
SCENE = isopach.simulate("terrain", points=250, seed=1)
GOOD = st.sampled_from([SCENE.a, SCENE.b, np.array(SCENE.b.points), np.asfortranarray(SCENE.a.points),
                        SCENE.b.points.astype(np.float32), "scan.ply"])


@st.composite
def mostly(draw: Callable[..., Any], fitting: Any, rest: Any) -> Any:
    """`st.one_of` takes each of its parts as often, however many are wrong."""
    return draw(fitting if draw(st.integers(0, 9)) < 8 else rest)


SCANS = mostly(GOOD, st.one_of(arrays(), THINGS))
#: Numbers of these are work: nobody wants a thousand million of them.
COUNTS = {"points", "points_b", "frames", "samples", "max_iterations", "threads", "wrinkles", "clusters", "starts"}


@contextlib.contextmanager
def only_clear_errors() -> Iterator[None]:
    COUNT["examples"] += 1
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            yield
        COUNT["done"] += 1
    except isopach.Error as error:
        text = str(error)
        assert text.strip() and "\n" not in text, repr(text)
        assert not re.search(r"(^|[\s(])--[a-z]", text), text
        assert error.exit_code in range(1, 7)
        COUNT["refused"] += 1
    except TypeError as error:  # of a call that no such function has
        assert re.match(r"\w+\(\) ", str(error)) and "\n" not in str(error), error
        COUNT["refused"] += 1


@pytest.fixture(autouse=True)
def folder(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    place = tmp_path_factory.mktemp("fuzz")
    with of_files(place):
        yield


@contextlib.contextmanager
def of_files(place: pathlib.Path) -> Iterator[None]:
    """A folder to stand in, with a scan and a file that is none."""
    SCENE.a.write(place / "scan.ply")
    (place / "noise.las").write_bytes(bytes(range(256)) * 4)
    before = os.getcwd()
    os.chdir(place)
    try:
        yield
    finally:
        os.chdir(before)


# --- to what ---------------------------------------------------------------------------------------------------------


def values_of(verb: str, keyword: str, default: Any) -> Any:
    from isopach import _table
    row = _table.keywords(verb).get(keyword, {"type": ""})
    words = [word for word in row["type"].split("|") if word.islower()]
    if keyword in COUNTS or row["type"] == "N":
        return st.one_of(st.integers(-2, 60), st.sampled_from([None, True, "x", 2.5, float("nan"), "", (1, 2)]))
    fitting = st.sampled_from(words) if words else st.sampled_from([default, None, 1.0, 0.5])
    return mostly(fitting, st.one_of(THINGS, NUMBERS))


def one_call(verb: str) -> Any:
    @st.composite
    def call(draw: Callable[..., Any]) -> tuple[list[Any], dict[str, Any]]:
        parameters = inspect.signature(getattr(isopach, verb)).parameters.values()
        scans, options = [], {}
        for p in parameters:
            if p.kind is p.POSITIONAL_OR_KEYWORD:
                scans.append(draw(st.sampled_from(["plane", "face", ""]) if p.name == "scene" else
                                  TEXTS if p.name == "dst" else
                                  st.lists(SCANS, max_size=3) if p.name == "frames" else SCANS))
            elif p.kind is p.VAR_POSITIONAL:
                scans += draw(st.lists(SCANS, max_size=2))
            elif p.default is p.empty:
                options[p.name] = draw(SCANS)
        named = [p for p in parameters if p.kind is p.KEYWORD_ONLY and p.default is not p.empty]
        for p in draw(st.lists(st.sampled_from(named), max_size=draw(st.sampled_from([0, 1, 3])), unique_by=lambda p: p.name)):
            options[p.name] = draw(values_of(verb, p.name, p.default))
        if verb == "simulate":
            options["points"] = draw(values_of(verb, "points", 50))
        return scans, options

    return call()


VERBS = ("compare", "match", "distance", "roughness", "accuracy", "scanners", "asymmetry", "sequence", "combine", "info",
         "simulate", "convert")


def try_verb(verb: str, call: tuple[list[Any], dict[str, Any]]) -> None:
    scans, options = call
    with only_clear_errors():
        result = getattr(isopach, verb)(*scans, **options)
        if result is not None:
            json.loads(result.to_json())
            repr(result)


def try_scan(points: Any, attributes: Any, faces: Any, word: Any) -> None:
    for options in ({}, {"attributes": attributes}, {"faces": faces}, {"unit": word}, {"vertical_unit": word}, {"crs": word},
                    {"name": word}):
        with only_clear_errors():
            scan = isopach.scan(points, **options)
            repr(scan), np.array(scan.points), len(scan.attributes)


def try_read(path: Any, classes: Any, crop: Any, word: Any) -> None:
    for name in (path, "scan.ply"):
        for options in ({}, {"classes": classes}, {"crop": crop}, {"unit": word}, {"threads": word}):
            with only_clear_errors():
                isopach.read(name, **options)


with warnings.catch_warnings():
    warnings.simplefilter("ignore")
    COMPARISON = isopach.compare(SCENE.a, SCENE.b, sigma1=0.1, sigma2=0.1)
    MATCHING = isopach.match(SCENE.b, SCENE.a, pose_only=True, accept_doubt=True)


def try_results(places: Any, number: Any, box: Any, average: bool) -> None:
    for call in (lambda: COMPARISON.at(places), lambda: COMPARISON.profile(places), lambda: COMPARISON.profile(places, number),
                 lambda: COMPARISON._raster(10, average, box), lambda: COMPARISON.cells.points(number),
                 lambda: MATCHING.apply(places), lambda: COMPARISON.save("out", palette=number),
                 lambda: COMPARISON.save("out", map_width=number, no_cells=True)):
        with only_clear_errors():
            call()
    if not isinstance(number, float) or not 0 < number < 0.5:  # of small pixels there are many
        with only_clear_errors():
            COMPARISON._raster(number, average, None)


CASES: dict[str, tuple[Callable[..., None], Any]] = {
    **{verb: (functools.partial(try_verb, verb), st.tuples(one_call(verb))) for verb in VERBS},
    "scan": (try_scan, st.tuples(SCANS, st.dictionaries(TEXTS, arrays(st.tuples(st.integers(0, 40))), max_size=2) | THINGS,
                                 THINGS | of_rows(3), THINGS)),
    "read": (try_read, st.tuples(TEXTS | THINGS, THINGS, THINGS, THINGS)),
    "results": (try_results, st.tuples(of_rows(2) | THINGS, NUMBERS | THINGS, of_rows(4) | THINGS, st.booleans())),
}


def examples_of(name: str, how: Any, turn: int = 0) -> None:
    function, passed = CASES[name]

    def example(arguments: Any) -> None:
        function(*arguments)

    passing: Any = given(passed)
    seeded: Any = seed(turn)
    seeded(how(passing(example)))()


@pytest.mark.parametrize("name", CASES)
def test_one_line_or_a_result(name: str) -> None:
    examples_of(name, common)


def for_a_while(seconds: float) -> None:
    end, turn = time.monotonic() + seconds, 0
    free = settings(common, derandomize=False, max_examples=25)
    with tempfile.TemporaryDirectory() as place, of_files(pathlib.Path(place)):
        while time.monotonic() < end:
            turn += 1
            for name in CASES:
                examples_of(name, free, turn)
    print(json.dumps(dict(COUNT)))


if __name__ == "__main__":
    for_a_while(float(sys.argv[1]))
