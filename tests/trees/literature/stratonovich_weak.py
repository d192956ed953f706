"""Schemes of weak order 2 in Stratonovich's sense: Roessler (2007) and Komori (2007), applied to Ito equations."""

from itertools import combinations
from typing import Any, ClassVar, NamedTuple

import numpy as np

from sdaeverify import SDE, THREE_POINT, Array, Claim, Increment, Law, Scheme, Step

from .stages import antisymmetric, own_columns, signs, stratonovich_drift, table, weighted


class RSTableau(NamedTuple):
    """alpha, A_0, B_0 of the drift; A_1, B_1, B_3 of the noise's stages, B_2 of those with hats; beta_1, beta_2."""

    alpha: Array
    A_0: Array
    B_0: Array
    A_1: Array
    B_1: Array
    B_3: Array
    B_2: Array
    beta_1: Array
    beta_2: Array


class StratonovichWeak(Scheme):
    """Three-point variables dW, two-point ones beside them, and the drift f - (1/2) sum_k DB_k B_k."""

    form: ClassVar[type] = SDE
    noise: ClassVar[frozenset[str]] = frozenset({"dW", "H"})
    law: ClassVar[Law] = THREE_POINT

    def refuses(self, problem: SDE) -> str:
        """Refuse diffusions whose derivative, and with it the Stratonovich drift, cannot be had."""
        return problem.why_not_derivative_of_diffusion()


