"""Stationary covariances of a recursion y_{n+1} = sum_i A_i y_{n-i} + q_n with white q_n of covariance Q.

Gamma_j = E y_{n+j} y_n^T, Gamma_{-j} = Gamma_j^T, obey the equations of Yule and Walker

    Gamma_j = sum_i A_i Gamma_{j-1-i} + Q [j = 0],     j = 0, ..., m + 1,

a sparse linear system of (m + 2) k^2 unknowns, m being the largest lag. With A_i / r^((i+1)/2) in place of A_i, they
are the sums of r^-n F^n Q F^n^T over n, F being the recursion's matrix.

From them comes the gain of noise: q_n = sum_j G_j xi_j acting on the past has a covariance that is linear in the
covariances of earlier ones, and Q -> sum_n r^-(n+1) sum_j S_jn Q S_jn^T, S_jn the response n steps after an impulse,
is a positive operator on matrices of k rows, however long the delay. The second moments of the recursion with noise
grow like r^n where its spectral radius, the gain at r, is 1; it decreases in r. For one noise of rank one, G = w g^T,
the gain is the sum of r^-(n+1) (g^T F^n w)^2.
"""

from typing import NamedTuple

import numpy as np
from scipy.linalg import eig, solve_banded
from scipy.sparse import csr_array

from ...arrays import Array
from ..linear.delay_step import Lagged
from ..linear.second_moments import smat, svec

EPS = float(np.finfo(float).eps)


class Gain(NamedTuple):
    """The gain of noise at some r.

    Attributes
    ----------
    value : float
    error : float
        An estimate, to first order: what rounding of every entry does to the eigenvalue. Rounding is taken from the
        change in one step of iterative refinement.
    """

    value: float
    error: float


class Banded(NamedTuple):
    """A matrix with its rows and columns put into an order that makes it a banded one.

    Attributes
    ----------
    matrix : csr_array, shape (N, N)
        In the first order.
    places : ndarray, shape (N,)
        Of the unknowns, in the new order.
    diagonals : ndarray, shape (below + above + 1, N)
        As LAPACK wants them, in the new order.
    below : int
        Number of diagonals below the main one.
    """

    matrix: csr_array
    places: Array
    diagonals: Array
    below: int

    def solve(self, right: Array) -> Array:
        """Return the solution for right sides of shape (N, S)."""
        widths = self.below, len(self.diagonals) - 1 - self.below
        moved = np.empty_like(right)
        moved[self.places] = right
        return np.asarray(solve_banded(widths, self.diagonals, moved)[self.places])


def banded(rows: Array, columns: Array, values: Array, places: Array) -> Banded:
    """Return a matrix given by entries, equal places being added."""
    size = len(places)
    new_rows, new_columns = places[rows], places[columns]
    offsets = new_columns - new_rows
    above, below = int(offsets.max()), int(-offsets.min())
    diagonals = np.zeros((above + below + 1, size))
    np.add.at(diagonals, (above - offsets, new_columns), values)
    return Banded(csr_array((values, (rows, columns)), shape=(size, size)), places, diagonals, below)


def scaled(recursion: Lagged, r: float) -> Lagged:
    """Return the recursion of r^(-n/2) y_n."""
    factors = float(r) ** (-0.5 * (recursion.lags + 1.0))
    return Lagged(recursion.lags, recursion.maps * factors[:, None, None])


def noise_gain(recursion: Lagged, r: float) -> Gain:
    """Return the gain of noise at some r above the squares of all eigenvalues of the recursion without noise."""
    recursion = scaled(recursion, r)
    k = recursion.maps.shape[-1]
    unit = np.eye(k * (k + 1) // 2)
    Q = np.stack([smat(each, k) for each in unit], axis=-1)
    gamma, change = covariances(recursion, Q)
    gain = np.stack([svec(P) for P in np.moveaxis(_noise(recursion, gamma), -1, 0)], axis=-1)
    values, left, right = eig(gain, left=True)
    largest = np.abs(values).argmax()
    y, x = left[:, largest], right[:, largest]
    value = float(np.abs(values[largest]))
    # At a multiple eigenvalue y is orthogonal to x, and rounding is at most what its square root would be.
    condition = np.abs(y) @ np.abs(gain) @ np.abs(x) / max(abs(np.vdot(y, x)), np.sqrt(EPS))
    return Gain(value, (change + 16.0 * EPS * k) * max(value, float(condition)))


def covariances(recursion: Lagged, Q: Array) -> tuple[Array, float]:
    """Return Gamma_0, ..., Gamma_{m+1} for some Q.

    Parameters
    ----------
    recursion : Lagged
        All of whose eigenvalues lie within the unit circle, the noise being left aside.
    Q : ndarray, shape (k, k, S)
        Symmetric in the first two.

    Returns
    -------
    gamma : ndarray, shape (m + 2, k, k, S)
    change : float
        Of the largest entries by a step of iterative refinement, relative.
    """
    k, count, lags = Q.shape[0], Q.shape[2], int(recursion.lags[-1]) + 2
    matrix = _yule_walker(recursion, lags)
    right = np.zeros((lags * k * k, count))
    right[: k * k] = Q.reshape(-1, count)
    found = matrix.solve(right)
    correction = matrix.solve(right - matrix.matrix @ found)
    change = float((np.abs(correction).max(axis=0) / np.abs(found).max(axis=0)).max())
    return np.asarray((found + correction).reshape(lags, k, k, count)), change


def _yule_walker(recursion: Lagged, count: int) -> Banded:
    # The entry (a, b) of Gamma_j has the place (j k + a) k + b, and that of its transpose (j k + b) k + a.
    k = recursion.maps.shape[-1]
    j, i, a, b, c = np.meshgrid(
        np.arange(count), np.arange(len(recursion.lags)), *3 * [np.arange(k)], indexing="ij", sparse=True
    )
    source = j - 1 - recursion.lags[i]
    rows = (j * k + a) * k + b + 0 * (i + c)
    columns = np.where(source >= 0, (source * k + c) * k + b, (-source * k + b) * k + c) + 0 * a
    values = -recursion.maps[0][i, a, c] + 0.0 * (j + b)
    used = values != 0.0
    diagonal = np.arange(count * k * k)
    return banded(
        np.concatenate([diagonal, rows[used]]),
        np.concatenate([diagonal, columns[used]]),
        np.concatenate([np.ones(len(diagonal)), values[used]]),
        _folded(count, k * k),
    )


def _folded(count: int, block: int) -> Array:
    # The place of every unknown if Gamma_j stands beside Gamma_{m+1-j}: all that are coupled are neighbours.
    ends = np.stack([np.arange(count), np.arange(count)[::-1]], axis=-1).ravel()[:count]
    places = np.argsort(ends)
    return np.asarray((places[:, None] * block + np.arange(block)).ravel())


def _noise(recursion: Lagged, gamma: Array) -> Array:
    # sum over noises and pairs of lags of G_i E(y_{n-i} y_{n-p}^T) G_p^T, shape (k, k, S).
    at = recursion.lags[None, :] - recursion.lags[:, None]
    blocks = np.where((at >= 0)[..., None, None, None], gamma[np.abs(at)], gamma[np.abs(at)].swapaxes(2, 3))
    G = recursion.maps[1:]
    return np.asarray(np.einsum("jiac,ipcds,jpbd->abs", G, blocks, G, optimize=True))
