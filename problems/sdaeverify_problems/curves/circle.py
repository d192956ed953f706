"""Brownian motion on the unit circle."""

import numpy as np

from sdaeverify import SDE, Angle, Array, Chart, Increment, hookimpl

from .. import _controls as controls
from .._known import limits, moments, monomials, solution
from ._circle import constraint, direction, jacobian, quarter_turn

SOURCE = "rotation by the angle W(t), Ito's formula"


def circle(theta_0: float = 0.5, horizon: float = 1.0) -> SDE:
    """Brownian motion on S^1: dX = J X o dW = -(1/2) X dt + J X dW, J = [[0, -1], [1, 0]], |X| = 1.

    X = (cos theta, sin theta) with theta = theta_0 + W(t), which is exact on any grid.

    Parameters
    ----------
    theta_0 : float
        Initial angle, radian.
    horizon : float
        Final time, in the unit in which the angle's variance grows by one.

    Source
    ------
    Oksendal (2003), Stochastic Differential Equations, chapter 5: Brownian motion on the unit circle.
    """

    def advance(z: Array, t: float, h: float, noise: Increment) -> Array:
        return z + noise.dW

    # E e^{i n theta} decays at the rate n^2/2.
    values = {
        "x_1": lambda t: np.exp(-t / 2) * np.cos(theta_0),
        "x_2": lambda t: np.exp(-t / 2) * np.sin(theta_0),
        "x_1^2": lambda t: 0.5 + 0.5 * np.exp(-2 * t) * np.cos(2 * theta_0),
        "x_1 x_2": lambda t: 0.5 * np.exp(-2 * t) * np.sin(2 * theta_0),
    }
    return SDE(
        controls=controls.SCALAR,
        drift=lambda t, x: -0.5 * x,
        diffusion=lambda t, x: quarter_turn(x)[:, None],
        diffusion_derivative=lambda t, x, y: quarter_turn(y)[:, None],
        start=[np.cos(theta_0), np.sin(theta_0)],
        constraint=constraint,
        jacobian=jacobian,
        noise_dim=1,
        horizon=horizon,
        traits=frozenset({"normal-milstein-term"}),
        noise=frozenset({"dW"}),
        observables=monomials(*values),
        truths=(
            solution(theta_0, advance, SOURCE, parts=lambda t, z: {"x": direction(z)}),
            *moments(values, SOURCE),
            *limits({"x_1": 0.0, "x_2": 0.0, "x_1^2": 0.5, "x_1 x_2": 0.0}, "uniform law"),
        ),
        chart=Chart(axes=(Angle(),), embed=direction, read=lambda x: np.arctan2(x[1], x[0])[None]),
        relaxation_time=2.0,
        units="radius 1, time so that the noise has unit strength",
        source="Oksendal 2003, chapter 5",
    )


@hookimpl
def sdaeverify_problems() -> list[object]:
    """Register the problem."""
    return [circle]
