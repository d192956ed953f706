"""A quadrature rule for one standard normal that adapts itself to the function: panels are bisected until they agree.

All panels of a round are evaluated in one batch.
"""

from collections.abc import Callable
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from ...arrays import Array
from ..step.step_noise import CUT

NODES = 16
# A panel and its halves agree within this part of the whole integral.
TOLERANCE = 1e-13
# At a jump, the error of a panel is its length: that of the last round is below 1e-12.
ROUNDS = 46
MOST_PANELS = 256


class Panels(NamedTuple):
    """Some intervals with the nodes of a Gauss-Legendre rule in each.

    Attributes
    ----------
    ends : ndarray, shape (2, I)
    values : ndarray, shape (..., I NODES)
        Of a function at all nodes.
    integrals : ndarray, shape (..., I)
        Of what is integrated, against the normal density.
    """

    ends: Array
    values: Array
    integrals: Array


class Bisected(NamedTuple):
    """A rule and its parent, each with the values that the function has at the nodes.

    Attributes
    ----------
    values, coarse_values : ndarray, shape (..., K)
    weights, coarse_weights : ndarray, shape (K,)
    """

    values: Array
    weights: Array
    coarse_values: Array
    coarse_weights: Array


def bisected(function: Callable[[Array], Array], integrand: Callable[[Array, Array], Array]) -> Bisected:
    """Return rules on [-9.5, 9.5] which integrate something made of a function; 0 is the end of a panel.

    Parameters
    ----------
    function : callable, ndarray of shape (K,) -> ndarray of shape (..., K)
        Evaluated at nodes in units of the standard deviation.
    integrand : callable, (values, weights) -> ndarray of shape (..., I)
        Integrals over I panels, from values of shape (..., I, NODES) and weights of shape (I, NODES).

    Returns
    -------
    Bisected
    """
    fine: list[Panels] = []
    coarse: list[Panels] = []
    parents = _panels(np.array([[-CUT, 0.0], [0.0, CUT]]), function, integrand)
    for left in reversed(range(ROUNDS)):
        middle = parents.ends.mean(axis=0)
        ends = np.stack([parents.ends[0], middle, middle, parents.ends[1]]).reshape(2, 2, -1)
        children = _panels(ends.swapaxes(0, 1).reshape(2, -1), function, integrand)
        done = _agree(parents, children, [*fine, parents])
        if left == 0 or np.count_nonzero(~done) > MOST_PANELS:
            done = np.ones_like(done)
        coarse.append(_chosen(parents, done))
        fine.append(_chosen(children, np.tile(done, 2)))
        if done.all():
            break
        parents = _chosen(children, np.tile(~done, 2))
    return Bisected(*_rule(fine), *_rule(coarse))


def _panels(ends: Array, function: Callable[[Array], Array], integrand: Callable[[Array, Array], Array]) -> Panels:
    z, weights = _nodes(ends)
    values = function(z.ravel())
    return Panels(ends, values, integrand(values.reshape(*values.shape[:-1], *z.shape), weights))


def _nodes(ends: Array) -> tuple[Array, Array]:
    # Nodes and weights of all panels, shape (I, NODES).
    q, w = _gauss_legendre()
    half = 0.5 * (ends[1] - ends[0])[:, None]
    z = 0.5 * (ends[0] + ends[1])[:, None] + half * q
    return z, half * w * np.exp(-0.5 * z**2) / np.sqrt(2.0 * np.pi)


def _agree(parents: Panels, children: Panels, all_panels: list[Panels]) -> Array:
    # Which parents have the integral of their two children, who are all first halves and then all second ones.
    first, second = np.split(children.integrals, 2, axis=-1)
    axes = tuple(range(first.ndim - 1))
    total = sum(panels.integrals.sum(axis=-1) for panels in all_panels)
    return np.asarray(np.abs(parents.integrals - first - second).max(axis=axes) <= TOLERANCE * np.abs(total).max())


def _chosen(panels: Panels, which: Array) -> Panels:
    return Panels(panels.ends[:, which], panels.values[..., np.repeat(which, NODES)], panels.integrals[..., which])


def _rule(parts: list[Panels]) -> tuple[Array, Array]:
    weights = np.concatenate([_nodes(part.ends)[1].ravel() for part in parts])
    return np.concatenate([part.values for part in parts], axis=-1), weights


@lru_cache(maxsize=1)
def _gauss_legendre() -> tuple[Array, Array]:
    q, w = np.polynomial.legendre.leggauss(NODES)
    return q, w
