"""Random polynomial vector fields and their elementary differentials, by exact derivatives of polynomials."""

from collections.abc import Sequence

import numpy as np

Array = np.ndarray


def directional(p: Array, v: Array) -> Array:
    """Return the derivative of a polynomial in a constant direction; axes of p are powers of each variable."""
    total = np.zeros_like(p)
    for axis, part in enumerate(v):
        powers = np.arange(1, p.shape[axis]).reshape([-1 if i == axis else 1 for i in range(p.ndim)])
        moved = np.zeros_like(p)
        moved[_cut(p.ndim, axis, slice(0, -1))] = p[_cut(p.ndim, axis, slice(1, None))] * powers
        total += part * moved
    return total


def _cut(dimensions: int, axis: int, places: slice) -> tuple[slice, ...]:
    return tuple(places if i == axis else slice(None) for i in range(dimensions))


def value(p: Array, z: Array) -> float:
    """Return a polynomial at a point."""
    for part in z[::-1]:
        p = p @ part ** np.arange(p.shape[-1])
    return float(p)


def elementary(fields: Sequence[Sequence[Array]], trees: Sequence, z: Array) -> Array:
    """Return F(tau) of each tree at z = (x, t), shape (N, d); field 0 is the drift, j > 0 the j-th noise."""
    d = len(z) - 1
    found = {}
    for each in trees:
        parts = list(fields[each.colour])
        for kid in each.kids:
            v = np.append(np.zeros(d), 1.0) if kid.colour < 0 else np.append(found[kid], 0.0)
            parts = [directional(p, v) for p in parts]
        found[each] = np.array([value(p, z) for p in parts])
    return np.array([found[each] for each in trees])


def product(p: Array, q: Array) -> Array:
    """Return the product of two polynomials, without the powers that are beyond the size of the arrays."""
    found = np.zeros_like(q)
    for place in np.argwhere(p):
        inside = tuple(slice(0, size - i) for i, size in zip(place, q.shape, strict=True))
        found[tuple(slice(i, None) for i in place)] += p[tuple(place)] * q[inside]
    return found
