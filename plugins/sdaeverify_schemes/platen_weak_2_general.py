"""Platen's explicit scheme of weak order 2 for noncommutative noise."""

from typing import ClassVar

import numpy as np

from sdaeverify import SDE, THREE_POINT, Array, Claim, Increment, Law, Scheme, Step, hookimpl
from sdaeverify.numerics import apply

from ._senses import by_growth
from ._side_by_side import side_by_side
from ._small_steps import STABLE
from .platen_weak_2 import SEPARATE


class PlatenWeak2General(Scheme):
    """Supporting values y = x + h f + B dW, y_j+- = x + h f +- s B_j and u_r+- = x +- s B_r with s = sqrt(h).

    With f and B taken at (t, x), f' and B' at time t + h, and B(u_r+-) at time t,

        x+ = x + (h/2) [f + f'(y)] + (1/4) sum_j [B'_j(y_j+) + B'_j(y_j-) + 2 B_j] dW_j
               + (1/4) sum_j sum_{r != j} [B_j(u_r+) + B_j(u_r-) - 2 B_j] dW_j
               + 1/(4 s) sum_j [B'_j(y_j+) - B'_j(y_j-)] (dW_j^2 - h)
               + 1/(4 s) sum_j sum_{r != j} [B_j(u_r+) - B_j(u_r-)] (dW_j dW_r + V_rj).

    V_rj = -V_jr = h zeta_r zeta_j for r < j with independent signs zeta, where H = sqrt(h/12) zeta for bounded
    increments. The products have the moments of independent two-point variables up to the required order.
    """

    name: ClassVar[str] = "platen-weak-2-general"
    form: ClassVar[type] = SDE
    noise: ClassVar[frozenset[str]] = frozenset({"dW", "H"})
    law: ClassVar[Law] = THREE_POINT
    claims: ClassVar[tuple[Claim, ...]] = (
        *by_growth(Claim(measure="weak", value=2.0, source="Kloeden & Platen 1992, section 15.1")),
        STABLE,
    )
    source: ClassVar[str] = "Kloeden & Platen 1992, (15.1.3)"

    def refuses(self, problem: SDE) -> str:
        """Refuse noise for which the cheaper `platen-weak-2` has the same order."""
        return "platen-weak-2 makes fewer evaluations for separate noise" if problem.traits & SEPARATE else ""

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the state x has shape (d, P)."""
        x, dW, s = state, noise.dW, np.sqrt(h)
        f, B, V = problem.drift(t, x), problem.diffusion(t, x), antisymmetric_noise(noise, h)
        centre = x + h * f
        new = x + 0.5 * h * (f + problem.drift(t + h, centre + apply(B, dW)))
        moves = [sign * s * B[:, j] for j in range(problem.noise_dim) for sign in (1.0, -1.0)]
        later = side_by_side(problem.diffusion, t + h, [centre + move for move in moves])
        beside = side_by_side(problem.diffusion, t, [x + move for move in moves])
        for j in range(problem.noise_dim):
            up, down = next(later)[:, j], next(later)[:, j]
            new = new + (up + down + 2.0 * B[:, j]) * (0.25 * dW[j]) + (up - down) * (0.25 / s * (dW[j] ** 2 - h))
            # Here j plays the role of r for all other columns k.
            above, below = next(beside), next(beside)
            for k in (k for k in range(problem.noise_dim) if k != j):
                up, down, product = above[:, k], below[:, k], dW[k] * dW[j] + V[j, k]
                new = new + (up + down - 2.0 * B[:, k]) * (0.25 * dW[k]) + (up - down) * (0.25 / s * product)
        return Step(new)


def antisymmetric_noise(noise: Increment, h: float) -> Array:
    """Return V_rj, antisymmetric in r and j, shape (l, l, P)."""
    assert noise.H is not None
    zeta = np.sqrt(12.0 / h) * noise.H
    order = np.sign(np.subtract.outer(np.arange(len(zeta)), np.arange(len(zeta))))
    return np.asarray(-h * order[..., None] * zeta[:, None] * zeta)


@hookimpl
def sdaeverify_schemes() -> list[Scheme]:
    """Register the scheme."""
    return [PlatenWeak2General()]
