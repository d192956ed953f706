"""Schemes of strong order 3/2 for additive noise: Roessler (2010) and Foster, dos Reis & Strange (2024)."""

from typing import ClassVar, NamedTuple

import numpy as np

from sdaeverify import SDE, Array, Claim, Increment, Scheme, Step

from .stages import table, weighted


class AdditiveTableau(NamedTuple):
    """alpha and A_0 of the drift; B_W, B_Z, beta_W and beta_Z of the noise dW and Z/h = H + dW/2."""

    alpha: Array
    A_0: Array
    B_W: Array
    B_Z: Array
    beta_W: Array
    beta_Z: Array


class Additive(Scheme):
    """y_i = x + sum_j A_ij h f(y_j) + B (B_W,i dW + B_Z,i Z/h), x+ = x + sum_i alpha_i h f(y_i) + B (...)."""

    form: ClassVar[type] = SDE
    noise: ClassVar[frozenset[str]] = frozenset({"dW", "H"})
    tableau: ClassVar[AdditiveTableau]
    claims: ClassVar[tuple[Claim, ...]] = (
        Claim(measure="strong", value=1.5, source="Roessler 2010, section 6"),
        Claim(measure="weak", value=2.0, source="measured"),
    )

    def refuses(self, problem: SDE) -> str:
        """Refuse noise that is not declared additive."""
        return "" if "additive-noise" in problem.traits else "the noise is not declared additive"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the state x has shape (d, P)."""
        T, x, Z, drifts = self.tableau, state, noise.time_integral(h) / h, []

        def kick(of_W: float, of_Z: float) -> Array:
            return problem.diffused(t, x, of_W * noise.dW + of_Z * Z)

        for A, of_W, of_Z in zip(T.A_0, T.B_W, T.B_Z, strict=True):
            drifts.append(problem.drift(t + A.sum() * h, x + h * weighted(A, drifts) + kick(of_W, of_Z)))
        return Step(x + h * weighted(T.alpha, drifts) + kick(float(T.beta_W.sum()), float(T.beta_Z.sum())))


class SRA2(Additive):
    """Roessler 2010, SRA2: as SRA1 with other times of the noise, which do not matter for a constant one."""

    name: ClassVar[str] = "sra2"
    source: ClassVar[str] = "Roessler 2010, SRA2"
    tableau: ClassVar[AdditiveTableau] = AdditiveTableau(
        alpha=np.array([1 / 3, 2 / 3]),
        A_0=table((), (3 / 4,)),
        B_W=np.zeros(2),
        B_Z=np.array([0.0, 3 / 2]),
        beta_W=np.array([0.0, 1.0]),
        beta_Z=np.array([3 / 2, -3 / 2]),
    )


class SRA3(Additive):
    """Roessler 2010, SRA3: of deterministic order 3."""

    name: ClassVar[str] = "sra3"
    source: ClassVar[str] = "Roessler 2010, SRA3"
    tableau: ClassVar[AdditiveTableau] = AdditiveTableau(
        alpha=np.array([1 / 6, 1 / 6, 2 / 3]),
        A_0=table((), (1.0,), (1 / 4, 1 / 4)),
        B_W=np.zeros(3),
        B_Z=np.array([0.0, 0.0, 3 / 2]),
        beta_W=np.array([1.0, 0.0, 0.0]),
        beta_Z=np.array([-1.0, 1.0, 0.0]),
    )


class ShARK(Additive):
    """Foster, dos Reis & Strange 2024, ShARK: both stages see H = Z/h - dW/2."""

    name: ClassVar[str] = "shark"
    source: ClassVar[str] = "Foster, dos Reis & Strange 2024, ShARK"
    tableau: ClassVar[AdditiveTableau] = AdditiveTableau(
        alpha=np.array([0.4, 0.6]),
        A_0=table((), (5 / 6,)),
        B_W=np.array([-0.5, 5 / 6 - 0.5]),
        B_Z=np.array([1.0, 1.0]),
        beta_W=np.array([1.0, 0.0]),
        beta_Z=np.array([0.0, 0.0]),
    )


SCHEMES = (SRA2(), SRA3(), ShARK())
