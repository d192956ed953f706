"""The scheme QUICSORT for Langevin dynamics, of strong order 3, with two time integrals of the noise."""

from typing import ClassVar

import numpy as np

from sdaeverify import Array, Claim, Increment, Langevin, Scheme, Step, hookimpl

# The nodes of Gauss-Legendre quadrature on [0, 1].
EARLY, LATE = 0.5 - np.sqrt(3.0) / 6.0, 0.5 + np.sqrt(3.0) / 6.0


class QUICSORT(Scheme):
    """Two force evaluations on a smooth path with dW, H and K of the Brownian path.

    With v = p + sigma (H + 6 K), w = sigma (dW - 12 K) and, of s in {l, r, 1}, (l, r) = 1/2 -+ sqrt(3)/6,

        e(s) = e^{-gamma s h},  a(s) = (1 - e(s))/gamma,  b(s) = (e(s) + gamma s h - 1)/(gamma^2 h),

        F_1 = F(q + a(l) v + b(l) w),   F_2 = F(q + a(r) v + b(r) w + a(1/3) h F_1),
        q+  = q + a(1) v + b(1) w + (h/2) [a(r) F_1 + a(l) F_2],
        p+  = e(1) v + a(1) w/h + (h/2) [e(r) F_1 + e(l) F_2] - sigma (H - 6 K).
    """

    name: ClassVar[str] = "quicsort"
    form: ClassVar[type[Langevin]] = Langevin
    noise: ClassVar[frozenset[str]] = frozenset({"dW", "H", "K"})
    claims: ClassVar[tuple[Claim, ...]] = (
        Claim(measure="strong", value=3.0, source="Scott, O'Kane, Jelincic & Foster 2025, Theorem 1.2"),
    )
    source: ClassVar[str] = "Foster, Lyons & Oberhauser 2021; Scott, O'Kane, Jelincic & Foster 2025"

    def refuses(self, problem: Langevin) -> str:
        """Refuse dynamics without friction, because the coefficients are divided by it."""
        return "" if problem.friction > 0.0 else "there is no friction, by which the coefficients are divided"

    def step(self, problem: Langevin, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the state (q, p) has shape (2 n, P)."""
        n, gamma, sigma = problem.noise_dim, problem.friction, problem.strength
        q, H, K = state[:n], noise.H, noise.K
        v, w = state[n:] + sigma * (H + 6.0 * K), sigma * (noise.dW - 12.0 * K)
        e, a = (lambda s: np.exp(-gamma * s * h)), (lambda s: -np.expm1(-gamma * s * h) / gamma)

        def moved(s: float) -> Array:
            return q + a(s) * v + (s * h - a(s)) / (gamma * h) * w

        first = problem.force(moved(EARLY))
        second = problem.force(moved(LATE) + a(1.0 / 3.0) * h * first)
        position = moved(1.0) + 0.5 * h * (a(LATE) * first + a(EARLY) * second)
        momentum = e(1.0) * v + a(1.0) * w / h + 0.5 * h * (e(LATE) * first + e(EARLY) * second)
        return Step(np.concatenate([position, momentum - sigma * (H - 6.0 * K)]))


@hookimpl
def sdaeverify_schemes() -> list[Scheme]:
    """Register the scheme."""
    return [QUICSORT()]
