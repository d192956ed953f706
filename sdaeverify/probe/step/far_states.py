"""States as far out as a one-step map may be asked about: velocities up to 1e8."""

import numpy as np

from ...arrays import Array
from ...forms import Equation, Problem
from ...numerics import norm
from .states import SCATTERED, allowed, cloud

SIZES = 10.0 ** np.arange(0.0, 8.5, 0.5)


def extreme_states(view: Problem, ito: Equation) -> Array:
    """Return the cloud of states, and its scattered points blown up to the sizes 1, 10^(1/2), ..., 10^8.

    Of constrained mechanics the velocities are blown up, which stay tangent; of an equation without constraints, the
    whole state. An equation with another constraint has its cloud alone. States at which drift or diffusion are not
    finite are left out.

    Parameters
    ----------
    view : Problem
        With its constraints, if it has some.
    ito : Equation
        The Ito equation of its comparable components.

    Returns
    -------
    ndarray, shape (d, S)
    """
    x = cloud(view, ito)
    rows = view.free_rows
    base = x[:, -SCATTERED:]
    with np.errstate(all="ignore"):
        length = norm(base[rows])
        far = np.repeat(base, len(SIZES), axis=1)
        far[rows] *= (SIZES / np.where(length > 0.0, length, 1.0)[:, None]).ravel()
        states = np.concatenate([x, far], axis=1) if len(base[rows]) else x
        return np.asarray(states[:, allowed(view, ito, states)])
