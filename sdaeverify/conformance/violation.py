"""The first violation of a step's contract, of exactness on trivial equations, or of the equation at some state.

A short step follows the equation at every state that solutions reach, not at those alone where orders are probed.
With Delta = Phi_h(x; xi) - x and the equation dx = f dt + B dW, whatever converges in law has

    E Delta = f h + o(h),    E Delta Delta^T = B B^T h + o(h)

at each x (Milstein 1986). A step that clips its state, or loses a term on one side of a threshold, has that
everywhere else, and a few states in the middle of the law do not show it.
"""

from typing import NamedTuple

import numpy as np

from ..arrays import Array
from ..contracts.measure import measures_following
from ..contracts.scheme import Scheme
from ..forms import Problem
from ..numerics import norm
from ..numerics.statistics import EPS
from ..probe.local.strong_defects import core
from ..probe.step.nodes import Nodes, step_nodes
from ..probe.step.one_step import OneStep, why_unresolved
from ..probe.step.states import WHEN, pilot_states
from .contract import contract_violation
from .exactness import exactness_violation

# In units of the horizon, or of time where that is shorter: errors that vanish as steps are shortened are let pass.
SIZES = 4.0 ** -np.array([6.0, 8.0, 10.0, 12.0, 14.0])
# Nodes a variable: exact to degree 3, which is enough for two moments. Noise of more nodes is not asked.
COUNT, MOST = 2, 64
# Columns of one call at most.
WORK = 16_384
# A part that is wrong by less is left to orders; an error of order 1/2 in h falls below this power of the factor.
SHARE, VANISHING = 0.05, 0.4
# At last, what is wrong is the same part of drift or noise for all steps; what is tamed is not.
SAME = 0.9
# A drift that moves a state by more than this in the shortest step may be tamed or truncated in all of them.
MOVED = 0.01
# Of the size that drift and noise have at other states: where they are 0 themselves, nothing is a part of them.
TYPICAL = 0.2
ROUNDINGS = 64.0
MOMENTS = "drift", "covariance"


