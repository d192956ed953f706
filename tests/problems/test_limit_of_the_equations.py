"""E |X^eps(T) - X^0(T)|^2 <= C eps, Laurent (2022), Theorem 2.3, for the equations themselves; no scheme is involved.

Affine problems are solved exactly, both equations on one Brownian path. Elsewhere both are followed by Euler paths
on the same noise, (1.2) with a projection after each step, that are fine enough for either: eps is at least 16 steps.
"""

from typing import NamedTuple

import numpy as np
import pytest

from facade import affine_constraint
from sdaeverify.measuring import group_sums, jackknife
from sdaeverify.numerics import slope_weights
from sdaeverify.probing import Source, brownian_steps

PATHS, STEPS = 1000, 2048
T = 0.125
EPS = 16.0 * T / STEPS * 2.0 ** np.arange(4.0)
TINY = 10.0 ** np.arange(-8.0, -3.0)


class Linear(NamedTuple):
    """dX = (A X + a) dt + B dW."""

    A: np.ndarray
    a: np.ndarray
    B: np.ndarray


def linear(problem) -> Linear:
    """Return the equation of an affine problem, read off at the origin and the unit vectors."""
    d, ito = problem.dimension, problem.ito()
    values = ito.drift(0.0, np.concatenate([np.zeros((d, 1)), np.eye(d)], axis=1))
    B = np.broadcast_to(ito.diffusion(0.0, np.zeros((d, 1))), (d, d, 1))[..., 0]
    return Linear(values[:, 1:] - values[:, :1], values[:, 0], B)


def mean_square(one: Linear, other: Linear, x: np.ndarray, t: float) -> float:
    """Return E |X - Y|^2 of two linear equations on one Brownian path, from x, by the eigenvalues of both."""
    values, V, forcing, noise = [], [], [], []
    for equation, sign in ((one, 1.0), (other, -1.0)):
        rates, modes = np.linalg.eig(equation.A)
        start, a, B = (np.linalg.solve(modes, part) for part in (x, equation.a, equation.B))
        values.append(rates)
        V.append(sign * modes)
        forcing.append(np.exp(rates * t) * start + integral(rates, t) * a)
        noise.append(B)
    rates, V = np.concatenate(values), np.concatenate(V, axis=1)
    mean, N = V @ np.concatenate(forcing), np.concatenate(noise)
    covariance = V @ (integral(rates[:, None] + rates, t) * (N @ N.T)) @ V.T
    return float((mean @ mean + np.trace(covariance)).real)


def integral(rates: np.ndarray, t: float) -> np.ndarray:
    """Return the integral of e^{rate s} over [0, t]."""
    safe = np.where(np.abs(rates) < 1e-12, 1.0, rates)
    return np.where(np.abs(rates) < 1e-12, t, np.expm1(safe * t) / safe)


def affine_squares(changed) -> np.ndarray:
    """Return E |X^eps - X^0|^2 for eps from 1e-8 to 1e-4, the limit or the penalty being changed."""
    return np.array([mean_square(*changed(eps), affine_constraint().initial(1)[:, 0], 0.5) for eps in TINY])


def right(eps: float) -> tuple[Linear, Linear]:
    """Return an equation and its limit."""
    return linear(affine_constraint(eps)), linear(affine_constraint(0.0))


def weak_penalty(eps: float) -> tuple[Linear, Linear]:
    """Return what is penalised by 1/sqrt(eps), and its limit."""
    return right(np.sqrt(eps))


def no_projected_noise(eps: float) -> tuple[Linear, Linear]:
    """Return an equation, and its limit with other noise along the manifold."""
    one, limit = right(eps)
    return one, limit._replace(B=1.1 * limit.B)


def slope(squares: np.ndarray) -> float:
    """Return the exponent of eps."""
    return float(slope_weights(np.log(TINY)) @ np.log(squares))


def test_affine_problems_tend_to_their_limit_with_the_first_power_of_eps():
    """E |X^eps - X^0|^2/eps tends to the normal variance q sigma^2/2, one standard deviation being sqrt(eps/2)."""
    squares, problem = affine_squares(right), affine_constraint()

    assert slope(squares) == pytest.approx(1.0, abs=1e-3)
    assert squares[0] / TINY[0] == pytest.approx(0.5 * problem.constraints * problem.strength**2, rel=1e-6)


@pytest.mark.parametrize(("wrong", "exponent"), [(weak_penalty, 0.5), (no_projected_noise, 0.0)])
def test_affine_families_with_another_limit_have_another_exponent(wrong, exponent):
    """A penalty of 1/sqrt(eps) halves the exponent; a limit with other noise is not approached."""
    assert slope(affine_squares(wrong)) == pytest.approx(exponent, abs=0.01)


def distances(family, drift) -> np.ndarray:
    """Return |X^eps(T) - X^0(T)|^2 for each eps on every path, shape (E, P)."""
    limit, members = family(0.0), [family(eps) for eps in EPS]
    equation, h = limit.ito(), T / STEPS
    x, y = [limit.initial(PATHS) for _ in members], limit.initial(PATHS)
    (levels,) = (
        noise for noise, _ in zip(brownian_steps(Source(7, "limit", 0, PATHS), len(y), T, 11), [0], strict=False)
    )
    for dW in levels[-1].dW:
        x = [z + h * drift(each, z) + each.strength * dW for each, z in zip(members, x, strict=True)]
        y = limit.admissible(y + h * equation.drift(0.0, y) + equation.diffused(0.0, y, dW))
    return np.stack([((z - y) ** 2).sum(axis=0) for z in x])


def exponent(family, drift):
    """Return the exponent of eps in the mean square distance, by the jackknife over groups of paths."""
    weights = slope_weights(np.log(EPS))
    counts = group_sums(np.ones(PATHS))
    return jackknife(group_sums(distances(family, drift)), counts, lambda means: float(weights @ np.log(means)))
