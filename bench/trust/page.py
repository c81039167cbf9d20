"""The page of the study: docs/evidence/trust-study.md."""

import collections
import statistics

from scipy.stats import beta

BANDS = [(0.6, 1.01, "60–100 %"), (0.3, 0.6, "30–60 %"), (0.1, 0.3, "10–30 %"), (-1, 0.1, "0–10 %")]
KINDS = {"rigid": "one surface, scanned twice", "changed": "changed between the scans", "hard": "badly scanned",
         "repeats": "symmetric, or repeats itself", "other": "no pose is right"}
TURNS = [(0, 10), (10, 30), (30, 60), (60, 181)]


def upper(failures, count):
    """95 % limit of a share (Clopper, Pearson), for runs that do not depend on each other."""
    return beta.ppf(0.95, failures + 1, count - failures) if failures < count else 1.0


def trusted(rows, kind=None):
    return [r for r in rows if r["code"] == 0 and kind in (None, r["class"])]


def percent(part, whole):
    return f"{100 * part / whole:.1f} %" if whole else "–"


def row_of(name, rows):
    accepted, wrong = trusted(rows), trusted(rows, "wrong")
    refused = [r for r in rows if r["code"] in (4, 5)]
    failed = len(rows) - len(accepted) - len(refused)
    lost = sum(r["class"] == "right" for r in refused)
    return (f"| {name} | {len(rows)} | {len(trusted(rows, 'right'))} | {len(trusted(rows, 'between'))} "
            f"| {len(wrong)} | {len(refused)} | {lost} | {failed} | {percent(len(wrong), len(rows))} |")


HEAD = ["| {} | runs | right | between | **wrong** | refused | of these right | no answer | wrong of all |",
        "|---|---|---|---|---|---|---|---|---|"]


def table(first, parts):
    lines = [HEAD[0].format(first), HEAD[1]]
    return lines + [row_of(name, rows) for name, rows in parts if rows] + [""]


def band_of(row):
    return next(name for low, high, name in BANDS if low <= row["common"] < high)


def by(rows, key, order=None):
    parts = collections.defaultdict(list)
    for r in rows:
        parts[key(r)].append(r)
    return [(name, parts[name]) for name in (order or sorted(parts))]


def decidable(rows):
    return [r for r in rows if r["kind"] in ("rigid", "changed", "hard") and r["common"] >= 0.6]


def aims(rows):
    wrong, open_cases = trusted(rows, "wrong"), decidable(rows)
    right = trusted(open_cases, "right")
    rigid = [r for r in open_cases if r["kind"] == "rigid"]
    near = trusted(rigid, "right") + trusted(rigid, "between")
    return [
        "| aim | reached |", "|---|---|",
        f"| wrong with exit 0: at most 1 % of the runs, better 0.1 % | {len(wrong)} of {len(rows)}: "
        f"{percent(len(wrong), len(rows))} (upper limit at 95 %: {100 * upper(len(wrong), len(rows)):.1f} %) |",
        f"| right with exit 0: 95 % where 60 % or more is in common and nothing repeats | {len(right)} of "
        f"{len(open_cases)}: {percent(len(right), len(open_cases))} |",
        f"| the same, rigid and well scanned alone | {len(trusted(rigid, 'right'))} of {len(rigid)}: "
        f"{percent(len(trusted(rigid, 'right')), len(rigid))}; with those between: {percent(len(near), len(rigid))} |",
        ""]


def times(new, old):
    """Of starts from which both programs end right."""
    before = {(r["pair"], r["start"]): r for r in old}
    pairs = [(r["seconds"], before[r["pair"], r["start"]]["seconds"]) for r in new
             if r["good"] and r["code"] == 0 and r["class"] == "right" and (r["pair"], r["start"]) in before and
             before[r["pair"], r["start"]]["class"] == "right"]
    pairs = [(a, b) for a, b in pairs if b > 0]
    if len(pairs) < 3:
        return []
    ratios = sorted(a / b for a, b in pairs)
    total = sum(a for a, _ in pairs) / sum(b for _, b in pairs)
    return [f"From {len(pairs)} good starts (turn below 10 degrees, shift below 10 % of the extent, right by both programs): "
            f"{total:.2f} times the CPU time of before in all, median of the ratios {statistics.median(ratios):.2f}, "
            f"95th percentile {ratios[int(0.95 * (len(ratios) - 1))]:.2f} (aim: at most 1.25).", ""]


def numbers(row):
    told = row.get("verdict") or {}
    told = {k: min(v) if isinstance(v, list) and v else v for k, v in told.items()}  # detail: of both scans
    words = [f"{k} {told[k]:.2f}" for k in ("agree", "shape", "detail", "slip") if isinstance(told.get(k), (int, float))]
    words += [told["stage"]] if told.get("stage") else []
    return ", ".join(words) or "–"


