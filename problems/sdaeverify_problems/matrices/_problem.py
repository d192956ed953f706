"""The fields of Langevin dynamics near or on x^T x = Id."""

from functools import partial
from typing import Any

import numpy as np

from ._constraint import hessians, jacobian, zeta
from ._geometry import MatrixGeometry


def matrix_constraint(d: int, p: int) -> dict[str, Any]:
    """Return the constraint, its derivatives and its geometry for d x p matrices stored by rows, from (Id, 0)."""
    return {
        "constraint": partial(zeta, p),
        "jacobian": partial(jacobian, p),
        "hessians": hessians(d, p),
        "geometry": partial(MatrixGeometry.near, p),
        "start": np.eye(d, p).ravel(),
    }
