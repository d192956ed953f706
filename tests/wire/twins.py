"""The schemes of the programs in C, in Python with the same operations in the same order, under the same names."""

from typing import ClassVar, NamedTuple

import numpy as np

from sdaeverify import (
    SDE,
    Claim,
    DelaySDAE,
    DelayState,
    HolonomicSDAE,
    HolonomicState,
    Langevin,
    Scheme,
    Step,
    hookimpl,
)


def claims(**orders):
    """Return claims of orders."""
    return tuple(Claim(measure=measure, value=value, source="measured") for measure, value in orders.items())


class Milstein(Scheme):
    """Milstein's scheme for one Brownian motion."""

    name: ClassVar[str] = "wired-milstein"
    form: ClassVar[type] = SDE
    claims: ClassVar[tuple] = claims(strong=1.0, weak=1.0)

    def refuses(self, problem):
        return "" if "scalar-noise" in problem.traits else "it needs a problem with scalar-noise"

    def step(self, problem, state, t, h, noise):
        x, w = state, noise.dW[0]
        f, B = problem.drift(t, x), np.broadcast_to(problem.diffusion(t, x)[:, 0], x.shape)
        DB = problem.derivative_of_diffusion(t, x, B)[:, 0]
        return Step(x + h * f + B * w + DB * (0.5 * (w * w - h)))


class SymplecticEuler(Scheme):
    """Symplectic Euler for Langevin dynamics."""

    name: ClassVar[str] = "wired-langevin"
    form: ClassVar[type] = Langevin
    claims: ClassVar[tuple] = claims(strong=1.0, weak=1.0)

    def step(self, problem, state, t, h, noise):
        n = problem.noise_dim
        q, p = state[:n], state[n:]
        p = p + h * (problem.force(q) - problem.friction * p) + problem.strength * noise.dW
        return Step(np.concatenate([q + h * p, p]))


class WithForce(NamedTuple):
    """Positions over momenta, and the force at the positions."""

    x: np.ndarray
    force: np.ndarray


class Verlet(Scheme):
    """Velocity Verlet with friction and noise in its second kick, which keeps the force."""

    name: ClassVar[str] = "wired-verlet"
    form: ClassVar[type] = Langevin
    claims: ClassVar[tuple] = claims(strong=1.0, weak=1.0)

    def enter(self, problem, state, t, h):
        q = state[: problem.noise_dim]
        return WithForce(state, np.broadcast_to(problem.force(q), q.shape))

    def parts(self, problem, state):
        return problem.parts(state.x)

    def step(self, problem, state, t, h, noise):
        n = problem.noise_dim
        q, p = state.x[:n], state.x[n:]
        kicked = p + 0.5 * h * state.force
        q = q + h * kicked
        F = problem.force(q)
        kicked = kicked + 0.5 * h * F - h * problem.friction * p + problem.strength * noise.dW
        return Step(WithForce(np.concatenate([q, kicked]), F))


class HalfExplicit(Scheme):
    """Half-explicit Euler with one constraint."""

    name: ClassVar[str] = "wired-holonomic"
    form: ClassVar[type] = HolonomicSDAE
    claims: ClassVar[tuple] = claims(strong=0.5, weak=1.0, drift="round-off")

    def refuses(self, problem):
        return f"it is for m = 1 at most, and the problem has m = {m}" if (m := problem.constraints) > 1 else ""

    def step(self, problem, state, t, h, noise):
        r, v, mu = state
        normal, new = problem.inverse_mass(self._gradient(problem, r)), r + h * v
        for _ in range(8):
            c = problem.constraint(new)[0] / product(self._gradient(problem, new), normal)
            new = new - normal * c
        J = self._gradient(problem, new)
        x = v + problem.inverse_mass(h * problem.force(t, r, v) + problem.diffused(t, r, v, noise.dW))
        lam = -product(J, x) / product(J, normal)
        return Step(HolonomicState(new, x + normal * lam, mu + lam))

    def _gradient(self, problem, r):
        return np.broadcast_to(problem.dg(r)[0], r.shape)


def product(a, b):
    """Return the scalar product, summed from the first component on."""
    total = a[0] * b[0]
    for one, other in zip(a[1:], b[1:], strict=True):
        total = total + one * other
    return total


class DelayEuler(Scheme):
    """Euler's scheme for delay equations of index 1."""

    name: ClassVar[str] = "wired-delay"
    form: ClassVar[type] = DelaySDAE
    claims: ClassVar[tuple] = claims(strong=0.5, weak=1.0)

    def step(self, problem, state, t, h, noise):
        (x, y), lag = state, problem.lag(state.x, h, noise)
        f, kick = problem.drift(t, x, lag.now, y), problem.diffused(t, x, lag.now, y, noise.dW)
        new = x + h * f + kick
        return Step(DelayState(new, problem.eliminated(t + h, new, lag.ahead(new)) if problem.constraints else y))


@hookimpl
def sdaeverify_schemes():
    """Register them."""
    return [Milstein(), SymplecticEuler(), Verlet(), HalfExplicit(), DelayEuler()]
