"""The form dx = f dt + g dW + c(x-) dJ with a compound Poisson process J (Ito)."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from sdaeverify import Array, Increment, Parts, Problem, Trivial
from sdaeverify.numerics import apply
from sdaeverify.trees import GenericClass

from ._compound_poisson import JUMPS, CompoundPoisson


@dataclass(frozen=True, kw_only=True, eq=False)
class JumpDiffusion(Problem):
    """A stochastic differential equation with jumps.

    Attributes
    ----------
    drift : callable, (t, x) -> ndarray, shape (d, P)
        f.
    diffusion : callable, (t, x) -> ndarray, shape (d, l, P) or (d, l, 1)
        g.
    jump : callable, (t, x) -> ndarray, shape (d, P)
        c: a jump of J by a mark y takes x to x + c(t, x) y.
    jumps : CompoundPoisson
        J.
    start : array_like, shape (d,)
        x at time 0.
    """

    drift: Callable[[float, Array], Array]
    diffusion: Callable[[float, Array], Array]
    jump: Callable[[float, Array], Array]
    jumps: CompoundPoisson
    start: ArrayLike

    @property
    def records(self) -> tuple[CompoundPoisson]:
        """The jumps drive it beside the Brownian motions."""
        return (self.jumps,)

    @property
    def names(self) -> Mapping[str, slice] | None:
        """One component, ``x``."""
        return None

    @property
    def dimension(self) -> int:
        """Number d of components."""
        return len(np.asarray(self.start))

    def initial(self, paths: int) -> Array:
        """Return the initial state on every path, shape (d, P)."""
        return np.repeat(np.asarray(self.start, dtype=float)[:, None], paths, axis=1)

    def parts(self, x: Array) -> Parts:
        """Return the state under its name."""
        return {"x": x}

    def equation(self) -> "JumpDiffusion":
        """Return the equation itself, which is no Ito equation without its jumps."""
        return self

    def coefficients(self, t: float, x: Array) -> tuple[Array, ...]:
        """Return f, g and c."""
        return self.drift(t, x), self.diffusion(t, x), self.jump(t, x)

    def diffused(self, t: float, x: Array, w: Array) -> Array:
        """Return g(t, x) w, shape (d, P)."""
        return apply(self.diffusion(t, x), w)

    def euler(self, t: float, x: Array, h: float, noise: Increment) -> Array:
        """Return x + f h + g dW + c dJ."""
        moved = x + h * self.drift(t, x) + self.diffused(t, x, noise.dW)
        return np.asarray(moved + self.jump(t, x) * noise.records[JUMPS].total)

    @classmethod
    def trivial_problems(cls) -> tuple[tuple[Trivial, ...], ...]:
        """Return dx = c dt, dx = S dW and dx = c dJ."""
        return tuple((_trivial(*each),) for each in EQUATIONS)

    @classmethod
    def generic_classes(cls) -> tuple[GenericClass, ...]:
        """Return the class of all polynomial equations with jumps."""
        return (GenericClass("JumpDiffusion", _draw, FEATURES),)


EQUATIONS = (("dx = c dt", 1, 0, 0), ("dx = S dW", 0, 1, 0), ("dx = c dJ", 0, 0, 1))
RATE, FINER = 40.0, 2.0**20
DRIFT, NOISE, JUMP = np.array([[0.6], [-0.4]]), np.array([[0.7, -0.3], [0.2, 0.9]]), np.array([[0.5], [-0.8]])


def _trivial(name: str, drift: int, noise: int, jump: int, rate: float = RATE) -> Trivial:
    problem = JumpDiffusion(
        drift=lambda _t, x: drift * DRIFT + 0.0 * x,
        diffusion=lambda _t, x: noise * NOISE[..., None] + 0.0 * x[:1, None],
        jump=lambda _t, x: jump * JUMP + 0.0 * x,
        jumps=CompoundPoisson(rate, (0.5, -0.2), (0.6, 0.4)),
        start=[1.0, -0.5],
        noise_dim=2,
        horizon=1.0,
        source="trivial problem",
    )

    def solution(t: float, W: Array, jumps: Any = None) -> Parts:
        J = 0.0 if jumps is None else jumps.total
        return {"x": problem.initial(W.shape[1]) + t * drift * DRIFT + noise * NOISE @ W + jump * JUMP * J}

    # As many jumps a step where steps are shorter.
    finer = None if rate > RATE else _trivial(name, drift, noise, jump, FINER * rate)
    return Trivial(name, problem, solution, finer)


# Coefficients of random equations: linear in x with a sine, so that all their derivatives differ from 0.
GROWING, CHANGING = "state-jumps", "state-noise"
FEATURES = {CHANGING: "noise that depends on the state", GROWING: "jumps that depend on the state"}


class _Drawn(NamedTuple):
    # The function b + A sin(x + s), its values of some shape.
    b: Array
    A: Array
    s: Array
    shape: tuple[int, ...]

    def __call__(self, _t: float, x: Array) -> Array:
        return np.asarray(self.b[:, None] + self.A @ np.sin(x + self.s[:, None])).reshape(*self.shape, -1)


def _draw(rng: np.random.Generator, without: frozenset[str]) -> JumpDiffusion:
    """Draw an equation in two dimensions with two motions; see `GenericClass`."""

    def drawn(shape: tuple[int, ...], *, constant: bool = False) -> _Drawn:
        rows = int(np.prod(shape))
        b, A, s = rng.uniform(0.5, 1.0, rows), rng.uniform(0.2, 0.5, (rows, 2)), rng.uniform(-1.0, 1.0, 2)
        return _Drawn(b, 0.0 * A if constant else A, s, shape)

    return JumpDiffusion(
        drift=drawn((2,)),
        diffusion=drawn((2, 2), constant=CHANGING in without),
        jump=drawn((2,), constant=GROWING in without),
        jumps=CompoundPoisson(float(rng.uniform(1.0, 3.0)), (0.5, -0.3), (0.6, 0.4)),
        start=rng.uniform(-1.0, 1.0, 2),
        noise_dim=2,
        horizon=1.0,
        source="drawn at random",
    )
