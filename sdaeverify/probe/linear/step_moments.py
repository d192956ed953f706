"""How second moments pass through one step of a scheme: P -> E A P A^T with A = [[R, r], [0, 1]] acting on (x, 1).

The expectation is exact for the atoms of a bounded law, and for steps that are affine in Gaussian noise, for which
the n + 1 vertices of a regular simplex are enough. Other steps need quadrature.
"""

from functools import partial
from typing import NamedTuple

import numpy as np

from ...arrays import Array
from ...contracts.scheme import Scheme, flatten
from ...forms import Problem
from ..step.one_step import OneStep
from ..step.step_noise import CUT, StepNoise
from .affine import AFFINE, relative
from .expectation import Expectation, FarNoise, expectation, factors_of, far_noise
from .linear_map import LinearMap, MemoryStep, linear_map
from .second_moments import Operator


class StepMoments(NamedTuple):
    """The operator of a step and what was noticed.

    Attributes
    ----------
    expectation : Expectation
        Of matrices E z z^T with z = (x, 1), x being all memory of the scheme.
    defect : float
        Of linearity in the state, relative: rounding if the step is linear.
    failed : bool
        Whether the scheme found no root somewhere.
    far : FarNoise
        Poles of the step in its noise, and what noise beyond the quadrature adds.
    """

    expectation: Expectation
    defect: float
    failed: bool
    far: FarNoise = FarNoise(np.inf, 0.0)

    @property
    def operator(self) -> Operator:
        """The operator, by the finer rule."""
        return self.expectation.operator

    @property
    def rule_error(self) -> float:
        """How much the two rules disagree, and what they leave out, relative to an operator of size at least 1."""
        return self.expectation.disagreement + self.far.left_out


def no_linear_step(scheme: Scheme, view: Problem) -> str:
    """Return why a step cannot be probed for a linear map, or an empty string; whether it is linear shows later."""
    if not StepNoise.of(OneStep(scheme, view)).tractable:
        return f"the atoms of {view.noise_dim} bounded variables are too many"
    kind = flatten(scheme.start(view, 1, view.horizon)).dtype.kind
    return "" if kind == "f" else "the scheme's memory is no array of real numbers"


def step_moments(one_step: OneStep, h: float, *, far: bool = True) -> StepMoments:
    """Return how second moments pass through a step of size h.

    Parameters
    ----------
    one_step : OneStep
    h : float
    far : bool
        Whether noise is searched for poles and for what it carries beyond the quadrature.

    Returns
    -------
    StepMoments
    """
    step, noise = MemoryStep(one_step, h), StepNoise.of(one_step)
    with np.errstate(all="ignore"):
        if noise.law.bounded:
            return _by_atoms(step, noise)
        points = np.concatenate([noise.simplex(), noise.trials()], axis=1)
        found = linear_map(step, noise.nodes(points, np.ones(points.shape[1])))
        if _affine(found, points):
            vertices = len(points) + 1
            return _exact(found, Operator(found.factors[..., :vertices], np.full(vertices, 1.0 / vertices)))
        seen = far_noise(partial(factors_of, step, noise), noise) if far else FarNoise(np.inf, 0.0)
        operators = expectation(step, noise, kinks=seen.pole > CUT)
        return StepMoments(operators, found.defect, found.failed, seen)


def _by_atoms(step: MemoryStep, noise: StepNoise) -> StepMoments:
    atoms = noise.rule(0)
    assert atoms is not None
    found = linear_map(step, atoms)
    return _exact(found, Operator(found.factors, atoms.weights))


def _exact(found: LinearMap, operator: Operator) -> StepMoments:
    return StepMoments(Expectation(operator, operator), found.defect, found.failed)


def _affine(found: LinearMap, points: Array) -> bool:
    # With vertices v_i, an affine function is the sum of its values there times (1 + v_i . x)/(n + 1).
    n = len(points)
    shares = (1.0 + points[:, : n + 1].T @ points[:, n + 1 :]) / (n + 1)
    # Without the last row, next to whose 1 a small R would not count.
    R = found.factors[:-1].reshape(-1, points.shape[1])
    at_vertices, beyond = np.split(R, [n + 1], axis=1)
    difference = beyond - at_vertices @ shares
    return bool(np.isfinite(R).all()) and relative(difference, np.abs(at_vertices) @ np.abs(shares)) <= AFFINE
