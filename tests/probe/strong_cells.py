"""Schemes of one formula each, correct and planted wrong, for the tests of local strong orders."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from cells import Formula, Rule
from facade import StrongOrder, consistency, local_strong, remove_delay, strong_orders, with_consistency
from sdaeverify import SDE, Array, HolonomicSDAE, HolonomicState, Increment, Problem, Scheme, Step
from sdaeverify.numerics import apply


def probed(scheme: Scheme, view: Problem, *, shortest: bool = False, links: int = 2) -> tuple[StrongOrder, ...]:
    """Return the strong orders of one step, with its deviation from the equation."""
    pair = remove_delay(scheme, view, links)
    fine = local_strong(*pair, shortest=True) if shortest else None
    names = tuple(pair[1].equation().names or "x")
    return with_consistency(strong_orders(local_strong(*pair), fine), consistency(*pair), names)


class WithAreas(Formula):
    """The same for a formula that uses H."""

    noise: ClassVar[frozenset[str]] = frozenset({"dW", "H"})


class NotSharp(Formula):
    """The same with the waiver."""

    local_order_is_global: ClassVar[bool] = False


@dataclass(frozen=True)
class Altered(Scheme):
    """Another scheme whose new state is altered: (problem, state, h, noise, new state) -> state."""

    scheme: Scheme
    change: Callable[[Any, Any, float, Increment, Any], Any]

    name: ClassVar[str] = "altered"
    form: ClassVar[type[HolonomicSDAE]] = HolonomicSDAE

    def step(self, problem: Any, state: Any, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        new = self.scheme.step(problem, state, t, h, noise).state
        return Step(self.change(problem, state, h, noise, new))


def euler(problem: SDE, x: Array, h: float, noise: Increment, *, drift: float = 1.0, strength: float = 1.0) -> Array:
    """Return x + drift f h + strength B dW."""
    return x + drift * h * problem.drift(0.0, x) + strength * apply(problem.diffusion(0.0, x), noise.dW)


def milstein(factor: float, clip: float = np.inf) -> Rule:
    """Return Milstein's rule with factor (1/2), and dW clipped at so many standard deviations."""

    def rule(problem: SDE, x: Array, h: float, noise: Increment) -> Array:
        dW = np.clip(noise.dW, -clip * np.sqrt(h), clip * np.sqrt(h))
        B = problem.diffusion(0.0, x)
        DBB = problem.derivative_of_diffusion(0.0, x, B[:, 0])[:, 0]
        return x + h * problem.drift(0.0, x) + B[:, 0] * dW + factor * DBB * (dW**2 - h)

    return rule


def no_correction(problem: SDE, x: Array, h: float, noise: Increment) -> Array:
    """Return the Euler step of the Stratonovich equation with the same coefficients."""
    B = problem.diffusion(0.0, x)
    return euler(problem, x, h, noise) - 0.5 * h * problem.derivative_of_diffusion(0.0, x, B[:, 0])[:, 0]


def sra1(area: float) -> Rule:
    """Return SRA1 with (area H + dW/2) in place of Z/h = H + dW/2 in its stage."""

    def rule(problem: SDE, x: Array, h: float, noise: Increment) -> Array:
        f, B = problem.drift(0.0, x), problem.diffusion(0.0, x)
        y = x + 0.75 * h * f + 1.5 * apply(B, area * noise.H + 0.5 * noise.dW)
        return x + h / 3.0 * (f + 2.0 * problem.drift(0.0, y)) + apply(B, noise.dW)

    return rule


def rotated(x: Array) -> Array:
    """Return J x."""
    return np.stack([-x[1], x[0]])


def on_circle(y: Array) -> Array:
    """Return the point of the unit circle nearest to y."""
    return y / np.sqrt((y * y).sum(axis=0))


def radially(problem: SDE, x: Array, h: float, noise: Increment) -> Array:
    """Return the Euler step projected onto the circle."""
    return on_circle(euler(problem, x, h, noise))


def too_wide(problem: SDE, x: Array, h: float, noise: Increment) -> Array:
    """Return the projected step on the circle of radius 1 + h."""
    return (1.0 + h) * radially(problem, x, h, noise)


def along_an_axis(problem: SDE, x: Array, h: float, noise: Increment) -> Array:
    """Return the Euler step moved onto the circle along the second axis."""
    y = euler(problem, x, h, noise)
    height = np.sqrt(np.maximum(1.0 - y[0] ** 2, 0.0))
    return np.stack([y[0], np.where(x[1] < 0.0, -height, height)])


def cayley(problem: SDE, x: Array, h: float, noise: Increment) -> Array:
    """Return (Id - J dW/2)^{-1} (Id + J dW/2) x."""
    half = 0.5 * noise.dW[0]
    y = x + half * rotated(x)
    return (y + half * rotated(y)) / (1.0 + half**2)


def multiplier_noise(problem: Any, old: HolonomicState, h: float, noise: Increment, new: HolonomicState) -> Any:
    """Make the multiplier one per cent too large."""
    return new._replace(mu=new.mu + 0.01 * (new.mu - old.mu))


def velocity_noise(
    problem: HolonomicSDAE, old: HolonomicState, h: float, noise: Increment, new: HolonomicState
) -> Any:
    """Add one per cent more variance to the velocity."""
    more = (np.sqrt(1.01) - 1.0) * apply(problem.diffusion(0.0, old.r, old.v), noise.dW)
    tangent = rotated(new.r)
    return new._replace(v=new.v + tangent * (tangent * more).sum(axis=0))
