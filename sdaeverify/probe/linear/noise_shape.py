"""Whether a linear step is an affine or a polynomial function of its noise, from its values at few nodes.

They are compared with its values at points that reach far, and at many random ones: a step that is different in a
small region of the noise is so at none of few nodes.
"""

from functools import lru_cache

import numpy as np
import scipy
from numpy.polynomial.hermite_e import hermevander

from ...arrays import Array
from ..step.nodes import Nodes, gauss_hermite
from ..step.step_noise import StepNoise
from .affine import AFFINE, SIZES, relative, trial_states
from .linear_map import LinearMap
from .second_moments import Operator


def image_state(dimension: int) -> Array:
    """Return a random state of length 1, shape (k,), from which images are found at many values of the noise."""
    return np.asarray(trial_states(dimension)[:, SIZES.index(1.0) - len(SIZES)])


# Cached, as it is the same for all step sizes of a scan.
@lru_cache(maxsize=64)
def trial_nodes(noise: StepNoise) -> Nodes:
    """Return the trial points as nodes."""
    return noise.nodes(trial_points(noise))


def trial_points(noise: StepNoise) -> Array:
    """Return the vertices of the simplex, and points that reach far beyond, shape (n, P)."""
    return np.concatenate([noise.simplex(), noise.trials()], axis=1)


def is_affine(noise: StepNoise, found: LinearMap) -> bool:
    """Return whether the factors at trial nodes are those of an affine function."""
    at_vertices, beyond = np.split(found.factors, [noise.normals + 1], axis=-1)
    return is_told(beyond, at_vertices, affine_shares(noise, noise.trials()))


def affine_shares(noise: StepNoise, x: Array) -> Array:
    """Return the weights of the values at the vertices in an affine function's values at points, shape (n + 1, P)."""
    # With vertices v_i, an affine function is the sum of its values there times (1 + v_i . x)/(n + 1).
    return np.asarray((1.0 + noise.simplex().T @ x) / (noise.normals + 1))


def polynomial_shares(points: Array, count: int) -> Array:
    """Return the weights of values at the product rule with `count` nodes in a polynomial's values at points (n, P).

    For functions phi_j that are orthonormal under a rule, u(x) = sum_k w_k u(x_k) sum_j phi_j(x_k) phi_j(x).
    """
    x, weights = gauss_hermite(count)
    degrees = np.arange(len(x))
    shares = np.ones((1, 1))
    for axis in points:
        first, last = (hermevander(z, degrees[-1]) / np.sqrt(scipy.special.factorial(degrees)) for z in (x, axis))
        shares = (shares[:, None] * (weights[:, None] * first @ last.T)).reshape(-1, len(axis))
    return shares


def is_told_at_random(found: Array, operator: Operator, shares: Array) -> bool:
    """Return whether images (k, P) at random normals are those of an operator's nodes, weighted by `shares`.

    Parameters
    ----------
    found : ndarray, shape (k, P)
    operator : Operator
    shares : ndarray, shape (K, P)
        Weights of the values at the nodes of the operator.
    """
    R, state = operator.factors[:-1], np.append(image_state(len(operator.factors) - 1), 1.0)
    at_nodes = np.einsum("ijk,j->ik", R, state)
    difference = found - at_nodes @ shares
    return bool(np.isfinite(found).all()) and relative(difference, np.abs(at_nodes) @ np.abs(shares)) <= AFFINE


def is_told(factors: Array, nodes: Array, shares: Array) -> bool:
    """Return whether factors are sums of the factors at some nodes, weighted by `shares`.

    Parameters
    ----------
    factors : ndarray, shape (k + 1, k + 1, P)
    nodes : ndarray, shape (k + 1, k + 1, K)
        Factors at the nodes.
    shares : ndarray, shape (K, P)
    """
    # Without the last row, whose entry 1 would hide errors of a small R.
    R, at_nodes = (each[:-1].reshape(-1, each.shape[-1]) for each in (factors, nodes))
    difference = R - at_nodes @ shares
    return bool(np.isfinite(R).all()) and relative(difference, np.abs(at_nodes) @ np.abs(shares)) <= AFFINE
