"""Comparisons in tiles: of scans that do not fit into memory, on this machine or by whatever runs functions elsewhere.

    job = isopach.tiles.plan("2012/*.laz", "2019.vpc", "job", max_memory="4G", classes=[2])
    job.run()                            # on this machine, one process a tile at a time
    job.run(executor=client)             # by a Dask client, submitit, concurrent.futures, mpi4py: anything with submit()
    result = job.reduce()                # the numbers of isopach.compare on all points, to the last bit

A job is a folder, which all that run tiles must see. Each tile is a process of its own, the program `isopach`, so that its
memory returns. Whatever is killed may be run again.
"""

from __future__ import annotations

import collections
import concurrent.futures
import contextlib
import json
import os
import pathlib
import secrets
import shutil
import signal
import subprocess
import sys
import sysconfig
import threading
import time
import warnings
from collections.abc import Callable, Iterable, Mapping
from typing import Any

from ._check import path_of, shown
from ._errors import InputError, ScanWarning, UsageError, error_of
from ._record import Record
from ._table import keywords, writing

__all__ = ["Job", "plan", "status"]


def _program() -> str:
    """The program that came with the module, or one on the path; ISOPACH_PROGRAM names another."""
    named = os.environ.get("ISOPACH_PROGRAM")
    beside = pathlib.Path(sysconfig.get_path("scripts")) / "isopach"
    found = named or (str(beside) if beside.is_file() else shutil.which("isopach"))
    if not found:
        raise InputError("the program isopach is not on the path: install the package as it is, or set ISOPACH_PROGRAM")
    return found


class _Processes:
    """Processes on this machine, so many at a time, as an executor; left by an exception, it stops those that run."""

    def __init__(self, at_once: int) -> None:
        self._threads = concurrent.futures.ThreadPoolExecutor(at_once)
        self._lock = threading.Lock()
        self._running: set[subprocess.Popen[str]] = set()
        self._stopped = False

    def submit(self, function: Callable[..., Any], *arguments: Any) -> concurrent.futures.Future[Any]:
        return self._threads.submit(function, *arguments, self)

    def began(self, process: subprocess.Popen[str]) -> None:
        with self._lock:
            self._running.add(process)
            if self._stopped:
                process.terminate()

    def ended(self, process: subprocess.Popen[str]) -> None:
        with self._lock:
            self._running.discard(process)

    def __enter__(self) -> _Processes:
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: Any) -> None:
        if kind is not None:
            with self._lock:
                self._stopped = True
                for process in self._running:
                    process.terminate()
        self._threads.shutdown(cancel_futures=kind is not None)


def _call(program: str, words: Iterable[str], processes: _Processes | None = None) -> tuple[int, str, str]:
    with subprocess.Popen([program, *words], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                          text=True) as process:
        if processes is not None:
            processes.began(process)
        try:
            printed, said = process.communicate()
        except BaseException:
            process.terminate()
            raise
        finally:
            if processes is not None:
                processes.ended(process)
        return process.returncode, printed, said.strip()


def _said(stderr: str) -> str:
    lines = [line for line in stderr.splitlines() if line.strip()]
    return lines[-1].removeprefix("isopach: ") if lines else "it ended without a word"


def _done(words: Iterable[str], allowed: tuple[int, ...] = (0,)) -> str:
    code, printed, stderr = _call(_program(), words)
    if code in allowed:
        return printed
    raise error_of(code if code in range(1, 7) else 1, _said(stderr))


def _run_tile(named: str | None, folder: str, index: int, threads: int, _call_of: str,
              processes: _Processes | None = None) -> tuple[int, str]:
    """What an executor is given: plain arguments, and a plain answer: the exit code, and why it is not 0.

    The program is that of the machine that runs this, unless ISOPACH_PROGRAM names one. `_call_of` is another word for
    every call: Dask takes calls with equal arguments for one, and would not try a tile again.
    """
    words = ["tile", "run", folder, f"--index={index}", "--quiet", f"--threads={threads}"]
    code, _, stderr = _call(named or _program(), words, processes)
    if code < 0:
        killed = ", as where memory runs out" if -code == signal.SIGKILL else ""
        return code, f"it was ended by {signal.Signals(-code).name}{killed}"
    return code, "" if code == 0 else _said(stderr)


def _words(options: Mapping[str, Any], table: Mapping[str, dict[str, Any]], call: str) -> list[str]:
    words: list[str] = []
    for keyword, value in options.items():
        if keyword not in table:
            raise TypeError(f"{call}() got an unexpected keyword argument {keyword!r}")
        row = table[keyword]
        name = "--" + row["names"][0]
        if value is None or (row["flag"] and value is False):
            continue
        if row["flag"]:
            if value is not True:
                raise UsageError(f"{keyword}: {shown(value)} is not True or False")
            words.append(name)
            continue
        many = value if row["list"] and isinstance(value, (list, tuple)) else [value]
        for one in many:
            text = ",".join(map(str, one)) if isinstance(one, (list, tuple)) else os.fspath(one) if hasattr(
                one, "__fspath__") else str(one)
            if not isinstance(text, str) or "\0" in text:
                raise UsageError(f"{keyword}: {shown(value)} cannot be told to a job: give a number, a word or a path")
            words.append(f"{name}={text}")
    return words


