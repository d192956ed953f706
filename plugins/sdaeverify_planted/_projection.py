"""Projection along given directions, of schemes that take wrong ones."""

import numpy as np

from sdaeverify import SDE, Array, DenseJacobian, Step
from sdaeverify_schemes.projections._old_normals import onto_constraint


def project_step(problem: SDE, x: Array, y: Array, normals: Array) -> Step:
    """Return the step from x to the point of the constraint near y along directions of shape (1, d, P)."""
    new = onto_constraint(problem, y, DenseJacobian(normals))
    return Step(np.where(new.found, new.r, x), ~new.found)
