"""Problems of each form with a solution in closed form that a scheme has no excuse to miss.

Each is offered in a few variants, from full noise to a single column and to an equation with an invariant, because
schemes refuse what they cannot treat.
"""

from collections.abc import Callable
from functools import cache
from typing import Any, NamedTuple

import numpy as np

from ..arrays import Array, Parts
from ..forms import SDE, DelaySDAE, HolonomicSDAE, Langevin, Problem

# Two columns, then one: full, diagonal, single.
NOISES: tuple[Array, ...] = (
    np.array([[0.7, -0.3], [0.2, 0.9]]),
    np.diag([0.7, 0.9]),
    np.array([[0.7], [0.2]]),
)
# For schemes that ask for noise of the same strength in each component.
EVEN = 0.8 * np.eye(2)
# For schemes that ask for an invariant: x_2 = 0.
ALONG = np.array([[0.7, -0.3], [0.0, 0.0]])
RATE = np.array([0.6, -0.4])
SPEED, FRICTION = 0.5, 0.5
# The checks' step size, and the factor by which it is shortened where an error is found.
H, SHORTER = 2.0**-6, 2.0**-20
# Delays, in steps: between mesh points, on one, within a step, and none.
DELAYS = (2.7, 2.0, 0.3, 0.0)
# One that stays where steps get shorter, so that a lagged value in the drift counts, and by how much they do then.
LONG, LESS_SHORT = 10.7 * H, 2.0**-10
# Rates and strengths of what vanishes on the solution; unlike, so that a lagged value in both of them stays.
PULL, TIE = 0.8, 0.5
SOURCE = "trivial problem of the conformance checks"


class Trivial(NamedTuple):
    """A problem and its solution.

    Attributes
    ----------
    name : str
        The equation, for messages.
    problem : Problem
    solution : callable, (float, ndarray of shape (l, P)) -> mapping of str to ndarray
        The components that are known at time t, given the sum of all increments of W.
    finer : Trivial or None
        What takes its place on shorter steps: a delay of the same number of them.
    shorter : float
        By how much steps are shortened.
    """

    name: str
    problem: Problem
    solution: Callable[[float, Array], Parts]
    finer: "Trivial | None" = None
    shorter: float = SHORTER

    @property
    def shortened(self) -> tuple["Trivial", float]:
        """The problem on shorter steps, and their size."""
        return self.finer or self, H * self.shorter

    @property
    def noisy(self) -> bool:
        """Whether the solution depends on W."""
        W = np.zeros((self.problem.noise_dim, 2))
        W[:, 1] = 1.0
        return any(bool(np.ptp(part, axis=1).any()) for part in self.solution(0.0, W).values())


@cache
def trivial_problems(form: type[Any]) -> tuple[tuple[Trivial, ...], ...]:
    """Return the problems of a form, each with its variants; none for a form that nothing is known of."""
    for known, problems in FORMS.items():
        if issubclass(form, known):
            return tuple(problems())
    return ()


def _sdes() -> list[tuple[Trivial, ...]]:
    noises = (*NOISES, EVEN, ALONG)
    still, moving = [0.0 * S for S in noises], [*(RATE for _ in noises[1:]), RATE * [1.0, 0.0]]
    return [
        tuple(_sde("dx = 0", 0.0 * RATE, S, invariant=S is still[-1]) for S in still),
        tuple(_sde("dx = c dt", c, S, invariant=S is still[-1]) for c, S in zip(moving, still, strict=True)),
        tuple(_sde("dx = S dW", 0.0 * RATE, S, invariant=S is ALONG) for S in noises),
    ]


def _sde(name: str, c: Array, S: Array, *, invariant: bool) -> Trivial:
    start, l = np.array([1.0, 0.0 if invariant else -0.5]), S.shape[1]
    diagonal = l == 2 and not (S - np.diag(np.diag(S))).any()
    problem = SDE(
        drift=lambda _t, x: c[:, None] + 0.0 * x,
        diffusion=lambda _t, x: S[..., None] + 0.0 * x[:1, None],
        diffusion_derivative=lambda _t, x, _y: np.zeros((2, l, x.shape[1])),
        constraint=(lambda x: x[1:]) if invariant else None,
        start=start,
        noise_dim=l,
        horizon=1.0,
        traits=frozenset({"additive-noise", "diagonal-noise"} if diagonal else {"additive-noise"}),
        source=SOURCE,
    )

    def solution(t: float, W: Array) -> Parts:
        return {"x": start[:, None] + t * c[:, None] + S @ W}

    return Trivial(name, problem, solution)


def _constrained() -> list[tuple[Trivial, ...]]:
    still = [_on_a_line("r at rest on r_2 = 0", 0.0, 0.0 * RATE, 0.0 * S) for S in NOISES]
    free = [_on_a_line("free motion on r_2 = 0", SPEED, 0.0 * RATE, 0.0 * S) for S in NOISES]
    kicked = [_on_a_line("dv = c dt + S dW on r_2 = 0", SPEED, RATE, S, known=("v",)) for S in NOISES]
    return [tuple(still), tuple(free), tuple(kicked)]


