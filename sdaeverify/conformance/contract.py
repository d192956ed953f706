"""The contract of a step: a pure function of its arguments, path by path.

Every interval of the program rests on it: paths that see each other are not independent, and a step that remembers
what it was asked before gives other errors in another order of calls.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from ..arrays import Array
from ..errors import FAULTS, SchemeError, one_line
from ..forms import NOISE, Problem
from ..noise import Increment
from ..probe.nodes import SEED
from ..probe.one_step import OneStep
from ..probe.states import SIZE, WHEN, cloud
from ..scheme import Scheme, State, Step, Stepper, flatten, same_kind
from ..statistics import EPS
from .batches import each, equal, frozen, nudged, taken

# A fine step, and the coarsest one that runs begin with by default, at which iterations differ most between paths.
FINE, COARSE = 64, 8
# Paths may differ between batches by so many rounding errors: vector instructions round otherwise at a row's end.
ROUNDINGS = 8.0
WRITES = "a step writes into its state or its noise"


@dataclass(frozen=True)
class Trial:
    """A scheme's step at the states of the cloud, each with its own noise; no input can be written into.

    Attributes
    ----------
    scheme : Scheme
    view : Problem
        Of the scheme's form.
    h : float
        Step size.
    x : ndarray, shape (d, P), or None
        States of the cloud; None where the scheme has memory that only steps can set.
    """

    scheme: Scheme
    view: Any
    h: float
    x: Array | None

    @cached_property
    def noise(self) -> Increment:
        """Noise of the step with the scheme's law, H where the problem has it drawn."""
        rng = np.random.Generator(np.random.Philox(key=SEED))
        dW, H = np.sqrt(self.h) * rng.standard_normal((2, self.view.noise_dim, SIZE))
        drawn = Increment(dW, H / np.sqrt(12.0) if "H" in self.view.noise else None)
        noise: Increment = frozen(self.scheme.law.increment(drawn._replace(**self._past(rng)), self.h))
        return noise

    def _past(self, rng: np.random.Generator) -> dict[str, Array]:
        """Return lagged values around the first state where the problem has a delay."""
        if self.view.recall(self.h, SIZE) is None:
            return {}
        x = self.view.initial(SIZE).x
        lagged, ahead = x + 0.5 * rng.standard_normal((2, *x.shape))
        return {"lagged": lagged, "ahead": ahead}

    @cached_property
    def state(self) -> State:
        """The scheme's states."""
        if self.x is not None:
            return frozen(OneStep(self.scheme, self.view).enter(self.x, WHEN * self.view.horizon, self.h))
        # A first step takes the paths apart.
        start = frozen(self.scheme.start(self.view, SIZE, self.h))
        result = self.step(start, self.noise)
        same_kind(start, result)
        return frozen(result.state)

    @cached_property
    def stepper(self) -> Stepper:
        """The step that all checks but one use."""
        return self.scheme.prepare(self.view, self.h)

    def step(self, state: State, noise: Increment) -> Step:
        """Make one step."""
        return self.stepper(state, WHEN * self.view.horizon, noise)

    @cached_property
    def first(self) -> Step:
        """The step of all paths, made before any other."""
        return self.step(self.state, self.noise)

    @cached_property
    def rounding(self) -> Array:
        """How much of each path may be rounding, shape (P,): eps of its size, or what eps of the inputs changes."""
        before, after = flatten(self.state), flatten(self.first.state)
        other = flatten(self.step(nudged(self.state), nudged(self.noise)).state)
        size = np.fmax(np.abs(before).max(axis=0), np.abs(after).max(axis=0))
        return np.asarray(ROUNDINGS * np.fmax(EPS * size, np.abs(other - after).max(axis=0)))

    def agree(self, paths: Array | slice) -> bool:
        """Tell whether some paths, in this order, go where they go among all of them."""
        some = self.step(taken(self.state, paths), taken(self.noise, paths))
        got, expected = flatten(some.state), flatten(taken(self.first.state, paths))
        if got.shape != expected.shape:
            return False
        same = (got == expected) | (np.isnan(got) & np.isnan(expected))
        return bool(np.all(same | (np.abs(got - expected) <= self.rounding[paths])))


