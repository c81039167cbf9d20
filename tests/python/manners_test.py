"""Threads, Ctrl-C, progress, logging, warnings."""

from __future__ import annotations

import logging
import os
import pathlib
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from typing import Any

import isopach
import numpy as np
import pytest
from conftest import without_timing

LARGE = 100_000
pytestmark = pytest.mark.filterwarnings("ignore::isopach.ScanWarning")


def cloud(n: int, seed: int, lift: float = 0.0) -> Any:
    numbers = np.random.default_rng(seed)
    xy = numbers.uniform(0, 1000, (n, 2))
    return np.column_stack([xy, np.sin(xy[:, 0] / 30) * np.cos(xy[:, 1] / 20) + lift])


def test_other_threads_run_meanwhile() -> None:
    a, b = cloud(LARGE, 1), cloud(LARGE, 2, 0.1)
    ticks, done = [], threading.Event()

    def count() -> None:
        while not done.wait(0.005):
            ticks.append(1)

    other = threading.Thread(target=count)
    other.start()
    isopach.compare(a, b)
    done.set()
    other.join()
    assert len(ticks) > 10


def test_two_threads_at_once_give_what_one_gives() -> None:
    pairs = [(cloud(20_000, 2 * k), cloud(20_000, 2 * k + 1, 0.1 * k)) for k in range(4)]
    alone = [without_timing(isopach.compare(*pair, threads=1).to_json()) for pair in pairs]
    found = [""] * len(pairs)

    def work(k: int) -> None:
        found[k] = without_timing(isopach.compare(*pairs[k], threads=1).to_json())

    workers = [threading.Thread(target=work, args=(k,)) for k in range(len(pairs))]
    for worker in workers:
        worker.start()
    for worker in workers:
        worker.join()
    assert found == alone


def test_number_of_threads_does_not_matter(monkeypatch: pytest.MonkeyPatch) -> None:
    a, b = cloud(20_000, 1), cloud(20_000, 2, 0.1)
    one = without_timing(isopach.compare(a, b, threads=1).to_json())
    assert without_timing(isopach.compare(a, b, threads=3).to_json()) == one
    monkeypatch.setenv("ISOPACH_THREADS", "2")
    assert without_timing(isopach.compare(a, b).to_json()) == one
    monkeypatch.setenv("ISOPACH_THREADS", "many")
    with pytest.raises(isopach.UsageError, match="^ISOPACH_THREADS: 'many'"):
        isopach.compare(a, b)


@pytest.fixture
def heeds_interrupts() -> Iterator[None]:
    """Shells start what runs in the background with SIGINT ignored, and Python then leaves it so."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


def test_interrupt(heeds_interrupts: None) -> None:
    a, b = cloud(4 * LARGE, 1), cloud(4 * LARGE, 2, 0.1)
    before = without_timing(isopach.compare(a[:5000], b[:5000]).to_json())
    times = []
    for delay in (0.0, 0.1, 0.3):
        sent: list[float] = []

        def interrupt(delay: float = delay, sent: list[float] = sent) -> None:
            time.sleep(delay)
            sent.append(time.monotonic())
            os.kill(os.getpid(), signal.SIGINT)

        sender = threading.Thread(target=interrupt)
        with pytest.raises(KeyboardInterrupt):
            sender.start()
            isopach.compare(a, b, noise_floor=True)
        times.append(time.monotonic() - sent[0])
        sender.join()
    assert without_timing(isopach.compare(a[:5000], b[:5000]).to_json()) == before
    assert min(times) < 0.3  # of one that is not held up by what else runs here; see bench/python/costs.py


def test_interrupted_save_leaves_nothing(tmp_path: pathlib.Path) -> None:
    result = isopach.compare(cloud(LARGE, 1), cloud(LARGE, 2, 0.1))

    def stop(stage: str, fraction: float) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        result.save(tmp_path / "out", progress=stop)
    assert not (tmp_path / "out").exists()


def test_progress_is_told() -> None:
    told = []
    isopach.compare(cloud(50_000, 1), cloud(50_000, 2), progress=lambda stage, fraction: told.append((stage, fraction)))
    assert told
    assert all(isinstance(stage, str) and 0 <= fraction <= 1 for stage, fraction in told)


def test_what_a_progress_function_raises_ends_the_run() -> None:
    def stop(stage: str, fraction: float) -> None:
        raise ZeroDivisionError(stage)

    with pytest.raises(ZeroDivisionError):
        isopach.compare(cloud(LARGE, 1), cloud(LARGE, 2), progress=stop)


def test_progress_bar_goes_away(capsys: pytest.CaptureFixture[str]) -> None:
    isopach.compare(cloud(50_000, 1), cloud(50_000, 2), progress=True)
    assert not capsys.readouterr().err.split("\r")[-1].strip()


def test_logging(caplog: pytest.LogCaptureFixture, plane: isopach.Scene) -> None:
    with caplog.at_level(logging.DEBUG, logger="isopach"):
        isopach.compare(plane.a, plane.b)
    assert "compare: done" in caplog.text
    assert "delaunay" in caplog.text


def test_silent_by_default(plane: isopach.Scene) -> None:
    code = ("import sys; sys.path[:0] = %r; import isopach;"
            "s = isopach.simulate('plane', points=300); isopach.compare(s.a, s.a)")
    told = subprocess.run([sys.executable, "-W", "error", "-c", code % sys.path[:2]], capture_output=True, text=True)
    assert (told.returncode, told.stdout, told.stderr) == (0, "", "")


def test_warnings_have_a_class_and_name_keywords() -> None:
    a, b = cloud(5000, 1), cloud(5000, 2, 5.0)
    with pytest.warns(isopach.ScanWarning, match="add match=True") as caught:
        result = isopach.compare(a, b)
    assert pathlib.Path(caught[0].filename).name == "manners_test.py"
    assert any("--match" in warning for warning in result.warnings)  # of the JSON, as the command line has it


def test_memory_does_not_grow(plane: isopach.Scene) -> Any:
    import resource

    def peak() -> Any:
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss

    a, b = np.array(plane.a.points), np.array(plane.b.points)
    for _ in range(100):
        isopach.compare(a, b, threads=1)
    before = peak()
    for _ in range(300):
        isopach.compare(a, b, threads=1).points_a
    assert peak() - before < 5000  # kB


def test_a_double_input_is_not_copied() -> None:
    code = """
import sys; sys.path[:0] = %r
import resource, isopach, numpy as np
a = np.random.default_rng(1).uniform(0, 1, (2_000_000, 3))
before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
isopach.scan(a)
print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before)
"""
    told = subprocess.run([sys.executable, "-c", code % sys.path[:2]], capture_output=True, text=True, check=True)
    assert int(told.stdout) < 20_000  # kB; the array has 48 MB
