"""A point that moves freely on the unit circle: how far it leaves the circle. Needs mici alone."""

from importlib.metadata import version

import mici
import numpy as np


def largest_residual(steps, **tolerances):
    system = mici.systems.DenseConstrainedEuclideanMetricSystem(
        neg_log_dens=lambda q: 0.0,
        grad_neg_log_dens=lambda q: 0.0 * q,
        constr=lambda q: np.array([q @ q - 1.0]),
        jacob_constr=lambda q: 2.0 * q[None],
    )
    integrator = mici.integrators.ConstrainedLeapfrogIntegrator(
        system, step_size=1.0 / steps, projection_solver_kwargs=tolerances
    )
    state = mici.states.ChainState(pos=np.array([1.0, 0.0]), mom=np.array([0.0, 1.0]), dir=1)
    found = []
    for _ in range(steps):
        state = integrator.step(state)
        found.append(abs(float(state.pos @ state.pos) - 1.0))
    return max(found)


print("largest | |q|^2 - 1 | up to time 1, mici", version("mici"))
for steps in (8, 16, 32):
    usual, sharp = largest_residual(steps), largest_residual(steps, constraint_tol=1e-14, position_tol=1e-14)
    print(f"{steps:2} steps: {usual:.1e} by default, {sharp:.1e} with constraint_tol=position_tol=1e-14")
