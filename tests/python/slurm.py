"""A cluster of one node for the time of a test: munged, slurmctld and slurmd, in a folder of their own."""

from __future__ import annotations

import contextlib
import os
import pathlib
import shutil
import socket
import subprocess
import tempfile
import time
from collections.abc import Callable, Iterator

DAEMONS = ("munged", "slurmctld", "slurmd")

CONFIGURATION = """\
ClusterName=isopach
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={controller}
SlurmdPort={daemon}
AuthType=auth/munge
AuthInfo=socket={folder}/munge.socket
CredType=cred/munge
SlurmUser=root
SlurmdUser=root
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core_Memory
SlurmdParameters=config_overrides
SchedulerParameters=sched_interval=1,batch_sched_delay=0,bf_interval=1
MpiDefault=none
NodeName={host} NodeAddr=127.0.0.1 CPUs=4 RealMemory=2000
PartitionName=all Nodes=ALL Default=YES
"""


def missing() -> str:
    """What keeps a cluster from being started here; empty if nothing does."""
    path = os.environ.get("PATH", "") + ":/usr/sbin:/usr/local/sbin"
    absent = [name for name in (*DAEMONS, "sbatch") if shutil.which(name, path=path) is None]
    if absent:
        return f"{', '.join(absent)}: not installed"
    return "" if os.geteuid() == 0 else "the daemons of SLURM need root"


def _free_ports(count: int) -> list[int]:
    with contextlib.ExitStack() as held:
        sockets = [held.enter_context(socket.socket()) for _ in range(count)]
        for one in sockets:
            one.bind(("127.0.0.1", 0))
        return [one.getsockname()[1] for one in sockets]


def _told(folder: pathlib.Path) -> str:
    texts = [f"{path.name}:\n{path.read_text(errors='replace')[-2000:]}" for path in sorted(folder.glob("*.log"))]
    return "\n".join(texts)


class Cluster:
    """Made by `cluster`; `environment` is what its commands need."""

    def __init__(self, environment: dict[str, str]) -> None:
        self.environment = environment

    def wait_until_idle(self, cwd: pathlib.Path, seconds: float = 120) -> None:
        """Until no job is left; those that wait for what failed go by themselves (--kill-on-invalid-dep)."""
        end = time.monotonic() + seconds
        while jobs := self.run("squeue", "--noheader", cwd=cwd):
            if time.monotonic() > end:
                raise TimeoutError(jobs)
            time.sleep(0.2)

    def run(self, *words: str, cwd: pathlib.Path) -> str:
        done = subprocess.run(words, cwd=cwd, env=self.environment, capture_output=True, text=True, timeout=60)
        assert done.returncode == 0, f"{words}: {done.stderr}"
        return done.stdout


@contextlib.contextmanager
def cluster() -> Iterator[Cluster]:
    with contextlib.ExitStack() as stack:
        folder = pathlib.Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="slurm")))
        folder.chmod(0o711)  # munged wants its socket to be reached by everybody
        (folder / "state").mkdir()
        key = folder / "munge.key"
        key.touch(0o600)
        key.write_bytes(os.urandom(1024))
        controller, daemon = _free_ports(2)
        host = socket.gethostname().split(".")[0]
        configuration = folder / "slurm.conf"
        configuration.write_text(CONFIGURATION.format(host=host, folder=folder, controller=controller, daemon=daemon))
        environment = {**os.environ, "SLURM_CONF": str(configuration),
                       "PATH": os.environ.get("PATH", "") + ":/usr/sbin:/usr/local/sbin"}

        def start(*words: str) -> subprocess.Popen[bytes]:
            log = stack.enter_context((folder / f"{words[0]}.out.log").open("wb"))
            process = subprocess.Popen(words, env=environment, cwd=folder, stdin=subprocess.DEVNULL, stdout=log,
                                       stderr=log)
            stack.callback(_stop, process)
            return process

        munged = start("munged", "--foreground", f"--socket={folder}/munge.socket", f"--key-file={key}",
                       f"--pid-file={folder}/munged.pid", f"--log-file={folder}/munged.log",
                       f"--seed-file={folder}/munge.seed", "--num-threads=2")
        _until(lambda: (folder / "munge.socket").exists(), [munged], folder)
        daemons = [munged, start("slurmctld", "-D", "-i"), start("slurmd", "-D", "-N", host)]
        made = Cluster(environment)

        def is_up() -> bool:
            told = subprocess.run(["sinfo", "--noheader", "--format=%T"], env=environment, capture_output=True,
                                  text=True)
            return told.returncode == 0 and told.stdout.strip() == "idle"

        _until(is_up, daemons, folder)
        yield made


def _until(is_so: Callable[[], bool], alive: list[subprocess.Popen[bytes]], folder: pathlib.Path) -> None:
    end = time.monotonic() + 60
    while not is_so():
        dead = [str(process.args) for process in alive if process.poll() is not None]
        if dead or time.monotonic() > end:
            raise RuntimeError(f"the cluster did not start ({', '.join(dead) or 'no answer'}):\n{_told(folder)}")
        time.sleep(0.1)


def _stop(process: subprocess.Popen[bytes]) -> None:
    process.terminate()
    try:
        process.wait(20)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()
