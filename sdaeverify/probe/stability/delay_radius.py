"""Spectral radius of the second moments of a delayed step, by sparse systems of the delay's length.

The radius r is the smallest number that exceeds the squared moduli of all eigenvalues without noise, counted by the
argument principle, and at which the gain of the noise is at most 1. No matrix of all second moments is formed.
"""

from collections.abc import Callable
from copy import copy
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
import scipy

from ...arrays import Array
from ...forms import Mesh
from ...numerics.roots import log_root
from ..linear.delay_step import Lagged, LinearDelayStep, as_recursion
from ..linear.second_moments import smat, triangle
from .spectral import WIDTHS, SpectralRadius

# Number of eigenvalues of a recursion y_{n+1} = sum_i A_i y_{n-i} outside a circle, by the argument principle.
#
# They are the z with det(Id - sum_i A_i z^-(i+1)) = 0, a polynomial D in 1/z with D = 1 at infinity, so their number
# is the winding number of D about 0 on the circle. On an arc of length a with |D''| <= L, the distance of D from the
# chord between its end values is at most L a^2/8. If 0 is farther from the chord, D turns by the principal angle
# between them. Arcs are halved until this holds for all: the number is then certain, since rounding is added to the
# bound.


# Size: arcs of the circle.
ARCS, ROUNDS, MOST_ARCS = 64, 60, 1 << 18


def outside(recursion: Lagged, radius: float) -> int | None:
    """Return the number of eigenvalues with |z| > radius, with multiplicities.

    Parameters
    ----------
    recursion : Lagged
    radius : float
        Positive.

    Returns
    -------
    int or None
        None if an eigenvalue is too close to the circle to be decided in floating point.
    """
    powers = recursion.lags + 1
    scaled = recursion.maps[0] * radius ** -powers[:, None, None].astype(float)
    with np.errstate(invalid="ignore"):
        curvature, rounding = _bounds(powers, scaled)
    if not np.isfinite(curvature):
        return None
    # D is conjugate at conjugate points, so that only the upper half of the circle is needed.
    ends = np.linspace(0.0, np.pi, ARCS + 1)
    values = _determinant(powers, scaled, ends)
    a, b, at_a, at_b = ends[:-1], ends[1:], values[:-1], values[1:]
    turned = 0.0
    for _ in range(ROUNDS):
        distance = _from_zero(at_a, at_b)
        short = distance > 0.125 * curvature * (b - a) ** 2 + rounding
        turned += float(np.angle(at_b[short] / at_a[short]).sum())
        a, b, at_a, at_b = a[~short], b[~short], at_a[~short], at_b[~short]
        if len(a) == 0:
            return -round(turned / np.pi)
        if len(a) > MOST_ARCS or np.minimum(np.abs(at_a), np.abs(at_b)).min() <= rounding:
            return None
        middle = 0.5 * (a + b)
        at_middle = _determinant(powers, scaled, middle)
        a, b = np.concatenate([a, middle]), np.concatenate([middle, b])
        at_a, at_b = np.concatenate([at_a, at_middle]), np.concatenate([at_middle, at_b])
    return None


def _determinant(powers: Array, scaled: Array, angles: Array) -> Array:
    turns = np.exp(-1j * angles[:, None] * powers)
    return np.asarray(np.linalg.det(np.eye(scaled.shape[-1]) - np.tensordot(turns, scaled, axes=1)))


def _from_zero(first: Array, last: Array) -> Array:
    # Return the distance of 0 from the segment between two complex numbers.
    chord = last - first
    length = np.maximum(np.abs(chord) ** 2, np.finfo(float).tiny)
    part = np.clip(-(np.conj(chord) * first).real / length, 0.0, 1.0)
    return np.asarray(np.abs(first + part * chord))


def _bounds(powers: Array, scaled: Array) -> tuple[float, float]:
    # Return bounds of |D''| and of rounding. A determinant is linear in each column, and at most the product of the
    # column norms (Hadamard).
    norms = np.linalg.norm(scaled, axis=1)
    columns = 1.0 + norms.sum(axis=0)
    product = float(columns.prod())
    slope, bend = float((powers @ norms / columns).sum()), float((powers**2 @ norms / columns).sum())
    # Errors of values: their rounding, and that of angles up to pi.
    return product * (bend + slope**2), 2.0 * EPS * product * (16.0 + 2.0 * np.pi * slope)


