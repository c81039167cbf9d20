"""Engines that run tiles, as docs/use/tiles.md has them: SLURM, GNU parallel, Snakemake, Dask, submitit, processes.

Each does a job of its own, all of them together do one, and workers are killed: the result is that of compare. Where an
engine is not installed (scripts/engines installs all) its tests are skipped; ISOPACH_ENGINES=all makes that a failure.
"""

from __future__ import annotations

import concurrent.futures
import contextlib
import json
import os
import pathlib
import random
import re
import shutil
import signal
import stat
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from typing import Any

import pytest
import slurm

import isopach

ROOT = pathlib.Path(__file__).resolve().parents[2]
PROGRAM = os.environ.get("ISOPACH_BIN") or shutil.which("isopach") or str(ROOT / "build/release/bin/isopach")
PAGE = ROOT / "docs/use/tiles.md"
SNAKEMAKE = str(pathlib.Path(sys.executable).parent / "snakemake")
IS_REQUIRED = os.environ.get("ISOPACH_ENGINES") == "all"

pytestmark = pytest.mark.skipif(not os.path.exists(PROGRAM), reason="the program isopach is not there")


def need(is_there: bool, what: str) -> None:
    if not is_there:
        (pytest.fail if IS_REQUIRED else pytest.skip)(f"{what}: scripts/engines installs it")


def module(name: str) -> Any:
    try:
        return __import__(name)
    except ImportError:
        need(False, f"{name} is not installed")


@pytest.fixture(autouse=True)
def environment(monkeypatch: pytest.MonkeyPatch, tmp_path: pathlib.Path) -> None:
    """Workers find the module and the program; commands run in the folder that holds the scans and the job."""
    monkeypatch.setenv("ISOPACH_PROGRAM", PROGRAM)
    monkeypatch.setenv("PYTHONPATH", str(pathlib.Path(isopach.__file__).parents[1]))
    monkeypatch.chdir(tmp_path)


@pytest.fixture(scope="module")
def scans(tmp_path_factory: pytest.TempPathFactory) -> tuple[pathlib.Path, pathlib.Path]:
    scene = isopach.simulate("terrain", points=6000, seed=7)
    folder = tmp_path_factory.mktemp("scans")
    scene.a.write(folder / "a.ply")
    scene.b.write(folder / "b.ply")
    return folder / "a.ply", folder / "b.ply"


