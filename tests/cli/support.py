"""Runs the real binary (ISOPACH_BIN) in a folder of its own, as a user would. Standard library only."""

import json
import math
import os
import pathlib
import random
import subprocess
import tempfile
import unittest

os.environ.setdefault("SOURCE_DATE_EPOCH", "1767225600")  # the date on maps and reports: 2026-01-01
BIN = os.environ.get("ISOPACH_BIN", str(pathlib.Path(__file__).resolve().parents[2] / "build/release/bin/isopach"))
SHARED = pathlib.Path(os.environ.get("ISOPACH_SHARED", pathlib.Path(__file__).resolve().parents[3] / "shared"))


def without_timing(text):
    result = json.loads(text)
    assert result.pop("timing_s")
    return json.dumps(result)


def hill(x, y):
    return 3 * math.exp(-((x - 12) ** 2 + (y - 9) ** 2) / 30) + 0.02 * x


def points(seed, n=400, lift=0.0, shift=0.0):
    """n random points of the hill over [0, 24] x [0, 18], three decimals."""
    numbers = random.Random(seed)
    found = []
    for _ in range(n):
        x, y = round(numbers.uniform(0, 24), 3), round(numbers.uniform(0, 18), 3)
        found.append((x + shift, y, round(hill(x, y) + lift, 3)))
    return found


class CliTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def path(self, name):
        return self.folder / name

    def write(self, name, lines):
        """A text file of points (tuples) or of lines (strings)."""
        text = "\n".join(line if isinstance(line, str) else "%r %r %r" % line for line in lines) + "\n"
        self.path(name).write_text(text)
        return name

    def scans(self, **options_b):
        self.write("a.xyz", points(1))
        self.write("b.xyz", points(2, **{"n": 500, "lift": 0.5, **options_b}))
        return "a.xyz", "b.xyz"

    def run_cli(self, *words, code=0, **options):
        """The finished run; fails unless it ended with `code` (None: any)."""
        run = subprocess.run([BIN, *map(str, words)], cwd=self.folder, capture_output=True, text=True, timeout=60,
                             **options)
        if code is not None:
            self.assertEqual(run.returncode, code, f"{words}\nstdout: {run.stdout}\nstderr: {run.stderr}")
        return run

    def result(self, *words):
        return json.loads(self.run_cli(*words, "--json", "-").stdout)

    def fails(self, code, *words, says=()):
        """Ends with `code` and exactly one line on stderr that holds every word of `says`; leaves nothing behind."""
        before = sorted(self.folder.rglob("*"))
        run = self.run_cli(*words, code=code)
        self.assertEqual(run.stderr.count("\n"), 1, run.stderr)
        self.assertTrue(run.stderr.startswith("isopach: "), run.stderr)
        for word in says:
            self.assertIn(word, run.stderr)
        self.assertEqual(run.stdout, "")
        self.assertEqual(sorted(self.folder.rglob("*")), before)
        return run.stderr
