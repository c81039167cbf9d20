"""docs/evidence/python.md, of what costs.py measured."""

HEAD = """# Python: what the module costs, and what it keeps

Written by `bench/python/costs.py`: isopach {isopach}, CPython {python}, NumPy {numpy}, {system}, {cores} cores, on a machine
with other work. Shares and counts carry over to other machines, seconds do not.

| asked | wanted | found |
|---|---|---|
"""


def _points(n):
    return f"{int(n):,}".replace(",", " ")


def _yes(holds):
    return "" if holds else " **missed**"


def _overhead(found):
    for n, row in found["points"].items():
        large = int(n) >= 1_000_000
        yield (f"processor time of `compare` of two ({_points(n)}, 3) arrays beyond that of the function of C++",
               "at most 3 %" if large else "–", f"{100 * row['share']:+.1f} % of {row['seconds']:.2f} s; calls of C++ differ by "
               f"{100 * row['spread']:.0f} % among themselves{_yes(not large or row['share'] <= 0.03)}")


def _copies(found):
    for title, share in found["shares"].items():
        copied = "float32" in title
        yield (f"memory for a scan of {title}, over its points as doubles", "1, one copy" if copied else "0, no copy",
               f"{max(share, 0.0):.3f}{_yes(abs(share - copied) < 0.05)}")


def _interrupt(found):
    waits = found["waits"]
    holds = max(waits) <= 0.3 and found["next_right"] >= len(waits)
    yield (f"from SIGINT to KeyboardInterrupt, at {len(waits)} random times of a comparison of {_points(found['points'])} + "
           f"{_points(found['points'])} points ({found['whole']:.0f} s)", "0.3 s each time, the next call works",
           f"median {waits[len(waits) // 2]:.3f} s, most {waits[-1]:.3f} s{_yes(holds)}")


def _growth(found):
    yield (f"growth of memory over {_points(found['calls'])} calls on 1000 points", "none",
           f"{found['kB'] / 1000:.1f} MB on {found['before_kB'] / 1000:.0f} MB{_yes(found['kB'] < 2000)}")


def _two_at_once(found):
    yield (f"two Python threads at once, `threads=1` each, {_points(found['points'])} + {_points(found['points'])} points: time "
           "over that of one after the other", "0.5 on two cores, the same results",
           f"{found['wall']:.2f}, the best of {found['repeats']}, with {found['cores']:.2f} cores to be had meanwhile; "
           f"{'the same results' if found['equal'] else 'other results **missed**'}")


def _same(found):
    holds = found["equal"] == found["cases"] >= 25 and not found["failed"]
    yield (f"option sets, over {', '.join(found['verbs'])}: JSON less timing, and every file written, identical between "
           "command line and Python", "25", f"{found['equal']} of {found['cases']}{_yes(holds)}")


def _fuzz(found):
    if "examples" not in found:
        yield "wrong and strange arguments at random, by hypothesis", "one clear line each", "failed **missed**"
        return
    yield (f"wrong and strange arguments at random, by hypothesis, for {found['seconds'] / 60:.0f} minutes",
           "one clear line each, no crash",
           f"{_points(found['examples'])} calls: {_points(found['refused'])} refused in one line, {_points(found['done'])} done")


def written(counts):
    """The page of what was measured so far, in the order of the sections."""
    rows = []
    for name, rows_of in (("overhead", _overhead), ("copies", _copies), ("interrupt", _interrupt), ("growth", _growth),
                          ("two_at_once", _two_at_once), ("same", _same), ("fuzz", _fuzz)):
        if name in counts:
            rows += ["| " + " | ".join(row) + " |\n" for row in rows_of(counts[name])]
    return HEAD.format(**counts["machine"]) + "".join(rows) + TAIL


TAIL = """
- **The function of C++** is `isopach::compare` with the same arrays, called by `bench/python/call.cpp` and timed from outside, in turns with
  Python; medians of both. What the module adds is the conversion of arguments, the thread of the run, the hint at a matching, and the writing
  and reading of its JSON.
- **Memory** is the peak of the process. A float64 array is used where it lies, whatever its order and strides.
- **Ctrl-C** is looked for 50 times a second; what is left is how soon the stage that runs looks whether it is to end.
- **Option sets** are those of `tests/python/same_test.py`, which CI runs. Command line and module are linked with the same functions of C++,
  `isopach-verbs`.
- **Arguments at random** are those of `tests/python/fuzz_test.py`: arrays of every type, order, stride and shape, options of every verb with values
  of every kind, methods of results. CI runs the first few hundred of them.
"""
