#!/usr/bin/env python3
"""What Python costs: time and memory beside the library's own, how soon Ctrl-C ends a run, two threads at once; writes a page.

    PYTHONPATH=build/release/python build/venv/bin/python bench/python/costs.py [--page docs/evidence/python.md]
        [--only SECTIONS] [--points 1000000] [--long 10000000] [--interrupts 20] [--calls 10000] [--fuzz SECONDS]
        [--counts FILE]

Prints each section when it is measured. With --counts, results are kept in that file, sections may be measured one by
one, and the page is of all that it holds. `fuzz` is tests/python/fuzz_test.py with other inputs for so many seconds.
"""

import argparse
import json
import os
import pathlib
import platform
import random
import re
import resource
import signal
import subprocess
import sys
import tempfile
import threading
import time
import warnings

import isopach
import numpy as np
import page

ROOT = pathlib.Path(__file__).resolve().parents[2]


def cloud(n, seed, lift=0.0):
    numbers = np.random.default_rng(seed)
    xy = numbers.uniform(0, 1000, (n, 2))
    return np.column_stack([xy, np.sin(xy[:, 0] / 30) * np.cos(xy[:, 1] / 20) + lift])


def overhead(told):
    """Time of a call over that of the function of C++ with the same arrays, less 1; of the processor, which other work on
    the machine hardly changes. Both in turns, so that they meet the same machine."""
    found = {}
    with tempfile.TemporaryDirectory() as folder:
        for n in (told.points // 100, told.points):
            scans = cloud(n, 1), cloud(n, 2, 0.1)
            files = [pathlib.Path(folder, name) for name in ("a.ply", "b.ply")]
            for file, scan in zip(files, scans, strict=True):
                isopach.scan(scan).write(file)
            inside, outside = [], []
            for _ in range(told.repeats):
                run = subprocess.run([told.call, *files, "2"], capture_output=True, text=True, check=True)
                inside.append(float(run.stdout.split()[-2]))  # of the second call of each: the first one warms up
                for _ in range(2):
                    begin = time.process_time()
                    net = isopach.compare(*scans).volume.net
                    used = time.process_time() - begin
                outside.append(used)
                assert net == float(run.stdout.split()[-1])
            found[n] = {"share": float(np.median(outside) / np.median(inside) - 1), "seconds": float(np.median(inside)),
                        "spread": float((max(inside) - min(inside)) / np.median(inside))}
    return {"repeats": told.repeats, "points": found}


COPIES = """
import resource, sys, isopach, numpy as np
n = {n}
numbers = np.random.default_rng(1)
a = {made}
peak = lambda: resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
before = peak()
s = isopach.scan(a)
print(peak() - before, s.points.nbytes)
"""


def copies(told):
    """What a scan of an array adds to the peak of memory, in shares of n x 3 doubles."""
    found = {}
    made = {"float64, C order": "numbers.random((n, 3))", "float64, Fortran order": "numbers.random((3, n)).T",
            "float64, every second row": "numbers.random((2 * n, 3))[::2]",
            "float32": "numbers.random((n, 3), dtype=np.float32)"}  # nothing larger before: the peak would hide a copy
    for title, array in made.items():
        run = subprocess.run([sys.executable, "-c", COPIES.format(n=4 * told.points, made=array)], capture_output=True,
                             text=True, check=True)
        grown, size = map(int, run.stdout.split())
        found[title] = 1024 * grown / size
    return {"points": 4 * told.points, "shares": found}


def interrupt(told):
    """Seconds from the signal to KeyboardInterrupt, and whether the next call gives what it gave before."""
    a, b = cloud(told.long, 1), cloud(told.long, 2, 0.1)
    begin = time.perf_counter()
    isopach.compare(a, b)
    whole = time.perf_counter() - begin
    small = a[:10_000], b[:10_000]
    wanted = isopach.compare(*small).volume
    chosen, waits, right = random.Random(told.seed), [], 0
    while len(waits) < told.interrupts:
        sent = []
        delay = chosen.uniform(0, whole)

        def send(delay=delay, sent=sent):
            time.sleep(delay)
            sent.append(time.perf_counter())
            os.kill(os.getpid(), signal.SIGINT)

        sender = threading.Thread(target=send)
        try:
            sender.start()
            isopach.compare(a, b)
            sender.join()  # the run was quicker this time: the signal comes here
            time.sleep(0.1)
        except KeyboardInterrupt:
            came = time.perf_counter()
            if sender.is_alive():
                sender.join()
            if came - sent[0] < whole:
                waits.append(came - sent[0])
        right += isopach.compare(*small).volume == wanted
    return {"points": told.long, "whole": whole, "waits": sorted(waits), "next_right": right}


def growth(told):
    a, b = cloud(1000, 1), cloud(1000, 2)

    def resident():  # now, not at most: earlier sections took more
        pages = int(pathlib.Path("/proc/self/statm").read_text().split()[1])
        return pages * resource.getpagesize() // 1024

    for _ in range(told.calls // 10):
        isopach.compare(a, b, threads=1).points_a
    before = resident()
    for _ in range(told.calls):
        isopach.compare(a, b, threads=1).points_a
    return {"calls": told.calls, "kB": resident() - before, "before_kB": before}


def two_at_once(told):
    """Time of two runs side by side, a thread each, over that of both one after the other."""
    n = told.points // 2
    a, b = cloud(n, 1), cloud(n, 2, 0.1)
    isopach.compare(a, b, threads=1)
    shares, equal = [], True
    for _ in range(told.repeats):
        begin = time.perf_counter()
        one = [isopach.compare(a, b, threads=1).to_dict() for _ in range(2)]
        serial = time.perf_counter() - begin
        found = [None, None]

        def work(k, found=found):
            found[k] = isopach.compare(a, b, threads=1).to_dict()

        workers = [threading.Thread(target=work, args=(k,)) for k in range(2)]
        begin, used = time.perf_counter(), time.process_time()
        for worker in workers:
            worker.start()
        for worker in workers:
            worker.join()
        shares.append({"wall": (time.perf_counter() - begin) / serial,
                       "cores": (time.process_time() - used) / (time.perf_counter() - begin)})
        for result in (*one, *found):
            result.pop("timing_s")
        equal = equal and found == one
    best = min(shares, key=lambda share: share["wall"])
    return {"points": n, **best, "repeats": told.repeats, "equal": equal}


def same(told):
    """How many command lines of tests/python/same_test.py say what Python says."""
    run = subprocess.run([sys.executable, "-B", "-m", "pytest", "-q", "-p", "no:cacheprovider", "-rA", "same_test.py"],
                         cwd=ROOT / "tests/python", capture_output=True, text=True)
    cases = re.findall(r"^(\w+) \S*::test_command_line_and_python_say_the_same\[(\w+)-", run.stdout, re.MULTILINE)
    return {"cases": len(cases), "equal": sum(word == "PASSED" for word, _ in cases),
            "verbs": sorted({verb for _, verb in cases}), "failed": run.returncode}


def fuzz(told):
    begin = time.perf_counter()
    run = subprocess.run([sys.executable, "-B", "-X", "faulthandler", ROOT / "tests/python/fuzz_test.py",
                          str(told.fuzz)], capture_output=True, text=True, stdin=subprocess.DEVNULL)
    sys.stderr.write(run.stderr[-4000:])
    last = run.stdout.strip().split("\n")[-1]
    found = json.loads(last) if run.returncode == 0 else {"failed": run.returncode}
    return {"seconds": time.perf_counter() - begin, **found}


SECTIONS = {"overhead": overhead, "copies": copies, "interrupt": interrupt, "growth": growth, "two_at_once": two_at_once,
            "same": same, "fuzz": fuzz}


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--page", type=pathlib.Path, help="the page to write, e.g. docs/evidence/python.md")
    parser.add_argument("--call", default=ROOT / "build/release/bin/isopach-call", help="the target isopach-call")
    parser.add_argument("--only", default=",".join(SECTIONS), help="sections, by commas: %(default)s")
    parser.add_argument("--points", type=int, default=1_000_000, metavar="N", help="points of each scan")
    parser.add_argument("--long", type=int, default=10_000_000, metavar="N", help="points of each scan of the interrupted runs")
    parser.add_argument("--interrupts", type=int, default=20, metavar="N")
    parser.add_argument("--repeats", type=int, default=9, metavar="N")
    parser.add_argument("--calls", type=int, default=10_000, metavar="N", help="calls for the growth of memory")
    parser.add_argument("--fuzz", type=int, default=600, metavar="SECONDS")
    parser.add_argument("--seed", type=int, default=1, metavar="N", help="of the times of interrupts")
    parser.add_argument("--counts", type=pathlib.Path, help="keep the results in this file")
    told = parser.parse_args()
    for name in told.only.split(","):
        if name and name not in SECTIONS:
            parser.error(f"--only {name}: none of {', '.join(SECTIONS)}")
    return told


def main():
    told = arguments()
    warnings.simplefilter("ignore", isopach.ScanWarning)
    counts = json.loads(told.counts.read_text()) if told.counts and told.counts.exists() else {}
    counts["machine"] = {"isopach": isopach.__version__, "python": platform.python_version(), "numpy": np.__version__,
                         "cores": os.cpu_count(), "system": f"{platform.system()} {platform.machine()}"}
    for name in filter(None, told.only.split(",")):
        counts[name] = json.loads(json.dumps(SECTIONS[name](told)))
        print(f"{name}: {json.dumps(counts[name])}", flush=True)
        if told.counts:
            told.counts.write_text(json.dumps(counts, indent=1))
    if told.page:
        told.page.write_text(page.written(counts))


if __name__ == "__main__":
    main()