def departure(scheme: Scheme, view: Problem) -> str:
    """Return at which state the law of a short step is not that of the equation, in one line, or an empty string.

    Parameters
    ----------
    scheme : Scheme
    view : Problem
        Of the scheme's form.

    Returns
    -------
    str
        Empty, too, where a step cannot be probed, where steps so short do not resolve the equation, and where its
        noise has too many nodes.
    """
    step, unit = OneStep(scheme, view), view.time_unit
    if why_unresolved(view, SIZES[-1] * unit) or step.refusal():
        return ""
    nodes = step_nodes(view.noise_dim, COUNT, areas="H" in scheme.noise, law=scheme.law)
    if not nodes.exact or len(nodes.weights) > MOST:
        return ""
    x = pilot_states(view, step.equation)
    x = x[:, SIZES[-1] * unit * norm(step.equation.drift(WHEN * view.horizon, x)) < MOVED]
    x = x[:, :: max(-(-x.shape[1] * len(nodes.weights) // WORK), 1)]
    return _of_law(ShortSteps.of(step, nodes, x), x) if x.size else ""


def _of_law(steps: "ShortSteps", x: Array) -> str:
    before, vanishing = steps.off(x, 0), (SIZES[1] / SIZES[0]) ** VANISHING
    for size in range(1, len(SIZES)):
        after = steps.off(x, size)
        least = SAME if size == len(SIZES) - 1 else vanishing
        wrong = (after > np.fmax(SHARE, least * before)).any(axis=(0, 1))
        if not wrong.any():
            return ""
        x, before = x[:, wrong], after[..., wrong]
    moment, component, state = np.unravel_index(before.argmax(), before.shape)
    part = f"{before.max():.2g} of the {MOMENTS[moment]} of {list(steps.rows)[component]}"
    return f"a short step from {_state_words(x[:, state])} is off by {part}, and by no less if it is shorter"


class ShortSteps(NamedTuple):
    """Steps of a scheme whose law is compared with that of the equation.

    Attributes
    ----------
    step : OneStep
    nodes : Nodes
        Exact for two moments.
    rows : dict of str to slice
        Of the C components that drift or diffusion depend on: what is an output alone is no state.
    least : ndarray, shape (2, C)
        Sizes of drift and covariance that errors are compared with at least; infinite where there is none.
    """

    step: OneStep
    nodes: Nodes
    rows: dict[str, slice]
    least: Array

    @classmethod
    def of(cls, step: OneStep, nodes: Nodes, x: Array) -> "ShortSteps":
        """Return those of a scheme whose states x, shape (d, S), are typical.

        Parameters
        ----------
        step : OneStep
            The scheme's step and the equation.
        nodes : Nodes
            Of its noise.
        x : ndarray, shape (d, S)
            States, whose sizes of a step tell what is typical.
        """
        parts = zip(step.names.items(), core(step.equation, x), strict=True)
        found = cls(step, nodes, {name: rows for (name, rows), counts in parts if counts}, np.zeros(0))
        least = TYPICAL * np.median(found._equation(x)[1], axis=-1)
        return found._replace(least=np.where(least > 0.0, least, np.inf))

    def off(self, x: Array, size: int) -> Array:
        """Return by which parts drift and covariance are off beyond rounding, shape (2, C, S); 0 if not finite."""
        wide, h = np.repeat(x, len(self.nodes.weights), axis=1), float(SIZES[size]) * self.step.view.time_unit
        noise = self.nodes.increment(h, x.shape[1])
        moved = (self.step(wide, self._t, h, noise) - wide).reshape(*x.shape, -1)
        rounding = ROUNDINGS * EPS * np.abs(x).max(axis=0)
        (drifts, squares), sizes = self._equation(x)
        found = np.zeros_like(sizes)
        for place, rows in enumerate(self.rows.values()):
            second = np.einsum("isk,jsk,k->ijs", moved[rows], moved[rows], self.nodes.weights)
            found[0, place] = _size(self.nodes.mean(moved[rows]) - h * drifts[place]) - rounding
            found[1, place] = _size(second - h * squares[place]) - rounding**2
        return np.nan_to_num(found / (h * (sizes + self.least[..., None])), nan=0.0, posinf=0.0)

    @property
    def _t(self) -> float:
        return WHEN * self.step.view.horizon

    def _equation(self, x: Array) -> tuple[tuple[list[Array], list[Array]], Array]:
        """Return f and B B^T of each component at the states, and their sizes, shape (2, C, S)."""
        equation, states = self.step.equation, x.shape[1]
        f = np.broadcast_to(equation.drift(self._t, x), x.shape)
        B = np.broadcast_to(equation.diffusion(self._t, x), (len(x), equation.noise_dim, states))
        drifts = [f[rows] for rows in self.rows.values()]
        squares = [np.einsum("iks,jks->ijs", B[rows], B[rows]) for rows in self.rows.values()]
        return (drifts, squares), np.array([[_size(part) for part in parts] for parts in (drifts, squares)])


def _size(values: Array) -> Array:
    return norm(values.reshape(-1, values.shape[-1]))


def _state_words(x: Array) -> str:
    return f"[{', '.join(f'{value:.3g}' for value in x[:4])}{', ...' if len(x) > 4 else ''}]"


def violation(scheme: Scheme, view: Problem) -> str:
    """Return the first violation in one line, or an empty string.

    Parameters
    ----------
    scheme : Scheme
    view : Problem
        Of the scheme's form; the contract is tried on it, exactness on trivial problems of the same form, and whether
        a step follows the equation at all states where a scheme claims to.

    Returns
    -------
    str

    Raises
    ------
    Exception
        What a step raises at states of the view: nothing can be said of such a scheme.
    """
    with np.errstate(all="ignore"):
        if text := contract_violation(scheme, view) or exactness_violation(scheme):
            return text
        return departure(scheme, view) if _follows(scheme, view) else ""


def _follows(scheme: Scheme, view: Problem) -> bool:
    """Tell whether a scheme claims to follow the equation on this problem in all its quantities."""
    held = [claim for claim in scheme.promises if claim.when <= view.traits and not claim.quantities]
    return not measures_following("paths", "law").isdisjoint(claim.measure for claim in held)
