"""Two order-independent checks of a solver: rows are independent, and its noise is that of the path."""

from typing import NamedTuple

import numpy as np

from sdaeverify import Problem
from sdaeverify.errors import FAULTS, one_line

from .contract import Adaptive
from .path import Path
from .sample import checked

OWN_STEPS, KEEPS_ITS_PATH = "own steps", "keeps its path"
# Number of rows that are solved separately.
ROWS = 3
# Half of the digits, a bound for rounding that differs between one path and a batch.
HALF = float(np.sqrt(np.finfo(float).eps))


class Answer(NamedTuple):
    """Result of a check.

    Attributes
    ----------
    check : str
    failed : str
        Fault in a sentence; empty if the check passes.
    skipped : str
        Why the check was skipped; empty if it was not.
    """

    check: str
    failed: str = ""
    skipped: str = ""


def check(solver: Adaptive, view: Problem, path: Path, tolerance: float) -> list[Answer]:
    """Run both checks and return their results.

    Parameters
    ----------
    solver : Adaptive
    view : Problem
        Problem in the solver's form.
    path : Path
        Path with several rows.
    tolerance : float
        Tolerance small enough for steps to be rejected.
    """
    answers = []
    for name, made in ((OWN_STEPS, own_steps), (KEEPS_ITS_PATH, keeps_its_path)):
        try:
            answers.append(made(solver, view, path, tolerance))
        except FAULTS as error:
            answers.append(Answer(name, one_line(error)))
    return answers


def own_steps(solver: Adaptive, view: Problem, path: Path, tolerance: float) -> Answer:
    """Check that a row solved alone equals its row in the batch, so that its steps do not depend on other rows.

    Parameters
    ----------
    solver, view, path, tolerance
        As in `check`.
    """
    if solver.own_noise:
        return Answer(OWN_STEPS, skipped="it has noise of its own")
    if solver.in_batches:
        return Answer(OWN_STEPS, skipped="paths that are solved together share their steps, as it says (in_batches)")
    together = checked(solver, solver.solve(view, path, tolerance), path.paths)
    for row in range(min(ROWS, path.paths)):
        alone = checked(solver, solver.solve(view, path.only(np.array([row])), tolerance), 1)
        counts = [(int(each.steps[i]), int(each.rejected[i])) for each, i in ((together, row), (alone, 0))]
        x, y = together.state[:, row], alone.state[:, 0]
        if counts[0] != counts[1] or np.any(np.abs(x - y) > HALF * (1.0 + np.abs(x))):
            apart = float(np.max(np.abs(x - y)))
            steps = f"{counts[0][0]} steps and {counts[0][1]} rejected in a batch of {path.paths}"
            return Answer(
                OWN_STEPS, f"row {row} has {steps}, {counts[1][0]} and {counts[1][1]} alone: {apart:.2g} apart"
            )
    return Answer(OWN_STEPS)


def keeps_its_path(solver: Adaptive, view: Problem, path: Path, tolerance: float) -> Answer:
    """Check that the Brownian motions a solver reports are those of the path at the same times.

    Parameters
    ----------
    solver, view, path, tolerance
        As in `check`.
    """
    found = checked(solver, solver.solve(view, path, tolerance), path.paths)
    if found.times is None or found.W is None:
        return Answer(KEEPS_ITS_PATH, skipped="the solver does not report its noise")
    apart, size = 0.0, 1.0
    for tick, W in zip(found.times, found.W, strict=True):
        known = path.at(tick).W
        apart, size = max(apart, float(np.max(np.abs(W - known)))), max(size, float(np.max(np.abs(known))))
    if not apart <= HALF * size:
        return Answer(KEEPS_ITS_PATH, f"the motions it reports are up to {apart:.2g} from the path at the same times")
    return Answer(KEEPS_ITS_PATH)
