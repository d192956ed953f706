"""Two runs compared: by which factor errors have grown or shrunk, on the noise that both runs share.

::

    folder      the evidence of a run, as it was stored          runs
    evidence    errors of either run, quantity by quantity       cells
    factors     new error over old error, with an interval       factors
    changes     same, worse, better, undecided                   changes
"""

from .cells import Comparison, Omitted, compare
from .changes import Change, Changed, changes
from .factors import Factor, factor
from .runs import StoredRun, damages, read_run

__all__ = [
    "Change",
    "Changed",
    "Comparison",
    "Factor",
    "Omitted",
    "StoredRun",
    "changes",
    "compare",
    "damages",
    "factor",
    "read_run",
]
