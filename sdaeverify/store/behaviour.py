"""Behaviour of schemes and problems, as digests of their results at fixed arguments.

The source code does not show the effect of data files, of the environment or of other modules; results do. They are
computed at many states, early and late, for the step sizes of the run and of its probes. Nine digits of each result
are used, so that a machine with different rounding gives the same digest.
"""

import hashlib
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np

from ..arrays import Array
from ..contracts.matching import match
from ..contracts.scheme import Scheme, State, Step, flatten
from ..contracts.specs import built
from ..errors import FAULTS
from ..forms import Problem
from ..forms.truths import Moment, Pathwise, Truth
from ..noise.brownian import Increment
from ..simulate.ensemble import PROBLEM, Behaviour, Marker, SchemeEvidence, Task, one_thread, run_block

PATHS = 16
SEED = 20170601
# Step sizes of probes, in units of time or in horizons, whichever are shorter.
PROBED = (2.0**-6, 2.0**-12)
# Time of the steps of these sizes, in horizons: after the end of every run.
LATE = 2.0
# Times at which a problem is evaluated, in horizons.
WHEN = (0.0, 0.37, 1.0)
# Number of significant bits; the offset keeps round numbers away from the boundary between two digests.
BITS, OFFSET = 30.0, 0.382
# A change of state smaller than this part of the state has fewer significant bits.
SMALL = 1e-3

# Appended to the names of schemes or problems whose results have changed.
CHANGED = "changed during the run, which is about neither version; run it again"
# A number, an array or a text.
Result = Any


def behaviours(task: Task, marker: Marker | None = None) -> tuple[Behaviour | None, ...]:
    """Return the behaviour of a task's schemes on its problem; None where it cannot be determined."""
    marker = marker or Marker()
    with np.errstate(all="ignore"), one_thread():
        try:
            with marker.of(PROBLEM):
                problem = built(task.spec)
                did = problem_digest(problem)
        except FAULTS:
            return tuple(None for _ in task.entries)
        return tuple(_behaviour(task, index, problem, did, marker) for index in range(len(task.entries)))


def _behaviour(task: Task, index: int, problem: Problem, did: str, marker: Marker) -> Behaviour | None:
    scheme = task.entries[index].scheme
    try:
        with marker.of(index):
            view = match(scheme, problem).problem
            return None if view is None else Behaviour(steps_digest(scheme, view, task.settings.steps), did)
    except FAULTS:
        return None


def run_observed(task: Task, block: int, marker: Marker | None = None) -> tuple[SchemeEvidence, ...]:
    """Simulate one block of paths, with the behaviour of schemes and problem before and after it.

    Parameters
    ----------
    task : Task
    block : int
    marker : Marker, optional
        As for `run_block`.

    Returns
    -------
    tuple of SchemeEvidence
        With an error for each scheme whose behaviour, or whose problem's, has changed in the meantime.
    """
    before = behaviours(task, marker)
    evidence = run_block(task, block, marker)
    after = behaviours(task, marker)
    return tuple(_with_behaviour(*each) for each in zip(evidence, before, after, strict=True))


def _with_behaviour(known: SchemeEvidence, before: Behaviour | None, after: Behaviour | None) -> SchemeEvidence:
    if changed := differing(before, after):
        return known._replace(errors=tuple(error or changed for error in known.errors))
    return known._replace(behaviour=before if before == after else None)


def steps_digest(scheme: Scheme, view: Problem, numbers: Sequence[int]) -> str:
    """Return a digest of the steps of a scheme.

    Two steps of the coarsest size spread the states over the region that a run reaches. From these states one step of
    each size is made, at increasing times.

    Parameters
    ----------
    scheme : Scheme
    view : Problem
        Of the scheme's form.
    numbers : sequence of int
        Steps of each level of the run, coarsest first.

    Returns
    -------
    str
    """
    with np.errstate(all="ignore"):
        return _digest(_Steps(scheme, view, tuple(numbers), _generator()).results())


def problem_digest(problem: Any) -> str:
    """Return a digest of a problem of any form: start, coefficients, defects, observables and truths."""
    rng, start = _generator(), flatten(problem.initial(PATHS))
    spread = (0.1 + np.abs(start)) * np.linspace(0.0, 1.0, PATHS)
    x = start + spread * rng.uniform(-1.0, 1.0, start.shape)
    with np.errstate(all="ignore"):
        known = (item for truth in problem.truths for item in _of_truth(problem, truth, rng))
        return _digest([*_of_equation(problem, x), *known])


def differing(*given: Behaviour | None) -> str:
    """Return an error text that names scheme or problem if their behaviour has changed; empty if it has not."""
    names = changed_parts(*given)
    return f"what the {' and the '.join(names)} does has {CHANGED}" if names else ""


def changed_parts(*given: Behaviour | None) -> list[str]:
    """Return which of scheme and problem have changed their behaviour, of those whose behaviour is known."""
    known = [one for one in given if one is not None]
    return [name for name in Behaviour._fields if len({getattr(one, name) for one in known}) > 1]


