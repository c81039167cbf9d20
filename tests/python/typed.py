"""Code as users write it, for mypy --strict: no line may need a cast."""

import pathlib

import isopach
import numpy as np
from numpy.typing import NDArray


def volumes(before: NDArray[np.float64], after: pathlib.Path) -> tuple[float, str]:
    result = isopach.compare(before, after, surface="overlay", sigma1=0.02, sigma2="@sigma", classes=[2, 8],
                             crop=(0, 0, 10, 10), progress=True)
    moved: isopach.Matching = isopach.match(after, before, freedom="x,y,z", objective="icp-plane")
    again = isopach.compare(before, after, pose=moved, fail_above={"p95": 0.05})
    dz: NDArray[np.float64] = again.points_b.dz_signed
    net: float = result.volume.net
    return net + float(dz[0]), result.unit


def scans(points: NDArray[np.float32]) -> isopach.Scan:
    made = isopach.scan(points, unit="mm", attributes={"quality": np.ones(len(points))})
    try:
        return isopach.read("scan.las", classes=2)
    except isopach.InputError as wrong:
        print(wrong.exit_code, wrong.keyword)
        return made
