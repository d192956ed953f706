"""Prints what probing one step (T1) of each solver costs, in seconds of CPU: at first, and once it is compiled.

pip install '.[ase,diffrax,mici,qutip,sdeint,tinydiffeq,torchsde]' && python reports/field/cost.py
"""

import sys
import time
import warnings

import pandas as pd
from run import SOLVERS

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


if __name__ == "__main__":
    warnings.simplefilter("ignore")
    schemes, problems = (*sys.argv[1:], SOLVERS, "")[:2] if len(sys.argv) == 3 else (SOLVERS, sys.argv[1])
    plan = plan_of(load_registry(), schemes, problems, "strong,weak")
    cells = [cell for problem in plan.problems for cell in problem.runnable]
    rows = [(cell.scheme.label, cell.spec.label, cell.measure.name, *seconds(cell)) for cell in cells]
    table = pd.DataFrame(rows, columns=["solver", "problem", "measure", "first", "again"])
    print(table.round(2).to_string())
