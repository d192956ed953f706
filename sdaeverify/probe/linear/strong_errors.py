"""Mean-square errors of a scheme along the paths of a linear equation, without sampling.

Let Phi be the flow of dz = A z dt + sum_j C_j z dW_j over a step, z = (x, 1), and M the matrix of a scheme's step, a
polynomial in the noise of the step, W and J = int W ds. With e = Y - X the difference of scheme and solution,

    e+ = M e + (M - Phi) z,    z+ = Phi z,

so that E e e^T, E e z^T and E z z^T satisfy a linear recursion. Its coefficients are E M (x) M, by quadrature,
E Phi (x) Phi = exp(h G), and E M (x) Phi: for monomials m of W and J, Ito's formula closes,

    d E[m Phi] = A E[m Phi] + sum_j (C_j E[m_j Phi] + E[m_jj Phi]/2 + E[W_j m_J_j Phi]),

with derivatives m_j, m_jj by W_j and m_J_j by J_j. The leading error solves the equation of the asymptotic error
(Kurtz and Protter 1991); here it is the limit of errors that are exact at each step size.
"""

from collections.abc import Sequence
from itertools import combinations_with_replacement
from typing import NamedTuple

import numpy as np
import scipy

from ...arrays import Array
from ...contracts.scheme import Scheme
from ...forms import Problem
from ...numerics.statistics import EPS
from ..step.nodes import Nodes
from ..step.one_step import OneStep
from ..step.step_noise import StepNoise
from .affine import AFFINE, relative
from .equation import LinearEquation, linear_equation, why_not_linear_equation
from .linear_map import MemoryStep, linear_map

# Size: nodes of each normal, largest degree of a step in its noise, and unknowns of the linear systems.
NODES, MOST_DEGREE, MOST_UNKNOWNS = 5, 4, 600
# Rounding error of one recursion, in units of EPS and of the size of the moments.
# Rounding: EPS for each operation.
ROUNDING = 16.0
# Size: further step sizes, each half of the one before.
FURTHER = 4
# Powers of W_1, ..., W_l and, with J, of J_1, ..., J_l.
Powers = tuple[int, ...]


class StrongErrors(NamedTuple):
    """Mean-square errors at time T for H step sizes.

    Attributes
    ----------
    h : ndarray, shape (H,)
    squares : ndarray, shape (H, d)
        E |Y_i - X_i|^2 for each component; NaN where a step is not linear in the state or no polynomial in its noise.
    floor : ndarray, shape (H,)
        Bound of the rounding error of the squares.
    size : ndarray, shape (d,)
        E |X_i|^2.
    """

    h: Array
    squares: Array
    floor: Array
    size: Array


def why_not_strong_errors(scheme: Scheme, view: Problem) -> str:
    """Return why the errors cannot be propagated, or an empty string; whether steps are linear is not tested here."""
    if scheme.law.bounded or scheme.law.clip or not scheme.noise <= {"dW", "H"}:
        return "the scheme uses other noise than Brownian increments and their time integrals"
    one_step = OneStep(scheme, view)
    if reason := why_not_linear_equation(view) or one_step.why_not_probed():
        return reason
    if StepNoise.of(one_step).rule(NODES) is None:
        return "there are too many Brownian motions"
    step = MemoryStep(one_step, view.horizon)
    if step.remembers or step.dimension != one_step.equation.dimension or isinstance(step.start, tuple):
        return "the scheme has memory beyond the problem's components"
    return ""


def strong_errors(scheme: Scheme, view: Problem, steps: Sequence[int]) -> StrongErrors:
    """Return the mean-square errors at the final time, without sampling.

    Parameters
    ----------
    scheme : Scheme
    view : Problem
        Problem in the scheme's form; `why_not_strong_errors` is empty for the pair.
    steps : sequence of int
        Numbers N of steps to the final time, each twice the previous one; four more are appended.
    """
    one_step = OneStep(scheme, view)
    counts = [*steps, *(steps[-1] * 2**level for level in range(1, FURTHER + 1))]
    equation, start = linear_equation(one_step.equation), one_step.equation.initial(1)[:, 0]
    found = [_squares(one_step, equation, start, count) for count in counts]
    squares, sizes, floors = (np.array(each) for each in zip(*found, strict=True))
    return StrongErrors(view.horizon / np.array(counts), squares, floors, sizes[-1])


def _squares(one_step: OneStep, equation: LinearEquation, start: Array, count: int) -> tuple[Array, Array, float]:
    """Return E |Y_i - X_i|^2 and E |X_i|^2 after some steps, and a bound of the rounding error."""
    h, d = one_step.view.horizon / count, len(start)
    joint = _recursion(one_step, equation, h)
    if joint is None:
        return np.full(d, np.nan), np.full(d, np.nan), np.inf
    z, n = np.append(start, 1.0), d + 1
    first = np.zeros((4, n * n))
    first[3] = np.outer(z, z).ravel()
    with np.errstate(all="ignore"):
        last = (np.linalg.matrix_power(joint, count) @ first.ravel()).reshape(4, n, n)
    size = max(float(np.abs(last[3]).max()), float(z @ z))
    return np.diagonal(last[0])[:d], np.diagonal(last[3])[:d], ROUNDING * EPS * count * size