# Stationary covariances of a recursion y_{n+1} = sum_i A_i y_{n-i} + q_n with white noise q_n of covariance Q.
#
# Gamma_j = E y_{n+j} y_n^T, Gamma_{-j} = Gamma_j^T, satisfy the Yule-Walker equations
#
#     Gamma_j = sum_i A_i Gamma_{j-1-i} + Q [j = 0],     j = 0, ..., m + 1,
#
# a sparse linear system of (m + 2) k^2 unknowns, where m is the largest lag. With A_i / r^((i+1)/2) in place of A_i,
# their solutions are the sums of r^-n F^n Q F^n^T over n, where F is the matrix of the recursion.
#
# They give the gain of the noise: q_n = sum_j G_j xi_j acting on past values has a covariance that is linear in
# earlier covariances. Q -> sum_n r^-(n+1) sum_j S_jn Q S_jn^T, with S_jn the response n steps after an impulse, is a
# positive operator on matrices of k rows, for any length of the delay. The second moments of the recursion with noise
# grow like r^n if its spectral radius, the gain at r, is 1; the gain decreases in r. For one noise of rank one,
# G = w g^T, the gain is the sum of r^-(n+1) (g^T F^n w)^2.


EPS = float(np.finfo(float).eps)


class Layout(NamedTuple):
    """Positions of the entries in the Yule-Walker system, the same for every r.

    Attributes
    ----------
    sources : ndarray, shape (E - N,)
        Indices of the coefficients A_i in the off-diagonal entries.
    order, starts : ndarray
        Permutation that sorts entries by rows and columns, in the first order of unknowns; start of each matrix
        entry.
    places : ndarray, shape (N,)
        Permutation of the unknowns that makes the matrix banded.
    above, below : int
        Numbers of diagonals above and below the main one.
    cells : ndarray, shape (E,)
        Index of every entry in LAPACK's flat array of diagonals.
    empty : csr_array, shape (N, N)
        The matrix in the first order, without values.
    """

    sources: Array
    order: Array
    starts: Array
    places: Array
    above: int
    below: int
    cells: Array
    empty: "scipy.sparse.csr_array"

    def matrix(self, values: Array) -> "scipy.sparse.csr_array":
        """Return the matrix with given values of its entries; values at the same position are added."""
        matrix = copy(self.empty)
        matrix.data = np.add.reduceat(values[self.order], self.starts)
        return matrix

    def solver(self, values: Array) -> Callable[[Array], Array]:
        """Return a function that solves systems with this matrix for right-hand sides of shape (N, S)."""
        places, above, below = self.places, self.above, self.below
        shape = 2 * below + above + 1, len(places)
        diagonals = np.bincount(self.cells, values, shape[0] * shape[1]).reshape(shape)
        factors, pivots, singular = scipy.linalg.lapack.dgbtrf(diagonals, below, above, overwrite_ab=True)
        if singular:
            raise np.linalg.LinAlgError("singular matrix")

        def solve(right: Array) -> Array:
            moved = np.empty_like(right)
            moved[places] = right
            found, _ = scipy.linalg.lapack.dgbtrs(factors, below, above, moved, pivots, overwrite_b=True)
            return np.asarray(found[places])

        return solve


def rescale(recursion: Lagged, r: float) -> Lagged:
    """Return the recursion that r^(-n/2) y_n satisfies."""
    factors = float(r) ** (-0.5 * (recursion.lags + 1.0))
    return Lagged(recursion.lags, recursion.maps * factors[:, None, None])


