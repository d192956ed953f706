"""Subjects of the checks: a scheme, a scheme on a problem, a problem."""

import inspect
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache, cached_property
from typing import Any, ClassVar

import numpy as np

from ..arrays import Array, Parts
from ..conformance.contract import trials
from ..conformance.own_run import stopped_states
from ..conformance.trial import Trial
from ..contracts.matching import Match, match
from ..contracts.scheme import Scheme, Step
from ..contracts.specs import ProblemSpec, describe, problem_name
from ..errors import FAULTS, UsageError, one_line
from ..forms import Delayed, IndexOne, Problem, as_sde, components, outside
from ..forms.delay.linked import linked_equation
from ..forms.names import article
from ..noise.brownian import Increment
from ..numerics import norm
from ..probe.step.states import cloud
from ..registry.load import Registry, load_registry
from ..registry.selection import only, select_problems, select_schemes
from .check import Inapplicable

Problems = str | Sequence[str | ProblemSpec | Callable[..., Problem]]

# Default number of problems on which a scheme is checked.
FEW = 3
# Number of steps over the horizon at which truncation shows, and of paths of the scheme's run.
LONG, OWN_PATHS = 2, 32


@dataclass(frozen=True)
class SchemeSubject:
    """A scheme, and the registry with the measures of its claims.

    Attributes
    ----------
    scheme : Scheme
    registry : Registry
    """

    scheme: Scheme
    registry: Registry


@dataclass(frozen=True)
class CellSubject:
    """A scheme on a problem of its form.

    Attributes
    ----------
    scheme : Scheme
    problem : Problem
        Problem in the view that the scheme solves.
    label : str
        Label of the problem.
    """

    scheme: Scheme
    problem: Problem
    label: str

    @property
    def trials(self) -> Iterator[Trial]:
        """A fine step at probe states, and a long step at states of a run of the scheme.

        Trials are created anew for each call, so that checks do not affect each other.
        """
        yield replace(self._at_the_cloud[0])
        yield replace(self._on_its_own)

    @property
    def coarse(self) -> Trial:
        """A coarse step at probe states, created anew for each call."""
        return replace(self._at_the_cloud[1])

    def of_paths(self, paths: int, steps: int) -> Trial:
        """Return a step on `paths` paths, with `steps` steps over the horizon."""
        return Trial(self.scheme, self.problem, self.problem.horizon / steps, None, paths)

    @cached_property
    def _at_the_cloud(self) -> tuple[Trial, ...]:
        return trials(self.scheme, self.problem)

    @cached_property
    def _on_its_own(self) -> Trial:
        states = stopped_states(self.scheme, self.problem, OWN_PATHS)
        return Trial(self.scheme, self.problem, self.problem.horizon / LONG, None, OWN_PATHS, states)


@cache
def load_plugins() -> Registry:
    """Return the registry of installed plugins, loaded once per process."""
    return load_registry()


def scheme_of(given: object, registry: Registry) -> Scheme:
    """Return a scheme, given as such or by its label.

    Raises
    ------
    UsageError
        If `given` is neither, or its label matches no scheme or several.
    """
    if isinstance(given, Scheme):
        return given
    if not isinstance(given, str):
        hint = f"; write {given.__name__}()" if isinstance(given, type) else ""
        raise UsageError(f"expected a scheme or its label, got {describe(given)}{hint}")
    return only("scheme", given, select_schemes(registry, given))


def problem_of(given: object, registry: Registry) -> ProblemSpec:
    """Return the specification of a problem, given as such, as its function or by its label.

    A function that cannot be registered is accepted here, because a check reports it.

    Raises
    ------
    UsageError
        If `given` is none of these, or its label matches no problem or several.
    """
    if inspect.isfunction(given):
        return ProblemSpec(problem_name(given), given)
    return only("problem", given, select_problems(registry, [given]))  # type: ignore[list-item]


def cells_of(scheme: Scheme, problems: Problems | None, registry: Registry) -> list[CellSubject]:
    """Return a scheme with each of the problems on which it is checked.

    Parameters
    ----------
    scheme : Scheme
    problems : str or sequence of str, ProblemSpec or callable, optional
        By default the three registered problems with the fewest components that the scheme accepts, excluding those
        on request and preferring the scheme's own form to a view.
    registry : Registry

    Raises
    ------
    UsageError
        If a named problem does not match the scheme, or no problem does.
    """
    if problems is None:
        return _smallest_cells(scheme, registry)
    if not problems:
        raise UsageError("problems is empty; leave it out for a few registered ones")
    return [_cell(scheme, spec) for spec in select_problems(registry, problems)]


def _cell(scheme: Scheme, spec: ProblemSpec) -> CellSubject:
    found = _match(scheme, spec.build(), spec.label)
    if found.problem is None:
        raise UsageError(f"scheme {scheme.label!r} cannot be put to problem {spec.label!r}: {found.reason}")
    return CellSubject(scheme, found.problem, spec.label)


