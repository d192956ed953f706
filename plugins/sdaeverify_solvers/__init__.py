"""Solvers that make whole runs: selection, measurement of pairs of solver and problem, verdicts and their table.

Adaptive solvers and sealed ones share these; each of the two works without the other.
"""

from .judged import Asked, judge
from .pairs import Pair, PairRun, Row, SolverWork, select_solvers
from .row_table import print_rows, records

__all__ = ["Asked", "Pair", "PairRun", "Row", "SolverWork", "judge", "print_rows", "records", "select_solvers"]