def noise_gain(recursion: Lagged, r: float) -> tuple[float, float]:
    """Return the gain of the noise at r, and its error; r must exceed the squared eigenvalues without noise.

    The error is estimated to first order, from the effect of rounding of every entry on the eigenvalue. Rounding is
    estimated from the change in one step of iterative refinement.
    """
    k = recursion.maps.shape[-1]
    gain, change = _gain_matrix(rescale(recursion, r))
    values, left, right = scipy.linalg.eig(gain, left=True)
    largest = np.abs(values).argmax()
    y, x = left[:, largest], right[:, largest]
    value = float(np.abs(values[largest]))
    # At a multiple eigenvalue y is orthogonal to x; the perturbation is then at most of the size of a square root.
    condition = np.abs(y) @ np.abs(gain) @ np.abs(x) / max(abs(np.vdot(y, x)), np.sqrt(EPS))
    return value, (change + 16.0 * EPS * k) * max(value, float(condition))


def _gain_matrix(recursion: Lagged, *, refined: bool = True) -> tuple[Any, float]:
    # Return the gain at r = 1 as a matrix in coordinates svec, and the relative change by refinement.
    i, j, scale = triangle(recursion.maps.shape[-1])
    gamma, change = covariances(recursion, _unit_covariances(recursion.maps.shape[-1]), refined=refined)
    return scale[:, None] * _noise(recursion, gamma)[:, i, j].T, change


