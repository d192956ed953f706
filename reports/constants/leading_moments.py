"""The leading weak error on a linear equation, predicted from a modified equation.

Let L be the generator, h^p L_p the terms of the modified equation and u(t, .) = E[g(X_T) | X_t = .]. Then

    E g(X_T^h) - E g(X_T) = h^p int_0^T E[(L_p u)(t, X_t)] dt + o(h^p)     (Talay and Tubaro 1990),

because one step at time t is off by h^(p+1) L_p u. For dx = (A x + a) dt + sum_j (C_j x + c_j) dW_j and z = (x, 1)
each elementary differential is linear: F(tau) = M_tau z, where M_tau is the product of the coefficients along a
tree without branches, and 0 for a tree with branches. With g(x) = z^T S z, u is a quadratic form of z as well, and
P = E z z^T obeys P' = G P. The integral is <S, int exp((T - t) G) D exp(t G) P_0 dt> with

    D P = sum c (M P + P M^T) over terms of one tree + sum c (M_1 P M_2^T + M_2 P M_1^T) over those of two.

Terms of third and higher order vanish, because g is quadratic.
"""

import numpy as np
import scipy

from sdaeverify import Array
from sdaeverify.probe.linear.equation import LinearEquation
from sdaeverify.probe.linear.second_moments import smat, svec
from sdaeverify_orders.trees.grow import DRIFT, Tree
from sdaeverify_orders.trees.modified.equation import ModifiedEquation


def leading_moments(modified: ModifiedEquation, equation: LinearEquation, start: Array, time: float) -> Array:
    """Return the coefficient of h^p in E z z^T of the scheme minus that of the solution, z = (x, 1).

    Parameters
    ----------
    modified : ModifiedEquation
        Of a class that the equation is in, with as many Brownian motions; p is its order.
    equation : LinearEquation
    start : ndarray, shape (d,)
        x at time 0.
    time : float
        T.

    Returns
    -------
    ndarray, shape (d + 1, d + 1)
    """
    n, z = len(start) + 1, np.append(start, 1.0)
    D = np.column_stack([svec(_defect(modified, equation, smat(unit, n))) for unit in np.eye(n * (n + 1) // 2)])
    G = equation.generator()
    both = scipy.linalg.expm(time * np.block([[G, D], [np.zeros_like(G), G]]))
    return smat(both[: len(G), len(G) :] @ svec(np.outer(z, z)), n)


def _defect(modified: ModifiedEquation, equation: LinearEquation, P: Array) -> Array:
    """Return D P: the rate at which E z z^T = P changes by the terms of h^p."""
    found = np.zeros_like(P)
    for term in modified.terms:
        if len(term.forest) == 1:
            half = _differential(term.forest[0], equation) @ P
        elif len(term.forest) == 2:
            half = np.linalg.multi_dot(
                [_differential(term.forest[0], equation), P, _differential(term.forest[1], equation).T]
            )
        else:
            continue
        found += term.value * (half + half.T)
    return found


def _differential(of: Tree, equation: LinearEquation) -> Array:
    """Return M with F(tau)(x) = M (x, 1)."""
    n = len(equation.drift)
    if of.colour < DRIFT or len(of.kids) > 1:
        return np.zeros((n, n))
    own = equation.drift if of.colour == DRIFT else equation.diffusion[..., of.colour - 1]
    return np.asarray(own @ _differential(of.kids[0], equation)) if of.kids else own