def failures(rows):
    lines = ["| pair | start | objective | turn, shift of the start | in common | off by | verdict |",
             "|---|---|---|---|---|---|---|"]
    for r in trusted(rows, "wrong"):
        lines.append(f"| {r['pair']} | {r['start']} | {r['objective']} | {r['turn']:.0f}°, {100 * r['shift']:.0f} % | "
                     f"{100 * r['common']:.0f} % | {r['degrees']:.1f}°, {100 * r['off']:.1f} % | {numbers(r)} |")
    return lines + [""] if len(lines) > 2 else ["None.", ""]


def tables(rows):
    bands = [name for _, _, name in BANDS]
    lines = ["### By overlap", "", "Share in common of the scan that has more of it, without the pairs that have no right "
             "pose.", ""]
    lines += table("in common", by([r for r in rows if r["kind"] != "other"], band_of, bands))
    lines += ["### By cause", ""] + table("kind of pair", [(KINDS[k], [r for r in rows if r["kind"] == k]) for k in KINDS])
    lines += ["### By start and objective", ""]
    lines += table("turn of the start", [(f"{a}–{min(b, 180)}°", [r for r in rows if a <= r["turn"] < b])
                                         for a, b in TURNS])
    lines += table("objective", by(rows, lambda r: r["objective"]))
    lines += ["### By group", "", "The limits come from other pairs, but how agreement depends on slip, and shape on "
              "agreement, was set after the first four starts of these pairs had been seen; later starts are new to it.", ""]
    return lines + table("group", by(rows, lambda r: r["group"]))


def grades(rows):
    found = collections.Counter((r["grade"] or "none", r["code"]) for r in rows)
    classes = collections.Counter((r["grade"] or "none", r["code"], r["class"]) for r in rows)
    lines = ["| verdict | exit code | runs | right | between | wrong | no pose |", "|---|---|---|---|---|---|---|"]
    for (grade, code), count in sorted(found.items()):
        cells = " | ".join(str(classes[grade, code, c]) for c in ("right", "between", "wrong", "none"))
        lines.append(f"| {grade} | {code} | {count} | {cells} |")
    return lines + [""]


INTRODUCTION = """# Wrong poses with exit 0: a study

Written by `bench/trust_study.py`: `isopach match` on {pairs} pairs of scans in {groups} groups, {starts} starts at most of
each, {runs} runs. Truth is known by making or given with the data; shared data that is absent is left out.

Starts: turns up to 10, 30, 60 and 180 degrees (6, 6, 5 and 8 of 25), half of them about z, the others about any axis; shifts up
to a tenth of the extent with the first, up to half of it else. Scans are cut by parallel planes so that 100, 80, 60, 40, 20, 10,
5 and 0 % of the area is in common (11, 3, 3, 3, 2, 1, 1 and 1 of 25), times what the views have in common. At most {points} points a
scan; no option but the objective.

*Right*: within 0.5 degrees and 1 % of the extent (the middle of MOVING). *Wrong*: more than 3 degrees or 3 %. *Between*: neither.
In the tables these columns are runs that ended with exit 0. *Refused*: exit 4 or 5, whatever the pose. *No answer*: other
exit codes, and runs that were ended after {longest} s of CPU. Symmetric objects are judged like all others: a pose that fits as well
but is not the true one is wrong.

"""


def written(rows, old, points, longest, name="now"):
    """`rows`: of the program under test, called `name`; `old`: of the one before, or none."""
    pairs, groups = {r["pair"] for r in rows}, {r["group"] for r in rows}
    most = max(collections.Counter(r["pair"] for r in rows).values())
    text = INTRODUCTION.format(pairs=len(pairs), groups=len(groups), starts=most, runs=len(rows), points=points,
                               longest=longest)
    lines = text.splitlines() + ["## Aims", ""] + aims(rows) + times(rows, old)
    lines += ["## In short", ""] + table("", [(name, rows), ("before", same_runs(old, rows))])
    if old:
        lines += ["Before: the program without a verdict, from the same starts where it was run.", ""]
    lines += [f"## {name.capitalize()}", "", "### By verdict", ""] + grades(rows) + tables(rows)
    lines += ["### All that were wrong with exit 0", ""] + failures(rows)
    if old:
        lines += ["## Before", "", "### By overlap", ""]
        lines += table("in common", by([r for r in old if r["kind"] != "other"], band_of, [n for _, _, n in BANDS]))
        lines += ["### By cause", ""] + table("kind of pair", [(KINDS[k], [r for r in old if r["kind"] == k])
                                                               for k in KINDS])
    return "\n".join(lines)


def same_runs(old, rows):
    known = {(r["pair"], r["start"]) for r in rows}
    return [r for r in old if (r["pair"], r["start"]) in known]
