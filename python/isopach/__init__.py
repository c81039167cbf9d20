"""isopach compares two 3D scans of one surface exactly, without a grid.

>>> import isopach
>>> scene = isopach.simulate("plane", points=1000)
>>> result = isopach.compare(scene.a, scene.b)
>>> result.volume.net > 0
True

The functions are the verbs of the command line, their keywords its options with underscores, and the attributes of
results the keys of its JSON: the same scans give the same bits from both. The sign is always d = B − A.
"""

from . import tiles
from ._comparer import Comparer
from ._core import version as __version__
from ._errors import ConvergenceError, Error, InputError, OverlapError, ScanWarning, ToleranceError, UsageError
from ._record import Record
from ._results import (Accuracy, Asymmetry, Cells, Combination, Comparison, Distances, Fields, Info, Matching, Profile,
                       Result, Roughness, Scanners, Scene, Sequence)
from ._scan import Scan, read, scan
from ._verbs import (ScanLike, accuracy, asymmetry, combine, compare, convert, distance, info, match, roughness, scanners,
                     sequence, simulate)

__all__ = [
    "Accuracy", "Asymmetry", "Cells", "Combination", "Comparer", "Comparison", "ConvergenceError", "Distances", "Error", "Fields",
    "Info", "InputError", "Matching", "OverlapError", "Profile", "Record", "Result", "Roughness", "Scan", "ScanLike", "ScanWarning",
    "Scanners", "Scene", "Sequence", "ToleranceError", "UsageError", "__version__", "accuracy", "asymmetry", "combine",
    "compare", "convert", "distance", "info", "match", "read", "roughness", "scan", "scanners", "sequence", "simulate",
    "tiles",
]
