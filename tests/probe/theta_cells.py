"""Steps with a lag for the tests of their moments: the theta method in closed form, and random ones."""

from typing import NamedTuple

import numpy as np

from facade import WIDTHS, LinearDelay, LinearDelayStep, Mesh, as_recursion, side_of
from sdaeverify import Array, Dissipation

MESHES = [Mesh(0, 0.0), Mesh(1, 0.0), Mesh(1, 0.3), Mesh(2, 0.0), Mesh(2, 0.7), Mesh(3, 0.4), Mesh(6, 0.1)]


class Linear(NamedTuple):
    """dx = (a x + b v + y) dt + (c x + d v) dW, 0 = l v + q x - y, v = x(t - tau)."""

    a: float
    b: float
    c: float
    d: float
    l: float = 0.0
    q: float = 0.0
    tau: float = 1.0

    @property
    def equation(self) -> LinearDelay:
        """The equation with y eliminated."""
        return LinearDelay(self.a + self.q, self.b + self.l, self.c, self.d, self.tau)

    @property
    def dissipation(self) -> Dissipation:
        """The constants of (4.1)."""
        a, b, c, d, l, q, _ = self
        mixed = abs(c * d)
        return Dissipation(-a, abs(a), abs(b), 1.0, c * c + mixed, d * d + mixed, 0.0, 1.0, abs(q), abs(l))

    def mesh(self, h: float) -> Mesh:
        """Return how the delay lies on steps of size h."""
        return Mesh.of(self.tau, h)

    def step(self, theta: float, h: float) -> LinearDelayStep:
        """Return the step of (x, y); of x_{n+1} in v_{n+1} the step knows the weight."""
        a, b, c, d, l, q, _ = self
        weight, s = self.mesh(h).weight, h * theta
        new_x = 1.0 - s * (a + q + weight * (b + l))
        explicit = h * (1.0 - theta)
        # Columns x_n, y_n, v_n, known part of v_{n+1}.
        x = np.array([1.0 + explicit * a, explicit, explicit * b, s * (b + l)]) / new_x
        kick = np.sqrt(h) * np.array([c, 0.0, d, 0.0]) / new_x
        y, ahead = q + l * weight, np.array([0.0, 0.0, 0.0, l])
        return LinearDelayStep(np.array([x, y * x + ahead]), np.array([[kick, y * kick]]))


SETS = {
    "I": Linear(-1.0, 0.0, 1.0, 0.0),
    "II": Linear(-1.0, 1.0, 1.0, 1.0),
    "III": Linear(-1.0, 1.0, 1.0, 1.0, 0.1, -10.0),
    "IV": Linear(-8.0, 2.0, 0.0, 1.0, 1.0, 1.0),
    "V": Linear(-4.0, 1.0, 0.0, 3.0, 1.0, 2.0),
    "VI": Linear(-4.0, 1.0, 0.0, 1.0, 0.2, 1.0),
}


def is_stable(step: LinearDelayStep, mesh: Mesh) -> bool | None:
    """Tell whether second moments tend to 0; None if the arithmetic does not tell."""
    if not np.isfinite(step.maps).all():
        return None
    recursion = as_recursion(step, mesh)
    side = side_of(recursion, 1.0)
    # Widths up to 1e-9 are tried: on the circle itself an eigenvalue of the means may lie, while noise makes the
    # radius larger.
    beside = (d for width in WIDTHS[:4] for d in (width, -width))
    while side == 0 and (d := next(beside, 0.0)):
        found = side_of(recursion, 1.0 + d)
        side = found if found * d < 0.0 else 0
    return {1: True, 0: None, -1: False}[side]


def random_step(rng: np.random.Generator, k: int, d: int, noises: int) -> LinearDelayStep:
    """Return a step with random coefficients whose second moments change by a factor of a few."""
    size = 0.5 / np.sqrt(k)
    return LinearDelayStep(
        size * rng.standard_normal((k, k + 2 * d)), 0.5 * size * rng.standard_normal((noises, k, k + 2 * d))
    )


def walked(step: LinearDelayStep, mesh: Mesh, x: Array, steps: int) -> list[Array]:
    """Return y_0, y_1, ... without noise, with one row, from x_{-m}, ..., x_0: (2.11) written out."""
    R, S, V = step.drift[0]
    m, delta = mesh
    known = list(x)
    for _ in range(steps):
        now = delta * known[-m] + (1.0 - delta) * known[-m - 1]
        ahead = (1.0 - delta) * known[-m] + (delta * known[1 - m] if m > 1 else 0.0)
        known.append(R * known[-1] + S * now + V * ahead)
    return known[len(x) - 1 :]
