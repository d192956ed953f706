"""Certified spectral radius of a positive operator T(P) = E A P A^T.

For c > 0, rho(T) < c holds if and only if c P - T(P) = Id has a positive definite solution P, which is then the sum
of T^n(Id)/c^(n+1). The residual E of a computed P shows whether the arithmetic is accurate enough: with |E| < 1,
Id + E is positive definite as well, and the statement holds for the computed P.

For operators too large for a matrix, the brackets of Collatz and Wielandt hold for any positive definite P,

    lambda_min(P^-1 T(P)) <= rho <= lambda_max(P^-1 T(P)).

They do not close if a system decouples or has algebraic components; the certificate above does.
"""

from typing import NamedTuple

import numpy as np
import scipy

from ...arrays import Array
from ..linear.second_moments import Operator, smat, svec

# Up to this size the operator is formed as a matrix; above, only its values are used.
# Size: of a matrix.
DENSE = 300
# Number of Arnoldi vectors. With SciPy's default of 20, it converged to eigenvalues that are not the largest.
# Size: of a Krylov space.
VECTORS = 60
# Most restarts of Arnoldi's method; without convergence by then, the radius is unknown.
# Size: of an iteration.
RESTARTS = 200
# Widths of brackets that are tried, absolute below rho = 1 and relative above.
# Size: widths that are tried; the one that holds is told.
WIDTHS = tuple(10.0**power for power in range(-12, 0))
# Theorem: any number below 1 will do. c P - L P = Id + R with |R| <= r < 1 and P > 0 proves rho < c (Krein-Rutman).
RESIDUAL = 0.5
# For operators larger than the first, it pays to test whether all factors are equal up to the second, relative, as
# with additive noise; the radius of the mean factor is used if its width is at most the third.
# Size: of an operator.
# Rounding: factors that differ by more cost more; the width of the radius of one factor is certified, and a tenth of
# `windows.MARGIN`.
LARGE, ROUNDING, CERTAIN = 20, 1e-9, 1e-10


class SpectralRadius(NamedTuple):
    """A spectral radius and a certified bound of its error.

    Attributes
    ----------
    rho : float
        Infinite if the operator is not finite, NaN if no eigenvalue was found.
    width : float
        |rho(T) - rho| <= width; infinite without a certificate.
    """

    rho: float
    width: float


def spectral_radius(operator: Operator, *, certified: bool = True) -> SpectralRadius:
    """Return the spectral radius of a positive operator; the width may be infinite if not certified."""
    if operator.size > DENSE:
        return _by_values(operator) if np.isfinite(operator.factors).all() else SpectralRadius(np.inf, np.inf)
    matrix = operator.dense()
    if not np.isfinite(matrix).all():
        return SpectralRadius(np.inf, np.inf)
    if (known := _of_one_factor(operator, matrix)) is not None:
        return known
    rho = float(np.abs(np.linalg.eigvals(matrix)).max())
    return SpectralRadius(rho, _certified_width(operator, matrix, rho) if certified else np.inf)


def _of_one_factor(operator: Operator, matrix: Array) -> SpectralRadius | None:
    """Return rho(A)^2 sum w if all factors equal A and it is certain: A has n rows instead of n (n + 1)/2."""
    if operator.size <= LARGE:
        return None
    factors, weights = operator
    one = factors.mean(axis=-1)
    if np.abs(factors - one[..., None]).max() > ROUNDING * np.abs(one).max():
        return None
    rho = float(np.abs(np.linalg.eigvals(one)).max() ** 2 * weights.sum())
    found = SpectralRadius(rho, _certified_width(operator, matrix, rho))
    return found if found.width <= CERTAIN * max(1.0, rho) else None


def are_below(operator: Operator, matrix: Array, *c: float) -> list[bool | None]:
    """Return whether the spectral radius is below each c > 0; None if rounding errors are too large to decide.

    Parameters
    ----------
    operator : Operator
    matrix : ndarray
        Matrix of the operator in coordinates svec.
    *c : float
    """
    n, bounds = operator.dimension, np.array(c)[:, None, None]
    unit = np.eye(n)
    try:
        P = smat(np.linalg.solve(bounds * np.eye(len(matrix)) - matrix, svec(unit)[:, None])[..., 0], n)
    except np.linalg.LinAlgError:
        return [None] * len(c)
    # Evaluated by the operator, not the matrix, whose rounding errors would not show.
    known = np.linalg.norm(bounds * P - operator(P) - unit, axis=(1, 2)) <= RESIDUAL
    # If rho < c, P is at least (1 - RESIDUAL) Id/c: half of this is allowed for rounding.
    below = np.linalg.eigvalsh(np.where(known[:, None, None], P, unit))[:, 0] > 0.5 * (1.0 - RESIDUAL) / np.array(c)
    return [bool(answer) if certain else None for answer, certain in zip(below, known, strict=True)]


def _certified_width(operator: Operator, matrix: Array, rho: float) -> float:
    for width in WIDTHS:
        d = width * max(1.0, rho)
        sides = (rho + d, rho - d) if rho > d else (rho + d,)
        if are_below(operator, matrix, *sides) == [True, False][: len(sides)]:
            return d
    return np.inf


def _by_values(operator: Operator) -> SpectralRadius:
    n, size = operator.dimension, operator.size
    values = scipy.sparse.linalg.LinearOperator(
        (size, size), matvec=lambda p: svec(operator(smat(p, n))), dtype=float
    )
    try:
        found, vectors = scipy.sparse.linalg.eigs(
            values, k=1, which="LM", v0=svec(np.eye(n)), ncv=min(VECTORS, size), maxiter=RESTARTS
        )
    except scipy.sparse.linalg.ArpackNoConvergence:
        return SpectralRadius(np.nan, np.inf)
    rho = float(np.abs(found[0]))
    # The eigenvalue rho has a semidefinite eigenmatrix; those of other eigenvalues are indefinite or complex.
    P = smat(vectors[:, 0].real, n)
    P *= np.sign(np.trace(P))
    try:
        bracket = scipy.linalg.eigvalsh(operator(P), P)
    except np.linalg.LinAlgError:
        return SpectralRadius(rho, np.inf)
    return SpectralRadius(rho, float(max(bracket[-1] - rho, rho - bracket[0])))