def _smallest_cells(scheme: Scheme, registry: Registry) -> list[CellSubject]:
    matched = [cell for spec in select_problems(registry) for cell in _matching(scheme, spec)]
    if not matched:
        raise UsageError(f"no registered problem matches scheme {scheme.label!r}; give problems=[...]")
    return sorted(matched, key=lambda cell: (bool(cell.problem.seen_as), components(cell.problem), cell.label))[:FEW]


def _matching(scheme: Scheme, spec: ProblemSpec) -> Iterator[CellSubject]:
    try:
        problem = spec.build()
    except FAULTS:
        # A broken problem is reported by its own checks.
        return
    if (found := _match(scheme, problem, spec.label)).problem is not None:
        yield CellSubject(scheme, found.problem, spec.label)


def _match(scheme: Scheme, problem: Problem, label: str) -> Match:
    try:
        with np.errstate(all="ignore"):
            return match(scheme, problem)
    except FAULTS as error:
        text = f"scheme {scheme.label!r} cannot be put to problem {label!r}: it raises {one_line(error)}"
        raise UsageError(text) from error


# Number of paths of the run, and time at which coefficients are evaluated.
PATHS, WHEN = 12, 0.2
# Distance by which states are moved off a manifold, relative to their size.
MOVED = 0.01


@dataclass(frozen=True)
class Euler(Scheme):
    """Euler scheme x+ = x + f h + B dW, which provides states along a run."""

    name: ClassVar[str] = "euler-of-the-kit"
    form: ClassVar[type[Problem]] = Problem

    def step(self, problem: Any, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        return Step(state + h * problem.drift(t, state) + problem.diffused(t, state, noise.dW))


@dataclass(frozen=True)
class ProblemSubject:
    """A problem, and the registry with the schemes of its controls.

    Attributes
    ----------
    spec : ProblemSpec
    registry : Registry
    """

    spec: ProblemSpec
    registry: Registry

    @cached_property
    def problem(self) -> Any:
        """The problem, built once."""
        return self.spec.build()

    @cached_property
    def equation(self) -> Any:
        """Ito equation of the problem; with a delay, that of the solution now and one delay ago."""
        delayed = self.problem.capability(Delayed)
        seen = as_sde(self.problem) if delayed is None else linked_equation(delayed, 2)
        if seen is None:
            raise Inapplicable(f"{article(type(self.problem).__name__)} has no view as an SDE")
        return seen

    @cached_property
    def x(self) -> Array:
        """States of the equation along an Euler run, shape (d, 12); off a manifold by the drift of the run.

        If a step of the drift is larger than the state, Euler's scheme may leave the domain of the solution. The
        states are then the probe states of single steps, moved at random.
        """
        with np.errstate(all="ignore"):
            states: Array = stopped_states(Euler(), self.equation, PATHS)
            step = self.equation.horizon / PATHS * norm(self.equation.drift(WHEN, states))
        if (step <= 1.0 + norm(states)).all() and not outside(self.equation, states).any():
            return states
        view = self.equation if self.problem.capability(IndexOne) else self.problem
        states = cloud(view, self.equation)[:, -PATHS:]
        moved = states + MOVED * (1.0 + norm(states)) * directions(states, 1)[0]
        return np.asarray(np.where(outside(self.equation, moved), states, moved))

    @property
    def B(self) -> Array:
        """Diffusion matrix at these states, shape (d, l, 12)."""
        shape = (len(self.x), self.equation.noise_dim, PATHS)
        return np.asarray(np.broadcast_to(self.equation.diffusion(WHEN, self.x), shape))

    def offering(self, *kinds: type[Problem]) -> Any:
        """Return the first of the given kinds that the problem offers.

        Raises
        ------
        Inapplicable
            If it offers none of them.
        """
        offered = [found for kind in kinds if (found := self.problem.capability(kind)) is not None]
        if not offered:
            raise Inapplicable(self.problem.why_not(kinds[0]))
        return offered[0]

    def start(self, paths: int = 1) -> Parts:
        """Return the initial components, and for index 1 the lagged values and time, for constraints."""
        problem = self.problem
        parts: Parts = problem.parts(problem.initial(paths))
        if problem.capability(IndexOne) is None:
            return parts
        return {**parts, "lagged": np.repeat(problem.past(-problem.delay), paths, axis=1), "t": np.zeros((1, 1))}


def directions(x: Array, count: int = 3) -> list[Array]:
    """Return random unit vectors, each of shape (d, P), normalised on each path."""
    vectors = np.random.default_rng(5).standard_normal((count, *x.shape))
    return list(vectors / np.linalg.norm(vectors, axis=1, keepdims=True))


def excess(value: Array, bound: float, *terms: Array) -> str:
    """Return in words by how much a value exceeds the rounding error of cancelling terms, or an empty string.

    Parameters
    ----------
    value : ndarray
        Value that should be 0.
    bound : float
        Rounding error relative to the terms.
    *terms : ndarray
        Terms that cancel in `value`.
    """
    size = max(1.0, *(float(np.max(np.abs(term), initial=0.0)) for term in terms), 0.0)
    worst = float(np.max(np.abs(value), initial=0.0))
    return "" if worst <= bound * size else f"off by {worst:.2g}, where {bound * size:.1g} would be rounding"