class Job:
    """A comparison in tiles, as a folder. Jobs that were planned before are opened with ``Job(folder)``."""

    def __init__(self, folder: str | os.PathLike[str]) -> None:
        self.folder = os.path.abspath(os.fsdecode(path_of(folder, "folder")))
        self.status  # raises where there is no job

    @property
    def status(self) -> Record:
        """State of the job, as ``isopach tile status --json`` has it.

        ``tiles`` are ``done``, ``failed`` or ``missing``; ``points``, ``points_done``; ``points_per_second`` of one run at a
        time and ``seconds_left`` at that pace; ``peak_bytes``, the largest memory of a tile, and ``memory``, what is allowed;
        ``broken``: ``scan``, ``path`` and ``why`` of the files that were left out; ``each``: of each tile ``state``, ``why``,
        ``points_a``, ``points_b``, ``seconds``, ``cpu_seconds``, ``peak_bytes``, ``threads``, ``host`` and ``ended``. What is
        not known is None.
        """
        return Record(json.loads(_done(["tile", "status", self.folder, "--json", "-", "--quiet"])))

    def missing(self) -> list[int]:
        """Numbers of the tiles that are not done."""
        return [tile.index for tile in self.status.each if tile.state != "done"]

    def run(self, executor: Any = None, *, retries: int = 2, threads: int = 1, at_once: int | None = None,
            progress: Callable[[int, int], None] | bool | None = None) -> Job:
        """Does all tiles that are not done; returns the job.

        `executor`: anything with ``submit(function, *arguments)`` that gives something with ``done()`` and ``result()``;
        None: processes on this machine. `at_once`: most tiles at a time (default: without an executor as many as there
        are cores for `threads` each; with one all that are left, which it queues). A tile that fails, or whose worker
        dies, is tried `retries` times more. `progress`: called with (tiles done, tiles), or True for a line on stderr.

        Raises InputError, which names the first tile that failed and says why, once all others are done; at once where
        the executor takes no more calls. Left by an exception, Ctrl-C among them, it cancels what it submitted; without
        an executor it stops its processes. What is done stays done. Test: tests/python/engines_test.py.
        """
        for name, value, least in (("retries", retries, 0), ("threads", threads, 1), ("at_once", at_once, 1)):
            if value is not None and (not isinstance(value, int) or value < least):
                raise UsageError(f"{name}: {shown(value)} is not a whole number of {least} or more")
        if executor is None:
            size = at_once or max(1, (os.cpu_count() or 1) // threads)
            with _Processes(size) as own:
                return self.run(own, retries=retries, threads=threads, at_once=at_once, progress=progress)
        if not callable(getattr(executor, "submit", None)):
            raise UsageError(f"executor: {shown(executor)} has no submit(): give a Dask client, a pool of processes, …")
        left = self.missing()
        calls = _Calls(executor, self.folder, threads)
        failed = calls.all(left, retries, at_once or len(left), _Line() if progress is True else progress or None)
        if failed:
            first = min(failed)
            raise InputError(f"{self.folder}: {len(failed)} of {len(left)} tiles failed, the first is {first}: "
                             f"{failed[first]}")
        return self

    def reduce(self, output: str | os.PathLike[str] | None = None, *, allow_missing: bool = False,
               points: bool = False, **options: Any) -> Record:
        """Joins the tiles; returns the JSON of isopach.compare as a Record.

        `output`: a folder for result.json, the report and the map; `options` say how these look, as in `save` of a
        result: palette, range, extent, title, author, logo, map_width, svg, report ("short"), pdf, report_vertices,
        no_map, raster.

        `points`: also the differences at the points, two LAZ files a tile, in that folder. `allow_missing`: compares the
        points of the tiles that are done and of the files that could be read; a warning of the result says so.
        """
        words = ["tile", "reduce", self.folder, "--json", "-", "--quiet"]
        if output is not None:
            words += ["-o", os.fsdecode(path_of(output, "output"))]
        words += _words(options, writing("compare"), "reduce")
        if allow_missing:
            words.append("--allow-missing")
        if points:
            words.append("--points")
        return Record(json.loads(_done(words, (0, 6))))

    def script(self, engine: str = "slurm", *, tiles_each: int | None = None, at_once: int | None = None,
               program: str | os.PathLike[str] | None = None) -> str:
        """A script that runs the tiles by an engine: slurm, parallel or snakemake.

        `tiles_each`: tiles that one job of the engine does; `at_once`: most jobs at a time; `program`: isopach on the
        machines that run it. Where they are not given the command `isopach tile script` chooses.
        """
        words = ["tile", "script", self.folder, f"--engine={engine}"]
        words += [f"--{name}={value}" for name, value in (("tiles-each", tiles_each), ("at-once", at_once))
                  if value is not None]
        if program is not None:
            words.append(f"--program={os.fsdecode(path_of(program, 'program'))}")
        return _done(words)

    def __repr__(self) -> str:
        state = self.status
        return f"Job of {state.tiles} tiles, {state.points} points, {state.done} done\n  {self.folder}"


class _Calls:
    """Calls of tiles that an executor has, and what became of them."""

    def __init__(self, executor: Any, folder: str, threads: int) -> None:
        self._executor, self._folder, self._threads = executor, folder, threads
        self._waiting: dict[int, Any] = {}

    def all(self, tiles: list[int], retries: int, at_once: int,
            told: Callable[[int, int], None] | None) -> dict[int, str]:
        """Does the tiles; gives those that failed, and why."""
        to_do = collections.deque((index, 0) for index in tiles)
        tries: dict[int, int] = {}
        failed: dict[int, str] = {}
        finished = 0
        try:
            while to_do or self._waiting:
                while to_do and len(self._waiting) < at_once:
                    index, tries[index] = to_do.popleft()
                    self._submit(index)
                for index, why in self._ended():
                    if why and tries[index] < retries:
                        to_do.append((index, tries[index] + 1))
                        continue
                    finished += 1
                    if why:
                        failed[index] = why
                    if told is not None:
                        told(finished, len(tiles))
        except BaseException:
            self._cancel()
            raise
        return failed

    def _submit(self, index: int) -> None:
        named = os.environ.get("ISOPACH_PROGRAM")
        try:
            self._waiting[index] = self._executor.submit(_run_tile, named, self._folder, index, self._threads,
                                                         secrets.token_hex(8))
        except Exception as error:
            raise InputError(f"{self._folder}: the executor takes no more tiles ({_one_line(error)}): run the job "
                             "again with another one; tiles that are done stay done") from error

    def _ended(self) -> list[tuple[int, str]]:
        """Waits for calls that have ended; why they failed, empty where they did not."""
        pause = 0.01
        while True:
            asked = time.monotonic()
            ready = [index for index, future in self._waiting.items() if future.done()]
            if ready:
                return [(index, self._why(self._waiting.pop(index))) for index in ready]
            # Some engines look at files to answer: most of the time nobody is asked.
            pause = min(max(2 * pause, 4 * (time.monotonic() - asked)), 1.0)
            time.sleep(pause)

    @staticmethod
    def _why(future: Any) -> str:
        try:
            code, why = future.result()
        except Exception as error:  # the engine's own: a worker that died, a call that was cancelled
            return _one_line(error)
        return why if code != 0 else ""

    def _cancel(self) -> None:
        for future in self._waiting.values():
            with contextlib.suppress(Exception):  # one that cannot be cancelled ends by itself
                future.cancel()


def _one_line(error: BaseException) -> str:
    """Of a message of many lines, such as a trace, the first and the last."""
    lines = [line.strip() for line in str(error).splitlines() if line.strip()]
    return f"{type(error).__name__}: " + " … ".join(lines[:1] + lines[1:][-1:])


class _Line:
    """One line on stderr, with the time left at the pace so far."""

    def __init__(self) -> None:
        self.start = time.monotonic()
        self.width = 0

    def __call__(self, done: int, of: int) -> None:
        line = f"{done} of {of} tiles"
        if 0 < done < of:
            left = (time.monotonic() - self.start) / done * (of - done)
            line += f", {left:.0f} s left" if left < 90 else f", {left / 60:.0f} min left"
        sys.stderr.write(f"\r{line:<{self.width}}" + ("\n" if done == of else ""))
        sys.stderr.flush()
        self.width = len(line)


def plan(a: str | os.PathLike[str], b: str | os.PathLike[str], job: str | os.PathLike[str], *,
         max_memory: str | int | None = None, tile_points: int | None = None, **options: Any) -> Job:
    """Looks at both scans, block by block, and sorts their points into tiles in the folder `job`.

    `a` and `b` are paths: files, folders, patterns, lists, catalogues. `max_memory`: what the run of one tile may take, as
    bytes or "4G". `tile_points`: most points of a tile instead. `options`: those of isopach.compare; what tiles cannot do
    raises UsageError, which names it. The job holds 24 bytes a point. Files of a set that cannot be read are left out: a
    ScanWarning names each, and `Job.reduce` refuses the job unless `allow_missing` is given.
    """
    words = ["tile", "plan", os.fsdecode(path_of(a, "a")), os.fsdecode(path_of(b, "b")), "-o",
             os.fsdecode(path_of(job, "job")), "--quiet"]
    if max_memory is not None:
        words.append(f"--max-memory={max_memory}")
    if tile_points is not None:
        words.append(f"--tile-points={tile_points}")
    _done(words + _words(options, keywords("compare"), "plan"))
    planned = Job(job)
    for file in planned.status.broken:
        warnings.warn(f"left out: {file.why}", ScanWarning, stacklevel=2)
    return planned


def status(job: str | os.PathLike[str]) -> Record:
    """State of a job, as `Job.status`."""
    return Job(job).status

