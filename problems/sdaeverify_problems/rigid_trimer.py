"""Three atoms with two rigid bonds, whose angle distinguishes the surface measure from wrong powers of det G."""

from collections.abc import Callable
from functools import cache

import numpy as np

from sdaeverify import Array, ConstrainedLangevin, Parts, Truth, hookimpl, on_request

from . import _controls as controls
from ._arguments import check_not_negative, check_positive
from ._interval_diffusion import IntervalDiffusion
from ._known import limits, moments
from ._quadrics import Quadrics

SOURCE = "diffusion of c = b_1 . b_2 on [-1, 1], eigenfunctions in polynomials"
# Matrices that map positions to the bonds. Number of polynomials in c: the coefficients are singular at c = 2 only,
# so that polynomials of degree 40 have errors of size 3.7^-40.
BONDS = np.kron([[-1.0, 1.0, 0.0], [0.0, -1.0, 1.0]], np.eye(3)).reshape(2, 3, 9)
POLYNOMIALS = 40


@on_request
def rigid_trimer(
    eps: float = 0.0, angle: float = 1.2, sigma: float = 1.0, horizon: float = 0.25
) -> ConstrainedLangevin:
    """Atoms x = (x_1, x_2, x_3) in R^9 with zeta_i = (|b_i|^2 - 1)/2, b_i = x_{i+1} - x_i, and f = 0.

    In the limit, c = b_1 . b_2 is a Markov diffusion, reversible for the density rho of the surface measure:

        (1/rho) (rho D phi')',    rho = sqrt(4 - c^2),    D = (sigma^2/2) |Pi grad c|^2 = 3 sigma^2 (1 - c^2)/(2 - c).

    The invariant mean of c^2 is (2 pi/3 - sqrt(3)/2)/(2 pi/3 + sqrt(3)). The centre is a Brownian motion.

    Parameters
    ----------
    eps : float
        Stiffness parameter, unit time; exact expectations exist only for 0.
    angle : float
        Initial angle from one bond to the next, radian.
    sigma : float
        Noise amplitude, unit length/sqrt(time), positive.
    horizon : float
        Final time.

    Source
    ------
    Laurent (2022), (1.2) and (1.4), on a chain of two rigid bonds.
    """
    check_not_negative(eps=eps)
    check_positive(sigma=sigma)
    zeta = Quadrics(np.einsum("ian,iam->inm", BONDS, BONDS), np.zeros((2, 9)), np.full(2, -0.5))
    turn = np.array([1.0 + np.cos(angle), np.sin(angle), 0.0])
    start = np.stack([np.zeros(3), [1.0, 0.0, 0.0], turn])
    return ConstrainedLangevin(
        eps=eps,
        family=lambda other: rigid_trimer(other, angle, sigma, horizon),
        drift=lambda x: 0.0 * x,
        strength=sigma,
        **zeta.fields(),
        start=(start - start.mean(axis=0)).ravel(),
        horizon=horizon,
        controls=controls.ADDITIVE if eps else controls.GENERAL,
        observables=OBSERVABLES,
        truths=() if eps else truths(float(np.cos(angle)), sigma),
        relaxation_time=np.inf if eps else 1.0 / angle_diffusion(sigma).gap,
        units="bond length 1, time in the unit in which sigma is given",
        source="Laurent 2022, (1.2) and (1.4), on a chain of two rigid bonds",
    )


def cosine(t: float, s: Parts) -> Array:
    """Return c = b_1 . b_2, shape (P,)."""
    x = s["x"]
    return np.asarray(((x[3:6] - x[:3]) * (x[6:] - x[3:6])).sum(axis=0))


OBSERVABLES: dict[str, Callable[[float, Parts], Array]] = {
    "c": cosine,
    "c^2": lambda t, s: cosine(t, s) ** 2,
    "c^3": lambda t, s: cosine(t, s) ** 3,
}


@cache
def angle_diffusion(sigma: float) -> IntervalDiffusion:
    """Return the diffusion of c in the limit eps = 0."""
    c, w = np.polynomial.legendre.leggauss(2 * POLYNOMIALS)
    density = w * np.sqrt(4.0 - c * c)
    return IntervalDiffusion(c, density / density.sum(), 3.0 * sigma**2 * (1.0 - c * c) / (2.0 - c), POLYNOMIALS)


def truths(start: float, sigma: float) -> tuple[Truth, ...]:
    """Return the expectations of powers of c at every time, and the invariant mean of c^2; odd powers have mean 0."""
    diffusion = angle_diffusion(sigma)
    values = {
        name: lambda t, n=n: diffusion.expectation(lambda c: c**n, start, t)
        for n, name in enumerate(OBSERVABLES, start=1)
    }
    return (*moments(values, SOURCE), *limits({"c^2": diffusion.mean(np.square)}, SOURCE))


@hookimpl
def sdaeverify_problems() -> list[object]:
    """Register the problem."""
    return [rigid_trimer]
