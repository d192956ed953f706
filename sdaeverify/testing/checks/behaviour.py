"""Checks of what a scheme does on a problem: the contract of a step, which every run begins with, name by name."""

from collections.abc import Callable
from dataclasses import replace
from functools import wraps
from itertools import product

import numpy as np

from ...conformance import contract
from ...conformance.exactness import exactness_violation
from ...conformance.step_counts import depends_on_count, why_not_counted
from ...conformance.trial import Trial
from ...contracts.scheme import flatten
from ..check import Inapplicable
from ..subjects import LONG, CellSubject, SchemeSubject

# Memory shows on few paths as on many.
FEW_PATHS = 4


def check_exactness(subject: SchemeSubject) -> str:
    """Expect exactness on dx = 0, dx = c dt and dx = S dW, but for a part that vanishes with h."""
    return exactness_violation(subject.scheme, followed=subject.registry.followed)


def check_any_number(subject: CellSubject) -> str:
    """Expect a step to take one path, and three, from the scheme's own start."""
    for paths, steps in product((1, 3), (contract.FINE, LONG)):
        trial = subject.of_paths(paths, steps)
        start = subject.scheme.start(subject.problem, paths, trial.h)
        if flatten(start).shape[-1] != paths:
            return f"it starts with {flatten(start).shape[-1]} paths where {paths} are wanted"
        if text := contract.returns_its_kind(replace(trial, given=start)):
            return f"on {paths} paths: {text}"
    return ""


def check_alone(subject: CellSubject) -> str:
    """Expect a path to go the same way alone and in any batch: paths that see each other are not independent.

    An iteration that ends when all paths have converged to a tolerance near rounding is remarked, and no failure.
    """
    if text := on_trials(contract.takes_paths_alone)(subject) or contract.takes_paths_alone(subject.coarse):
        return text
    if text := contract.takes_many_paths(subject.coarse):
        return text
    if remark := on_trials(contract.ends_together)(subject) or contract.ends_together(subject.coarse):
        raise Inapplicable(remark)
    return ""


def check_any_count(subject: CellSubject) -> str:
    """Expect steps of a run of 10 and of 50 steps to be like those of runs of 2^k steps, which all levels have."""
    if reason := why_not_counted(subject.scheme, subject.problem):
        raise Inapplicable(reason)
    return depends_on_count(subject.scheme, subject.problem)


def check_whole_state(subject: CellSubject) -> str:
    """Expect all memory to be in the state: from a copy of it, a fresh copy of the scheme goes on alike."""
    return contract.carries_its_memory(subject.of_paths(FEW_PATHS, contract.COARSE))


def on_trials(check: Callable[[Trial], str]) -> Callable[[CellSubject], str]:
    """Return the check of a cell that tells what a check finds first on its trials, with the step size."""

    @wraps(check)
    def of_cell(subject: CellSubject) -> str:
        for trial in subject.trials:
            if text := check(trial):
                steps = subject.problem.horizon / trial.h
                return f"{text} (h = {trial.h:.3g}, {np.round(steps):.0f} steps)"
        return ""

    return of_cell