class RS(StratonovichWeak):
    """Noise stages of motion k see A_1 h f + B_1 b_k dW_k + B_3 b_l dW_l with l != k, hats B_2 b_l V_kl/sqrt(h).

    V_kl = dW_k sign_l for l < k and V_lk = -V_kl. The weights are beta_1 dW_k without a hat, beta_2 sqrt(h) with one.
    """

    tableau: ClassVar[RSTableau]
    claims: ClassVar[tuple[Claim, ...]] = (Claim(measure="weak", value=2.0, source="Roessler 2007"),)

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the state x has shape (d, P)."""
        T, x, s, dW, motions = self.tableau, state, np.sqrt(h), noise.dW, range(problem.noise_dim)
        f: list[Array] = []
        b: list[Array] = []
        for A_0, B_0, A_1, B_1, B_3 in zip(T.A_0, T.B_0, T.A_1, T.B_1, T.B_3, strict=True):
            noise_at = x + h * weighted(A_1, f)
            own, others = weighted(B_1, b) * dW, weighted(B_3, b) * dW
            drift_at = x + h * weighted(A_0, f) + _all(weighted(B_0, b) * dW)
            f.append(stratonovich_drift(problem, t + A_0.sum() * h, drift_at))
            states = [noise_at + _column(own, k) + _all(others) - _column(others, k) for k in motions]
            b.append(own_columns(problem, t + A_1.sum() * h, states))
        V = signed_areas(noise) / s
        hats = [own_columns(problem, t, [x + _all(weighted(B_2, b) * V[k]) for k in motions]) for B_2 in T.B_2]
        kick = _all(weighted(T.beta_1, b) * dW) + s * _all(weighted(T.beta_2, hats))
        return Step(x + h * weighted(T.alpha, f) + kick)


def signed_areas(noise: Increment) -> Array:
    """Return V_kl, shape (l, l, P)."""
    l, other = len(noise.dW), signs(noise)
    pairs = [noise.dW[k] * other[j] for j, k in combinations(range(l), 2)]
    return antisymmetric(np.reshape(pairs, (-1, noise.dW.shape[-1])), l)


def _all(columns: Any) -> Any:
    return columns.sum(axis=1) if np.ndim(columns) == 3 else 0.0


def _column(columns: Any, k: int) -> Any:
    return columns[:, k] if np.ndim(columns) == 3 else 0.0


FOUR_BY_OWN = table((), (2 / 3,), (1 / 12, 1 / 4), (-5 / 4, 1 / 4, 2.0))
FOUR_BY_OTHERS = table((), (), (1 / 4, 3 / 4), (1 / 4, 3 / 4))
THREE_EIGHTHS = np.array([1 / 8, 3 / 8, 3 / 8, 1 / 8])
NOISE: dict[str, Array] = {
    "A_1": table((), (), (1.0,), (1.0,)),
    "B_1": FOUR_BY_OWN,
    "B_3": FOUR_BY_OTHERS,
    "B_2": table((), (1.0,), (-1.0,), ()),
    "beta_1": THREE_EIGHTHS,
    "beta_2": np.array([0.0, -1 / 4, 1 / 4, 0.0]),
}


class RS1(RS):
    """Roessler 2007, RS1: of deterministic order 2."""

    name: ClassVar[str] = "rs1"
    source: ClassVar[str] = "Roessler 2007, RS1"
    tableau: ClassVar[RSTableau] = RSTableau(
        alpha=np.array([0.0, 0.0, 1 / 2, 1 / 2]),
        A_0=table((), (), (1.0,), ()),
        B_0=table((), (), (1 / 4, 3 / 4), ()),
        **NOISE,
    )


class RS2(RS):
    """Roessler 2007, RS2: of deterministic order 3."""

    name: ClassVar[str] = "rs2"
    source: ClassVar[str] = "Roessler 2007, RS2"
    tableau: ClassVar[RSTableau] = RSTableau(
        alpha=np.array([1 / 4, 1 / 4, 1 / 2, 0.0]),
        A_0=table((), (2 / 3,), (1 / 6, 1 / 2), ()),
        B_0=table((), (), (1 / 4, 3 / 4), ()),
        **NOISE,
    )


class KomoriTableau(NamedTuple):
    """c_0, A_00 and A_0j of the drift; c_j, A_j0, A_jj and A_jl of the noise."""

    c_0: Array
    A_00: Array
    A_0j: Array
    c_j: Array
    A_j0: Array
    A_jj: Array
    A_jl: Array


class NON(StratonovichWeak):
    """Komori 2007, NON: of deterministic order 4.

    Y_i = h F(x + A_00 Y + A_0j sum_k Y_k) and Y_k,i = dW_k b_k(x + A_j0 Y + A_jj Y_k + A_jl sum_l Y_l) with l != k.
    Beside them, for l < j with b_l and b_j of x, a two-point variable sign_j and y = sign_j b_j/2, z = dW_l b_l,

        x+ = ... + dW_l [b_l(x + y) - b_l(x - y)]/2 - sign_j [b_j(x + z) - b_j(x)]/2.
    """

    name: ClassVar[str] = "komori-non"
    source: ClassVar[str] = "Komori 2007, NON"
    claims: ClassVar[tuple[Claim, ...]] = (Claim(measure="weak", value=2.0, source="Komori 2007"),)
    tableau: ClassVar[KomoriTableau] = KomoriTableau(
        c_0=np.array([1 / 6, 1 / 3, 1 / 3, 1 / 6]),
        A_00=table((), (1 / 2,), (0.0, 1 / 2), (0.0, 0.0, 1.0)),
        A_0j=table((), (1.0,), (-9 / 8, 9 / 8), (1.0,)),
        c_j=THREE_EIGHTHS,
        A_j0=table((), (2.0,), (), (-2.0,)),
        A_jj=FOUR_BY_OWN,
        A_jl=FOUR_BY_OTHERS,
    )

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the state x has shape (d, P)."""
        T, x, dW, motions = self.tableau, state, noise.dW, range(problem.noise_dim)
        f: list[Array] = []
        b: list[Array] = []
        for A_00, A_0j, A_j0, A_jj, A_jl in zip(T.A_00, T.A_0j, T.A_j0, T.A_jj, T.A_jl, strict=True):
            noise_at, own, others = x + h * weighted(A_j0, f), weighted(A_jj, b), weighted(A_jl, b)
            drift_at = x + h * weighted(A_00, f) + _all(weighted(A_0j, b))
            f.append(stratonovich_drift(problem, t + A_00.sum() * h, drift_at))
            states = [noise_at + _column(own, k) + _all(others) - _column(others, k) for k in motions]
            b.append(dW * own_columns(problem, t + A_j0.sum() * h, states))
        pairs = self.pairs(problem, t, x, noise)
        return Step(x + h * weighted(T.c_0, f) + _all(weighted(T.c_j, b)) + pairs)

    def pairs(self, problem: SDE, t: float, x: Array, noise: Increment) -> Any:
        """Return what pairs of motions add, shape (d, P)."""
        other, B = signs(noise), problem.diffusion(t, x)
        total: Any = 0.0
        for j in range(problem.noise_dim):
            for l in range(j):
                y, z = 0.5 * other[j] * B[:, j], noise.dW[l] * B[:, l]
                up, down, far = (problem.diffusion(t, x + move) for move in (y, -y, z))
                total = total + 0.5 * noise.dW[l] * (up - down)[:, l] - 0.5 * other[j] * (far - B)[:, j]
        return total


SCHEMES = (RS1(), RS2(), NON())
