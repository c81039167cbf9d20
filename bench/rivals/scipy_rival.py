#!/usr/bin/env python3
"""SciPy as rival: scipy_rival.py POINTS REPEATS. Prints `version`, then median seconds of CPU of each step."""

import statistics
import sys
import time

import numpy
import scipy
from scipy.interpolate import LinearNDInterpolator
from scipy.spatial import Delaunay

count, repeats = int(sys.argv[1]), int(sys.argv[2])
random = numpy.random.default_rng(1)
points, queries = random.random((count, 2)), random.random((count, 2))
heights = numpy.sin(17 * points[:, 0])


def seconds(work):
    times = []
    for _ in range(repeats):
        start = time.thread_time()
        result = work()
        times.append(time.thread_time() - start)
    return statistics.median(times), result


delaunay_seconds, triangulation = seconds(lambda: Delaunay(points))
interpolator = LinearNDInterpolator(triangulation, heights)
interpolate_seconds, _ = seconds(lambda: interpolator(queries))
print(scipy.__version__, delaunay_seconds, interpolate_seconds)
