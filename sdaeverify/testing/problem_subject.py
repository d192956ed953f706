"""A problem under trial: states along a run of its equation, at which its functions are compared with each other."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar

import numpy as np

from ..arrays import Array, Parts
from ..conformance.own_run import stopped_states
from ..contracts.scheme import Scheme, Step
from ..contracts.specs import ProblemSpec
from ..forms import Delayed, IndexOne, Problem, as_sde
from ..forms.delay.linked import linked_equation
from ..noise.brownian import Increment
from ..numerics import norm
from ..probe.step.states import cloud
from ..registry.load import Registry
from .check import Inapplicable

# Paths of the run, and the time at which coefficients are looked at.
PATHS, WHEN = 12, 0.2
# How far states are moved off a manifold, in parts of their size.
MOVED = 0.01


@dataclass(frozen=True)
class Euler(Scheme):
    """x+ = x + f h + B dW: the run along which states are taken, and the simulation that truths are compared with."""

    name: ClassVar[str] = "euler-of-the-kit"
    form: ClassVar[type[Problem]] = Problem

    def step(self, problem: Any, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        return Step(state + h * problem.drift(t, state) + problem.diffused(t, state, noise.dW))


@dataclass(frozen=True)
class ProblemSubject:
    """A problem, and what is registered: schemes that its controls name.

    Attributes
    ----------
    spec : ProblemSpec
    registry : Registry
    """

    spec: ProblemSpec
    registry: Registry

    @cached_property
    def problem(self) -> Any:
        """The problem itself, of whatever form."""
        return self.spec.build()

    @cached_property
    def equation(self) -> Any:
        """Its Ito equation, with a delay that of the solution now and one delay ago."""
        delayed = self.problem.capability(Delayed)
        seen = as_sde(self.problem) if delayed is None else linked_equation(delayed, 2)
        if seen is None:
            raise Inapplicable(f"a {type(self.problem).__name__} has no view as an SDE")
        return seen

    @cached_property
    def x(self) -> Array:
        """States of the equation along a run, shape (d, 12); off a manifold by what the run has left it.

        Where a step of the drift is larger than the state, Euler's scheme leads to where no solution is: the states
        are then those at which steps are probed, moved at random.
        """
        with np.errstate(all="ignore"):
            states: Array = stopped_states(Euler(), self.equation, PATHS)
            step = self.equation.horizon / PATHS * norm(self.equation.drift(WHEN, states))
        if (step <= 1.0 + norm(states)).all():
            return states
        view = self.equation if self.problem.capability(IndexOne) else self.problem
        states = cloud(view, self.equation)[:, -PATHS:]
        return np.asarray(states + MOVED * (1.0 + norm(states)) * directions(states, 1)[0])

    @cached_property
    def B(self) -> Array:
        """The diffusion matrix at these states, shape (d, l, 12)."""
        shape = (len(self.x), self.equation.noise_dim, PATHS)
        return np.asarray(np.broadcast_to(self.equation.diffusion(WHEN, self.x), shape))

    def offering(self, *kinds: type[Problem]) -> Any:
        """Return the problem, if it offers one of some kinds.

        Raises
        ------
        Inapplicable
            If it does not.
        """
        offered = [found for kind in kinds if (found := self.problem.capability(kind)) is not None]
        if not offered:
            raise Inapplicable(self.problem.why_not(kinds[0]))
        return offered[0]

    def start(self, paths: int = 1) -> Parts:
        """Return the initial components, with what else a constraint may depend on."""
        problem = self.problem
        parts: Parts = problem.parts(problem.initial(paths))
        if problem.capability(IndexOne) is None:
            return parts
        return {**parts, "lagged": np.repeat(problem.past(-problem.delay), paths, axis=1), "t": np.zeros((1, 1))}


def directions(x: Array, count: int = 3) -> list[Array]:
    """Return unit vectors in random directions on each path."""
    vectors = np.random.default_rng(5).standard_normal((count, *x.shape))
    return list(vectors / np.linalg.norm(vectors, axis=1, keepdims=True))


def excess(value: Array, bound: float, *terms: Array) -> str:
    """Return in words how far a number is from a rounding error of terms that cancel, or an empty string.

    Parameters
    ----------
    value : ndarray
        What should be 0.
    bound : float
        Rounding error relative to the terms.
    *terms : ndarray
        What cancels in it.
    """
    size = max(1.0, *(float(np.max(np.abs(term), initial=0.0)) for term in terms), 0.0)
    worst = float(np.max(np.abs(value), initial=0.0))
    return "" if worst <= bound * size else f"off by {worst:.2g}, where {bound * size:.1g} would be rounding"