class _Steps(NamedTuple):
    """Steps of a scheme at fixed arguments."""

    scheme: Scheme
    view: Problem
    numbers: tuple[int, ...]
    rng: np.random.Generator

    def results(self) -> Iterator[Result]:
        h, far = self.view.horizon / self.numbers[0], np.sqrt(np.linspace(1.0, self.numbers[0], PATHS))
        state = start = self.scheme.start(self.view, PATHS, h)
        yield from _fields(start)
        for t in (0.0, h):
            found, after = self._step(state, t, h, far)
            yield from found
            state = _finite(after, start)
        for t, shorter in self._moments():
            yield from self._step(state, t, shorter, 1.0)[0]

    def _moments(self) -> Iterator[tuple[float, float]]:
        T, last = self.view.horizon, len(self.numbers) - 1
        for level, number in enumerate(self.numbers[1:], start=1):
            yield T * (number * level // last - 1) / number, T / number
        yield from ((LATE * T, h * min(1.0, T)) for h in PROBED)

    def _step(self, state: State, t: float, h: float, far: Any) -> tuple[list[Result], State]:
        try:
            result = self.scheme.prepare(self.view, h)(state, t, self._noise(state, t, h, far))
            return list(_digest_step(state, result)), result.state
        except FAULTS as error:
            return [type(error).__name__], state

    def _noise(self, state: State, t: float, h: float, far: Any) -> Increment:
        drawn = self.view.drawn(self.rng, h, PATHS, far)
        noise = self.view.add_past(h, self.scheme.law.increment(drawn, h))
        if noise.lagged is None or not t:
            return noise
        # The lagged values of a path are the states of other paths.
        x = self.scheme.parts(self.view, state)["x"]
        return noise._replace(lagged=np.roll(x, 1, axis=-1), ahead=np.roll(x, 2, axis=-1))


def _digest_step(before: State, result: Step) -> Iterator[Result]:
    least = SMALL * float(np.abs(flatten(before)).max())
    for old, new in zip(_fields(before), _fields(result.state), strict=True):
        yield _content(new - old, least)
    yield from (mask for mask in (result.failed, result.truncated) if mask is not None)
    for name, value in sorted({**result.outputs, **result.costs}.items()):
        yield from (name, _content(value, least))


def _of_equation(problem: Any, x: Array) -> Iterator[Result]:
    yield repr((sorted(problem.traits), sorted(problem.noise), problem.controls))
    yield from (problem.horizon, problem.relaxation_time, problem.noise_dim, flatten(problem.initial(1)))
    for when in WHEN:
        yield from _try_evaluating(problem.coefficients, when * problem.horizon, x)
    yield from _try_evaluating(_read, problem, x)


def _read(problem: Any, x: Array) -> Iterator[Result]:
    """Yield components, defects and observables of states."""
    parts = problem.parts(problem.state(x))
    yield from (*parts.values(), *(defect.value for defect in problem.residuals(parts).values()))
    for name, observable in problem.observables.items():
        yield from (name, *(observable(when * problem.horizon, parts) for when in WHEN))


def _of_truth(problem: Problem, truth: Truth, rng: np.random.Generator) -> Iterator[Result]:
    if isinstance(truth, Pathwise):
        yield from _try_evaluating(_path, problem, truth, rng)
    elif isinstance(truth, Moment):
        yield from (truth.observable, *_try_evaluating(lambda t: [truth.value(t)], problem.horizon))
    else:
        yield from vars(truth).values()


def _path(problem: Problem, truth: Pathwise, rng: np.random.Generator) -> Iterator[Result]:
    h, z = problem.horizon / len(WHEN), truth.start(PATHS)
    yield f"{truth.order} {truth.extra_normals}"
    for index in range(len(WHEN)):
        noise = problem.drawn(rng, h, PATHS)
        if truth.extra_normals:
            noise = noise._replace(xi=rng.standard_normal((truth.extra_normals, PATHS)))
        z = truth.advance(z, index * h, h, noise)
        yield from truth.parts((index + 1) * h, z).values()


def _try_evaluating(evaluated: Callable[..., Iterable[Result]], *arguments: Any) -> list[Result]:
    try:
        return list(evaluated(*arguments))
    except FAULTS as error:
        return [type(error).__name__]


def _generator() -> np.random.Generator:
    return np.random.Generator(np.random.Philox(key=SEED))


def _fields(state: State) -> tuple[Array, ...]:
    return state if isinstance(state, tuple) else (state,)


def _finite(state: State, start: State) -> State:
    """Return a state with values that are not finite replaced by those of the start."""
    kept = [np.where(np.isfinite(new), new, old) for new, old in zip(_fields(state), _fields(start), strict=True)]
    return type(state)(*kept) if isinstance(state, tuple) else kept[0]


def _content(values: Any, least: float = 0.0) -> bytes:
    """Return numbers as whole multiples of a power of 2: the largest of them, or `least` if larger, has 30 bits."""
    array = np.asarray(values, dtype=float)
    finite = np.isfinite(array)
    size = max(float(np.abs(array).max(where=finite, initial=0.0)), least)
    # Sizes are round numbers, often powers of 2. The factor 3 keeps them away from the steps of the ceiling.
    bits = BITS - np.ceil(np.log2(3.0 * size)) if size > 0.0 else 0.0
    digits = np.where(finite, np.floor(array * 2.0**bits + OFFSET), array)
    return f"{array.shape} {bits} ".encode() + digits.tobytes()


def _digest(results: Iterable[Result]) -> str:
    digest = hashlib.blake2b(digest_size=12)
    for result in results:
        content = result.encode() if isinstance(result, str) else result
        digest.update(content if isinstance(content, bytes) else _content(content))
        digest.update(b"\0")
    return digest.hexdigest()
