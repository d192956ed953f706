"""Checks of a scheme's steps on a problem: the contract of a step, which every run tests first, check by check."""

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

# A few paths show memory as well as many do.
FEW_PATHS = 4


def check_exactness(subject: SchemeSubject) -> str:
    """Expect exactness on dx = 0, dx = c dt and dx = S dW, except for a part that vanishes with h."""
    return exactness_violation(subject.scheme, followed=subject.registry.followed)


def check_any_number(subject: CellSubject) -> str:
    """Expect a step to accept one path, and three, from the scheme's start."""
    for paths, steps in product((1, 3), (contract.FINE, LONG)):
        trial = subject.of_paths(paths, steps)
        start = subject.scheme.start(subject.problem, paths, trial.h)
        if flatten(start).shape[-1] != paths:
            return f"it starts with {flatten(start).shape[-1]} paths where {paths} are wanted"
        if text := contract.returns_its_kind(replace(trial, given=start)):
            return f"on {paths} paths: {text}"
    return ""


def check_alone(subject: CellSubject) -> str:
    """Expect a path to be the same alone and in any batch, because coupled paths are not independent.

    An iteration that stops when all paths have converged to a tolerance near rounding is reported as a remark, not as
    a failure.
    """
    if text := on_trials(contract.takes_paths_alone)(subject) or contract.takes_paths_alone(subject.coarse):
        return text
    if text := contract.takes_many_paths(subject.coarse):
        return text
    if remark := on_trials(contract.ends_together)(subject) or contract.ends_together(subject.coarse):
        raise Inapplicable(remark)
    return ""


def check_any_count(subject: CellSubject) -> str:
    """Expect steps of runs of 10 and 50 steps to agree with those of runs of 2^k steps, used by all levels."""
    if reason := why_not_counted(subject.scheme, subject.problem):
        raise Inapplicable(reason)
    return depends_on_count(subject.scheme, subject.problem)


def check_whole_state(subject: CellSubject) -> str:
    """Expect the state to hold all memory: a fresh copy of the scheme continues equally from a copy of it."""
    return contract.carries_its_memory(subject.of_paths(FEW_PATHS, contract.COARSE))


def on_trials(check: Callable[[Trial], str]) -> Callable[[CellSubject], str]:
    """Return the check of a cell that applies a check to its trials and reports the first fault."""

    @wraps(check)
    def of_cell(subject: CellSubject) -> str:
        for trial in subject.trials:
            if text := check(trial):
                steps = subject.problem.horizon / trial.h
                return f"{text} (h = {trial.h:.3g}, {np.round(steps):.0f} steps)"
        return ""

    return of_cell
