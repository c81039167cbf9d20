"""The Python that the studies run in: a virtual environment of their own with numpy and scipy."""

import os
import pathlib
import subprocess
import sys
import venv

ROOT = pathlib.Path(__file__).resolve().parents[2]
HOME = ROOT / "build" / "trust"


def enter(packages=("numpy", "scipy")):
    """Runs the script again by the Python of the environment in build/trust, made on first use."""
    if pathlib.Path(sys.prefix).resolve() == HOME.resolve():
        return
    python = HOME / "bin" / "python3"
    if not python.exists():
        venv.create(HOME, with_pip=True)
        done = subprocess.run([python, "-m", "pip", "install", "--quiet", *packages])
        if done.returncode != 0:
            python.unlink()
            sys.exit("numpy and scipy cannot be installed: without them there is no study")
    os.environ.update(OMP_NUM_THREADS="1", OPENBLAS_NUM_THREADS="1")
    os.execv(python, [str(python), "-B", *sys.argv])
