"""The constraint x^T x = Id for d x p matrices x, stored by rows: the entries on and above the diagonal."""

from typing import Any

import numpy as np

from sdaeverify import Array


def matrix_constraint(d: int, p: int) -> dict[str, Any]:
    """Return zeta = (x^T x - Id)_ij, i <= j, and its derivatives, for dynamics that start at (Id, 0)."""
    i, j = np.triu_indices(p)
    q, unit = np.arange(len(i)), np.eye(p)[i, j][:, None]
    # Pairs of columns of x that are multiplied in each entry of x^T x.
    pairs = np.zeros((len(q), p, p))
    pairs[q, i, j] += 1.0
    pairs[q, j, i] += 1.0

    def zeta(x: Array) -> Array:
        rows = x.reshape(d, p, -1)
        return np.asarray((rows[:, i] * rows[:, j]).sum(axis=0) - unit)

    def jacobian(x: Array) -> Array:
        rows = x.reshape(d, p, -1)
        Dg = np.zeros((len(q), *rows.shape), dtype=x.dtype)
        Dg[q, :, i] += np.swapaxes(rows, 0, 1)[j]
        Dg[q, :, j] += np.swapaxes(rows, 0, 1)[i]
        return Dg.reshape(len(q), *x.shape)

    hessians = np.einsum("nm,kij->knimj", np.eye(d), pairs).reshape(len(q), d * p, d * p)
    return {"constraint": zeta, "jacobian": jacobian, "hessians": hessians, "start": np.eye(d, p).ravel()}
