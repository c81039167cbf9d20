"""Runs of the program, kept in a file of JSON lines so that a study that was interrupted goes on."""

import concurrent.futures
import hashlib
import json
import os
import pathlib
import resource
import subprocess
import tempfile
import threading

import numpy as np

from trust import geometry, starts

LONGEST = 120  # CPU seconds of a run


class Program:
    def __init__(self, label, binary):
        self.label, self.binary = label, str(pathlib.Path(binary).resolve())
        self.digest = hashlib.sha256(pathlib.Path(self.binary).read_bytes()).hexdigest()[:12]

    def __call__(self, *words):
        run = subprocess.run([self.binary, *map(str, words)], capture_output=True, text=True)
        if run.returncode != 0:
            raise RuntimeError(f"{' '.join(map(str, words))}: {run.stderr.strip()}")

    def timed(self, *words):
        """Exit code, output, what it said of failures, CPU seconds. A run that takes too long is ended: code below 0."""
        with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as said:
            process = subprocess.Popen([self.binary, *map(str, words)], stdout=out, stderr=said, preexec_fn=limited)
            _, status, used = os.wait4(process.pid, 0)
            process.returncode = os.waitstatus_to_exitcode(status)
            for file in (out, said):
                file.seek(0)
            return process.returncode, out.read().decode(), said.read().decode(), used.ru_utime + used.ru_stime


def limited():
    resource.setrlimit(resource.RLIMIT_CPU, (LONGEST, LONGEST))


def command(objective):
    return ["--objective", objective, "--pose-only", "--threads", 1]


def judged(program, pair, start, moving, fixed, folder):
    """One run: what it ended with, what it said and how far off it was."""
    scan, model, truth, common = starts.scans_of(pair, start, moving, fixed)
    starts.write_ply(folder / "moving.ply", scan)
    starts.write_ply(folder / "fixed.ply", model)
    code, out, said, seconds = program.timed("match", folder / "moving.ply", folder / "fixed.ply", "--json", "-",
                                             *command(start.objective))
    row = {"program": program.label, "digest": program.digest, "pair": pair.name, "start": start.index,
           "group": pair.group, "kind": pair.kind, "flat": pair.flat, "objective": start.objective,
           "turn": round(start.turn, 2), "vertical": start.vertical, "shift": round(start.shift, 4),
           "share": start.share, "common": round(common, 4), "good": start.good, "code": code,
           "seconds": round(seconds, 3), "class": "none", "grade": None}
    try:
        told = json.loads(out)
    except ValueError:
        row["said"] = said.strip().replace(str(folder), "")[:300]
        return row
    if told.get("pose"):
        degrees, share = geometry.error(np.array(told["pose"]["matrix"]), truth, scan)
        row.update({"degrees": round(degrees, 4), "off": round(share, 5)})
        row["class"] = "wrong" if pair.kind == "other" else geometry.class_of(degrees, share)
    verdict = told.get("verdict")
    if verdict:
        row["grade"] = verdict.get("grade")
        row["verdict"] = {k: v for k, v in verdict.items() if isinstance(v, (int, float, str, list)) and k != "map"}
    return row


def kept_scans(pair, source, cache):
    """The scans of a pair, made once."""
    place = cache / (pair.name.replace(" ", "-").replace(",", "") + ".npz")
    if place.exists():
        with np.load(place) as file:
            return file["moving"], file["fixed"]
    moving, fixed = pair.make(source, pair.random())
    np.savez(place, moving=moving, fixed=fixed)
    return np.asarray(moving), np.asarray(fixed)


def read_rows(path):
    if not path.exists():
        return []
    rows = []
    for line in path.read_text().splitlines():
        try:
            rows.append(json.loads(line))
        except ValueError:
            pass  # the line during which an earlier run was interrupted
    return rows


def study(programs, pairs, source, cache, results, count, jobs, say):
    """Runs what is not in `results` yet. `count`: starts of a pair."""
    done = {(r["program"], r["digest"], r["pair"], r["start"]) for r in read_rows(results)}
    lock = threading.Lock()

    def run(pair, start, moving, fixed):
        with tempfile.TemporaryDirectory() as name:
            for program in programs:
                if (program.label, program.digest, pair.name, start.index) not in done:
                    row = judged(program, pair, start, moving, fixed, pathlib.Path(name))
                    with lock, results.open("a") as file:
                        file.write(json.dumps(row) + "\n")

    if results.exists() and not results.read_bytes().endswith(b"\n"):
        with results.open("a") as file:
            file.write("\n")
    with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
        for pair in pairs:
            moving, fixed = kept_scans(pair, source, cache)
            waiting = [pool.submit(run, pair, s, moving, fixed) for s in starts.starts_of(pair)[:count]]
            for future in waiting:
                future.result()
            say(f"{pair.name}: {len(moving)} on {len(fixed)} points, {len(waiting)} starts")
