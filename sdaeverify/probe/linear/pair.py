"""Mean-square distance between the paths of scheme and solution, without sampling: a pair of linear recursions.

For dX = (A X + a) dt + C dW, and a step Y+ = M Y + r + N xi with dW = sqrt(h) xi, exactly

    X+ = E X + J a + S xi + I,    E = e^{Ah},   J = int_0^h e^{As} ds,   S = J C/sqrt(h),
    Cov I = int_0^h e^{As} C C^T e^{A^T s} ds - S S^T,    I independent of xi,

so that D = Y - X and X satisfy a linear recursion with exact second moments. In terms of D, small distances
are not differences of large numbers. The integrals are computed in the eigenbasis of A, without e^{-As}, which
overflows if A is stiff.
"""

from typing import NamedTuple

import numpy as np

from ...arrays import Array
from ...contracts.scheme import Scheme
from ...forms import Problem
from ...numerics.statistics import EPS
from ..step.one_step import OneStep
from ..step.step_noise import StepNoise
from .affine import AFFINE, relative
from .equation import LinearEquation, linear_equation, why_not_linear_equation
from .linear_map import MemoryStep, linear_map

# Rounding error of one recursion, in units of EPS and of the size of the moments.
# Rounding: EPS for each operation.
ROUNDING = 16.0
# Largest condition number of the eigenvectors of A.
# Rounding: eigenvectors of this condition number are known to 1e6 eps = 2e-10.
ILL = 1e6


class Recursion(NamedTuple):
    """z+ = F z + noise of covariance Q, for z with n components, the last of which is 1.

    Attributes
    ----------
    F, Q : ndarray, shape (n, n)
    """

    F: Array
    Q: Array

    def then(self, later: "Recursion") -> "Recursion":
        """Return the composition of this step and a later one."""
        return Recursion(later.F @ self.F, later.F @ self.Q @ later.F.T + later.Q)

    def power(self, count: int) -> "Recursion":
        """Return the composition of `count` steps."""
        found, square = Recursion(np.eye(len(self.F)), np.zeros_like(self.Q)), self
        while count:
            if count % 2:
                found = found.then(square)
            square, count = square.then(square), count // 2
        return found


class AffineStep(NamedTuple):
    """A step Y+ = M Y + r + N xi.

    Attributes
    ----------
    M : ndarray, shape (d, d)
    r : ndarray, shape (d,)
    N : ndarray, shape (d, l)
    defect : float
        Largest relative deviation of the step from this form: rounding if the step is affine.
    """

    M: Array
    r: Array
    N: Array
    defect: float


def why_not_linear_pair(scheme: Scheme, view: Problem) -> str:
    """Return why the distance to the solution cannot be propagated, or an empty string; see also `affine_step`."""
    if scheme.law.bounded or scheme.law.clip or scheme.noise != {"dW"}:
        return "the scheme uses other noise than Brownian increments"
    if reason := why_not_linear_equation(view) or OneStep(scheme, view).why_not_probed():
        return reason
    step = MemoryStep(OneStep(scheme, view), view.horizon)
    if step.dimension != step.one_step.equation.dimension or isinstance(step.start, tuple):
        return "the scheme has memory beyond the problem's components"
    return "the noise is not additive" if linear_equation(step.one_step.equation).diffusion[:, :-1].any() else ""


def affine_step(one_step: OneStep, h: float) -> AffineStep:
    """Return a step of size h as an affine function of state and noise, with its deviation from the step."""
    noise = StepNoise.of(one_step)
    xi = np.concatenate([noise.simplex(), noise.trials()], axis=1)
    found = linear_map(MemoryStep(one_step, h), noise.nodes(xi))
    vertices, (rows, shifts) = noise.normals + 1, (found.factors[:-1, :-1], found.factors[:-1, -1])
    M, r = rows[..., :vertices].mean(axis=-1), shifts[:, :vertices].mean(axis=-1)
    N = shifts[:, :vertices] @ xi[:, :vertices].T / vertices
    turned = relative((rows - M[..., None]).reshape(-1, xi.shape[1]), 1.0 + np.abs(rows).reshape(-1, xi.shape[1]))
    size = np.abs(r)[:, None] + np.abs(N) @ np.abs(xi)
    bent = relative(shifts - r[:, None] - N @ xi, size)
    return AffineStep(M, r, N, max(found.defect, turned, bent))


def mean_square_distance(one_step: OneStep, h: float, count: int) -> tuple[float, float]:
    """Return E |Y - X|^2 after some steps from the common start, and a bound of its rounding error.

    Parameters
    ----------
    one_step : OneStep
        Scheme and problem for which `why_not_linear_pair` is empty.
    h : float
    count : int

    Returns
    -------
    tuple of float
        The distance is infinite if it overflows. It is NaN, and the bound infinite, if the step is not affine or the
        equation has an ill-conditioned basis of eigenvectors.
    """
    step, x = affine_step(one_step, h), one_step.equation.initial(1)[:, 0]
    equation, d = linear_equation(one_step.equation), len(x)
    pair, condition = _pair(step, equation, h)
    if step.defect > AFFINE or condition > ILL:
        return float("nan"), float("inf")
    z = np.concatenate([np.zeros(d), x, [1.0]])
    end = pair.power(count)
    P = end.F @ np.outer(z, z) @ end.F.T + end.Q
    if not np.isfinite(P).all():
        return float("inf"), 0.0
    size = max(float(np.abs(P).max()), float(x @ x), 1.0)
    rounding = ROUNDING * EPS * (count + h * count * equation.rate)
    return float(np.trace(P[:d, :d])), size * rounding


def _pair(step: AffineStep, equation: LinearEquation, h: float) -> tuple[Recursion, float]:
    # Return the recursion of (D, X, 1), and the condition number of the eigenvectors of A.
    A, a, C = equation.drift[:-1, :-1], equation.drift[:-1, -1], equation.diffusion[:-1, -1]
    d, (rates, V) = len(A), np.linalg.eig(A)
    inverse = np.linalg.inv(V)
    E, J = ((V * factor @ inverse).real for factor in (np.exp(rates * h), _integral(rates, h)))
    W = inverse @ C
    both = (V @ (W @ W.conj().T * _integral(rates[:, None] + rates.conj(), h)) @ V.conj().T).real
    S = J @ C / np.sqrt(h)
    rest, off = both - S @ S.T, step.N - S
    F, Q = np.eye(2 * d + 1), np.zeros((2 * d + 1, 2 * d + 1))
    F[:d] = np.concatenate([step.M, step.M - E, (step.r - J @ a)[:, None]], axis=1)
    F[d:-1, d:] = np.concatenate([E, (J @ a)[:, None]], axis=1)
    Q[: 2 * d, : 2 * d] = np.block([[off @ off.T + rest, off @ S.T - rest], [S @ off.T - rest, both]])
    return Recursion(F, Q), float(np.linalg.cond(V))


def _integral(rates: Array, h: float) -> Array:
    """Return int_0^h e^{z s} ds = (e^{zh} - 1)/z for each rate z."""
    z = rates * h
    return np.where(np.abs(z) > 0.0, np.expm1(z) / np.where(np.abs(z) > 0.0, z, 1.0), 1.0) * h
