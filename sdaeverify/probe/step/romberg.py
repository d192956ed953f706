"""Expectations after a short time from the coefficients of an equation: extrapolated trees of Euler steps.

A tree is Euler's method with k steps of size h/k whose noise takes the 2 l values +-sqrt(l h/k) e_i with equal
probability; all (2 l)^k leaves are enumerated. Mean, covariance and third moments of the noise are right, so that

    E_k phi = E phi(x(t + h)) + c_1(h)/k + c_2(h)/k^2 + ...,    c_j(h) = O(h^(j+1)),

and Romberg's extrapolation of k = 1 ... K in 1/k to 0 has an error of O(h^(K+1)).
"""

from collections.abc import Callable
from math import factorial

import numpy as np

from ...arrays import Array
from ...forms import Equation

# Number of extrapolated trees by the number of Brownian motions: one more tree would have too many leaves.
DEPTHS = {1: 5, 2: 5, 3: 4}
# Size: trees; defects of higher order are attributed to the reference.
SHALLOWEST = 3


def depth(noises: int) -> int:
    """Return the number K of trees for l Brownian motions."""
    return DEPTHS.get(noises, SHALLOWEST)


def weights(K: int) -> Array:
    """Return the weights (-1)^(K-k) k^K / (k! (K-k)!), k = 1 ... K, of the extrapolation in 1/k to 0."""
    return np.array([(-1.0) ** (K - k) * k**K / (factorial(k) * factorial(K - k)) for k in range(1, K + 1)])


def extrapolate_means(
    ito: Equation, functions: Callable[[Array], Array], x: Array, step: tuple[float, float], K: int
) -> Array:
    """Return E phi(x(t + h)) given x(t) = x, with an error O(h^(K+1)).

    Parameters
    ----------
    ito : Equation
    functions : callable, ndarray of shape (d, P) -> ndarray of shape (F, P)
        Functions phi.
    x : ndarray, shape (d, S)
    step : (float, float)
        Time t and step size h.
    K : int
        Number of trees.

    Returns
    -------
    ndarray, shape (F, S)
    """
    t, h = step
    means = [functions(leaves(ito, x, t, h / k, k)) for k in range(1, K + 1)]
    trees = np.stack([values.reshape(len(values), x.shape[1], -1).mean(axis=2) for values in means])
    return np.asarray(np.einsum("k,kfs->fs", weights(K), trees))


def leaves(ito: Equation, x: Array, t: float, h: float, steps: int) -> Array:
    """Return the leaves of a tree of Euler steps of size h.

    Parameters
    ----------
    ito : Equation
    x : ndarray, shape (d, S)
        States at the root.
    t, h : float
    steps : int

    Returns
    -------
    ndarray, shape (d, S (2 l)^steps)
        Leaves of one root are contiguous, all equally probable.
    """
    for step in range(steps):
        x = _branches(ito, x, t + step * h, h)
    return x


def _branches(ito: Equation, x: Array, t: float, h: float) -> Array:
    l, centre = ito.noise_dim, (x + h * ito.drift(t, x))[..., None]
    kicks = np.sqrt(l * h) * ito.diffusion(t, x).swapaxes(1, 2)
    branches = np.empty((*x.shape, 2 * l))
    np.add(centre, kicks, out=branches[..., :l])
    np.subtract(centre, kicks, out=branches[..., l:])
    return branches.reshape(len(x), -1)