def _unit_covariances(k: int) -> Array:
    return np.stack([smat(each, k) for each in np.eye(k * (k + 1) // 2)], axis=-1)


def covariances(recursion: Lagged, Q: Array, *, refined: bool = True) -> tuple[Array, float]:
    """Return Gamma_0, ..., Gamma_{m+1} for covariances Q.

    Parameters
    ----------
    recursion : Lagged
        All its eigenvalues without noise lie within the unit circle.
    Q : ndarray, shape (k, k, S)
        Symmetric in the first two axes.
    refined : bool, optional
        Whether to make a step of iterative refinement.

    Returns
    -------
    gamma : ndarray, shape (m + 2, k, k, S)
    change : float
        Relative change of the largest entries by refinement; NaN without it.
    """
    k, count, lags = Q.shape[0], Q.shape[2], int(recursion.lags[-1]) + 2
    maps = recursion.maps[0]
    layout = _layout(tuple(recursion.lags.tolist()), k, (maps != 0.0).tobytes(), lags)
    values = np.concatenate([np.ones(len(layout.places)), -maps.ravel()[layout.sources]])
    right = np.zeros((lags * k * k, count))
    right[: k * k] = Q.reshape(-1, count)
    solve = layout.solver(values)
    found = solve(right)
    if not refined:
        return found.reshape(lags, k, k, count), np.nan
    correction = solve(right - layout.matrix(values) @ found)
    change = float((np.abs(correction).max(axis=0) / np.abs(found).max(axis=0)).max())
    return np.asarray((found + correction).reshape(lags, k, k, count)), change


@lru_cache(maxsize=16)
def _layout(lags: tuple[int, ...], k: int, there: bytes, count: int) -> Layout:
    # The entry (a, b) of Gamma_j has the index (j k + a) k + b, and that of its transpose (j k + b) k + a.
    j, i, a, b, c = np.meshgrid(
        np.arange(count), np.arange(len(lags)), *3 * [np.arange(k)], indexing="ij", sparse=True
    )
    source = j - 1 - np.array(lags)[i]
    used = np.frombuffer(there, bool).reshape(len(lags), k, k)[i, a, c] & np.ones_like(j + b, bool)
    diagonal, places = np.arange(count * k * k), _fold_places(count, k * k)
    beside = np.where(source >= 0, (source * k + c) * k + b, (-source * k + b) * k + c) + 0 * a
    rows = np.concatenate([diagonal, ((j * k + a) * k + b + 0 * (i + c))[used]])
    columns = np.concatenate([diagonal, beside[used]])
    order = np.lexsort((columns, rows))
    change = (np.diff(rows[order]) != 0) | (np.diff(columns[order]) != 0)
    starts = np.concatenate([[0], 1 + np.flatnonzero(change)])
    ends = np.searchsorted(rows[order][starts], np.arange(len(places) + 1))
    offsets = places[columns] - places[rows]
    above, below = int(offsets.max()), int(-offsets.min())
    cells = (below + above - offsets) * len(places) + places[columns]
    entries = np.zeros(len(starts)), columns[order][starts], ends
    empty = scipy.sparse.csr_array(entries, shape=(len(places), len(places)))
    sources = ((i * k + a) * k + c + 0 * (j + b))[used]
    return Layout(sources, order, starts, places, above, below, cells, empty)


def _fold_places(count: int, block: int) -> Array:
    # Return the index of every unknown if Gamma_j is placed next to Gamma_{m+1-j}: coupled unknowns are then
    # neighbours.
    ends = np.stack([np.arange(count), np.arange(count)[::-1]], axis=-1).ravel()[:count]
    places = np.argsort(ends)
    return np.asarray((places[:, None] * block + np.arange(block)).ravel())


def _noise(recursion: Lagged, gamma: Array) -> Array:
    # Return the sum over noises and pairs of lags of G_i E(y_{n-i} y_{n-p}^T) G_p^T, shape (S, k, k).
    at = recursion.lags[None, :] - recursion.lags[:, None]
    there = gamma[np.abs(at)]
    blocks = np.where((at >= 0)[..., None, None, None], there, there.swapaxes(2, 3))
    count, k = at.shape[0], gamma.shape[1]
    past = blocks.transpose(4, 0, 2, 1, 3).reshape(-1, 1, count * k, count * k)
    G = recursion.maps[1:].swapaxes(1, 2).reshape(-1, k, count * k)
    return np.asarray((G @ past @ G.swapaxes(1, 2)).sum(axis=1))


# A gain is decided if it differs from 1 by more than this multiple of its error.
# Rounding: a difference from 1 that is known to one digit.
ERRORS = 10.0
# Bound of powers of r, to avoid overflow.
# Rounding: a product with another number is finite.
LARGEST_POWER = 1e200
# Size: of a bracket; larger radii are as unstable.
LARGEST_RADIUS = 1e30
# Largest companion matrix whose eigenvalues are computed, largest noise that counts as none, and required relative
# width.
# Size: of a matrix.
# Rounding: noise of 1e-12 changes second moments by 1e-24, and a double radius by the root of that; a width of 1e-10
# is a tenth of `windows.MARGIN`.
DENSE, NEGLIGIBLE, CERTAIN = 256, 1e-12, 1e-10
# First guesses of r above the square of the largest eigenvalue, relative and absolute.
# Size: of the first bracket, which is enlarged until it holds.
ABOVE, BESIDE = 1.1, 1e-3


def radius(step: LinearDelayStep, mesh: Mesh) -> SpectralRadius:
    """Return the spectral radius of the second moments of the state with its history.

    Parameters
    ----------
    step : LinearDelayStep
    mesh : Mesh

    Returns
    -------
    SpectralRadius
        Its width is a distance at which both sides are decided, as `side_of` decides. If the power m + 1 of a radius
        is below 1e-200, only a bound is returned.
    """
    if not np.isfinite(step.maps).all():
        return SpectralRadius(np.inf, np.inf)
    recursion = as_recursion(step, mesh)
    floor = LARGEST_POWER ** (-1.0 / (recursion.lags[-1] + 1.0))
    if (found := _from_eigenvalues(recursion, floor)) is not None:
        return found
    excess = _excess_of(recursion)
    low, high = _bracket(excess, 1.0 / (recursion.lags[-1] + 1.0), floor)
    if high >= LARGEST_RADIUS:
        return SpectralRadius(np.inf, np.inf)
    if low <= floor and excess(floor) > 0.0:
        return SpectralRadius(0.5 * floor, 0.5 * floor)
    rho = log_root(excess, low, high)
    return SpectralRadius(rho, _width(recursion, rho))


def _from_eigenvalues(recursion: Lagged, floor: float) -> SpectralRadius | None:
    """Return the radius of a recursion with a small companion matrix, or None if it is not certain.

    Eigenvalues are counted only on both sides of the result. Without noise, where bisection has no slope to use, this
    takes a fiftieth of the counts of `_bracket`.
    """
    count, k = int(recursion.lags[-1]) + 1, recursion.maps.shape[-1]
    if count * k > DENSE:
        return None
    F = np.eye(count * k, k=-k)
    for lag, part in zip(recursion.lags, recursion.maps[0], strict=True):
        F[:k, lag * k : (lag + 1) * k] = part
    rho = float(np.abs(np.linalg.eigvals(F)).max() ** 2)
    if np.abs(recursion.maps[1:]).max(initial=0.0) > NEGLIGIBLE:
        rho = _radius_of_noise(recursion, rho)
    found = SpectralRadius(rho, _width(recursion, rho) if rho > floor else np.inf)
    return found if found.width <= CERTAIN * rho else None


def _radius_of_noise(recursion: Lagged, least: float) -> float:
    """Return the r at which the gain is 1, or the square of the largest eigenvalue if the gain is below 1 above it.

    1/gain is 0 there and nearly linear in r beyond. The gain decreases at least like 1/r, which bounds r on both
    sides.
    """

    def gain(r: float) -> float:
        return float(np.abs(np.linalg.eigvals(_gain_matrix(rescale(recursion, r), refined=False)[0])).max())

    def excess(r: float) -> float:
        if r <= least:
            return -1.0
        found = gain(r)
        return 1.0 / found - 1.0 if found > 0.0 else np.inf

    start = ABOVE * least + BESIDE
    low, high = _enclose(excess, *sorted([start, start * gain(start)]))
    return float(scipy.optimize.brentq(excess, max(low, least), high, xtol=1e-15 * high, rtol=1e-15))


def _enclose(excess: Callable[[float], float], low: float, high: float) -> tuple[float, float]:
    """Return ends between which an increasing function changes sign, moved outwards by rounding errors or more.

    At a root at an end, as for a gain of exactly c/r, rounding determines the sign.
    """
    part = 16.0 * EPS
    while low > 0.0 and excess(low) > 0.0:
        low, part = low * max(0.0, 1.0 - part), 2.0 * part
    while excess(high) < 0.0 and high < LARGEST_RADIUS:
        high, part = high * (1.0 + part), 2.0 * part
    return low, high


def _excess_of(recursion: Lagged) -> Callable[[float], float]:
    """Return a function that is negative below the radius, positive above, and nearly linear if noise sets it."""
    free = np.inf

    def excess(r: float) -> float:
        nonlocal free
        # If no eigenvalue is outside a circle, none is outside a larger one.
        if r < free and outside(recursion, float(np.sqrt(r))) != 0:
            return -1.0
        free = min(free, r)
        gain, _ = noise_gain(recursion, r)
        return 1.0 / gain - 1.0 if gain > 0.5 else 1.0

    return excess


def side_of(recursion: Lagged, r: float) -> int:
    """Return 1 if r is above the spectral radius, -1 if it is below, 0 if neither is certain."""
    count = outside(recursion, float(np.sqrt(r)))
    if count != 0:
        return 0 if count is None else -1
    return _side_by_gain(recursion, r)


def _side_by_gain(recursion: Lagged, r: float) -> int:
    gain, error = noise_gain(recursion, r)
    return 0 if abs(gain - 1.0) <= ERRORS * error else int(np.sign(1.0 - gain))


def _is_between(recursion: Lagged, low: float, high: float) -> bool:
    """Return whether the spectral radius is certainly between two numbers."""
    count = outside(recursion, float(np.sqrt(low)))
    if count == 0:
        # No eigenvalue is outside the larger circle either.
        return _side_by_gain(recursion, low) < 0 and _side_by_gain(recursion, high) > 0
    return count is not None and side_of(recursion, high) > 0


def _bracket(excess: Callable[[float], float], step: float, floor: float) -> tuple[float, float]:
    # Increase steps from the scale of one delay: far below the radius, many eigenvalues would have to be counted.
    below = excess(1.0) <= 0.0
    low, high = 1.0, 1.0
    while (below and low == high) or (below and high < LARGEST_RADIUS and excess(high) <= 0.0):
        low, high, step = high, high * np.exp(step), 2.0 * step
    while not below and (low == high or (low > floor and excess(low) > 0.0)):
        low, high, step = max(floor, low * np.exp(-step)), low, 2.0 * step
    return low, high


def _width(recursion: Lagged, rho: float) -> float:
    for width in WIDTHS:
        d = width * rho
        if _is_between(recursion, rho - d, rho + d):
            return d
    return np.inf
