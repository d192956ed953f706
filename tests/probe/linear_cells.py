"""Linear problems and schemes of one formula each, for the tests of second moments and of stability."""

from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

import numpy as np

from cells import Formula
from probe.strong_cells import euler
from sdaeverify import SDE, TWO_POINT, Array, Claim, Increment, Law, Scheme, Step
from sdaeverify.numerics import apply


def linear(a: Any, columns: Any = (), x_0: Any = (1.0,), **further: Any) -> SDE:
    """Return dx = A x dt + sum_j (C_j x + c_j) dW_j, the columns being given as C_j or as (C_j, c_j)."""
    A = np.atleast_2d(np.asarray(a, dtype=float))
    given = [column if isinstance(column, tuple) else (column, np.zeros(len(A))) for column in columns]
    C = [(np.atleast_2d(np.asarray(matrix, dtype=float)), np.asarray(c, dtype=float)) for matrix, c in given]

    def diffusion(t: float, x: Array) -> Array:
        return np.stack([matrix @ x + c[:, None] for matrix, c in C], axis=1)

    return SDE(
        drift=lambda t, x: A @ x,
        diffusion=diffusion,
        start=np.broadcast_to(np.asarray(x_0, dtype=float), (len(A),)).copy(),
        noise_dim=len(C),
        **{"horizon": 1.0, "source": "test", **further},
    )


class TwoPoint(Formula):
    """The same with two-point variables."""

    law: ClassVar[Law] = TWO_POINT


def milstein(problem: SDE, x: Array, h: float, noise: Increment) -> Array:
    twice = problem.diffusion(0.0, problem.diffusion(0.0, x)[:, 0])[:, 0]
    return np.asarray(euler(problem, x, h, noise) + 0.5 * twice * (noise.dW**2 - h))


def balanced(problem: SDE, x: Array, h: float, noise: Increment) -> Array:
    return np.asarray(x + (euler(problem, x, h, noise) - x) / (1.0 + np.abs(noise.dW).sum(axis=0)))


def tamed(problem: SDE, x: Array, h: float, noise: Increment) -> Array:
    f = h * problem.drift(0.0, x)
    return np.asarray(x + f / (1.0 + np.abs(f)) + apply(problem.diffusion(0.0, x), noise.dW))


def implicit_in_noise(problem: SDE, x: Array, h: float, noise: Increment) -> Array:
    return np.asarray((x + h * problem.drift(0.0, x)) / (1.0 - problem.diffusion(0.0, np.ones_like(x))[0] * noise.dW))


def exact_growth(a: float, b: float) -> Formula:
    return Formula(lambda problem, x, h, noise: x * np.exp((a - 0.5 * b * b) * h + b * noise.dW))


def two_windows(problem: SDE, x: Array, h: float, noise: Increment) -> Array:
    """Multiply E x^2 by 1 + (h - 1/2)(h - 2)(h - 3)/(5 (1 + h)^3): stable for h < 1/2 and for 2 < h < 3."""
    rho = 1.0 + 0.2 * (h - 0.5) * (h - 2.0) * (h - 3.0) / (1.0 + h) ** 3
    return np.asarray(np.sqrt(rho / h) * noise.dW * x)


class Memory(NamedTuple):
    """The components, the last drift, and something that reaches neither of them."""

    x: Array
    last: Array
    unseen: Array


class AdamsBashforth(Scheme):
    """x+ = x + h (3/2 f_n - 1/2 f_(n-1)) + B dW, and a random walk that nothing depends on."""

    name: ClassVar[str] = "adams-bashforth"
    form: ClassVar[type[SDE]] = SDE

    def enter(self, problem: SDE, state: Array, t: float, h: float) -> Memory:
        return Memory(state, problem.drift(t, state), np.zeros((1, state.shape[1])))

    def parts(self, problem: SDE, state: Memory) -> dict[str, Array]:
        return {"x": state.x}

    def step(self, problem: SDE, state: Memory, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        f = problem.drift(t, state.x)
        x = state.x + h * (1.5 * f - 0.5 * state.last) + apply(problem.diffusion(t, state.x), noise.dW)
        return Step(Memory(x, f, 2.0 * state.unseen + noise.dW[:1]))


class History(NamedTuple):
    """The present and the past."""

    x: Array
    past: Array


@dataclass(frozen=True)
class Delayed(Scheme):
    """x+ = x + h (f(x) + c x_(n - m)) + B dW: the delay equation with f and delay m h, the past being memory."""

    steps: int
    strength: float

    name: ClassVar[str] = "delayed"
    form: ClassVar[type[SDE]] = SDE

    def enter(self, problem: SDE, state: Array, t: float, h: float) -> History:
        return History(state, np.repeat(state, self.steps, axis=0))

    def parts(self, problem: SDE, state: History) -> dict[str, Array]:
        return {"x": state.x}

    def step(self, problem: SDE, state: History, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        x = euler(problem, state.x, h, noise) + h * self.strength * state.past[-1:]
        return Step(History(x, np.concatenate([state.x, state.past[:-1]])))


class Reversible(NamedTuple):
    """The components, their companion, and the coefficients there."""

    x: Array
    z: Array
    drift: Array
    diffusion: Array


@dataclass(frozen=True)
class ReversibleHeun(Scheme):
    """z+ = 2 x - z + h F(z) + B(z) dW, x+ = x + h (F(z) + F(z+))/2 + (B(z) + B(z+)) dW/2."""

    promised: tuple[Claim, ...] = ()

    name: ClassVar[str] = "reversible-heun"
    form: ClassVar[type[SDE]] = SDE

    @property
    def promises(self) -> tuple[Claim, ...]:
        return self.promised

    def enter(self, problem: SDE, state: Array, t: float, h: float) -> Reversible:
        return Reversible(state, state, problem.drift(t, state), _flat_diffusion(problem, t, state))

    def parts(self, problem: SDE, state: Reversible) -> dict[str, Array]:
        return dict(problem.parts(state.x))

    def step(self, problem: SDE, state: Reversible, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        x, z, F, B = state

        def kick(flat: Array) -> Array:
            return apply(flat.reshape(len(x), -1, x.shape[1]), noise.dW)

        z = 2.0 * x - z + h * F + kick(B)
        F_new, B_new = problem.drift(t + h, z), _flat_diffusion(problem, t + h, z)
        return Step(Reversible(x + 0.5 * h * (F + F_new) + 0.5 * kick(B + B_new), z, F_new, B_new))


def _flat_diffusion(problem: SDE, t: float, x: Array) -> Array:
    B = np.broadcast_to(problem.diffusion(t, x), (len(x), problem.noise_dim, x.shape[1]))
    return B.reshape(-1, x.shape[1])
