"""Schemes of weak order 2 in Ito's sense: Roessler (2009) and Debrabant & Roessler (2009)."""

from itertools import combinations
from typing import ClassVar, NamedTuple

import numpy as np

from sdaeverify import SDE, THREE_POINT, Array, Claim, Increment, Law, Scheme, Step

from .stages import antisymmetric, own_columns, signs, table, weighted


class ItoTableau(NamedTuple):
    """alpha, A_0, B_0 of the drift; A_1, B_1 of the noise's stages, B_2 of those with hats; beta_1 to beta_4."""

    alpha: Array
    A_0: Array
    B_0: Array
    A_1: Array
    B_1: Array
    B_2: Array
    beta: Array


class ItoWeak(Scheme):
    """Stages with the three-point variables dW and with I_kl = (dW_k dW_l -+ V_kl)/2, I_kk = (dW_k^2 - h)/2.

    Drift stages see A_0 h f + B_0 b dW, noise stages of motion k A_1 h f + B_1 b_k sqrt(h), those with hats
    B_2 sum_l b_l I_kl/sqrt(h) with l != k. The weights are beta_1 dW_k + beta_2 I_kk/sqrt(h) without a hat and
    beta_3 dW_k + beta_4 sqrt(h) with one.
    """

    form: ClassVar[type] = SDE
    noise: ClassVar[frozenset[str]] = frozenset({"dW", "H"})
    law: ClassVar[Law] = THREE_POINT
    tableau: ClassVar[ItoTableau]
    claims: ClassVar[tuple[Claim, ...]] = (
        Claim(measure="weak", value=2.0, source="Roessler 2009; Debrabant & Roessler 2009"),
    )

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the state x has shape (d, P)."""
        T, x, s, motions = self.tableau, state, np.sqrt(h), range(problem.noise_dim)
        f: list[Array] = []
        b: list[Array] = []
        for A_0, B_0, A_1, B_1 in zip(T.A_0, T.B_0, T.A_1, T.B_1, strict=True):
            drift_at = x + h * weighted(A_0, f) + _times(weighted(B_0, b), noise.dW)
            noise_at, move = x + h * weighted(A_1, f), s * weighted(B_1, b) + np.zeros((len(x), len(motions), 1))
            f.append(problem.drift(t + A_0.sum() * h, drift_at))
            b.append(own_columns(problem, t + A_1.sum() * h, [noise_at + move[:, k] for k in motions]))
        I = self.double_integrals(noise, h) / s
        moves = [[_times(weighted(B_2, b), I[k]) for k in motions] for B_2 in T.B_2]
        hats = [own_columns(problem, t, [x + move for move in each]) for each in moves]
        own = (noise.dW**2 - h) / (2.0 * s)
        kick = _times(weighted(T.beta[0], b), noise.dW) + _times(weighted(T.beta[1], b), own)
        kick = kick + _times(weighted(T.beta[2], hats), noise.dW) + s * weighted(T.beta[3], hats).sum(axis=1)
        return Step(x + h * weighted(T.alpha, f) + kick)

    def double_integrals(self, noise: Increment, h: float) -> Array:
        """Return I_kl, 0 on the diagonal, shape (l, l, P)."""
        V = antisymmetric(self.variables_of_pairs(noise, h), len(noise.dW))
        return 0.5 * (noise.dW[:, None] * noise.dW * (1.0 - np.eye(len(noise.dW))[..., None]) + V)

    def variables_of_pairs(self, noise: Increment, h: float) -> Array:
        """Return V_kl, shape (l (l - 1)/2, P): h times a sign, uncorrelated for different pairs."""
        other = signs(noise)
        pairs = [other[j] * other[k] for j, k in combinations(range(len(other)), 2)]
        return np.reshape(pairs, (-1, other.shape[-1]))


class OneSignEach(ItoWeak):
    """V_kl = sqrt(h) sign_k for k < l: 2 l - 1 variables a step, and weak order 1 from three motions on.

    E I_kl I_km is then h^2/4 for k < l < m, where that of the double integrals is 0.
    """

    def variables_of_pairs(self, noise: Increment, h: float) -> Array:
        """Return V_kl, shape (l (l - 1)/2, P)."""
        other = signs(noise)
        pairs = [np.sqrt(h) * other[j] for j, _ in combinations(range(len(other)), 2)]
        return np.reshape(pairs, (-1, other.shape[-1]))


def _times(columns: Array, by: Array) -> Array:
    """Return the sum of columns, shape (d, l, P), each times a number of its own; 0 where there are none."""
    return 0.0 if np.ndim(columns) == 0 else np.einsum("dlp,lp->dp", columns, by)


TWO_SIDES = table((), (1.0,), (-1.0,))
WEIGHTS = np.array([[1 / 2, 1 / 4, 1 / 4], [0.0, 1 / 2, -1 / 2], [-1 / 2, 1 / 4, 1 / 4], [0.0, 1 / 2, -1 / 2]])
NEW = table((), (1.0,), (1.0,))
SIX = np.sqrt(6.0)


class RI1(ItoWeak):
    """Roessler 2009, RI1: of deterministic order 3."""

    name: ClassVar[str] = "ri1"
    source: ClassVar[str] = "Roessler 2009, RI1"
    tableau: ClassVar[ItoTableau] = ItoTableau(
        alpha=np.array([1 / 4, 1 / 2, 1 / 4]),
        A_0=table((), (2 / 3,), (-1 / 3, 1.0)),
        B_0=table((), (1.0,), ()),
        A_1=NEW,
        B_1=TWO_SIDES,
        B_2=TWO_SIDES,
        beta=WEIGHTS,
    )


class RI3(ItoWeak):
    """Roessler 2009, RI3: of deterministic order 3."""

    name: ClassVar[str] = "ri3"
    source: ClassVar[str] = "Roessler 2009, RI3"
    tableau: ClassVar[ItoTableau] = ItoTableau(
        alpha=np.array([1 / 6, 1 / 6, 2 / 3]),
        A_0=table((), (1.0,), (1 / 4, 1 / 4)),
        B_0=table((), ((3.0 - 2.0 * SIX) / 5.0,), ((6.0 + SIX) / 10.0,)),
        A_1=NEW,
        B_1=TWO_SIDES,
        B_2=TWO_SIDES,
        beta=WEIGHTS,
    )


class RI5(ItoWeak):
    """Roessler 2009, RI5: other weights of the noise."""

    name: ClassVar[str] = "ri5"
    source: ClassVar[str] = "Roessler 2009, RI5"
    tableau: ClassVar[ItoTableau] = ItoTableau(
        alpha=np.array([1 / 10, 3 / 14, 24 / 35]),
        A_0=table((), (1.0,), (25 / 144, 35 / 144)),
        B_0=table((), (1 / 3,), (-5 / 6,)),
        A_1=NEW / 4,
        B_1=TWO_SIDES / 2,
        B_2=TWO_SIDES,
        beta=np.array([[1.0, -1.0, -1.0], [0.0, 1.0, -1.0], [1 / 2, -1 / 4, -1 / 4], [0.0, 1 / 2, -1 / 2]]),
    )


class RI6(ItoWeak):
    """Roessler 2009, RI6: of deterministic order 2."""

    name: ClassVar[str] = "ri6"
    source: ClassVar[str] = "Roessler 2009, RI6"
    tableau: ClassVar[ItoTableau] = ItoTableau(
        alpha=np.array([1 / 2, 1 / 2, 0.0]),
        A_0=table((), (1.0,), ()),
        B_0=table((), (1.0,), ()),
        A_1=NEW,
        B_1=TWO_SIDES,
        B_2=TWO_SIDES,
        beta=WEIGHTS,
    )


def _hats_of_dri1() -> Array:
    old, both = 214 / 513 * np.sqrt(1105 / 991), 491 / 513 * np.sqrt(221 / 4955)
    return table((), (-old, -both, -both), (old, both, both))


class DRI1(ItoWeak):
    """Debrabant & Roessler 2009, DRI1: with smallest error constants."""

    name: ClassVar[str] = "dri1"
    source: ClassVar[str] = "Debrabant & Roessler 2009, DRI1"
    tableau: ClassVar[ItoTableau] = ItoTableau(
        alpha=np.array([1 / 6, 2 / 3, 1 / 6]),
        A_0=table((), (1 / 2,), (-1.0, 2.0)),
        B_0=table((), ((6.0 - SIX) / 10.0,), ((3.0 + 2.0 * SIX) / 5.0,)),
        A_1=NEW * 342 / 491,
        B_1=TWO_SIDES * 3.0 * np.sqrt(38 / 491),
        B_2=_hats_of_dri1(),
        beta=np.array(
            [
                [193 / 684, 491 / 1368, 491 / 1368],
                [0.0, np.sqrt(491 / 38) / 6, -np.sqrt(491 / 38) / 6],
                [-4955 / 7072, 4955 / 14144, 4955 / 14144],
                [0.0, -np.sqrt(4955 / 221) / 8, np.sqrt(4955 / 221) / 8],
            ]
        ),
    )


class RI6OneSignEach(OneSignEach, RI6):
    """RI6 with the variables of StochasticDiffEq.jl, of which there are 2 l - 1."""

    name: ClassVar[str] = "ri6-one-sign-each"


SCHEMES = (RI1(), RI3(), RI5(), RI6(), DRI1())
