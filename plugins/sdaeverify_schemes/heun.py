"""Heun's schemes: for Stratonovich's integral, and for additive noise, where the weak order is 2."""

from typing import ClassVar

import numpy as np

from sdaeverify import SDE, Array, Claim, Increment, Scheme, Step, hookimpl
from sdaeverify.numerics import apply

from ._additive import not_additive
from ._senses import LINEAR_GROWTH, by_growth
from ._side_by_side import TOGETHER
from ._small_steps import STABLE

COMMUTATIVE = ("scalar-noise", "diagonal-noise", "vanishing-milstein-term")
ADDITIVE = frozenset({"additive-noise"})
RUEMELIN = "Ruemelin 1982, for commutative noise"
LIPSCHITZ = "no projection; at least the strong order, g being Lipschitz near the solution"


class Heun(Scheme):
    """Heun's scheme with the Stratonovich drift F = f - (1/2) sum_j DB_j B_j of the Ito equation.

    y  = x + h F(t, x) + B(t, x) dW,
    x+ = x + (h/2) [F(t, x) + F(t + h, y)] + (1/2) [B(t, x) + B(t + h, y)] dW.
    """

    name: ClassVar[str] = "heun"
    form: ClassVar[type[SDE]] = SDE
    claims: ClassVar[tuple[Claim, ...]] = (
        *by_growth(
            Claim(measure="strong", value=0.5, source="Ruemelin 1982"),
            *(Claim(measure="strong", value=1.0, when=frozenset({trait}), source=RUEMELIN) for trait in COMMUTATIVE),
            Claim(measure="weak", value=1.0, source="measured"),
            Claim(measure="weak", value=2.0, when=ADDITIVE, source="the scheme heun-additive there"),
        ),
        Claim(measure="drift", value=0.5, source=LIPSCHITZ),
        # No constrained problem has diagonal noise.
        Claim(measure="drift", value=1.0, when=frozenset({"scalar-noise"}), source=LIPSCHITZ),
        Claim(measure="drift", value=1.0, when=frozenset({"vanishing-milstein-term"}), source=LIPSCHITZ),
        STABLE,
    )
    source: ClassVar[str] = "Ruemelin 1982; Kloeden & Platen 1992, section 11.1"

    def refuses(self, problem: SDE) -> str:
        """Refuse diffusions without a derivative, which the Stratonovich drift needs."""
        return problem.why_not_derivative_of_diffusion()

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the state x has shape (d, P)."""
        x = state
        F, B = stratonovich(problem, t, x)
        kick = apply(B, noise.dW)
        G, C = stratonovich(problem, t + h, x + h * F + kick)
        return Step(x + 0.5 * (h * (F + G) + kick + apply(C, noise.dW)))


class HeunAdditive(Scheme):
    """x+ = x + (h/2) [f(t, x) + f(t + h, x + h f(t, x) + B dW)] + B dW for a constant B."""

    name: ClassVar[str] = "heun-additive"
    form: ClassVar[type[SDE]] = SDE
    claims: ClassVar[tuple[Claim, ...]] = (
        *by_growth(
            Claim(measure="strong", value=1.0, source="Kloeden & Platen 1992, section 10.3: Milstein's order"),
            Claim(measure="weak", value=2.0, source="Kloeden & Platen 1992, (15.1.1) with constant b, any moments"),
        ),
        Claim(
            measure="invariant",
            value=2.0,
            when=LINEAR_GROWTH | {"unconstrained"},
            source="Talay 1990: the weak order, for ergodic problems",
        ),
        STABLE,
    )
    source: ClassVar[str] = "Kloeden & Platen 1992, (15.1.1) with constant b"

    def refuses(self, problem: SDE) -> str:
        """Refuse noise that is not declared additive."""
        return not_additive(problem)

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the state x has shape (d, P)."""
        x = state
        f, kick = problem.drift(t, x), problem.diffused(t, x, noise.dW)
        return Step(x + 0.5 * h * (f + problem.drift(t + h, x + h * f + kick)) + kick)


def stratonovich(problem: SDE, t: float, x: Array) -> tuple[Array, Array]:
    """Return F(t, x) = f - (1/2) sum_j DB_j B_j, shape (d, P), and B(t, x).

    Parameters
    ----------
    problem : SDE
        Problem in Ito's form.
    t : float
    x : ndarray, shape (d, P)
    """
    B = problem.diffusion(t, x)
    return problem.drift(t, x) - 0.5 * turned_noise(problem, t, x, B), B


def turned_noise(problem: SDE, t: float, x: Array, B: Array) -> Array:
    """Return sum_j DB_j B_j, shape (d, P).

    For few paths all columns B_j are evaluated in one call, as if on further paths.

    Parameters
    ----------
    problem : SDE
    t : float
    x : ndarray, shape (d, P)
    B : ndarray, shape (d, l, P) or (d, l, 1)
        Diffusion at t and x.
    """
    (d, P), l = x.shape, B.shape[1]
    columns = np.empty((d, l, P))
    columns[...] = B
    if l * x.size > TOGETHER:
        each = (problem.derivative_of_diffusion(t, x, columns[:, j])[:, j] for j in range(l))
        return np.asarray(sum(each))
    change = problem.derivative_of_diffusion(t, np.concatenate([x] * l, axis=1), columns.reshape(d, l * P))
    alike = change.shape[-1] == 1
    return np.asarray(sum(change[:, j, :] if alike else change[:, j, j * P : (j + 1) * P] for j in range(l)))


@hookimpl
def sdaeverify_schemes() -> list[Scheme]:
    """Register both schemes."""
    return [Heun(), HeunAdditive()]
