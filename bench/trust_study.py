#!/usr/bin/env python3
"""How often `isopach match` is wrong with exit 0: pairs of scans with known poses, many starts of each; writes a page.

    python3 -B bench/trust_study.py --isopach build/release/bin/isopach [--old PROGRAM] [--data DIR] [--jobs N]
        [--starts N] [--only WORDS] [--page FILE] [--case PAIR:START --out DIR]

Makes a virtual environment with numpy and scipy in build/trust, keeps the scans in build/trust/scans and every run in
build/trust/runs.jsonl: a study that was interrupted goes on where it was. Results of another build of the program are
kept apart. `--old` runs an earlier program from the same starts and sets it beside. `--case` writes the two scans, the
true pose and the command of one start, for a closer look. Every start follows from the name of its pair.
"""

import argparse
import pathlib
import sys
import tempfile

from trust import environment

if __name__ == "__main__":
    environment.enter()

import numpy as np

from trust import page, pairs, runs, starts


def arguments():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--isopach", help="the program under test")
    parser.add_argument("--old", help="an earlier program, from the same starts")
    parser.add_argument("--data", default=environment.ROOT.parent / "shared" / "data", type=pathlib.Path)
    parser.add_argument("--jobs", type=int, default=1, help="runs at a time")
    parser.add_argument("--starts", type=int, default=starts.STARTS, metavar="N", help="of each pair, the first N of %(default)s")
    parser.add_argument("--only", help="pairs whose name or group contains one of these, by commas")
    parser.add_argument("--page", type=pathlib.Path, default=environment.ROOT / "docs" / "evidence" / "trust-study.md")
    parser.add_argument("--no-run", action="store_true", help="only the page of what was run")
    parser.add_argument("--case", help="PAIR:START, e.g. 'quarry, scanned twice:3'")
    parser.add_argument("--out", type=pathlib.Path, help="folder for the files of --case")
    told = parser.parse_args()
    if not (told.isopach or told.old):
        parser.error("--isopach or --old is needed")
    return told


def chosen_pairs(told):
    found = []
    for pair in pairs.all_pairs():
        missing = [folder for folder in pair.needs if not (told.data / folder).is_dir()]
        if missing:
            print(f"{pair.name}: left out, no {', '.join(missing)} in the data", file=sys.stderr)
        elif is_asked(told.only, pair.name, pair.group):
            found.append(pair)
    return found


def write_case(told, source, cache):
    name, index = told.case.rsplit(":", 1)
    pair = next(p for p in pairs.all_pairs() if p.name == name)
    start = starts.starts_of(pair)[int(index)]
    moving, fixed, truth, common = starts.scans_of(pair, start, *runs.kept_scans(pair, source, cache))
    told.out.mkdir(parents=True, exist_ok=True)
    starts.write_ply(told.out / "moving.ply", moving)
    starts.write_ply(told.out / "fixed.ply", fixed)
    np.savetxt(told.out / "truth.txt", truth, fmt="%.17g")
    words = " ".join(map(str, runs.command(start.objective)))
    print(f"{pair.kind}; {100 * common:.0f} % in common; truth in truth.txt\nisopach match moving.ply fixed.ply {words}")


def is_asked(only, pair, group):
    return not only or any(word in pair or word in group for word in only.split(","))


def main():
    told = arguments()
    home = environment.HOME
    cache, results = home / "scans", home / "runs.jsonl"
    cache.mkdir(parents=True, exist_ok=True)
    programs = [runs.Program(label, binary) for label, binary in (("new", told.isopach), ("old", told.old)) if binary]
    with tempfile.TemporaryDirectory() as folder:
        source = pairs.Source(programs[0], told.data, pathlib.Path(folder))
        if told.case:
            return write_case(told, source, cache)
        count = told.starts
        if not told.no_run:
            runs.study(programs, chosen_pairs(told), source, cache, results, count, told.jobs,
                       lambda text: print(text, flush=True))
    known = {(p.label, p.digest) for p in programs}
    rows = [r for r in runs.read_rows(results) if (r["program"], r["digest"]) in known and r["start"] < count]
    rows = [r for r in rows if is_asked(told.only, r["pair"], r["group"])]
    new, old = ([r for r in rows if r["program"] == label] for label in ("new", "old"))
    told.page.write_text(page.written(new or old, old if new else [], pairs.POINTS, runs.LONGEST,
                                      "now" if new else "before"))
    print(f"{told.page.name}: {len(rows)} runs")


if __name__ == "__main__":
    main()
