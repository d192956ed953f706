"""Known moments of the test problem of Qu, Huang & Liu (2010), (5.1)."""

import numpy as np
import scipy

from sdaeverify import Array, Moment

from .. import _known as known
from . import _linear_delay as linear
from ._coefficients import Coefficients
from ._renewal_equation import mean
from ._scalar_delay import ScalarDelay


def moments(at: Coefficients, horizon: float) -> tuple[Moment, ...]:
    """Return E x, E x^2 and E y: at all times if l = 0, otherwise up to the first delay."""
    if at.l == 0.0:
        equation = ScalarDelay(at.a + at.q, at.b, at.c, at.d, 0.0, 1.0, 1.0, 1.0)
        y = Moment(observable="y", value=lambda t: at.q * mean(equation, t), source=linear.MOMENTS)
        return (*others, y) if (others := linear.delay_moments(equation, horizon)) else ()
    return _first_interval(at) if horizon <= 1.0 else ()


def _first_interval(at: Coefficients) -> tuple[Moment, ...]:
    """Return the moments up to the first delay, where v(t) = t, by their linear differential equations.

    m' = A m + p, S' = (2 A + c^2) S + 2 (p + c d t) m + d^2 t^2, p = b t + l sin t.
    """
    values = {
        "x": lambda t: float(_solve_moments(at, t)[0]),
        "x^2": lambda t: float(_solve_moments(at, t)[1]),
        "y": lambda t: float(at.l * np.sin(t) + at.q * _solve_moments(at, t)[0]),
    }
    return known.moments(values, "linear equations of the first two moments, v being known")


def _solve_moments(at: Coefficients, t: float) -> Array:
    a, b, c, d, l, q = at
    A = a + q

    def rates(s: float, moment: Array) -> list[float]:
        p = b * s + l * np.sin(s)
        m, S = moment
        return [A * m + p, (2.0 * A + c * c) * S + 2.0 * (p + c * d * s) * m + d * d * s * s]

    if t == 0.0:
        return np.ones(2)
    return np.asarray(
        scipy.integrate.solve_ivp(rates, (0.0, t), [1.0, 1.0], "DOP853", rtol=1e-13, atol=1e-14).y[:, -1]
    )
