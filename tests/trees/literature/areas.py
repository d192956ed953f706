"""Roessler (2010): schemes of strong order 1 for noises that need not commute, with Levy areas."""

from typing import ClassVar, NamedTuple

import numpy as np

from sdaeverify import SDE, Array, Claim, Increment, Scheme, Step

from .stages import noise_matrix, own_columns, table, weighted


class AreaTableau(NamedTuple):
    """alpha and A_0 of the drift, A_1 and B_1 of the noise's stages, beta_1 and beta_2 of its weights."""

    alpha: Array
    A_0: Array
    A_1: Array
    B_1: Array
    beta_1: Array
    beta_2: Array


class Areas(Scheme):
    """Noise stages of motion k see A_1 h f + B_1 sum_l b_l I_lk/sqrt(h); weights are beta_1 dW_k + beta_2 sqrt(h)."""

    form: ClassVar[type] = SDE
    noise: ClassVar[frozenset[str]] = frozenset({"dW", "A"})
    tableau: ClassVar[AreaTableau]
    claims: ClassVar[tuple[Claim, ...]] = (
        Claim(measure="strong", value=1.0, source="Roessler 2010, SRI1 and SRI2"),
        Claim(measure="weak", value=1.0, source="Roessler 2010: at least the strong order"),
    )

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the state x has shape (d, P)."""
        T, x, s, l = self.tableau, state, np.sqrt(h), problem.noise_dim
        first, integrals = noise_matrix(problem, t, x), noise.double_integrals(h) / s
        moves = [np.einsum("dlp,lp->dp", first, integrals[:, k]) for k in range(l)]
        f: list[Array] = []
        b: list[Array] = []
        for A_0, A_1, B_1 in zip(T.A_0, T.A_1, T.B_1, strict=True):
            noise_at = x + h * weighted(A_1, f)
            f.append(problem.drift(t + A_0.sum() * h, x + h * weighted(A_0, f)))
            b.append(own_columns(problem, t + A_1.sum() * h, [noise_at + B_1[0] * move for move in moves]))
        kick = np.einsum("dlp,lp->dp", weighted(T.beta_1, b), noise.dW) + s * weighted(T.beta_2, b).sum(axis=1)
        return Step(x + h * weighted(T.alpha, f) + kick)


class SRI1(Areas):
    """Roessler 2010, SRI1: one value of the drift."""

    name: ClassVar[str] = "sri1"
    source: ClassVar[str] = "Roessler 2010, SRI1"
    tableau: ClassVar[AreaTableau] = AreaTableau(
        alpha=np.array([1.0, 0.0, 0.0]),
        A_0=table((), (), ()),
        A_1=table((), (), ()),
        B_1=table((), (1.0,), (-1.0,)),
        beta_1=np.array([1.0, 0.0, 0.0]),
        beta_2=np.array([0.0, 1 / 2, -1 / 2]),
    )


class SRI2(Areas):
    """Roessler 2010, SRI2: of deterministic order 2."""

    name: ClassVar[str] = "sri2"
    source: ClassVar[str] = "Roessler 2010, SRI2"
    tableau: ClassVar[AreaTableau] = AreaTableau(
        alpha=np.array([1 / 2, 1 / 2, 0.0]),
        A_0=table((), (1.0,), ()),
        A_1=table((), (1.0,), (1.0,)),
        B_1=table((), (1.0,), (-1.0,)),
        beta_1=np.array([1.0, 0.0, 0.0]),
        beta_2=np.array([0.0, 1 / 2, -1 / 2]),
    )


SCHEMES = (SRI1(), SRI2())
