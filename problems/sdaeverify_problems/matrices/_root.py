"""Steps from matrices onto a level set of x^T x along the normals x Lambda of another matrix, by Newton's method.

With C = x^T x, B = x^T y and W = x^T x' = B + C Lambda, the equation x'^T x' = L for x' = y + x Lambda is

    F(Lambda) = Lambda C Lambda + Lambda B + B^T Lambda = L - y^T y,    F'(Lambda) D = W^T D + D W.

As tr(D F'(Lambda) D) = tr(D (W + W^T) D), F is injective where the symmetric part of W is positive definite: a convex
set, so that a root in it is the only one there and is connected to Lambda = 0 if that is in it, too.
"""

from functools import partial
from itertools import accumulate
from typing import NamedTuple

import numpy as np

from sdaeverify import Array, Mask
from sdaeverify.numerics import Root, newton

from ._lyapunov import cayley_transform, product, series, transposed_product

# Iterations and squarings in each: the usual ones on all paths, then those of the paths that take longer. With two
# squarings, what an update leaves out is a 2^-16th of the rest even where eigenvalues of W are 1/3 or 3.
USUAL, LATE = (4, 2), (26, 5)
HALF = 0.5


class MatrixLevel(NamedTuple):
    """The equation for Lambda on every path.

    Attributes
    ----------
    C, B, right : ndarray, shape (p, p, P)
        x^T x, x^T y and L - y^T y.
    rounding : ndarray, shape (P,)
        Bound of the rounding errors of Lambda, in its largest entry.
    """

    C: Array
    B: Array
    right: Array
    rounding: Array

    @classmethod
    def of(cls, x: Array, C: Array, y: Array, L: Array) -> "MatrixLevel":
        """Return the equation for x and y of shape (d, p, P), C and L of shape (p, p, P)."""
        square = transposed_product(y, y)
        # A sum of d products and three more have d + 2 rounding errors, halved by the inverse of F'.
        size = (len(x) + 2.0) * np.finfo(float).eps * np.abs(square).max(axis=(0, 1))
        return cls(C, transposed_product(x, y), L - square, size)

    def solve(self) -> Root:
        """Return Lambda, shape (p p, P), converged where it is surely the root that is connected to Lambda = 0."""
        with np.errstate(all="ignore"):
            root = self._iterate(self._guess().reshape(-1, len(self.rounding)), *USUAL)
            late = ~root.converged
            if late.any():
                rest = MatrixLevel(*(part[..., late] for part in self))._iterate(root.x[:, late], *LATE)
                root.x[:, late], root.converged[late] = rest.x, rest.converged
                root.iterations[late] += rest.iterations
            sure = _definite(self.B) & _definite(self.B + product(self.C, self._matrix(root.x)))
        return root._replace(converged=root.converged & sure)

    def _guess(self) -> Array:
        """Return Lambda for C = c Id if V = Lambda + S, S + K = B/c with K^T = -K, commutes with K.

        Then V^2 = T = (L - y^T y + B^T B/c)/c + K^2: exact in the limit eps = 0, up to powers of T/t - Id from the
        third on.
        """
        p, unit = len(self.C), np.eye(len(self.C))[..., None]
        c = _trace(self.C) / p
        B = self.B / c
        S = 0.5 * _twice_sym(B)
        T = self.right / c + transposed_product(B, B) + product(B - S, B - S)
        t = _trace(T) / p
        rest = T / t - unit
        return 0.5 * _twice_sym(np.sqrt(t) * (unit + 0.5 * rest - 0.125 * product(rest, rest)) - S)

    def _iterate(self, begin: Array, most: int, squarings: int) -> Root:
        root = newton(self._linearise, begin, self.rounding, most, partial(_update, squarings))
        # Where powers of A do not decay, an update is a small part of Newton's, and its size not that of the error.
        A = cayley_transform(np.swapaxes(self.B + product(self.C, self._matrix(root.x)), 0, 1))[1]
        left = np.abs(_squares(A, squarings)[-1]).max(axis=(0, 1))
        return root._replace(converged=root.converged & (left <= HALF))

    def _linearise(self, entries: Array) -> tuple[Array, Array]:
        Lambda = self._matrix(entries)
        half = 0.5 * product(self.C, Lambda)
        U = self.B + half
        return (_twice_sym(product(Lambda, U)) - self.right).reshape(entries.shape), U + half

    def _matrix(self, entries: Array) -> Array:
        return entries.reshape(self.C.shape)


def _update(squarings: int, W: Array, defect: Array) -> Array:
    inverse, A = cayley_transform(np.swapaxes(W, 0, 1))
    # No later update would take back what is not symmetric in Lambda.
    return (0.5 * _twice_sym(series(inverse, _squares(A, squarings), defect.reshape(W.shape)))).reshape(defect.shape)


def _squares(A: Array, squarings: int) -> list[Array]:
    return list(accumulate(range(squarings), lambda power, _: product(power, power), initial=A))


def _definite(W: Array) -> Mask:
    """Tell where the symmetric part S is surely positive definite: tr S > 0 and (tr S)^2 > (p - 1) |S|^2."""
    S, trace = 0.5 * _twice_sym(W), _trace(W)
    return np.asarray((trace > 0.0) & (trace**2 > (len(W) - 1.0) * np.einsum("ijP,ijP->P", S, S)))


def _twice_sym(A: Array) -> Array:
    """Return A + A^T."""
    return A + np.swapaxes(A, 0, 1)


def _trace(A: Array) -> Array:
    return np.asarray(np.einsum("iiP->P", A))
