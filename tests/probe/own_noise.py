"""Variables of mean 0, variance 1 and third moment 0 that a step makes of a normal one, and schemes that use them."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
import scipy

from probe.weak_cells import equation
from sdaeverify import SDE, Array, Claim, Increment, Scheme, Step

Shape = Callable[[Array], Array]


def three_point(z: Array) -> Array:
    """Return +-sqrt(3) or 0 by quantiles, as weak solvers make it."""
    u = scipy.special.ndtr(z)
    return np.sqrt(3.0) * ((u > 5.0 / 6.0).astype(float) - (u < 1.0 / 6.0))


def two_point(z: Array) -> Array:
    return np.where(z < 0.0, -1.0, 1.0)


def uniform(z: Array) -> Array:
    return np.sqrt(12.0) * (scipy.special.ndtr(z) - 0.5)


def five_point(z: Array) -> Array:
    """Return 0, +-1, +-sqrt(3) with probabilities 1/3, 1/4 and 1/12 of either sign."""
    u = 2.0 * np.abs(scipy.special.ndtr(z) - 0.5)
    return np.sign(z) * np.where(u > 5.0 / 6.0, np.sqrt(3.0), np.where(u > 1.0 / 3.0, 1.0, 0.0))


def permuted(z: Array) -> Array:
    """Return a uniform variable whose eighths have changed their places."""
    eighths = 8.0 * scipy.special.ndtr(z)
    return np.sqrt(12.0) * ((np.floor(eighths) * 5.0 % 8.0 + eighths % 1.0) / 8.0 - 0.5)


def laplace(z: Array) -> Array:
    return -np.sign(z) * np.log(2.0 * scipy.special.ndtr(-np.abs(z))) / np.sqrt(2.0)


SHAPES: dict[str, Shape] = {
    shape.__name__: shape for shape in (three_point, two_point, uniform, five_point, permuted, laplace)
}
MATRICES = np.random.Generator(np.random.Philox(key=1)).normal(0.0, 0.4, (3, 2, 2))


def noisy(motions: int) -> SDE:
    """Return an equation in the plane whose noise does not commute."""

    def diffusion(t: float, x: Array) -> Array:
        return np.stack([0.2 * (j + 1) + MATRICES[j] @ x for j in range(motions)], axis=1)

    return equation(lambda t, x: 0.3 * np.sin(x) - x, diffusion, [1.0, 0.5], noise_dim=motions)


@dataclass(frozen=True)
class OwnNoise(Scheme):
    """Euler-Maruyama with variables of its own in the place of dW: `size` times a shape of dW, or of H."""

    shape: str = "three_point"
    of: str = "dW"
    size: float = 1.0

    name: ClassVar[str] = "own-noise"
    form: ClassVar[type[SDE]] = SDE
    claims: ClassVar[tuple[Claim, ...]] = (Claim(measure="weak", value=1.0, source="made up"),)

    @property
    def noise(self) -> frozenset[str]:
        """What it uses."""
        return frozenset({"dW", self.of})

    def step(self, problem: Any, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        z = np.sqrt(12.0 / h) * noise.H if self.of == "H" else noise.dW / np.sqrt(h)
        kick = problem.diffused(t, state, self.size * np.sqrt(h) * SHAPES[self.shape](z))
        return Step(state + h * problem.drift(t, state) + kick)
