"""A linear drift and an affine constraint: all laws are Gaussian, for every eps and at every time."""

import numpy as np

from sdaeverify import ConstrainedLangevin, ParameterError, hookimpl

from .. import _controls as controls
from .._arguments import check_not_negative
from ._langevin import AffineLangevin
from ._truths import flat_chart, observables, truths


def affine_constraint(
    eps: float = 0.25, d: int = 2, q: int = 1, coupling: float = 0.5, sigma: float = 0.7, horizon: float = 0.5
) -> ConstrainedLangevin:
    """Langevin dynamics near or on a flat: f(x) = -K x + k, zeta(x) = B^T x - b, K = Id + coupling C.

    B, b, k and C are fixed and have no special structure: f has a normal part, and K couples normal and tangential
    directions. With P = B (B^T B)^{-1} B^T and m the zero of the drift, exactly

        dX = -(K + P/eps) (X - m) dt + sigma dW,   and for eps = 0 the same in the kernel of P.

    Parameters
    ----------
    eps : float
        Stiffness parameter, unit time.
    d : int
        Number of components.
    q : int
        Number of constraints, between 1 and d - 1.
    coupling : float
        Strength of the coupling, 0 for the drift -x + k; the symmetric part of K must be positive definite.
    sigma : float
        Noise amplitude, unit x/sqrt(time).
    horizon : float
        Final time, in units of the relaxation time of the drift -x.

    Source
    ------
    Laurent (2022), (1.2) and (1.4), with an affine constraint.
    """
    given = affine_langevin(eps, d, q, coupling, sigma)
    law = given.law()
    tangents = np.linalg.svd(given.B)[0][:, q:]
    start = given.p + 0.8 * tangents[:, 0]
    chart = flat_chart(law, np.eye(d) if eps else tangents)
    return ConstrainedLangevin(
        eps=eps,
        family=lambda other: affine_constraint(other, d, q, coupling, sigma, horizon),
        drift=lambda x: given.k[:, None] - given.K @ x,
        strength=sigma,
        constraint=lambda x: given.B.T @ x - given.b[:, None],
        jacobian=lambda x: np.broadcast_to(given.B.T[..., None], (q, *x.shape)),
        hessians=np.zeros((q, d, d)),
        start=start,
        horizon=horizon,
        traits=frozenset({"additive-noise"}),
        controls=controls.STATIONARY_PAIR if chart else controls.ADDITIVE,
        observables=observables(given),
        truths=truths(given, start),
        chart=chart,
        relaxation_time=1.0 / law.slowest(),
        units="x in units of its choice, time so that the drift without coupling has rate 1",
        source="Laurent 2022, (1.2) and (1.4), with an affine constraint",
    )


def affine_langevin(eps: float, d: int, q: int, coupling: float, sigma: float) -> AffineLangevin:
    """Return the data of the problem.

    Parameters
    ----------
    eps : float
        Stiffness parameter; 0 for the limit dynamics on the constraint.
    d, q : int
        Dimension, and number of constraints.
    coupling : float
        Size of the deviation of K from the identity.
    sigma : float
        Strength of the noise.
    """
    check_not_negative(eps=eps)
    if not 0 < q < d:
        raise ParameterError(f"q must be between 1 and d - 1, got q = {q!r} and d = {d!r}")
    i, j = np.indices((d, d))
    K = np.eye(d) + coupling * 2.0 / d * np.sin(1.0 + 2.0 * i + 5.0 * j)
    if not (np.isfinite(K).all() and np.linalg.eigvalsh(K + K.T)[0] > 0.0):
        raise ParameterError(f"the symmetric part of K is not positive definite for coupling = {coupling!r}")
    B = np.eye(d)[:, :q] + 0.4 / np.sqrt(d) * np.cos(1.0 + i + 2.0 * j)[:, :q]
    return AffineLangevin(K, 0.5 * np.cos(np.arange(d)), B, 0.3 / (1.0 + np.arange(q)), sigma, eps)


@hookimpl
def sdaeverify_problems() -> list[object]:
    """Register the problem."""
    return [affine_constraint]
