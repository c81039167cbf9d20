"""Comparisons in tiles: of scans that do not fit into memory, on this machine or by whatever runs functions elsewhere.

    job = isopach.tiles.plan("2012/*.laz", "2019.vpc", "job", max_memory="4G", classes=[2])
    job.run()                            # on this machine, one process a tile at a time
    job.run(executor=client)             # by a Dask client, submitit, concurrent.futures, mpi4py: anything with submit()
    result = job.reduce()                # the numbers of isopach.compare on all points, to the last bit

A job is a folder, which all that run tiles must see. Each tile is a process of its own, the program `isopach`, so that its
memory returns. Whatever is killed may be run again.
"""

from __future__ import annotations

import concurrent.futures
import json
import os
import pathlib
import shutil
import subprocess
import sys
import sysconfig
import time
import warnings
from collections.abc import Callable, Iterable, Mapping
from typing import Any

from ._check import path_of, shown
from ._errors import InputError, ScanWarning, UsageError, error_of
from ._record import Record
from ._table import keywords

__all__ = ["Job", "plan", "status"]


def _program() -> str:
    """The program that came with the module, or one on the path; ISOPACH_PROGRAM names another."""
    named = os.environ.get("ISOPACH_PROGRAM")
    beside = pathlib.Path(sysconfig.get_path("scripts")) / "isopach"
    found = named or (str(beside) if beside.is_file() else shutil.which("isopach"))
    if not found:
        raise InputError("the program isopach is not on the path: install the package as it is, or set ISOPACH_PROGRAM")
    return found


def _call(program: str, words: Iterable[str]) -> tuple[int, str, str]:
    done = subprocess.run([program, *words], capture_output=True, text=True, stdin=subprocess.DEVNULL)
    return done.returncode, done.stdout, done.stderr.strip()


def _said(stderr: str) -> str:
    lines = [line for line in stderr.splitlines() if line.strip()]
    return lines[-1].removeprefix("isopach: ") if lines else "it ended without a word"


def _done(words: Iterable[str], allowed: tuple[int, ...] = (0,)) -> str:
    code, printed, stderr = _call(_program(), words)
    if code in allowed:
        return printed
    raise error_of(code if code in range(1, 7) else 1, _said(stderr))


def _run_tile(program: str, folder: str, index: int, threads: int) -> tuple[int, int, str]:
    """What an executor is given: plain arguments, and a plain answer."""
    code, _, stderr = _call(program, ["tile", "run", folder, f"--index={index}", "--quiet", f"--threads={threads}"])
    return index, code, "" if code == 0 else _said(stderr)


def _words(options: Mapping[str, Any]) -> list[str]:
    table = keywords("compare")
    words: list[str] = []
    for keyword, value in options.items():
        if keyword not in table:
            raise TypeError(f"plan() got an unexpected keyword argument {keyword!r}")
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

    def run(self, executor: Any = None, *, retries: int = 2, threads: int = 1, workers: int | None = None,
            progress: Callable[[int, int], None] | bool | None = None) -> Job:
        """Does all tiles that are not done; returns the job.

        `executor`: anything with ``submit(function, *arguments)`` that gives something with ``done()`` and ``result()``;
        None: `workers` processes on this machine (default: as many as there are cores for `threads` each). A tile that
        fails is tried `retries` times more. `progress`: called with (tiles done, tiles), or True for a line on stderr.
        Raises InputError, which names the first tile that failed and says why, once all others are done.
        """
        if executor is None:
            size = workers or max(1, (os.cpu_count() or 1) // max(1, threads))
            with concurrent.futures.ThreadPoolExecutor(size) as own:
                return self.run(own, retries=retries, threads=threads, progress=progress)
        told = _Line() if progress is True else progress or None
        left = self.missing()
        tries = dict.fromkeys(left, 0)
        failed: dict[int, str] = {}
        waiting = {self._submit(executor, index, threads) for index in left}
        finished = 0
        while waiting:
            ready = {item for item in waiting if item[1].done()}
            if not ready:
                time.sleep(0.02)
                continue
            waiting -= ready
            for index, future in ready:
                try:
                    _, code, why = future.result()
                except Exception as error:  # a worker that died: the engine's own exception
                    code, why = 1, f"{type(error).__name__}: {error}"
                if code != 0 and tries[index] < retries:
                    tries[index] += 1
                    waiting.add(self._submit(executor, index, threads))
                    continue
                finished += 1
                if code != 0:
                    failed[index] = why
                if told is not None:
                    told(finished, len(left))
        if failed:
            first = min(failed)
            raise InputError(f"{self.folder}: {len(failed)} of {len(left)} tiles failed, the first is {first}: {failed[first]}")
        return self

    def _submit(self, executor: Any, index: int, threads: int) -> tuple[int, Any]:
        return index, executor.submit(_run_tile, _program(), self.folder, index, threads)

    def reduce(self, output: str | os.PathLike[str] | None = None, *, allow_missing: bool = False) -> Record:
        """Joins the tiles; returns the JSON of isopach.compare as a Record. `output`: a folder for result.json."""
        words = ["tile", "reduce", self.folder, "--json", "-", "--quiet"]
        if output is not None:
            words += ["-o", os.fsdecode(path_of(output, "output"))]
        if allow_missing:
            words.append("--allow-missing")
        return Record(json.loads(_done(words, (0, 6))))

    def script(self, engine: str = "slurm", *, tiles_each: int = 1) -> str:
        """A script that runs the tiles by an engine: slurm, parallel or snakemake."""
        return _done(["tile", "script", self.folder, f"--engine={engine}", f"--tiles-each={tiles_each}"])

    def __repr__(self) -> str:
        state = self.status
        return f"Job of {state.tiles} tiles, {state.points} points, {state.done} done\n  {self.folder}"


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
    _done(words + _words(options))
    planned = Job(job)
    for file in planned.status.broken:
        warnings.warn(f"left out: {file.why}", ScanWarning, stacklevel=2)
    return planned


def status(job: str | os.PathLike[str]) -> Record:
    """State of a job, as `Job.status`."""
    return Job(job).status

