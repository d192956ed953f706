"""Linear systems in the plane with three and with four noises, no two of which commute."""

from collections.abc import Callable

import numpy as np

from sdaeverify import SDE, Array, Control, hookimpl

from .. import _controls as controls
from .._known import moments, monomials
from ._linear_moments import SOURCE, generator, mean, second

A = np.array([[-1.0, 0.5], [-0.5, -1.0]])
# A basis of all matrices.
B = np.array(
    [[[0.25, 0.0], [0.0, -0.15]], [[0.0, 0.2], [0.2, 0.0]], [[0.0, -0.2], [0.2, 0.0]], [[0.15, 0.1], [0.0, 0.15]]]
)
START = np.array([1.0, 0.5])


def three_motions(horizon: float = 1.0) -> SDE:
    """Three noises that do not commute: dx = A x dt + B_1 x dW_1 + B_2 x dW_2 + B_3 x dW_3, x(0) = (1, 1/2).

    A = [[-1, 1/2], [-1/2, -1]], B_1 = diag(0.25, -0.15), B_2 = [[0, 0.2], [0.2, 0]], B_3 = [[0, -0.2], [0.2, 0]]. The
    three brackets B_j B_k - B_k B_j are linearly independent: a scheme that confuses the Levy areas of two pairs of
    motions is wrong on this problem, but right on problems with two motions.

    Parameters
    ----------
    horizon : float
        Final time, in the unit of the damping time.

    Source
    ------
    Kloeden & Platen (1992), section 10.3, (3.13): the condition of commutativity, here violated.
    """
    return linear_system(3, horizon, frozenset({"dW", "H", "A"}), controls.WITH_LEVY_AREAS)


def four_motions(horizon: float = 1.0) -> SDE:
    """Four noises that do not commute: dx = A x dt + B_1 x dW_1 + ... + B_4 x dW_4, x(0) = (1, 1/2).

    A and B_1, B_2, B_3 are those of `three_motions`, B_4 = [[0.15, 0.1], [0, 0.15]]. Weak order 2 requires that the
    double integrals of the disjoint pairs (1, 2) and (3, 4) are uncorrelated, which needs at least four motions.

    Parameters
    ----------
    horizon : float
        Final time, in the unit of the damping time.

    Source
    ------
    Kloeden & Platen (1992), section 10.3, (3.13): the condition of commutativity, here violated.
    """
    return linear_system(4, horizon, frozenset({"dW", "H"}), controls.NONCOMMUTING)


def linear_system(l: int, horizon: float, noise: frozenset[str], known: tuple[Control, ...]) -> SDE:
    """Return the linear system with the first l noises.

    Parameters
    ----------
    l : int
    horizon : float
    noise : frozenset of str
        Fields of the increments that are drawn.
    known : tuple of Control
    """
    G = generator(A, B[:l])

    def diffusion(t: float, x: Array) -> Array:
        return np.stack([b @ x for b in B[:l]], axis=1)

    def first(row: int) -> Callable[[float], float]:
        return lambda t: float(mean(A, START, t)[row])

    def product(row: int, column: int) -> Callable[[float], float]:
        return lambda t: float(second(G, START, t)[row, column])

    values = {"x_1": first(0), "x_2": first(1)}
    values |= {"x_1^2": product(0, 0), "x_1 x_2": product(0, 1), "x_2^2": product(1, 1)}
    return SDE(
        controls=known,
        drift=lambda t, x: A @ x,
        diffusion=diffusion,
        diffusion_derivative=lambda t, x, y: diffusion(t, y),
        start=START,
        noise_dim=l,
        noise=noise,
        horizon=horizon,
        observables=monomials(*values),
        truths=moments(values, SOURCE),
        units="x dimensionless, time in the unit of the damping time",
        source="Kloeden & Platen 1992, section 10.3",
    )


@hookimpl
def sdaeverify_problems() -> list[object]:
    """Register the problems."""
    return [three_motions, four_motions]
