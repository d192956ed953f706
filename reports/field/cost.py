"""Prints what probing one step (T1) costs, in seconds of CPU: at first, and once the step is compiled.

Of each solver the dearest cell of the run; all cells of solvers and problems that are named.

pip install '.[ase,diffrax,mici,qutip,sdeint,tinydiffeq,torchsde]' && python reports/field/cost.py [SOLVERS PROBLEMS]
"""

import sys
import time
import warnings

import pandas as pd
from run import RUNS

from sdaeverify.api import plan_of
from sdaeverify.contracts.settings import Settings
from sdaeverify.registry.load import load_registry


def seconds(cell):
    """Return the CPU seconds of probing a cell for the first time, and once more."""
    begun = [time.process_time()]
    for _ in range(2):
        cell.measure.probe(cell.scheme, cell.seen, Settings(paths=1024, coarsest=16, levels=4))
        begun.append(time.process_time())
    return begun[1] - begun[0], begun[2] - begun[1]


def costs(runs):
    """Return a row for each cell of some runs, the dearest first."""
    registry = load_registry()
    plans = [plan_of(registry, schemes, problems, measures) for schemes, problems, measures, _ in runs]
    cells = [cell for plan in plans for problem in plan.problems for cell in problem.runnable]
    rows = [(cell.scheme.label, cell.spec.label, cell.measure.name, *seconds(cell)) for cell in cells]
    return pd.DataFrame(rows, columns=["solver", "problem", "measure", "first", "again"]).sort_values("again")[::-1]


if __name__ == "__main__":
    warnings.simplefilter("ignore")
    named = [(*sys.argv[1:], "strong,weak", "")] if sys.argv[1:] else []
    table = costs(named or RUNS.values())
    print((table if named else table.groupby("solver", sort=False).head(1)).round(2).to_string(index=False))
