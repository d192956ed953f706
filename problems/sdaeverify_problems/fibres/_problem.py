"""A fibre as a constrained problem, with a fine reference solution."""

from functools import partial

import numpy as np
from numpy.typing import ArrayLike

from sdaeverify import Control, HolonomicSDAE

from .. import _controls as controls
from .._arguments import in_one_line, instance, number
from .._inherent_truth import with_inherent_truth
from . import _inextensible as inextensible
from ._checks import check_functions, check_lengths, rows
from ._fibre import Fibre
from ._noise import FibreNoise
from ._observables import observables
from ._structure import fibre_structure

# Number of steps of the finest level and of the fine reference at the default settings.
FINEST_STEPS, REFERENCE_STEPS = 256, 512


@in_one_line
def fibre_problem(
    fibre: Fibre, horizon: float, position: ArrayLike | None = None, velocity: ArrayLike | None = None
) -> HolonomicSDAE:
    """Return a fibre as a problem.

    The problem has a fine reference solution if D is the identity, so that the noise does not depend on velocities,
    and if `is_resolved` holds. It has controls if `mild` holds, because the controls are explicit schemes.

    Parameters
    ----------
    fibre : Fibre
    horizon : float
        Final time.
    position, velocity : array_like, shape (N, d), optional
        Initial data; by default straight and at rest.

    Raises
    ------
    ParameterError
        If the fibre or the horizon has a wrong type.
    ProblemError
        If the initial data or the results of u, C or D have an unexpected shape, if an edge of the initial chain does
        not have the length ds, or if the velocity would change a length.
    """
    instance("fibre", fibre, Fibre)
    chain, noise, horizon = fibre.chain, FibreNoise(fibre), number("horizon", horizon)
    r = chain.straight() if position is None else rows(chain, "position", position)
    v = np.zeros(len(r)) if velocity is None else rows(chain, "velocity", velocity)
    check_lengths(chain, r)
    check_functions(fibre, r, v)
    problem = HolonomicSDAE(
        controls=_controls(fibre, horizon),
        force=fibre.force,
        diffusion=noise.matrix,
        diffusion_product=noise.product,
        constraint=partial(inextensible.constraint, chain),
        jacobian=partial(inextensible.dense, chain),
        curvature=partial(inextensible.curvature, chain),
        linearisation=lambda r: inextensible.ChainJacobian(chain, chain.edges(r)),
        structure=fibre_structure(fibre),
        constraint_bound=inextensible.bound(chain),
        position=r,
        velocity=v,
        horizon=horizon,
        fastest_time=min(_stiffness(fibre) ** -0.5, fibre.Dr**2),
        noise_dim=len(r),
        traits=noise.traits,
        observables=observables(fibre),
        units="length of the fibre 1, time in the unit in which alpha, Fr and Dr are given",
        source="Lindner et al. 2018, (2.8)",
    )
    return with_inherent_truth(problem) if fibre.D is None and is_resolved(fibre, horizon) else problem


def is_resolved(fibre: Fibre, horizon: float) -> bool:
    """Return whether an explicit reference of second order in time is stable with 512 steps up to the horizon.

    A motion of frequency w without friction grows by (1 + (w h)^4/4)^(1/2) per step, by a factor of less than e over
    all n steps if n (w h)^4 <= 8. The drag requires h Dr^{-2} <= 2.
    """
    h = horizon / REFERENCE_STEPS
    return REFERENCE_STEPS * (_stiffness(fibre) * h * h) ** 2 <= 8.0 and h <= 2.0 * fibre.Dr**2


def mild(fibre: Fibre, horizon: float) -> bool:
    """Return whether Euler's explicit method is stable with 256 steps, the finest level, up to the horizon.

    A motion of frequency w without friction grows by (1 + (w h)^2)^(1/2) per step, by a factor of less than e over
    all n steps if n (w h)^2 <= 2. The drag requires h Dr^{-2} <= 2.
    """
    h = horizon / FINEST_STEPS
    return FINEST_STEPS * _stiffness(fibre) * h * h <= 2.0 and h <= 2.0 * fibre.Dr**2


def _stiffness(fibre: Fibre) -> float:
    """Return an upper bound of w^2, the sum of the contributions of bending and of the tension by weight."""
    ds = fibre.chain.ds
    return 16.0 / (fibre.alpha * ds * ds) ** 2 + 4.0 / (fibre.Fr * ds) ** 2


def _controls(fibre: Fibre, horizon: float) -> tuple[Control, ...]:
    if not mild(fibre, horizon):
        return ()
    return controls.VANISHING if fibre.D is None else controls.GENERAL
