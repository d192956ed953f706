"""A chain of N points in R^d, clamped or free at its first end and free at its last end, with its ghost points.

Lindner et al. (2018), sections 2.3-2.7. States of shape (n, P), n = N d, hold one point after the other.
"""

from typing import NamedTuple

import numpy as np

from sdaeverify import Array

from .._arguments import count

# Largest number of points.
MOST = 100_000


class Chain(NamedTuple):
    """Points r_1..r_N with |r_i - r_{i-1}| = ds, of a fibre of length 1.

    Attributes
    ----------
    N, d : int
    ds : float
        Unit length.
    root : ndarray, shape (2, d, 1), or None
        Fixed points r_{-1} and r_0 of a clamp; None if both ends are free, so that r_1 is unconstrained.
    """

    N: int
    d: int
    ds: float
    root: Array | None

    @property
    def arc_lengths(self) -> Array:
        """Arc length s_i of each point, counted from the clamp or from the free end, shape (N,)."""
        return (np.arange(self.N) + (0.5 if self.root is None else 1.5)) * self.ds

    def straight(self) -> Array:
        """Return the positions of a straight fibre, shape (n,): downwards from the clamp, -s_i e_2, or along e_1."""
        direction = np.eye(self.d)[0] if self.root is None else -np.eye(self.d)[1]
        # Adding zero removes the sign of -0.0.
        return np.outer(self.arc_lengths, direction).ravel() + 0.0

    def points(self, x: Array) -> Array:
        """Reshape the rows of a state or of directions by points: (n, ..., P) -> (N, d, ..., P)."""
        return x.reshape(self.N, self.d, *x.shape[1:])

    def positions(self, r: Array) -> Array:
        """Return r_0..r_{N+1}, shape (N + 2, d, P)."""
        return self._extend(self.points(r), None if self.root is None else self.root[1:])

    def velocities(self, v: Array) -> Array:
        """Return v_0..v_{N+1}, shape (N + 2, d, P)."""
        return self._extend(self.points(v), None if self.root is None else 0.0)

    def bends(self, x: Array) -> Array:
        """Return r_{i+1} - 2 r_i + r_{i-1}, i = 0..N+1, of x = positions(r), shape (N + 2, d, P).

        Second differences beyond a free end vanish: r_{N+1} = 2 r_N - r_{N-1} and r_{N+2} = 3 r_N - 2 r_{N-1}.
        """
        edges, bends = x[1:] - x[:-1], np.zeros_like(x)
        np.subtract(edges[1:], edges[:-1], out=bends[1:-1])
        if self.root is not None:
            bends[0] = edges[0] - (self.root[1] - self.root[0])
        return bends

    def edges(self, r: Array) -> Array:
        """Return r_i - r_{i-1} for all constrained edges, shape (m, d, P)."""
        return self._differences(self.points(r), 0.0 if self.root is None else self.root[1:])

    def differences(self, y: Array) -> Array:
        """Return y_i - y_{i-1} of directions for all constrained edges: (n, ..., P) -> (m, d, ..., P)."""
        return self._differences(self.points(y), 0.0)

    def _extend(self, x: Array, first: Array | float | None) -> Array:
        begin = 2.0 * x[:1] - x[1:2] if first is None else np.broadcast_to(first, x[:1].shape)
        return np.concatenate([begin, x, 2.0 * x[-1:] - x[-2:-1]])

    def _differences(self, x: Array, first: Array | float) -> Array:
        inner = x[1:] - x[:-1]
        return inner if self.root is None else np.concatenate([x[:1] - first, inner])


def clamped_chain(N: int, d: int) -> Chain:
    """Return a chain clamped at the origin, downwards: ds = 1/(N + 1), r_{-1} = (ds/2) e_2, r_0 = -(ds/2) e_2.

    Raises
    ------
    ParameterError
        If N is not an integer from 2 to 100000, or d is neither 2 nor 3.
    """
    count("N", N, 2, MOST)
    count("d", d, 2, 3)
    ds = 1.0 / (N + 1)
    root = np.outer([0.5 * ds, -0.5 * ds], np.eye(d)[1])
    return Chain(N, d, ds, root[..., None])


def free_chain(N: int, d: int) -> Chain:
    """Return a chain with two free ends, ds = 1/N.

    Raises
    ------
    ParameterError
        If N is not an integer from 2 to 100000, or d is neither 2 nor 3.
    """
    count("N", N, 2, MOST)
    count("d", d, 2, 3)
    return Chain(N, d, 1.0 / N, None)
