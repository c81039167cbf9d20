#!/usr/bin/env python3
"""How often what the program says of the precision of its poses is true: error divided by stated standard deviation.

    python3 -B bench/pulls.py --isopach build/release/bin/isopach [--kinds full,mound] [--count N] [--jobs N] [--page FILE]

Poses of `match`, symmetry planes of `asymmetry`, combined parts of `combine`; the scans are made here, not by `isopach
simulate`, surfaces and noise anew in each simulation. Prints a line for each kind; with --page writes docs/evidence/pulls.md.
Makes a virtual environment with numpy and scipy in build/trust.
"""

import argparse
import collections
import concurrent.futures
import pathlib
import tempfile

from trust import environment

if __name__ == "__main__":
    environment.enter()

import numpy as np
from scipy.stats import chi2, kstest

from trust import pull_kinds

KINDS = {**pull_kinds.POSES, **pull_kinds.PLANES, **pull_kinds.PARTS, **pull_kinds.SCALES}
HEAD = ("| scans | simulations | within 1.96, all | least and most of one component | r.m.s. pull | worst | jointly within 95 % | "
        "chi square, mean / freedom | KS, p | nothing stated |\n|---|---|---|---|---|---|---|---|---|---|")


def simulated(simulation, program, count, jobs):
    """`simulation`: of (program, folder, seed), as the pull of a kind."""
    def one(seed):
        with tempfile.TemporaryDirectory() as folder:
            return simulation(program, pathlib.Path(folder), seed)

    with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
        return list(pool.map(one, range(count)))


def line(kind, pulls):
    stated = [p for p in pulls if not p.why]
    silent = ", ".join(f"{n} {why}" for why, n in collections.Counter(p.why for p in pulls if p.why).items()) or "–"
    if len(stated) < 5:
        return f"| {kind.words} | {len(pulls)} | – | – | – | – | – | – | – | {silent} |"
    z = np.array([p.error / p.sigma for p in stated])
    chi, freedom = np.array([p.chi for p in stated]), stated[0].freedom
    within = (np.abs(z) < 1.96).mean(axis=0)
    jointly = (chi < chi2.ppf(0.95, freedom)).mean()
    return (f"| {kind.words} | {len(pulls)} | {100 * within.mean():.1f} % | {100 * within.min():.1f}, "
            f"{100 * within.max():.1f} % | {np.sqrt((z * z).mean()):.2f} | {np.abs(z).max():.1f} | {100 * jointly:.1f} % | "
            f"{chi.mean() / freedom:.2f} | {kstest(chi, chi2(freedom).cdf).pvalue:.2g} | {silent} |")


INTRODUCTION = """# Pulls: error over stated standard deviation

Written by `bench/pulls.py`. Where what is stated is true, the errors of each component divided by its standard deviation have
an r.m.s. of 1 and lie within 1.96 in 95 % of the simulations; squared in the whole covariance they follow chi square with as
many degrees of freedom as there are components. The aim is 93–97 %. With {count} simulations the share of one component
is itself uncertain by {spread:.1f} %, so the least and the most of six stray further. *KS*: probability that chi square would be as far
from its distribution as it is, by chance. *Nothing stated*: the run ended with exit 4 or 5 (refused), covariances
are null (not stated), or some motions were left as they were and have a deviation of 0 (motions held); these are not in the other columns.

"""
SCALE = """## Scale

`isopach match --freedom x,y,z,turn-x,turn-y,turn-z,scale --pose-only`: whether the scale is drawn to one side.

| scans | simulations | refused | mean of scale - 1 | standard error | in standard errors |
|---|---|---|---|---|---|
{row}
"""
CHAPTERS = [
    ("Poses", pull_kinds.POSES, "`isopach match --pose-only` from a start within 1 degree and 2 % of the extent. Hills over a unit "
     "square, r.m.s. height 0.05, wavelengths 1 to 0.2; noise 0.004 along z; 3000 points a scan if nothing else is said. "
     "Components: turns about x, y, z through the centre, shifts along x, y, z."),
    ("Symmetry planes", pull_kinds.PLANES, "`isopach asymmetry --direction z` of an analytic face, 150 by 190 mm, 6000 points, noise 0.15 mm, rolled "
     "and turned by up to 8 degrees. Components: two of the direction, each taken as 1/√2 of the one standard deviation that is "
     "stated, and the offset at the stated point."),
    ("Combined parts", pull_kinds.PARTS, "`isopach combine`: an object of 64 by 40 mm, 2500 points on it, noise 0.05 mm. Components as "
     "of the poses, of the jaw in the face."),
]


def scale_line(kind, program, count, jobs):
    """Mean of scale less 1 and its standard error: samples of a surface must not make it larger or smaller."""
    all_runs = simulated(kind.off, program, count, jobs)
    off = np.array([o for o in all_runs if o is not None])
    error = off.std(ddof=1) / np.sqrt(len(off))
    return (f"| {kind.words} | {len(all_runs)} | {len(all_runs) - len(off)} | {off.mean():.2e} | {error:.2e} | "
            f"{abs(off.mean()) / error:.1f} |")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--isopach", required=True)
    parser.add_argument("--kinds", default=",".join(KINDS), help=f"of {', '.join(KINDS)}")
    parser.add_argument("--count", type=int, default=200, help="simulations of each kind")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--page", type=pathlib.Path)
    told = parser.parse_args()
    program = str(pathlib.Path(told.isopach).resolve())
    wanted = told.kinds.split(",")
    text = INTRODUCTION.format(count=told.count, spread=100 * np.sqrt(0.95 * 0.05 / told.count))
    for title, kinds, words in CHAPTERS:
        chosen = [key for key in kinds if key in wanted]
        if not chosen:
            continue
        print(f"{title}\n{HEAD}")
        text += f"## {title}\n\n{words}\n\n{HEAD}\n"
        for key in chosen:
            row = line(kinds[key], simulated(kinds[key].pull, program, told.count, told.jobs))
            print(row, flush=True)
            text += row + "\n"
            if told.page:
                told.page.write_text(text)
        text += "\n"
    for key in set(pull_kinds.SCALES) & set(wanted):
        row = scale_line(pull_kinds.SCALES[key], program, 2 * told.count, told.jobs)
        print(row)
        text += SCALE.format(row=row)
        if told.page:
            told.page.write_text(text)


if __name__ == "__main__":
    main()
