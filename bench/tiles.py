#!/usr/bin/env python3
"""Comparisons in tiles against the same in memory: equal results, time of each step, memory, what is passed up; writes a page.

    python3 -B bench/tiles.py --isopach build/release/bin/isopach [--page docs/evidence/tiles.md] [--counts FILE]
        [--sizes 1000000,4000000,10000000] [--large 100000000] [--memory 4G] [--room DIR]

Two flights over the simulated hillside. Times are CPU seconds, user and system, of the whole process on all threads, so that
other work on the machine matters little; memory is the largest resident size that the kernel reports. `--large 0` leaves
the large one out; it needs 130 bytes of disk a point in --room.
"""

import argparse
import json
import os
import pathlib
import shutil
import struct
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parents[1]


def run(words, **options):
    """CPU seconds, wall seconds, largest resident size in bytes, and what was printed."""
    begin = time.perf_counter()
    process = subprocess.Popen([str(w) for w in words], stdout=subprocess.PIPE, text=True, **options)
    printed = process.stdout.read()
    _, status, used = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode != 0:
        sys.exit(f"{' '.join(map(str, words))}: exit {process.returncode}")
    return {"cpu": used.ru_utime + used.ru_stime, "wall": time.perf_counter() - begin, "peak": used.ru_maxrss * 1024}, printed


def told(text):
    result = json.loads(text)
    result.pop("timing_s"), result.pop("outputs")
    result["localisation"] = {}
    return result


def size_of(folder, ending):
    return sum(file.stat().st_size for file in folder.rglob("*" + ending))


