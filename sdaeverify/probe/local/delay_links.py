"""A delay equation as an ordinary one: the solution now and one delay ago, each with a Brownian motion.

For s in [0, tau] the pair (x(s + tau), x(s)) satisfies an equation without delay, in which the older solution is the
past of the other and phi its own past; so does x(s) alone. A scheme that makes these steps, the oldest one first, is
then a one-step map as usual. Results for the pair hold after the first delay, results for x alone up to it.

For s in (tau, T - tau], the older solution has a nonconstant past as well. It is replaced by phi(0), so that the pair
can be probed at all times of steps up to T.

Means of one step are then also taken over the older noise. This is what accumulates over the steps: given its past, a
step with additive noise is consistent of order 1/2 only (Definition 3.1 of Qu, Huang & Liu 2010), but converges with
1.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from ...arrays import Array, Mask, Parts
from ...contracts.scheme import Scheme, State, Step, flatten
from ...forms import Delayed, IndexOne, Problem
from ...forms.delay.linked import X, history_at, linked_equation
from ...noise.brownian import Increment
from ...noise.laws import Law
from ...numerics.newton import SOLVED
from ..step.nodes import SEED

Y = "y"


def remove_delay(scheme: Scheme, view: Problem, links: int = 2, until: float = np.inf) -> tuple[Scheme, Problem]:
    """Return a scheme and a problem without delay whose single steps are equivalent to those with the delay.

    Parameters
    ----------
    scheme : Scheme
    view : Problem
        Problem in the scheme's form.
    links : int
        2 for the solution after the first delay, 1 for the solution up to it.
    until : float
        End of the problem in delays, if that is before its horizon.

    Returns
    -------
    Scheme, Problem
        The given ones if there is no delay.
    """
    delayed = view.capability(Delayed)
    if delayed is None:
        return scheme, view
    # Any end at or after the horizon is replaced by infinity, so that equal problems compare equal.
    end = until if until * delayed.delay < delayed.horizon else np.inf
    return LinkedScheme(scheme, delayed, links), linked_equation(delayed, links, end)


def why_not_algebraic(scheme: Scheme, view: Problem) -> str:
    """Return why components other than x are memory that a step from x alone would reset, or an empty string."""
    form = view.capability(IndexOne)
    if form is None:
        return ""
    if len(flatten(scheme.start(view, 1, view.horizon))) > form.dimension + form.constraints:
        return "the scheme has memory beyond x and y"
    solved = not form.constraints or keeps_constraint(scheme, view)
    return "" if solved else "steps do not solve for y, which then is memory of the scheme"


def keeps_constraint(scheme: Scheme, view: Problem) -> bool:
    """Return whether y solves the constraint after a step that begins with such a y.

    The step is one after the first delay: earlier, lagged values come from the history, which a scheme may know.
    """
    form = view.capability(IndexOne)
    if form is None or not form.constraints:
        return False
    h, paths = min(view.horizon, form.delay or view.horizon) / 64.0, 8
    rng = np.random.Generator(np.random.Philox(key=SEED + 5))
    past = form.near_past(rng, paths, 0.1)
    noise = Increment(np.sqrt(h) * rng.standard_normal((view.noise_dim, paths)), None, **past)
    t, x = form.delay + h if form.delay else 0.0, np.repeat(form.past(0.0), paths, axis=1)
    state = form.consistent(t, x, form.lag(x, h, noise).now)
    after = scheme.parts(view, scheme.prepare(view, h)(scheme.enter(view, state, t, h), t, noise).state)
    known = {"t": np.full((1, 1), t + h), "lagged": past.get("ahead", after["x"])}
    value, scale = view.residuals({**after, **known})["u"]
    return bool((np.abs(value) <= SOLVED * scale).all())


@dataclass(frozen=True)
class LinkedScheme(Scheme):
    """The steps of a scheme at the present time and one or more delays ago.

    Attributes
    ----------
    scheme : Scheme
    problem : Delayed
    links : int
        Number of steps; the oldest one has the history as its past.
    """

    scheme: Scheme
    problem: Delayed
    links: int

    name: ClassVar[str] = "linked"
    form: ClassVar[type[Problem]] = Problem

    @property
    def law(self) -> Law:
        """Law of the increments of the given scheme."""
        return self.scheme.law

    def start(self, problem: Any, paths: int, h: float) -> State:
        """Return the initial state; that of the given scheme if it keeps more memory than `enter` sets."""
        own = self.scheme.start(self.problem, paths, h)
        entered = self.scheme.enter(self.problem, self.problem.initial(paths), 0.0, h)
        alike = type(own) is type(entered) and flatten(own).shape == flatten(entered).shape
        return super().start(problem, paths, h) if alike else own

    def parts(self, problem: Any, state: State) -> Parts:
        """Return the solution at the present time and at earlier multiples of the delay, as named components."""
        named: Parts = problem.parts(state)
        return named

    def step(
        self,
        problem: Problem,  # noqa: ARG002 - it was made from this scheme's problem
        state: Array,
        t: float,
        h: float,
        noise: Increment,
    ) -> Step:
        """Make the steps; t is the time of the oldest one."""
        delay, new, steps = self.problem.delay, [], []
        lagged, ahead = (history_at(self.problem, s, state) for s in (t, t + h))
        for age, (x, own) in enumerate(reversed(_split(state, noise, self.links))):
            step = self._step_link(x, t + age * delay, h, own._replace(lagged=lagged, ahead=ahead))
            lagged, ahead = x, self.scheme.parts(self.problem, step.state)[X]
            new.append(ahead)
            steps.append(step)
        failed, truncated = (_any_of([getattr(step, name) for step in steps]) for name in ("failed", "truncated"))
        return Step(np.concatenate(new[::-1]), failed=failed, truncated=truncated)

    def _step_link(self, x: Array, t: float, h: float, noise: Increment) -> Step:
        assert noise.lagged is not None
        state = self.scheme.enter(self.problem, self.problem.consistent(t, x, noise.lagged), t, h)
        return self.scheme.prepare(self.problem, h)(state, t, noise)


def _any_of(masks: Iterable[Mask | None]) -> Mask | None:
    given = [mask for mask in masks if mask is not None]
    return np.any(given, axis=0) if given else None


def _split(state: Array, noise: Increment, links: int) -> list[tuple[Array, Increment]]:
    nothing: list[Array | None] = [None] * links
    H = nothing if noise.H is None else np.split(noise.H, links)
    increments = map(Increment, np.split(noise.dW, links), H)
    return list(zip(np.split(state, links), increments, strict=True))
