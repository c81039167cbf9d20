#!/usr/bin/env python3
"""What becomes of files, results and exit codes when something fails: faults, kills, signals, limits, broken input; writes a page.

    python3 -B bench/reliability.py --isopach build/release/bin/isopach --faults build/release/bin/libisopach-faults.so
        [--page docs/evidence/reliability.md] [--only SECTIONS] [--size N] [--jobs N] [--minutes M] [--counts FILE] [--no-run]
        [--valgrind] [--short]

FAULTS is the library of tests/faults. Every trial follows from its number: a command that is printed fails again. Exits 1
if something was against the contract. --short takes a fixed sample of a few hundred trials, in half a minute, and writes
no page. Standard library only; where strace is, kills before every call of the kernel are tried as well.
"""

import argparse
import concurrent.futures
import datetime
import json
import os
import pathlib
import queue
import random
import shutil
import subprocess
import sys
import tempfile
import time

from trials import cases, ends, injections, memory_check, mutants, page, streams, tally

ROOT = pathlib.Path(__file__).resolve().parents[1]
SECTIONS = ["faults", "kills", "signals", "limits", "two runs", "streams", "broken files", "same bits"]
FAST = {"compare", "distance", "info", "simulate", "convert", "match"}


def arguments():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--isopach", required=True, help="the program under test")
    parser.add_argument("--faults", required=True, help="the library of tests/faults")
    parser.add_argument("--page", type=pathlib.Path, help="the page to write, e.g. docs/evidence/reliability.md")
    parser.add_argument("--only", default=",".join(SECTIONS), help="sections, by commas: %(default)s")
    parser.add_argument("--size", type=int, default=100, metavar="N", help="calls of each kind that fail in a case (default %(default)s)")
    parser.add_argument("--jobs", type=int, default=1, help="trials at a time")
    parser.add_argument("--minutes", type=float, default=1e6, help="no trial begins after so many minutes")
    parser.add_argument("--valgrind", action="store_true", help="also one run of every case under valgrind")
    parser.add_argument("--short", action="store_true", help="a fixed sample, in half a minute")
    parser.add_argument("--counts", type=pathlib.Path, help="keep the counts in this file; the page is of all that it holds")
    parser.add_argument("--no-run", action="store_true", help="only the page of the counts that are kept")
    told = parser.parse_args()
    for name in ("isopach", "faults"):
        path = pathlib.Path(getattr(told, name)).resolve()
        if not path.is_file():
            parser.error(f"--{name} {path}: no such file")
        setattr(told, name, str(path))
    return told


def called(sandbox, trial):
    """A trial is a function and what it takes; the sandbox is the argument before the case."""
    work, *given = trial
    at = next(i for i, value in enumerate(given) if isinstance(value, cases.Case))
    work(*given[:at], sandbox, *given[at:])