def _recursion(one_step: OneStep, equation: LinearEquation, h: float) -> Array | None:
    """Return the map of E e e^T, E e z^T, E z e^T, E z z^T over a step; None if the step is not of this kind."""
    noise, n = StepNoise.of(one_step), len(equation.drift)
    rule = noise.rule(NODES)
    assert rule is not None
    # Far points, because any function agrees with a polynomial at the few nodes of a rule.
    trials = noise.nodes(noise.trials())
    found, far = (linear_map(MemoryStep(one_step, h), nodes) for nodes in (rule, trials))
    step = _polynomial((found.factors, _variables(rule)), (far.factors, _variables(trials)))
    if step is None or found.failed or not found.defect <= AFFINE or len(step) * n > MOST_UNKNOWNS:
        return None
    scaled = LinearEquation(h * equation.drift, np.sqrt(h) * equation.diffusion)
    flow = weighted_flow(scaled, [*step])
    MF = sum(np.kron(step[each], flow[each]) for each in step)
    FM = sum(np.kron(flow[each], step[each]) for each in step)
    MM = np.einsum("abk,cdk,k->acbd", found.factors, found.factors, rule.weights).reshape(n * n, n * n)
    FF = scipy.linalg.expm(_generator(scaled))
    zero = np.zeros_like(MM)
    return np.block(
        [
            [MM, MM - MF, MM - FM, MM - MF - FM + FF],
            [zero, MF, zero, MF - FF],
            [zero, zero, FM, FM - FF],
            [zero, zero, zero, FF],
        ]
    )


def _generator(equation: LinearEquation) -> Array:
    A, C = equation
    unit = np.eye(len(A))
    noise = np.einsum("abj,cdj->acbd", C, C).reshape(A.size, A.size)
    return np.asarray(np.kron(A, unit) + np.kron(unit, A) + noise)


def _variables(nodes: Nodes) -> Array:
    """Return W and, if the scheme uses it, J of a step of length 1 at nodes."""
    return nodes.dW if nodes.H is None else np.concatenate([nodes.dW, nodes.H + 0.5 * nodes.dW])


def _polynomial(near: tuple[Array, Array], far: tuple[Array, Array]) -> dict[Powers, Array] | None:
    """Return the coefficients of the polynomial of lowest degree with given values; None above degree 4.

    Parameters
    ----------
    near, far : tuple of ndarray
        Values, shape (n, n, K), and variables, shape (v, K), to fit and to compare.
    """
    shape = near[0].shape[:2]
    for degree in range(MOST_DEGREE + 1):
        powers = _powers(len(near[1]), degree)
        found = np.linalg.lstsq(_monomials(powers, near[1]).T, near[0].reshape(-1, near[0].shape[-1]).T, rcond=None)[
            0
        ]
        if all(_explains(found, powers, *each) for each in (near, far)):
            return dict(zip(powers, found.reshape(-1, *shape), strict=True))
    return None


def _explains(found: Array, powers: Sequence[Powers], values: Array, variables: Array) -> bool:
    flat, monomials = values.reshape(-1, values.shape[-1]), _monomials(powers, variables)
    off = relative(flat - found.T @ monomials, np.abs(found.T) @ np.abs(monomials))
    return bool(np.isfinite(flat).all()) and off <= AFFINE


def _monomials(powers: Sequence[Powers], variables: Array) -> Array:
    return np.array([np.prod(variables ** np.array(each)[:, None], axis=0) for each in powers])


def _powers(variables: int, degree: int) -> list[Powers]:
    """Return the powers of all monomials up to a degree."""
    picks = (each for k in range(degree + 1) for each in combinations_with_replacement(range(variables), k))
    return [tuple(each.count(i) for i in range(variables)) for each in picks]


def weighted_flow(equation: LinearEquation, powers: Sequence[Powers]) -> dict[Powers, Array]:
    """Return E[m Phi] over a step of length 1 for monomials m that are closed under the equations of the module.

    Parameters
    ----------
    equation : LinearEquation
        Scaled to a step of length 1.
    powers : sequence of tuple of int
    """
    A, C = equation
    n, l, place = len(A), C.shape[-1], {each: k for k, each in enumerate(powers)}
    system = np.kron(np.eye(len(powers)), A)
    for each, k in place.items():
        for j in range(l):
            for other, factor in _derivatives(each, j, l, C[..., j]):
                m = place[other]
                system[k * n : (k + 1) * n, m * n : (m + 1) * n] += factor
    start = np.zeros((len(powers) * n, n))
    start[:n] = np.eye(n)
    ends = scipy.linalg.expm(system) @ start
    return {each: ends[k * n : (k + 1) * n] for each, k in place.items()}


def _derivatives(each: Powers, j: int, l: int, C: Array) -> list[tuple[Powers, Array]]:
    """Return the terms of the equation of a monomial from the j-th motion: powers and matrix factors."""
    unit, terms = np.eye(len(C)), []
    if (a := each[j]) > 0:
        terms.append((_moved(each, {j: -1}), a * C))
    if a > 1:
        terms.append((_moved(each, {j: -2}), 0.5 * a * (a - 1) * unit))
    if len(each) > l and (b := each[l + j]) > 0:
        terms.append((_moved(each, {j: 1, l + j: -1}), b * unit))
    return terms


def _moved(each: Powers, by: dict[int, int]) -> Powers:
    return tuple(power + by.get(k, 0) for k, power in enumerate(each))