class Bench:
    def __init__(self, told_arguments, room):
        self.isopach, self.room, self.memory = told_arguments.isopach, room, told_arguments.memory

    def scans(self, points):
        folder = self.room / f"scans-{points}"
        if not (folder / "truth.json").exists():
            run([self.isopach, "simulate", "terrain", "--points", points, "-o", folder, "--quiet"])
        return [folder / "a.ply", folder / "b.ply"]

    def steps(self, scans, *limits):
        job = self.room / "job"
        shutil.rmtree(job, ignore_errors=True)
        found = {}
        found["plan"], _ = run([self.isopach, "tile", "plan", *scans, "-o", job, "--quiet", *limits])
        found["run"], _ = run([self.isopach, "tile", "run", job, "--quiet"])
        found["reduce"], text = run([self.isopach, "tile", "reduce", job, "--json", "-", "--quiet"])
        status = json.loads(run([self.isopach, "tile", "status", job, "--json", "-", "--quiet"])[1])
        found |= {"tiles": status["tiles"], "points": status["points"], "largest": max(t["points"] for t in status["each"]),
                  "spilled": (job / "points").stat().st_size, "passed_up": size_of(job, ".part"),
                  "cells": size_of(job, ".cells")}
        shutil.rmtree(job)
        return found, told(text)

    def size(self, points):
        scans = self.scans(points)
        whole, text = run([self.isopach, "compare", *scans, "--json", "-", "--quiet"])
        rows = []
        for share in (4, 16, 64):
            found, result = self.steps(scans, "--tile-points", 2 * points // share)
            rows.append(found | {"equal": result == told(text)})
            print(f"{points}: {rows[-1]}", file=sys.stderr)
        return {"points": points, "whole": whole, "rows": rows}

    def large(self, points):
        scans = self.scans(points)
        temporary = self.room / "temporary"
        temporary.mkdir(exist_ok=True)
        found, text = run([self.isopach, "compare", *scans, "--json", "-", "--quiet", "--max-memory", self.memory],
                          env=os.environ | {"TMPDIR": str(temporary)})
        result = json.loads(text)
        steps, again = self.steps(scans, "--max-memory", self.memory)
        return {"points": points, "memory": self.memory, "found": found, "steps": steps, "equal": again == told(text),
                "coverage": result["domain"]["coverage"], "net": result["volume"]["net"],
                "truth": json.loads((scans[0].parent / "truth.json").read_text())}


def gib(count):
    return f"{count / 2**30:.2f}"


def table(head, rows):
    lines = ["| " + " | ".join(head) + " |", "|" + "--:|" * len(head)]
    return "\n".join(lines + ["| " + " | ".join(map(str, row)) + " |" for row in rows])


def spaced(number):
    return f"{number:,}".replace(",", " ")


def page(found):
    parts = ["""# Tiles

Written by `bench/tiles.py`; do not edit. Two flights over the simulated hillside, binary PLY. Times are CPU seconds, user
and system, of whole processes on two threads; memory is the largest resident size. In memory: `isopach compare`; in tiles:
`tile plan`, `tile run`, `tile reduce` ([how](../method/tiles.md), [use](../use/tiles.md)). Equal: `result.json` of both, less the timing and
`localisation`, which counts the work of one way of doing it.

## The same bits, and what they cost
"""]
    rows = []
    for size in found["sizes"]:
        whole = size["whole"]
        rows.append([spaced(2 * size["points"]), "in memory", "", "", "", f"{whole['cpu']:.1f}", "1", gib(whole["peak"]), "", ""])
        for row in size["rows"]:
            cpu = sum(row[step]["cpu"] for step in ("plan", "run", "reduce"))
            rows.append(["", row["tiles"]] + [f"{row[step]['cpu']:.1f}" for step in ("plan", "run", "reduce")] +
                        [f"{cpu:.1f}", f"{cpu / whole['cpu']:.2f}",
                         " / ".join(gib(row[step]["peak"]) for step in ("plan", "run", "reduce")),
                         f"{100 * row['passed_up'] / row['cells']:.1f} %", "yes" if row["equal"] else "**NO**"])
    parts.append(table(["points", "tiles", "plan s", "run s", "reduce s", "all s", "of in memory", "peak GiB, each step",
                        "passed up, of the cells' bytes", "equal"], rows))
    if found.get("large"):
        large = found["large"]
        steps = large["steps"]
        base = found["sizes"][-1]
        per_point = large["found"]["cpu"] / (2 * large["points"]) / (base["whole"]["cpu"] / (2 * base["points"]))
        alls = sum(steps[s]["cpu"] for s in ("plan", "run", "reduce"))
        peak = max(large["found"]["peak"], *(steps[s]["peak"] for s in ("plan", "run", "reduce")))
        share = (steps["plan"]["cpu"] + steps["reduce"]["cpu"]) / alls
        limit = float(large["memory"][:-1]) * 1e9
        parts.append(f"""
## Beyond memory

{spaced(large['points'])} + {spaced(large['points'])} points, `compare --max-memory {large['memory']}`: {large['found']['cpu']:.0f} s of CPU, {large['found']['wall']:.0f} s by the clock,
{steps['tiles']} tiles of at most {spaced(steps['largest'])} points. The same in three steps: {'equal' if large['equal'] else '**NOT EQUAL**'}.

""" + table(["what", "found", "asked"], [
            ["largest resident size, GiB", f"{peak / 2**30:.2f}{' (not reached)' if peak > limit else ''}", f"{limit / 2**30:.2f}"],
            ["time a point, of that in memory at " + spaced(2 * base["points"]), f"{per_point:.2f}{' (not reached)' if per_point > 1.5 else ''}", "1.5"],
            ["plan and reduce, of all", f"{100 * share:.0f} %{' (not reached)' if share > 0.1 else ''}", "10 %"],
            ["plan, run, reduce, s of CPU", " / ".join(f"{steps[s]['cpu']:.0f}" for s in ("plan", "run", "reduce")), ""],
            ["disk: points, final cells, passed up, GiB", " / ".join(gib(steps[k]) for k in ("spilled", "cells", "passed_up")), ""],
            ["net volume, m³; true", f"{large['net']:.0f}; {large['truth']['net']:.0f}" if "net" in large["truth"] else f"{large['net']:.0f}", ""]]))
        parts.append(model(large))
    return "\n".join(parts) + "\n"


def model(large):
    """What the measured constants say of a country."""
    steps, points = large["steps"], 2 * large["points"]
    total, workers, memory = 1e11, 100, 8e9
    run_s = steps["run"]["cpu"] / points
    tile = (memory - 1.5e8) / 420
    tiles = total / tile
    # What goes up grows as the rim of a tile: the square root of its points.
    up = steps["passed_up"] / steps["tiles"] / (points / steps["tiles"]) ** 0.5 * tile ** 0.5
    reduce_s = steps["reduce"]["cpu"] / points * total
    return f"""
## A model of 10¹¹ points on 100 workers

Not run: from the constants above. Workers of two threads and 8 GB take tiles of {tile / 1e6:.0f} million points, so there are {tiles:.0f}. All tiles take {run_s * total / 3600:.0f} hours
of CPU, {run_s * total / 3600 / workers / 2:.1f} hours by the clock on {workers} workers of two threads. Each passes up about {up / 1e6:.0f} MB, all together {up * tiles / 1e9:.0f} GB, of which the join needs about
{up * tiles * 3 / 1e9:.0f} GB of memory. Plan reads the points twice, on one machine: {steps['plan']['cpu'] / points * total / 3600:.0f} hours. Reduce looks at all final cells three times, on one machine:
{reduce_s / 3600:.0f} hours of CPU. **What breaks first**: `reduce`, then `plan`, which are one process each. The sums over final cells can be made by the workers in a second round, and the
join can go up a tree of squares; neither is built.
"""


def nodes_passed_up(file):
    """Of a part (tiles/part_bytes.cpp): the square and the places of its nodes."""
    data = file.read_bytes()
    words = struct.unpack_from("<Q", data, 8)[0]
    at = 16 + (words + 7) // 8 * 8
    square = struct.unpack_from("<4d", data, at)
    count = struct.unpack_from("<Q", data, at + 32)[0]
    return square, [struct.unpack_from("<2d", data, at + 40 + 16 * i) for i in range(count)]


def picture(asked, room):
    """The squares of a small job, and the nodes of A that they pass up."""
    run([asked.isopach, "simulate", "terrain", "--points", 14000, "-o", room / "small", "--quiet"])
    job = room / "small-job"
    run([asked.isopach, "tile", "plan", room / "small/a.ply", room / "small/b.ply", "-o", job, "--tile-points", 3500, "--no-layer-check",
         "--border", "hull", "--quiet"])
    run([asked.isopach, "tile", "run", job, "--quiet"])
    box = json.loads((job / "manifest.json").read_text())["frame"]["box"]
    (x0, y0, _), (x1, y1, _) = box
    scale = 640 / max(x1 - x0, y1 - y0)
    size = [round((x1 - x0) * scale) + 20, round((y1 - y0) * scale) + 20]
    lines, dots = [], []
    for file in sorted((job / "tiles").glob("*.part")):
        square, nodes = nodes_passed_up(file)
        low = [max(square[0], x0), max(square[1], y0)]
        high = [min(square[2], x1), min(square[3], y1)]
        lines.append(f'<rect x="{10 + (low[0] - x0) * scale:.1f}" y="{10 + (y1 - high[1]) * scale:.1f}" '
                     f'width="{(high[0] - low[0]) * scale:.1f}" height="{(high[1] - low[1]) * scale:.1f}"/>')
        dots += [f"M{10 + (x - x0) * scale:.1f} {10 + (y1 - y) * scale:.1f}h0" for x, y in nodes]
    asked.picture.write_text(
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {size[0]} {size[1]}" width="{size[0]}" height="{size[1]}" role="img">\n'
        "<title>Squares of a quadtree, and points along their sides</title>\n"
        '<rect width="100%" height="100%" fill="#ffffff"/>\n<g fill="#eef3f8" stroke="#33506b" stroke-width="1">\n'
        + "\n".join(lines) + f'\n</g>\n<path d="{"".join(dots)}" stroke="#b2182b" stroke-width="2.2" stroke-linecap="round"/>\n</svg>\n')


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--isopach", default=ROOT / "build/release/bin/isopach", type=pathlib.Path)
    parser.add_argument("--sizes", default="1000000,4000000,10000000", help="points of each scan, by commas")
    parser.add_argument("--large", type=int, default=100_000_000, metavar="N")
    parser.add_argument("--memory", default="4G")
    parser.add_argument("--room", type=pathlib.Path, help="a folder for scans and jobs; by default one that is removed")
    parser.add_argument("--counts", type=pathlib.Path, help="keep the results in this file; what it holds is not run again")
    parser.add_argument("--page", type=pathlib.Path)
    parser.add_argument("--picture", type=pathlib.Path, help="docs/use/tiles.svg; nothing else is done")
    return parser.parse_args()


def main():
    asked = arguments()
    asked.isopach = asked.isopach.resolve()
    found = json.loads(asked.counts.read_text()) if asked.counts and asked.counts.exists() else {}
    with tempfile.TemporaryDirectory() as passing:
        room = asked.room or pathlib.Path(passing)
        room.mkdir(parents=True, exist_ok=True)
        if asked.picture:
            return picture(asked, room)
        bench = Bench(asked, room)

        def keep():
            if asked.counts:
                asked.counts.write_text(json.dumps(found, indent=1))

        for points in map(int, asked.sizes.split(",")):
            if points not in [size["points"] for size in found.setdefault("sizes", [])]:
                found["sizes"].append(bench.size(points))
                keep()
        if asked.large and not found.get("large"):
            found["large"] = bench.large(asked.large)
            keep()
    text = page(found)
    if asked.page:
        asked.page.write_text(text)
    else:
        print(text)
    return None


if __name__ == "__main__":
    main()