def _on_a_line(name: str, speed: float, a: Array, S: Array, known: tuple[str, ...] = ("r", "v", "mu")) -> Trivial:
    start = np.array([0.3, 0.0])
    problem = HolonomicSDAE(
        force=lambda _t, r, _v: a[:, None] + 0.0 * r,
        diffusion=lambda _t, r, _v: S[..., None] + 0.0 * r[:1, None],
        constraint=lambda r: r[1:],
        jacobian=lambda r: np.array([[[0.0], [1.0]]]) + 0.0 * r[:1],
        curvature=lambda _r, y, _z: 0.0 * y[1:],
        constraint_bound=1.0,
        position=start,
        velocity=[speed, 0.0],
        noise_dim=S.shape[1],
        horizon=1.0,
        traits=frozenset({"additive-noise"}),
        source=SOURCE,
    )
    along = np.array([[1.0], [0.0]])

    def solution(t: float, W: Array) -> Parts:
        v = along * (speed + t * a[0] + S[:1] @ W)
        parts = {"r": start[:, None] + t * v, "v": v, "mu": 0.0 * W[:1]}
        return {key: parts[key] for key in known}

    return Trivial(name, problem, solution)


def _langevins() -> list[tuple[Trivial, ...]]:
    still = _damped("q at rest", 0.0, 0.0, 0.0, ("q", "p"))
    coasting = _damped("dp = -gamma p dt", SPEED, 0.0, 0.0, ("q", "p"))
    kicked = _damped("dp = (c - gamma p) dt + sigma dW", SPEED, 0.4, 0.7, ("p",))
    return [(still,), (coasting,), (kicked,)]


def _damped(name: str, speed: float, force: float, sigma: float, known: tuple[str, ...]) -> Trivial:
    along, start = np.array([[1.0], [-0.5]]), np.array([0.3, 0.8])
    problem = Langevin(
        force=lambda q: force * along + 0.0 * q,
        friction=FRICTION,
        strength=sigma,
        position=start,
        momentum=speed * along[:, 0],
        horizon=1.0,
        source=SOURCE,
    )

    def solution(t: float, W: Array) -> Parts:
        decayed = -np.expm1(-FRICTION * t) / FRICTION
        p = along * (speed + decayed * (force - FRICTION * speed)) + sigma * W
        parts = {"q": start[:, None] + decayed * speed * along + 0.0 * W, "p": p}
        return {key: parts[key] for key in known}

    return Trivial(name, problem, solution)


def _delays() -> list[tuple[Trivial, ...]]:
    noise, none = (NOISES[1], NOISES[2]), tuple(np.zeros_like(S) for S in NOISES[1:])
    equations = [(0.0 * RATE, none), (RATE, none), (0.0 * RATE, noise)]
    on_few_steps = [
        tuple(_on_both(steps, c, S, algebraic=algebraic) for S in strengths for algebraic in (True, False))
        for steps in DELAYS
        for c, strengths in equations
    ]
    long = (_delayed(LONG, RATE, S, algebraic=algebraic) for S in none for algebraic in (True, False))
    return [*on_few_steps, tuple(trivial._replace(shorter=LESS_SHORT) for trivial in long)]


def _on_both(steps: float, c: Array, S: Array, *, algebraic: bool) -> Trivial:
    coarse, fine = (_delayed(steps * h, c, S, algebraic=algebraic) for h in (H, H * SHORTER))
    return coarse._replace(finer=fine)


def _delayed(tau: float, c: Array, S: Array, *, algebraic: bool) -> Trivial:
    """Return x moving at the velocity c, or by noise, and y that follows its past or, by noise, x itself.

    Where x moves at the velocity c, all else that coefficients hold vanishes if lagged values are right.
    """
    start, follows = np.array([1.0, -0.5]), not S.any()
    given: dict[str, Any] = {"constraint": _lags(follows), "algebraic": start - tau * c} if algebraic else {}

    def behind(x: Array, v: Array) -> Array:
        return np.asarray(v - x + tau * c[:, None]) if follows else 0.0 * x

    def drift(_t: float, x: Array, v: Array, y: Array) -> Array:
        tie = y - (v if follows else x) if algebraic else 0.0
        return np.asarray(c[:, None] + PULL * behind(x, v) + TIE * tie)

    def solution(t: float, W: Array) -> Parts:
        x = start[:, None] + t * c[:, None] + S @ W
        return {"x": x, "y": x - tau * c[:, None]} if algebraic else {"x": x}

    problem = DelaySDAE(
        drift=drift,
        diffusion=lambda _t, x, v, _y: S[..., None] + PULL * behind(x, v)[:, None],
        delay=tau,
        history=lambda t: start + t * c,
        **given,
        noise_dim=S.shape[1],
        horizon=1.0,
        traits=frozenset({"additive-noise"} if not follows else set()),
        source=SOURCE,
    )
    equation = "dx = S dW" if S.any() else "dx = c dt" if c.any() else "dx = 0"
    follower = (", y = x(t - tau)" if follows else ", y = x") if algebraic else ""
    return Trivial(equation + follower, problem, solution)


def _lags(follows: bool) -> Callable[[float, Array, Array, Array], Array]:
    return lambda _t, x, v, y: y - (v if follows else x)


FORMS: dict[type[Any], Callable[[], list[tuple[Trivial, ...]]]] = {
    SDE: _sdes,
    DelaySDAE: _delays,
    HolonomicSDAE: _constrained,
    Langevin: _langevins,
}
