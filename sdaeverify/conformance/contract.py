"""The contract of a step: a pure function of its arguments, path by path.

Every interval of the program relies on it: paths that influence each other are not independent, and a step that
remembers earlier calls has errors that depend on their order. Each check takes a trial and returns the violation in
one line, or an empty string.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ..arrays import Array, Mask, arrays, each
from ..contracts.scheme import Scheme, State, Step, Stepper, flatten, same_kind
from ..contracts.stages import FIRST_BLOCK
from ..errors import FAULTS, SchemeError, one_line
from ..forms import BROWNIAN, Problem
from ..noise.brownian import Increment
from ..numerics.linalg import all_finite
from ..numerics.statistics import EPS
from ..probe.step.nodes import SEED
from ..probe.step.one_step import OneStep
from ..probe.step.states import WHEN, cloud
from ..probe.step.times import in_a_row
from .batches import equal, freeze, take_paths
from .own_run import level_noise, stops_along
from .trial import Trial

# Steps per horizon of a fine step, and of the default coarsest step, at which iteration counts differ most by path.
FINE, COARSE = 64, 8
# Paths of the repeated calls that detect call counters: few, because there are as many calls as steps in a row.
FEW = slice(0, 2)
# Size: paths of a crowd that are stepped alone.
FEW_ALONE = 3
# States times components of a large batch: a step that treats paths by their index may do so only at large indices.
MANY = 640
# Paths of the one large batch of the kit: more than a run simulates together by default.
LARGE = 2**14
# Difference between batches that is accepted, relative to the state: a tolerance near rounding. Defects of one step
# cannot be distinguished from rounding below some hundreds of EPS times the weights of their reference, which is
# about the same.
JOINT = 4096.0 * EPS
WRITES = "a step writes into its state or its noise"

Check = Callable[[Trial], str]
ALONE = "of few paths"


def trials(scheme: Scheme, view: Problem) -> tuple[Trial, Trial]:
    """Return trials of a fine and a coarse step of a scheme at the probe states."""
    one_step = OneStep(scheme, view)
    x = None if one_step.why_not_probed(beside=True) else cloud(view, one_step.equation)
    return Trial(scheme, view, view.horizon / FINE, x), Trial(scheme, view, view.horizon / COARSE, x)


def contract_violation(scheme: Scheme, view: Problem) -> str:
    """Return the first violation of the contract in one line, or an empty string.

    An error raised by the first step at states of the problem passes through: it is no violation of the contract.

    Raises
    ------
    SchemeError
        If a step raises an error in one of the checks, which change its input.
    """
    trial, coarse = trials(scheme, view)
    if text := leaves_inputs_alone(trial) or returns_its_kind(trial):
        return text
    tries = [(occasion, trial, check) for occasion, check in CHECKS.items()]
    return _first_violation([*tries, (ALONE, coarse, CHECKS[ALONE])])


def _first_violation(tries: list[tuple[str, Trial, Check]]) -> str:
    for occasion, trial, check in tries:
        try:
            text = check(trial)
        except FAULTS as error:
            raise SchemeError(f"a step {occasion} raises {one_line(error)}") from error
        if text:
            return text
    return ""


def leaves_inputs_alone(trial: Trial) -> str:
    """Expect a step to leave state and noise as they were, read-only or not: other schemes read the noise, too.

    Compare the read-only inputs of the first step with copies made before.
    """
    try:
        copies = each(np.copy, trial.state), each(np.copy, trial.noise)
        _ = trial.first
    except ValueError as error:
        if "read-only" in str(error):
            return WRITES
        raise
    return "" if equal(copies[0], trial.state) and equal(copies[1], trial.noise) else WRITES


def returns_its_kind(trial: Trial) -> str:
    """Expect a step to return a state like the one it was given, and flags, outputs and costs with a value a path.

    Compare shapes and types in the result of a step with those of its state and number of paths.
    """
    result, paths = trial.first, trial.paths
    try:
        same_kind(trial.state, result)
    except SchemeError as error:
        return str(error)
    masks = [mask for mask in (result.failed, result.truncated) if mask is not None]
    if not all(mask.shape == (paths,) and mask.dtype == np.bool_ for mask in masks):
        return f"failed and truncated must be boolean arrays of shape (P,), P = {paths} paths"
    rows = (*result.outputs.values(), *result.costs.values())
    return (
        ""
        if all(np.shape(row)[-1:] == (paths,) for row in rows)
        else f"an output or cost must have one value a path, P = {paths}"
    )


def stays_finite(trial: Trial) -> str:
    """Expect a step from finite states to be finite, unless it is marked as failed.

    Find non-finite numbers on paths with finite states and steps that are not marked as failed.
    """
    before, after = all_finite(flatten(trial.state)), all_finite(flatten(trial.first.state))
    failed = np.zeros(trial.paths, dtype=bool) if trial.first.failed is None else trial.first.failed
    lost = int(np.count_nonzero(before & ~after & ~failed))
    return f"a step is not finite on {lost} of {trial.paths} paths that it does not mark as failed" if lost else ""


def repeats_itself(trial: Trial) -> str:
    """Expect the same call to give the same bits, after another call and from a step prepared anew.

    Repeat the step after another call, and with a newly prepared step.
    """
    # Memory of a step shows only after a call with other arguments in between.
    first, backwards = trial.first, slice(None, None, -1)
    trial.step(take_paths(trial.state, backwards), take_paths(trial.noise, backwards))
    again = trial.step(trial.state, trial.noise)
    if not same_step(first, again):
        return "the same step made twice gives two results: it must depend only on its arguments"
    anew = trial.scheme.prepare(trial.view, trial.h)(trial.state, WHEN * trial.view.horizon, trial.noise)
    return "" if same_step(again, anew) else "a step gives different numbers when it is prepared again"


def repeats_itself_for_long(trial: Trial) -> str:
    """Expect the same call to give the same bits, after other calls, many of them, and from a step prepared anew.

    Repeat the step after another call, with a newly prepared step, and as often as a long run makes steps. A run of
    the program also repeats the first step of each run of paths at its end.
    """
    return repeats_itself(trial) or _counts_calls(trial)


def _counts_calls(trial: Trial) -> str:
    state, noise = take_paths(trial.state, FEW), take_paths(trial.noise, FEW)
    first = trial.step(state, noise)
    for call in range(2, in_a_row(trial.view) + 1):
        if not same_step(first, trial.step(state, noise)):
            return f"the same step gives a different result at call {call}: it must depend only on its arguments"
    return ""


def follows_the_paths(trial: Trial) -> str:
    """Expect the same results for paths in another order, because the place of a path in the batch must not matter.

    Make the step of the same paths in another order.
    """
    order = np.roll(np.arange(trial.paths)[::-1], 4)
    return "paths in another order give other results: each must be stepped by itself" if trial.apart(order) else ""


def takes_paths_alone(trial: Trial) -> str:
    """Make the step of each half of the paths, of every fourth path alone, and of all in a batch of a run's size.

    A batch of different states, as in a run, is compared with its paths alone, too. Differences up to `JOINT` are
    accepted: see `ends_together`.
    """
    return _depends_on_batch(apart_in_batches(trial))


def takes_many_paths(trial: Trial) -> str:
    """Make the step of all paths, each many times and in random order, in one large batch."""
    return _depends_on_batch(trial.apart(_shuffled(trial, LARGE)))


def _depends_on_batch(apart: float) -> str:
    text = f"a path in a different batch gives a different result, by {apart:.2g} of the state's size"
    return f"{text}: each path must be stepped by itself, without memory" if apart > JOINT else ""


def apart_in_batches(trial: Trial) -> float:
    """Return the largest difference of paths between batches, beyond rounding, relative to the largest state."""
    half, many = trial.paths // 2, max(MANY // len(flatten(trial.state)), 1)
    parts = [slice(0, half), slice(half, None), *(slice(n, n + 1) for n in range(0, trial.paths, 4))]
    sizes = FIRST_BLOCK, trial.paths * many
    batches: list[Array | slice] = [*parts, *(_shuffled(trial, size) for size in sizes)]
    return max(*map(trial.apart, batches), _apart_in_crowd(trial.crowded))


def _apart_in_crowd(trial: Trial) -> float:
    """Return the same for a batch in which no two paths are alike: a few of its paths, each alone and many times."""
    few = np.linspace(0, trial.paths - 1, FEW_ALONE).astype(int).tolist()
    return max(trial.apart(np.repeat(path, count)) for path in few for count in (1, trial.paths))


def _shuffled(trial: Trial, size: int) -> Array:
    """Return paths in random order, shape (size,): in a row of copies, an exchange between copies would not show."""
    return np.random.Generator(np.random.Philox(key=SEED + 18)).integers(0, trial.paths, size)


def ends_together(trial: Trial) -> str:
    """Return that paths differ between batches by no more than a solver's tolerance, or an empty string.

    An iteration that ends when all paths have converged continues on converged paths as long as other paths have not
    converged. This changes them by the tolerance at most, which is too small to affect an interval or an order.
    """
    apart = apart_in_batches(trial)
    text = f"a path in a different batch gives a different result, by {apart:.2g} of the state's size"
    return f"{text}: let an iteration end for each path by itself" if 0.0 < apart <= JOINT else ""


def uses_declared_noise(trial: Trial) -> str:
    """Expect a step to use no noise but what it declares: the rest may not be drawn, or be anything.

    Replace noise that the scheme does not declare by NaN. If a step gives different results in two calls with the
    same arguments, this check cannot be made, and passes.
    """
    given, known = trial.noise, trial.scheme.noise
    fields = [name for name in BROWNIAN if getattr(given, name) is not None and name not in known]
    silent = given._replace(
        **{name: np.full_like(getattr(given, name), np.nan) for name in fields},
        records={n: part if n in known else each(_nothing, part) for n, part in given.records.items()},
    )
    undeclared = [*fields, *(name for name in given.records if name not in known)]
    same = same_step(trial.first, trial.step(trial.state, silent))
    same = same or not same_step(trial.first, trial.step(trial.state, trial.noise))
    return "" if same else f"uses noise that it does not declare: {', '.join(undeclared)}"


def reads_only_the_equation(trial: Trial) -> str:
    """Expect a step to depend on the equation alone: not on a problem's source, observables or truths.

    Make the step for a copy of the problem without source, observables, truths and controls.
    """
    bare = replace(trial.view, source="a copy", units="", observables={}, truths=(), controls=())
    same = same_step(trial.first, replace(trial, view=bare, given=trial.state).first)
    return "" if same else "a step depends on the source, the observables or the truths of the problem"


def _nothing(part: Array) -> Array:
    return np.full(part.shape, np.nan)


def same_step(a: Step, b: Step) -> bool:
    """Return whether two steps have the same state and outputs, to the last bit."""
    names = a.outputs.keys() == b.outputs.keys()
    return equal(a.state, b.state) and names and all(equal(a.outputs[k], b.outputs[k]) for k in a.outputs)


CHECKS: dict[str, Check] = {
    "made again": repeats_itself,
    "on paths in a different order": follows_the_paths,
    ALONE: takes_paths_alone,
    "without the noise it does not declare": uses_declared_noise,
}


# Whether a step depends on its noise, and keeps no reference to it.


def hears_its_noise(trial: Trial) -> str:
    """Expect a step to use the increment of the Brownian motion wherever the equation has noise.

    Make the step with noise of opposite sign and of half the size, on paths that ignore it also with half the step.

    A linear step may by chance be even in dW, constant on one side of 0, or constant, at one step size. A failed step
    may return its state unchanged, and if the equation has no noise at a state, no change is expected. A step that
    accepts or rejects may leave some paths unchanged, but not all.
    """
    listening, deaf = _listening_and_deaf(trial)
    if deaf.any():
        deaf &= _listening_and_deaf(replace(trial, h=0.5 * trial.h))[1]
    count = int(np.count_nonzero(deaf))
    if trial.scheme.discontinuous_in_noise and count < np.count_nonzero(listening):
        return ""
    return f"the step ignores the sign or size of the noise on {count} of {trial.paths} paths" if count else ""


def _listening_and_deaf(trial: Trial) -> tuple[Mask, Mask]:
    """Return the paths on which a step has to use its noise, and those of them on which it does not."""
    steps = [trial.first, *(trial.step(trial.state, _scale_noise(trial.noise, s)) for s in (-1.0, 0.5))]
    new, opposite, half = (flatten(made.state) for made in steps)
    changed = np.any((new != opposite) | (new != half), axis=0)
    failed = np.all([np.zeros(trial.paths, dtype=bool) if made.failed is None else made.failed for made in steps], 0)
    listening = _is_kicked(trial) & ~failed
    return listening, listening & ~changed


def keeps_no_noise(trial: Trial) -> str:
    """Expect the new state to share no memory with the noise, which is drawn afresh.

    Check whether the arrays of the new state share memory with the noise.
    """
    noise = list(arrays(trial.noise))
    shared = any(np.may_share_memory(a, b) for a in arrays(trial.first.state) for b in noise)
    return "the new state is a view of the noise, which the next draw overwrites" if shared else ""


def _scale_noise(noise: Increment, s: float) -> Increment:
    H, K = (None if part is None else s * part for part in (noise.H, noise.K))
    return noise._replace(dW=s * noise.dW, H=H, K=K, A=None if noise.A is None else s**2 * noise.A)


def _is_kicked(trial: Trial) -> np.ndarray[Any, np.dtype[np.bool_]]:
    """Return the paths on which the noise of the equation moves the state, shape (P,)."""
    parts = trial.scheme.parts(trial.view, trial.state)
    kick = trial.view.kick(WHEN * trial.view.horizon, parts, trial.noise)
    return np.ones(trial.paths, dtype=bool) if kick is None else np.any(kick != 0.0, axis=0)


# Whether the state of a scheme contains all its memory: a run continued from a copy of the state gives the same
# result.


# Steps of the run, and the numbers of steps after which it is continued from a copy.
STEPS, TAKEN_UP = 8, (0, 3)


def carries_its_memory(trial: Trial) -> str:
    """Continue a run from copies of its state with a new copy of the scheme, and compare the final states."""
    stops = list(stops_along(trial.scheme, trial.view, trial.h, list(_noises(trial))))
    for begin in TAKEN_UP:
        fresh = replace(trial.scheme)
        state, stepper = each(np.array, stops[begin].state), fresh.prepare(trial.view, trial.h)
        if not equal(_last(stepper, state, trial.h, begin, [stop.noise for stop in stops[begin:]]), stops[-1].end):
            when = f"after {begin} steps" if begin else "at its start"
            text = f"a run continued from a copy of its state {when} gives a different result"
            return f"{text}: the scheme has memory outside its state"
    return ""


def _noises(trial: Trial) -> Iterator[Increment]:
    for n in range(STEPS):
        drawn = level_noise(trial.view, trial.paths, trial.h, n)
        yield trial.lawful(drawn if "H" in trial.view.noise else drawn._replace(H=None))


def _last(stepper: Stepper, state: State, h: float, begin: int, noises: Sequence[Increment]) -> State:
    for n, noise in enumerate(noises, begin):
        state = stepper(freeze(state), n * h, noise).state
    return state