class Study:
    def __init__(self, told, folder):
        self.told, self.folder = told, pathlib.Path(folder)
        self.tally = tally.Tally()
        self.inputs = self.folder / "inputs"
        cases.made_inputs(told.isopach, self.inputs)
        mutants.make_inputs(self.inputs)
        self.boxes = queue.Queue()
        self.box = cases.Sandbox(told.isopach, self.folder / "first", self.inputs)
        for k in range(told.jobs):
            self.boxes.put(cases.Sandbox(told.isopach, self.folder / f"box{k}", self.inputs))
        chosen = [c for c in cases.all_cases() if not told.short or c.share >= 1]
        self.cases = chosen[::2] if told.short else chosen
        self.injector = injections.Injector(told.faults, told.isopach, self.tally)
        self.size = 3 if told.short else told.size
        self.end = time.monotonic() + 60 * told.minutes
        self.each(self.cases, lambda sandbox, case: cases.measure(sandbox, case, self.injector))

    def each(self, trials, work):
        """`work(sandbox, trial)` for every trial, in an order of chance, --jobs at a time, until time is up."""
        trials = random.Random(0).sample(trials, len(trials))

        def one(trial):
            sandbox = self.boxes.get()
            try:
                if time.monotonic() < self.end:
                    work(sandbox, trial)
            finally:
                self.boxes.put(sandbox)

        with concurrent.futures.ThreadPoolExecutor(self.told.jobs) as pool:
            for done in [pool.submit(one, trial) for trial in trials]:
                done.result()

    def few(self, case, most, least=2):
        return max(least, round(most * self.size / 100 * case.share))

    def faults(self):
        trials = injections.plan(self.cases, self.size)
        self.each(trials, lambda sandbox, trial: self.injector.fault(sandbox, *trial))

    def shares(self, case, count, most):
        """`count` numbers from 0 to `most`, by chance, the same in every study."""
        rng = random.Random(case.shown())
        return [rng.uniform(0, most) for _ in range(count)]

    def kills(self):
        trials, tally = [], self.tally
        for case in (c for c in self.cases if c.has_folder or c.target):
            trials += [(ends.kill_before_call, self.injector, case, kind, number) for kind in ("step", "open", "close", "stat", "list")
                       for number in injections.sampled(case.calls[kind], self.few(case, 40))]
            trials += [(ends.kill_at_random, case, tally, share) for share in self.shares(case, self.few(case, 40), 1.1)]
            if case.verb in ("compare", "convert") and case.share >= 1:
                trials += [(ends.kill_before_system_call, case, tally, call)
                           for call in ends.last_system_calls(self.box, case, self.few(case, 150))]
        self.each(trials, called)

    def signals(self):
        trials = [(ends.signal_at_random, case, self.tally, number, share) for case in self.cases
                  for number, share in enumerate(self.shares(case, self.few(case, 60, 5), 1.05))]
        self.each(trials, called)

    def limits(self):
        trials = []
        for case in self.cases:
            count = self.few(case, 40)
            if case.has_folder or case.target:
                trials += [(ends.file_limit, case, self.tally, 1.3 * i / count) for i in range(count)]
            trials += [(ends.memory_limit, case, self.tally, 400_000_000 * (i + 1) // count) for i in range(count)]
        self.each(trials, called)

    def two_runs(self):
        self.each([self.cases[0]], lambda sandbox, case: ends.two_runs(sandbox, case, self.tally, self.few(case, 100)))

    def streams(self):
        def work(sandbox, case):
            streams.closed_streams(sandbox, case, self.tally)
            streams.full_streams(sandbox, case, self.tally)
            streams.readers_that_leave(sandbox, case, self.tally)
        self.each([c for c in self.cases if c.verb in FAST or not self.told.short], work)
        streams.pipes(self.box, self.tally, ["a.xyz", "a.ply", "a.las", "a.laz", "a.pcd", "cube.obj", "cube.stl", "grid.asc"])

    def broken_files(self):
        count = 4 if self.told.short else self.size
        trials = [t for t in mutants.plan(count) if not self.told.short or t[1].split()[0] in FAST and t[0] not in mutants.GDAL]
        self.each(trials, lambda sandbox, trial: mutants.try_mutant(sandbox, self.tally, *trial))

    def same_bits(self):
        self.each(self.cases, lambda sandbox, case: streams.same_bits(sandbox, case, self.tally))
        lines = ["compare a.xyz b.xyz --surface both", "distance a.xyz b.xyz", "match hill_a.xyz hill_b.xyz --pose-only",
                 "roughness hill_a.xyz"]
        streams.same_in_any_order(self.box, self.tally, lines[:2] if self.told.short else lines)

    def run(self):
        for section in filter(None, self.told.only.split(",")):
            begin = time.monotonic()
            getattr(self, section.replace(" ", "_"))()
            merged(self.told, self.tally)
            print(f"{section}: {self.tally.count(section)} trials in {time.monotonic() - begin:.0f} s", flush=True)
        if self.told.valgrind and shutil.which("valgrind") is None:
            raise SystemExit("--valgrind: valgrind is not here")
        if self.told.valgrind:
            self.each(self.cases, lambda sandbox, case: memory_check.under_valgrind(sandbox, case, self.tally))
            print(f"valgrind: {self.tally.count('valgrind')} runs", flush=True)


def merged(told, found):
    """The counts of this run beside those that the file of counts keeps of other sections."""
    kept = json.loads(told.counts.read_text()) if told.counts and told.counts.exists() else {"rows": [], "measured": {}}
    mine = {section for section, _, _ in found.rows}
    rows = [r for r in kept["rows"] if r[0] not in mine] + [[*key, dict(row)] for key, row in found.rows.items()]
    held = [o for o in kept.get("offences", []) if o[0] not in mine] + [list(o) for o in found.offences]
    counts = {"rows": rows, "measured": {**kept["measured"], **found.measured}, "offences": held}
    if told.counts:
        told.counts.write_text(json.dumps(counts, indent=1))
    return counts


def main():
    told = arguments()
    begin, found = time.monotonic(), tally.Tally()
    if not told.no_run:
        with tempfile.TemporaryDirectory(prefix="reliability-") as folder:
            study = Study(told, folder)
            study.run()
        found = study.tally
    counts = merged(told, found)
    total = sum(sum(row.values()) for row in found.rows.values())
    print(f"{total} trials in {time.monotonic() - begin:.0f} s, {len(found.offences)} against the contract")
    if told.page:
        version = subprocess.run([told.isopach, "--version"], capture_output=True, text=True).stdout.split()[-1]
        told.page.write_text(page.written(counts, version, os.uname()))
    return 1 if found.offences else 0


if __name__ == "__main__":
    sys.exit(main())