def isopach_said(*words: str) -> str:
    done = subprocess.run([PROGRAM, *words], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout


def told(text: str) -> Any:
    """A result.json without what counts the work of one way of doing it."""
    numbers = json.loads(text)
    for key in ("timing_s", "outputs", "localisation"):
        numbers.pop(key)
    return numbers


@pytest.fixture(scope="module")
def whole(scans: tuple[pathlib.Path, pathlib.Path]) -> Any:
    return told(isopach_said("compare", *map(str, scans), "--json", "-"))


@pytest.fixture
def job(scans: tuple[pathlib.Path, pathlib.Path], tmp_path: pathlib.Path) -> isopach.tiles.Job:
    made = isopach.tiles.plan(*scans, tmp_path / "job", tile_points=1500)
    assert made.status.tiles == 16
    return made


@pytest.fixture
def small_job(scans: tuple[pathlib.Path, pathlib.Path], tmp_path: pathlib.Path) -> isopach.tiles.Job:
    """For submitit, whose local executor takes seconds for each call."""
    made = isopach.tiles.plan(*scans, tmp_path / "job", tile_points=4000)
    assert made.status.tiles == 4
    return made


def reduced(job: isopach.tiles.Job) -> Any:
    assert job.missing() == []
    result = told(isopach_said("tile", "reduce", job.folder, "--json", "-"))
    names = {path.name for path in pathlib.Path(job.folder, "tiles").iterdir()}
    assert not [name for name in names if name.startswith(".")], names
    return result


def script(engine: str, *words: str, job: str = "job") -> str:
    return isopach_said("tile", "script", job, "--engine", engine, "--program", PROGRAM, *words)


def recipe(heading: str) -> str:
    """The commands under a heading of the page, for a shell that finds the program."""
    section = PAGE.read_text().split(f"\n### {heading}\n")[1]
    found = re.search(r"```sh\n(.*?)```", section, re.DOTALL)
    assert found
    path = pathlib.Path("bin")
    path.mkdir()
    (path / "isopach").symlink_to(PROGRAM)
    return f'set -e; export PATH="$PWD/bin:{pathlib.Path(sys.executable).parent}:$PATH"\n{found.group(1)}'


def sh(command: str, **options: Any) -> None:
    done = subprocess.run(["sh", "-c", command], capture_output=True, text=True, timeout=120, **options)
    assert done.returncode == 0, f"{command}\n{done.stdout}{done.stderr}"


# --- engines of the command line


@pytest.fixture(scope="module")
def cluster() -> Iterator[slurm.Cluster]:
    absent = slurm.missing()
    need(not absent, absent)
    with slurm.cluster() as made:
        yield made


def result() -> Any:
    return told(pathlib.Path("result/result.json").read_text())


def test_slurm(job: isopach.tiles.Job, whole: Any, cluster: slurm.Cluster, tmp_path: pathlib.Path) -> None:
    sh(recipe("SLURM"), env=cluster.environment)
    cluster.wait_until_idle(tmp_path)
    assert reduced(job) == whole and result() == whole
    assert len(list(tmp_path.glob("slurm-*_*.out"))) == job.status.tiles


def test_slurm_array_that_fails_is_submitted_again(job: isopach.tiles.Job, whole: Any, cluster: slurm.Cluster,
                                                   tmp_path: pathlib.Path) -> None:
    """Several tiles a task; submitted by the line that the script tells, of which the last part is cancelled."""
    points = pathlib.Path(job.folder, "points")
    kept = points.read_bytes()
    points.write_bytes(kept[: len(kept) // 2])
    text = script("slurm", "--tiles-each", "5", "--at-once", "2")
    assert re.search(r"--array=0-3%2\n", text) and re.search(r"--mem=\d+M\n", text)
    pathlib.Path("job.sh").write_text(text)
    line = next(row for row in text.splitlines() if row.startswith("# sbatch "))
    sh(line[2:], env=cluster.environment)
    cluster.wait_until_idle(tmp_path)
    assert job.missing() and not pathlib.Path("result").exists()
    assert "cut short" in "".join(path.read_text() for path in pathlib.Path.cwd().glob("slurm-*_*.out"))
    points.write_bytes(kept)
    sh(line[2:], env=cluster.environment)
    cluster.wait_until_idle(tmp_path)
    assert reduced(job) == whole and result() == whole


def test_parallel(job: isopach.tiles.Job, whole: Any) -> None:
    need(shutil.which("parallel") is not None, "GNU parallel is not installed")
    sh(recipe("GNU parallel"))
    assert reduced(job) == whole and result() == whole


def test_parallel_of_several_tiles_in_a_folder_with_a_name(job: isopach.tiles.Job, whole: Any,
                                                           tmp_path: pathlib.Path) -> None:
    need(shutil.which("parallel") is not None, "GNU parallel is not installed")
    name = "it's $HOME {} `x`"
    os.rename(job.folder, tmp_path / name)
    pathlib.Path("job.sh").write_text(script("parallel", "--tiles-each", "3", "--at-once", "3", job=name))
    sh("sh job.sh")
    assert reduced(isopach.tiles.Job(name)) == whole and result() == whole


def test_snakemake(job: isopach.tiles.Job, whole: Any) -> None:
    need(os.path.exists(SNAKEMAKE), "Snakemake is not installed")
    sh(recipe("Snakemake"))
    assert reduced(job) == whole and result() == whole


# --- whatever has submit()


@contextlib.contextmanager
def dask() -> Iterator[Any]:
    distributed = module("distributed")
    with distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as local, \
            distributed.Client(local) as client:
        yield client


@contextlib.contextmanager
def submitit() -> Iterator[Any]:
    executor = module("submitit").AutoExecutor(folder="logs", cluster="local")
    executor.update_parameters(timeout_min=5)
    yield executor


def processes() -> Any:
    return concurrent.futures.ProcessPoolExecutor(2)


EXECUTORS = [dask, submitit, processes]


@pytest.mark.parametrize("engine", EXECUTORS)
def test_executors(engine: Callable[[], Any], small_job: isopach.tiles.Job, whole: Any, tmp_path: pathlib.Path,
                   monkeypatch: pytest.MonkeyPatch) -> None:
    """Every third tile is killed at its first try."""
    job = small_job
    monkeypatch.setenv("ISOPACH_PROGRAM", program(tmp_path, """
        k=${4#--index=}
        [ "$2" != run ] || [ $((k % 3)) != 0 ] || ! mkdir "$0.$k" 2>/dev/null || kill -9 $$"""))
    heard: list[tuple[int, int]] = []
    with engine() as executor:
        job.run(executor, at_once=3, progress=lambda done, of: heard.append((done, of)))
    assert reduced(job) == whole
    n = job.status.tiles
    assert heard == [(k, n) for k in range(1, n + 1)]
    assert len(list(tmp_path.glob("program.*"))) == (n + 2) // 3


def program(folder: pathlib.Path, first: str) -> str:
    """isopach, which does something else first."""
    path = folder / "program"
    path.write_text(f'#!/bin/sh\n{first}\nexec "{PROGRAM}" "$@"\n')
    path.chmod(path.stat().st_mode | stat.S_IXUSR)
    return str(path)


@pytest.mark.parametrize("engine", EXECUTORS)
def test_failures_are_one_line(engine: Callable[[], Any], small_job: isopach.tiles.Job, tmp_path: pathlib.Path,
                               monkeypatch: pytest.MonkeyPatch) -> None:
    job = small_job
    monkeypatch.setenv("ISOPACH_PROGRAM", program(tmp_path, '[ "$2 $4" != "run --index=2" ] || kill -9 $$'))
    n = job.status.tiles
    says = f"1 of {n} tiles failed, the first is 2.*SIGKILL"
    with engine() as executor, pytest.raises(isopach.InputError, match=says) as e:
        job.run(executor, retries=1)
    assert "\n" not in str(e.value)
    assert job.missing() == [2]


def test_dask_worker_killed(job: isopach.tiles.Job, whole: Any) -> None:
    """Its tiles go to another one."""
    killed: list[int] = []
    with dask() as client:
        workers = list(client.run(os.getpid).values())

        def kill(done: int, _: int) -> None:
            if done == 3:
                killed.append(workers[0])
                os.kill(workers[0], signal.SIGKILL)

        job.run(client, progress=kill)
        assert killed and killed[0] not in client.run(os.getpid).values()
    assert reduced(job) == whole


def test_submitit_worker_killed(small_job: isopach.tiles.Job, whole: Any, tmp_path: pathlib.Path,
                                monkeypatch: pytest.MonkeyPatch) -> None:
    """The process that runs tile 2 dies with it, once."""
    monkeypatch.setattr(module("submitit").Job, "_results_timeout_s", 1)  # it waits for slow file systems
    monkeypatch.setenv("ISOPACH_PROGRAM", program(
        tmp_path, '[ "$2 $4" != "run --index=2" ] || ! mkdir "$0.2" 2>/dev/null || kill -9 $PPID $$'))
    with submitit() as executor:
        small_job.run(executor)
    assert (tmp_path / "program.2").exists()
    assert reduced(small_job) == whole


def test_broken_pool(job: isopach.tiles.Job, whole: Any, tmp_path: pathlib.Path,
                     monkeypatch: pytest.MonkeyPatch) -> None:
    """A pool of processes is of no use once one of them is dead: another one does the rest."""
    monkeypatch.setenv("ISOPACH_PROGRAM", program(
        tmp_path, '[ "$2 $4" != "run --index=5" ] || ! mkdir "$0.5" 2>/dev/null || kill -9 $PPID $$'))
    says = "takes no more tiles .*BrokenProcessPool.*another one"
    with processes() as pool, pytest.raises(isopach.InputError, match=says):
        job.run(pool)
    assert job.missing()
    with processes() as pool:
        job.run(pool)
    assert reduced(job) == whole


def test_interrupted(job: isopach.tiles.Job, tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Ctrl-C that only the interpreter hears, as in a notebook: it stops the processes, and starts no more."""
    monkeypatch.setenv("ISOPACH_PROGRAM", program(tmp_path, '[ "$2" != run ] || { echo $$ >"$0.$$"; exec sleep 600; }'))
    code = "import isopach; isopach.tiles.Job('job').run(at_once=2)"
    run = subprocess.Popen([sys.executable, "-c", code], stderr=subprocess.PIPE, text=True, start_new_session=True)
    while len(started := list(tmp_path.glob("program.*"))) < 2:
        assert run.poll() is None
        time.sleep(0.05)
    run.send_signal(signal.SIGINT)
    _, said = run.communicate(timeout=60)
    assert "KeyboardInterrupt" in said
    assert len(list(tmp_path.glob("program.*"))) == 2
    for path in started:
        with pytest.raises(ProcessLookupError):
            os.kill(int(path.name.rsplit(".", 1)[1]), 0)


def test_arguments(job: isopach.tiles.Job) -> None:
    wrong: list[dict[str, Any]] = [{"retries": -1}, {"threads": 0}, {"at_once": 0}, {"at_once": 1.5}]
    for words in wrong:
        with pytest.raises(isopach.UsageError, match=next(iter(words))):
            job.run(**words)
    with pytest.raises(isopach.UsageError, match="executor.*submit"):
        job.run(object())


def test_python_of_the_page(tmp_path: pathlib.Path) -> None:
    for name in ("distributed", "submitit"):
        module(name)
    room: dict[str, Any] = {}
    for block in re.findall(r"```python\n(.*?)```", PAGE.read_text(), re.DOTALL):
        exec(compile(block, str(PAGE), "exec"), room)
    expected = told(isopach_said("compare", "2012.ply", "2019.ply", "--json", "-"))
    for name in ("job", "by_processes", "by_dask", "by_submitit"):
        assert reduced(isopach.tiles.Job(name)) == expected


# --- one job, all of them


class InTurn:
    """Calls go to several engines in turn."""

    def __init__(self, engines: list[Any]) -> None:
        self.engines, self.calls = engines, 0

    def submit(self, function: Any, *arguments: Any) -> Any:
        self.calls += 1
        return self.engines[self.calls % len(self.engines)].submit(function, *arguments)


def test_one_job_by_all_of_them(job: isopach.tiles.Job, whole: Any, cluster: slurm.Cluster,
                                tmp_path: pathlib.Path) -> None:
    need(shutil.which("parallel") is not None, "GNU parallel is not installed")
    need(os.path.exists(SNAKEMAKE), "Snakemake is not installed")
    left = job.missing()
    random.Random(4).shuffle(left)
    by_slurm, by_parallel, by_snakemake, others = left[:3], left[3:6], left[6:9], left[9:]

    pathlib.Path("job.sh").write_text(script("slurm"))
    sh(f"sbatch --array={','.join(map(str, by_slurm))} job.sh", env=cluster.environment)

    text = script("parallel")
    tiles = f"printf '%s\\n' {' '.join(map(str, by_parallel))} |"
    text, count = re.subn(r"^seq \d+ \d+ \|", lambda _: tiles, text, flags=re.M)
    assert count == 1
    sh("\n".join(row for row in text.splitlines() if "tile reduce" not in row))

    pathlib.Path("Snakefile").write_text(script("snakemake"))
    sh(f"{SNAKEMAKE} --cores 2 " + " ".join(f"{job.folder}/tiles/{k:06d}.part" for k in by_snakemake))
    cluster.wait_until_idle(tmp_path)
    assert sorted(job.missing()) == sorted(others)

    with dask() as client, submitit() as executor, processes() as pool:
        job.run(InTurn([client, executor, pool]))
    assert reduced(job) == whole
    sh(f"{SNAKEMAKE} --cores 2")  # nothing is done twice: the result alone is missing
    assert result() == whole
