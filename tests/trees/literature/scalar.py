"""Roessler (2010), section 6: schemes of strong order 3/2 for scalar and for diagonal noise."""

from typing import ClassVar, NamedTuple

import numpy as np

from sdaeverify import SDE, Array, Claim, Increment, Scheme, Step

from .stages import noise_matrix, table, weighted


class ScalarTableau(NamedTuple):
    """alpha, A_0 and B_0 of the stages of the drift, A_1 and B_1 of those of the noise; beta_1 to beta_4.

    The beta multiply dW, (dW^2 - h)/(2 sqrt(h)), Z/h and (dW^3 - 3 h dW)/(6 h).
    """

    alpha: Array
    A_0: Array
    B_0: Array
    A_1: Array
    B_1: Array
    beta: Array


class SRI(Scheme):
    """Drift stages see A_0 h f + B_0 b Z/h, noise stages A_1 h f + B_1 b sqrt(h)."""

    form: ClassVar[type] = SDE
    noise: ClassVar[frozenset[str]] = frozenset({"dW", "H"})
    tableau: ClassVar[ScalarTableau]
    claims: ClassVar[tuple[Claim, ...]] = (Claim(measure="strong", value=1.5, source="Roessler 2010, section 6"),)

    def refuses(self, problem: SDE) -> str:
        """Refuse noise that is neither scalar nor diagonal."""
        separate = problem.traits & {"scalar-noise", "diagonal-noise"}
        return "" if separate else "the noise is neither scalar nor diagonal"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the state x has shape (d, P)."""
        T, x, s, dW, Z = self.tableau, state, np.sqrt(h), noise.dW, noise.time_integral(h) / h
        f: list[Array] = []
        b: list[Array] = []
        for A_0, B_0, A_1, B_1 in zip(T.A_0, T.B_0, T.A_1, T.B_1, strict=True):
            drift_at = x + h * weighted(A_0, f) + Z * weighted(B_0, b)
            noise_at = x + h * weighted(A_1, f) + s * weighted(B_1, b)
            f.append(problem.drift(t + A_0.sum() * h, drift_at))
            b.append(own_noise(problem, t + A_1.sum() * h, noise_at))
        integrals = (dW, (dW**2 - h) / (2.0 * s), Z, (dW**3 - 3.0 * h * dW) / (6.0 * h))
        kick = sum(integral * weighted(beta, b) for integral, beta in zip(integrals, T.beta, strict=True))
        return Step(x + h * weighted(T.alpha, f) + kick)


def own_noise(problem: SDE, t: float, x: Array) -> Array:
    """Return the one column of scalar noise, or the diagonal of diagonal noise, shape (d, P)."""
    B = noise_matrix(problem, t, x)
    return B[:, 0] if problem.noise_dim == 1 else np.einsum("jjp->jp", B)


class SRI2W1(SRI):
    """Roessler 2010, SRI2W1: of deterministic order 3."""

    name: ClassVar[str] = "sri2w1"
    source: ClassVar[str] = "Roessler 2010, SRI2W1"
    tableau: ClassVar[ScalarTableau] = ScalarTableau(
        alpha=np.array([1 / 6, 1 / 6, 2 / 3, 0.0]),
        A_0=table((), (1.0,), (1 / 4, 1 / 4), ()),
        B_0=table((), (), (1.0, 1 / 2), ()),
        A_1=table((), (1 / 4,), (1.0,), (0.0, 0.0, 1 / 4)),
        B_1=table((), (-1 / 2,), (1.0,), (2.0, -1.0, 1 / 2)),
        beta=np.array(
            [
                [-1.0, 4 / 3, 2 / 3, 0.0],
                [1.0, -4 / 3, 1 / 3, 0.0],
                [2.0, -4 / 3, -2 / 3, 0.0],
                [-2.0, 5 / 3, -2 / 3, 1.0],
            ]
        ),
    )


SCHEMES = (SRI2W1(),)
