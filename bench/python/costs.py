#!/usr/bin/env python3
"""What Python costs: time and memory beside the library's own, how soon Ctrl-C ends a run, two threads at once.

    PYTHONPATH=build/release/python bench/python/costs.py [--points 1000000] [--interrupts 20]

Prints a table. The time of a run is what `timing_s.total` of its result does not explain: conversion of arguments, the
thread of the run, the reading of its JSON.
"""

import argparse
import os
import random
import resource
import signal
import subprocess
import sys
import threading
import time
import warnings

import isopach
import numpy as np


def cloud(n, seed, lift=0.0):
    numbers = np.random.default_rng(seed)
    xy = numbers.uniform(0, 1000, (n, 2))
    return np.column_stack([xy, np.sin(xy[:, 0] / 30) * np.cos(xy[:, 1] / 20) + lift])


def overhead(n, repeats=5):
    a, b = cloud(n, 1), cloud(n, 2, 0.1)
    shares = []
    for _ in range(repeats):
        begin = time.perf_counter()
        result = isopach.compare(a, b)
        wall = time.perf_counter() - begin
        shares.append(wall / result.timing_s.total - 1)
    return sorted(shares)[repeats // 2]


def interrupts(n, count, seed=1):
    """Seconds from the signal to KeyboardInterrupt."""
    a, b = cloud(n, 1), cloud(n, 2, 0.1)
    begin = time.perf_counter()
    isopach.compare(a, b)
    whole = time.perf_counter() - begin
    chosen, waits = random.Random(seed), []
    while len(waits) < count:
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
            if sent:
                waits.append(time.perf_counter() - sent[0])
        sender.join()
    isopach.compare(a[:10000], b[:10000])
    return whole, waits


COPIES = """
import resource, sys, isopach, numpy as np
a = np.random.default_rng(1).uniform(0, 1, ({n}, 3)){change}
peak = lambda: resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
before = peak()
s = isopach.scan(a)
print(peak() - before)
"""


def copied(n, change):
    """MB that a scan of an array adds to the peak of memory."""
    run = subprocess.run([sys.executable, "-c", COPIES.format(n=n, change=change)], capture_output=True, text=True, check=True)
    return int(run.stdout) / 1000


def growth(calls):
    a, b = cloud(1000, 1), cloud(1000, 2)
    for _ in range(200):
        isopach.compare(a, b, threads=1)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    for _ in range(calls):
        isopach.compare(a, b, threads=1)
    return (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) / 1000


def two_at_once(n):
    """Time of two runs side by side, a thread each, over that of both one after the other."""
    a, b = cloud(n, 1), cloud(n, 2, 0.1)
    isopach.compare(a, b, threads=1)
    begin = time.perf_counter()
    one = [isopach.compare(a, b, threads=1).to_dict() for _ in range(2)]
    serial = time.perf_counter() - begin
    found = [None, None]

    def work(k):
        found[k] = isopach.compare(a, b, threads=1).to_dict()

    workers = [threading.Thread(target=work, args=(k,)) for k in range(2)]
    begin = time.perf_counter()
    for worker in workers:
        worker.start()
    for worker in workers:
        worker.join()
    parallel = time.perf_counter() - begin
    for result in (*one, *found):
        result.pop("timing_s")
    assert found == one
    return parallel / serial


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--points", type=int, default=1_000_000, metavar="N", help="points of each scan")
    parser.add_argument("--interrupts", type=int, default=20, metavar="N")
    parser.add_argument("--calls", type=int, default=10_000, metavar="N", help="calls for the growth of memory")
    options = parser.parse_args()
    warnings.simplefilter("ignore", isopach.ScanWarning)
    n = options.points
    print(f"overhead of compare, 2 x {n} points: {100 * overhead(n):.2f} %")
    for title, change in (("float64, C order", ""), ("float64, Fortran order", ".copy(order='F')"),
                          ("float32", ".astype(np.float32)")):
        print(f"copied of {title}: {copied(n, change):.1f} MB of {24e-6 * n:.1f}")
    whole, waits = interrupts(n, options.interrupts)
    print(f"Ctrl-C in runs of {whole:.2f} s, {len(waits)} times: median {sorted(waits)[len(waits) // 2]:.3f} s, "
          f"most {max(waits):.3f} s")
    print(f"two threads at once: {two_at_once(n // 4):.2f} of the time of one after the other")
    print(f"growth of memory over {options.calls} calls: {growth(options.calls):.1f} MB")


if __name__ == "__main__":
    main()
