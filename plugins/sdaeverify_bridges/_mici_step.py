"""One step of mici's constrained integrator, path by path."""

from collections.abc import Callable

import numpy as np
from mici.errors import Error
from mici.integrators import ConstrainedLeapfrogIntegrator
from mici.states import ChainState
from mici.systems import DenseConstrainedEuclideanMetricSystem

from sdaeverify import Array, HolonomicSDAE, Mask


def half_step(problem: HolonomicSDAE, h: float, inner: int) -> Callable[[Array, Array], tuple[Array, Array, Mask]]:
    """Return the flow of a problem over h without friction and noise: (r, v) -> r, v and a success flag.

    v is projected onto the tangent space first.
    """
    n = problem.dimension
    M = np.eye(n) if problem.mass is None else np.asarray(problem.mass, dtype=float)

    def force(r: Array) -> Array:
        column = r[:, None]
        return np.array(np.broadcast_to(problem.force(0.0, column, 0.0 * column), (n, 1))[:, 0])

    def jacobian(r: Array) -> Array:
        return np.array(np.broadcast_to(problem.dg(r[:, None]), (problem.constraints, n, 1))[..., 0])

    system = DenseConstrainedEuclideanMetricSystem(
        neg_log_dens=lambda r: 0.0,  # not used: the flow only needs the gradient
        grad_neg_log_dens=lambda r: -force(r),
        constr=lambda r: problem.constraint(r[:, None])[:, 0],
        jacob_constr=jacobian,
        metric=None if problem.mass is None else M,
    )
    integrator = ConstrainedLeapfrogIntegrator(system, step_size=h, n_inner_step=inner)

    def one(r: Array, p: Array) -> tuple[Array, Array, bool]:
        state = ChainState(pos=r.copy(), mom=p.copy(), dir=1)
        state.mom = system.project_onto_cotangent_space(state.mom, state)
        try:
            state = integrator.step(state)
        except Error:
            return r, p, False
        return state.pos, state.mom, True

    def moved(r: Array, v: Array) -> tuple[Array, Array, Mask]:
        ends = [one(*pair) for pair in zip(r.T, (M @ v).T, strict=True)]
        r, p, found = (np.stack(part, axis=-1) for part in zip(*ends, strict=True))
        return r, problem.inverse_mass(p), found

    return moved
