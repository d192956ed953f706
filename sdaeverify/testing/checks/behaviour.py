"""Checks of what a scheme does on a problem: the contract of a step, which every run begins with, name by name."""

from collections.abc import Callable
from dataclasses import replace
from itertools import product

import numpy as np

from ...conformance import contract
from ...conformance.contract import carries_its_memory, hears_its_noise, keeps_no_noise
from ...conformance.exactness import exactness_violation
from ...conformance.trial import Trial
from ...contracts.scheme import flatten
from ..subjects import LONG, CellSubject, SchemeSubject

# Memory shows on few paths as on many.
FEW_PATHS = 4


def exact(subject: SchemeSubject) -> str:
    """Expect exactness on dx = 0, dx = c dt and dx = S dW, but for a part that vanishes with h."""
    return exactness_violation(subject.scheme)


def untouched(subject: CellSubject) -> str:
    """Expect a step to leave state and noise as they were, read-only or not: other schemes read the noise, too."""
    return _each(subject, contract.leaves_inputs_alone)


def like_its_state(subject: CellSubject) -> str:
    """Expect a step to return a state like the one it was given, and flags, outputs and costs with a value a path."""
    return _each(subject, contract.returns_its_kind)


def any_number(subject: CellSubject) -> str:
    """Expect a step to take one path, and three, from the scheme's own start."""
    for paths, steps in product((1, 3), (contract.FINE, LONG)):
        trial = subject.of_paths(paths, steps)
        start = subject.scheme.start(subject.problem, paths, trial.h)
        if flatten(start).shape[-1] != paths:
            return f"it starts with {flatten(start).shape[-1]} paths where {paths} are wanted"
        if text := contract.returns_its_kind(replace(trial, given=start)):
            return f"on {paths} paths: {text}"
    return ""


def finite(subject: CellSubject) -> str:
    """Expect a step from finite states to be finite, unless it says that it failed."""
    return _each(subject, contract.stays_finite)


def same_again(subject: CellSubject) -> str:
    """Expect the same call to give the same bits, after another call and from a step prepared anew."""
    return _each(subject, contract.repeats_itself)


def reordered(subject: CellSubject) -> str:
    """Expect paths in another order to go where they went: their place in the batch is no part of the noise."""
    return _each(subject, contract.follows_the_paths)


def alone(subject: CellSubject) -> str:
    """Expect a path to go the same way alone and in any batch: paths that see each other are not independent."""
    return _each(subject, contract.takes_paths_alone) or contract.takes_paths_alone(subject.coarse)


def nothing_else_heard(subject: CellSubject) -> str:
    """Expect a step to use no noise but what it declares: the rest may not be drawn, or be anything."""
    return _each(subject, contract.uses_declared_noise)


def heard(subject: CellSubject) -> str:
    """Expect a step to use the increment of the Brownian motion wherever the equation has noise."""
    return _each(subject, hears_its_noise)


def own_memory(subject: CellSubject) -> str:
    """Expect the new state to share no memory with the noise, which is drawn afresh."""
    return _each(subject, keeps_no_noise)


def whole_state(subject: CellSubject) -> str:
    """Expect all memory to be in the state: from a copy of it, a fresh copy of the scheme goes on alike."""
    return carries_its_memory(subject.of_paths(FEW_PATHS, contract.COARSE))


def _each(subject: CellSubject, check: Callable[[Trial], str]) -> str:
    """Return what a check finds first on the trials of a scheme, with the step size."""
    for trial in subject.trials:
        if text := check(trial):
            steps = subject.problem.horizon / trial.h
            return f"{text} (h = {trial.h:.3g}, {np.round(steps):.0f} steps)"
    return ""