Check = Callable[[Trial], str]
ALONE = "of few paths"


def contract_breach(scheme: Scheme, view: Problem) -> str:
    """Return the first violation of the contract in one line, or an empty string.

    What a step raises at states of the problem passes through: a scheme that cannot be run has broken no promise.
    """
    one_step = OneStep(scheme, view)
    x = None if one_step.refusal() else cloud(view, one_step.ito)
    trial, coarse = (Trial(scheme, view, view.horizon / steps, x) for steps in (FINE, COARSE))
    try:
        copies = each(np.copy, trial.state), each(np.copy, trial.noise)
        result = trial.first
    except ValueError as error:
        if "read-only" in str(error):
            return WRITES
        raise
    if not (equal(copies[0], trial.state) and equal(copies[1], trial.noise)):
        return WRITES
    tries = [(occasion, trial, check) for occasion, check in CHECKS.items()]
    return _wrong_kind(trial, result) or _first_violation([*tries, (ALONE, coarse, CHECKS[ALONE])])


def _first_violation(tries: list[tuple[str, Trial, Check]]) -> str:
    for occasion, trial, check in tries:
        try:
            text = check(trial)
        except FAULTS as error:
            text = f"a step {occasion} raises {one_line(error)}"
        if text:
            return text
    return ""


def _wrong_kind(trial: Trial, result: Step) -> str:
    try:
        same_kind(trial.state, result)
    except SchemeError as error:
        return str(error)
    masks = [mask for mask in (result.failed, result.truncated) if mask is not None]
    if not all(mask.shape == (SIZE,) and mask.dtype == np.bool_ for mask in masks):
        return f"failed or truncated is no boolean array of shape (P,) on P = {SIZE} paths"
    rows = (*result.outputs.values(), *result.costs.values())
    return "" if all(np.shape(row)[-1:] == (SIZE,) for row in rows) else "an output or cost is not one value a path"


def _repeats_itself(trial: Trial) -> str:
    # What a step remembers shows after it was asked something else in between.
    backwards = slice(None, None, -1)
    trial.step(taken(trial.state, backwards), taken(trial.noise, backwards))
    again = trial.step(trial.state, trial.noise)
    if not _same_step(trial.first, again):
        return "the same step made again gives other numbers: it depends on something beside its arguments"
    anew = trial.scheme.prepare(trial.view, trial.h)(trial.state, WHEN * trial.view.horizon, trial.noise)
    return "" if _same_step(again, anew) else "a step prepared anew gives other numbers"


def _follows_the_paths(trial: Trial) -> str:
    order = np.roll(np.arange(SIZE)[::-1], 4)
    return "" if trial.agree(order) else "in another order, paths go elsewhere"


def _takes_paths_alone(trial: Trial) -> str:
    batches = [slice(0, SIZE // 2), slice(SIZE // 2, None), *(slice(n, n + 1) for n in range(0, SIZE, 4))]
    return (
        ""
        if all(map(trial.agree, batches))
        else "a path goes elsewhere in another batch: it sees its neighbours, or the step remembers"
    )


def _uses_declared_noise(trial: Trial) -> str:
    undeclared = {
        name: np.full_like(part, np.nan)
        for name, part in trial.noise._asdict().items()
        if part is not None and name in NOISE - trial.scheme.noise
    }
    other = trial.step(trial.state, trial.noise._replace(**undeclared))
    return "" if _same_step(trial.first, other) else f"uses noise that it does not declare: {', '.join(undeclared)}"


def _same_step(a: Step, b: Step) -> bool:
    names = a.outputs.keys() == b.outputs.keys()
    return equal(a.state, b.state) and names and all(equal(a.outputs[k], b.outputs[k]) for k in a.outputs)


CHECKS: dict[str, Check] = {
    "made again": _repeats_itself,
    "of paths in another order": _follows_the_paths,
    ALONE: _takes_paths_alone,
    "without the noise it does not declare": _uses_declared_noise,
}
