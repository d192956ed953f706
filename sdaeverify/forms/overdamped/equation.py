"""Penalised or constrained Langevin dynamics as an Ito equation, Laurent (2022), (1.4) and (1.2)."""

from typing import TYPE_CHECKING

import numpy as np

from ...arrays import Array
from ..sde.sde import SDE

if TYPE_CHECKING:
    from .constrained_langevin import ConstrainedLangevin


def langevin_equation(problem: "ConstrainedLangevin") -> SDE:
    """Return the Ito equation of penalised or constrained dynamics, (1.4) or (1.2)."""
    sigma, eps, d = problem.strength, problem.eps, problem.dimension

    def penalised(_: float, x: Array) -> Array:
        at = problem.near(x)
        return problem.drift(x) + 0.25 * sigma**2 * at.fixman - at.relaxation / eps

    def constrained(_: float, x: Array) -> Array:
        at, f = problem.near(x), problem.drift(x)
        tau = at.divergence - at.normal_traces
        return f - at.normal(f) - 0.5 * sigma**2 * at.J.transposed(at.gram.solve(tau))

    def projector(_: float, x: Array) -> Array:
        at = problem.near(x)
        return sigma * (np.eye(d)[..., None] - at.J.transposed(at.dual))

    def projected(_: float, x: Array, w: Array) -> Array:
        return sigma * (w - problem.near(x).normal(w))

    return SDE(
        drift=penalised if eps else constrained,
        diffusion=(lambda *_: sigma * np.eye(d)[..., None]) if eps else projector,
        diffusion_product=(lambda *given: sigma * given[-1]) if eps else projected,
        start=problem.start,
        constraint=None if eps else problem.constraint,
        **problem.carried,
        source=f"{'penalised' if eps else 'constrained'} dynamics of: {problem.source}",
        seen_as="penalised SDE" if eps else "constrained SDE",
    )
