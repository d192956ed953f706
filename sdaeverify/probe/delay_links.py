"""A delay equation as an ordinary one: the solution now and one delay ago, each with its own Brownian motion.

For s in [0, tau] the pair (x(s + tau), x(s)) obeys an equation without delay, the older solution being the other's
past and phi its own; so does x(s) alone. A scheme that makes both steps, the older one first, is then a one-step map
like any other: what is found for ``x`` holds after the first delay, what is found for ``x before tau`` up to it.
"""

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from ..arrays import Array, Parts
from ..forms import SDE, DelaySDAE, DelayState, Problem
from ..laws import Law
from ..noise import Increment
from ..scheme import Claim, Scheme, State, Step
from .nodes import SEED

YOUNG, OLD, ALGEBRAIC = "x", "x before tau", "y"
# A defect this small, in parts of the terms that cancel in it, is a solver's: no order shows in it.
CLOSE = 1e-9


def linked(scheme: Scheme, view: Problem) -> tuple[Scheme, Problem]:
    """Return a scheme and a problem without delay on which one step says what it says with the delay.

    Parameters
    ----------
    scheme : Scheme
    view : Problem
        Of a form of the scheme.

    Returns
    -------
    Scheme, Problem
        The given ones where there is no delay.
    """
    if not isinstance(view, DelaySDAE) or not view.delay:
        return scheme, view
    return LinkedScheme(scheme, view), linked_equation(view)


def keeps_constraint(scheme: Scheme, view: Problem) -> bool:
    """Tell whether y solves the constraint after a step that begins with such a y, so that its order is that of x."""
    if not isinstance(view, DelaySDAE) or not view.constraints:
        return False
    h, paths = min(view.horizon, view.delay or view.horizon) / 64.0, 8
    rng = np.random.Generator(np.random.Philox(key=SEED + 5))
    start = view.initial(paths)
    lagged, ahead = start.x + 0.1 * rng.standard_normal((2, *start.x.shape))
    past = {"lagged": lagged, "ahead": ahead} if view.delay else {}
    noise = Increment(np.sqrt(h) * rng.standard_normal((view.noise_dim, paths)), None, **past)
    state = DelayState(start.x, view.eliminated(0.0, start.x, view.lag(start.x, h, noise).now))
    after = scheme.parts(view, scheme.prepare(view, h)(scheme.enter(view, state, 0.0, h), 0.0, noise).state)
    value, scale = view.residuals({**after, "t": np.full((1, 1), h), "lagged": ahead if view.delay else after["x"]})[
        "u"
    ]
    return bool((np.abs(value) <= CLOSE * scale).all())


@dataclass(frozen=True)
class LinkedScheme(Scheme):
    """The steps of a scheme now and one delay ago.

    Attributes
    ----------
    scheme : Scheme
    problem : DelaySDAE
        With a delay.
    """

    scheme: Scheme
    problem: DelaySDAE

    name: ClassVar[str] = "linked"
    form: ClassVar[type[SDE]] = SDE

    @property
    def law(self) -> Law:
        """Law of the increments."""
        return self.scheme.law

    @property
    def promises(self) -> tuple[Claim, ...]:
        """The scheme's own."""
        return self.scheme.promises

    def parts(self, problem: Any, state: State) -> Parts:
        """Return the solution now and one delay ago."""
        named: Parts = problem.parts(state)
        return named

    def step(
        self,
        problem: SDE,  # noqa: ARG002 - it was made from this scheme's problem
        state: Array,
        t: float,
        h: float,
        noise: Increment,
    ) -> Step:
        """Make both steps, t being the time of the older one."""
        d, delay, past = self.problem.dimension, self.problem.delay, self.problem.past
        x, v = state[:d], state[d:]
        now, then = _halved(noise)
        w, w_next = (np.broadcast_to(past(min(0.0, s - delay)), v.shape) for s in (t, t + h))
        older = self._one(v, w, t, h, then._replace(lagged=w, ahead=w_next))
        v_next = self._x(older)
        newer = self._one(x, v, t + delay, h, now._replace(lagged=v, ahead=v_next))
        failed = [step.failed for step in (older, newer) if step.failed is not None]
        return Step(np.concatenate([self._x(newer), v_next]), failed=np.any(failed, axis=0) if failed else None)

    def _one(self, x: Array, v: Array, t: float, h: float, noise: Increment) -> Step:
        state = DelayState(x, self.problem.eliminated(t, x, v) if self.problem.constraints else x[:0])
        return self.scheme.prepare(self.problem, h)(self.scheme.enter(self.problem, state, t, h), t, noise)

    def _x(self, step: Step) -> Array:
        return self.scheme.parts(self.problem, step.state)[YOUNG]


def linked_equation(problem: DelaySDAE) -> SDE:
    """Return the Ito equation of (x(s + tau), x(s)), shape (2 d, P), with y eliminated and time s."""
    plain, d, tau = problem.without_y(), problem.dimension, problem.delay
    none = np.zeros((0, 1))

    def drift(s: float, z: Array) -> Array:
        x, v, w = z[:d], z[d:], problem.past(min(0.0, s - tau)) + 0.0 * z[d:]
        return np.concatenate([plain.drift(s + tau, x, v, none), plain.drift(s, v, w, none)])

    def diffusion(s: float, z: Array) -> Array:
        x, v, w = z[:d], z[d:], problem.past(min(0.0, s - tau)) + 0.0 * z[d:]
        young, old = plain.diffusion(s + tau, x, v, none), plain.diffusion(s, v, w, none)
        paths, l = z.shape[-1], problem.noise_dim
        both = np.zeros((2 * d, 2 * l, paths), dtype=np.result_type(young, old))
        both[:d, :l], both[d:, l:] = young, old
        return both

    return SDE(
        drift=drift,
        diffusion=diffusion,
        start=np.tile(problem.past(0.0)[:, 0], 2),
        names={YOUNG: slice(0, d), OLD: slice(d, 2 * d)},
        noise_dim=2 * problem.noise_dim,
        noise=problem.noise,
        horizon=min(problem.horizon, tau),
        traits=problem.traits - {"scalar-noise", "diagonal-noise", "algebraic", "constrained"},
        source=f"now and one delay ago: {problem.source}",
        seen_as="linked equation",
    )


def _halved(noise: Increment) -> tuple[Increment, Increment]:
    l = len(noise.dW) // 2
    H = (None, None) if noise.H is None else (noise.H[:l], noise.H[l:])
    return Increment(noise.dW[:l], H[0]), Increment(noise.dW[l:], H[1])
