"""Brownian motion on an ellipse by arc length, or motion that is reversible for the measure delta(g)."""

from collections.abc import Callable

import numpy as np

from sdaeverify import SDE, Angle, Array, Chart, InvariantMean, hookimpl

from .. import _controls as controls
from .._arguments import check_choice
from .._known import limits, monomials
from ._arc_length import arc_truth, circumference, speed
from ._circle import quarter_turn

# Slowest relaxation rate of the law of the eccentric angle.
RATE = 0.152863743


def ellipse(measure: str = "arc", theta_0: float = 0.5, horizon: float = 1.0) -> SDE:
    """Motion on g(x) = (x_1^2/4 + x_2^2 - 1)/2 = 0 along the unit tangent t = J grad g/|grad g|, W in R.

    arc:    dX = t o dW, uniform in arc length, exactly s = s_0 + W(t);
    delta:  dX = t o dW - (1/2) t <t, grad log|grad g|> dt, reversible for delta(g) dx = ds/|grad g|.

    The drift of the second equation is Fixman's. With X = (2 cos theta, sin theta), delta(g) is uniform in theta.

    Parameters
    ----------
    measure : str
        Invariant measure, ``arc`` or ``delta``.
    theta_0 : float
        Initial eccentric angle, radian.
    horizon : float
        Final time, in the unit in which the variance of the arc length grows by one; the minor semi-axis is 1.

    Source
    ------
    Ciccotti, Lelievre & Vanden-Eijnden (2008), Projection of diffusions on submanifolds.
    """
    check_choice("measure", measure, ("arc", "delta"))
    fixman = 1.0 if measure == "delta" else 0.0

    def drift(t: float, x: Array) -> Array:
        """Return (1/2) Dt t - (fixman/2) t <n, H t>/|grad g|, n = grad g/|grad g|, H = D^2 g."""
        n, length = normal(x)
        t_ = quarter_turn(n)
        Ht = np.stack([0.25 * t_[0], t_[1]])
        return 0.5 * (quarter_turn(Ht) - (1.0 + fixman) * t_ * (n * Ht).sum(axis=0)) / length

    return SDE(
        controls=controls.SCALAR,
        drift=drift,
        diffusion=lambda t, x: quarter_turn(normal(x)[0])[:, None],
        start=[2.0 * np.cos(theta_0), np.sin(theta_0)],
        constraint=lambda x: 0.5 * (0.25 * x[0] * x[0] + x[1] * x[1] - 1.0)[None],
        jacobian=lambda x: np.stack([0.25 * x[0], x[1]])[None],
        noise_dim=1,
        horizon=horizon,
        traits=frozenset({"normal-milstein-term"}),
        noise=frozenset({"dW"} if measure == "arc" else {"dW", "H"}),
        observables=OBSERVABLES,
        truths=(arc_truth(theta_0, fixman), *means(lambda theta: speed(theta) ** (1.0 - fixman))),
        chart=Chart(axes=(Angle(),), embed=embed, read=lambda x: np.arctan2(x[1], 0.5 * x[0])[None]),
        # By arc length the relaxation time is that of a circle.
        relaxation_time=1.0 / RATE if fixman else 2.0 * (circumference() / (2 * np.pi)) ** 2,
        units="small half axis 1, time so that the noise has unit strength",
        source="Ciccotti, Lelievre & Vanden-Eijnden 2008, on x^2/4 + y^2 = 1",
    )


OBSERVABLES = {
    **monomials("x_1", "x_2"),
    "cos 2 theta": lambda t, s: 0.25 * s["x"][0] ** 2 - s["x"][1] ** 2,
    "sin 2 theta": lambda t, s: s["x"][0] * s["x"][1],
    **monomials("x_1^4"),
}


def normal(x: Array) -> tuple[Array, Array]:
    """Return the unit normal grad g/|grad g|, shape (2, P), and |grad g|, shape (P,)."""
    gradient = np.stack([0.25 * x[0], x[1]])
    length = np.sqrt((gradient * gradient).sum(axis=0))
    return gradient / length, length


def embed(z: Array) -> Array:
    """Return the point of eccentric angle z, shape (1, P) -> (2, P)."""
    return np.concatenate([2.0 * np.cos(z), np.sin(z)])


def means(density: Callable[[Array], Array]) -> tuple[InvariantMean, ...]:
    """Return the means of all observables under a density of theta, by the trapezoidal rule, exact to rounding."""
    theta = 2 * np.pi * np.arange(256) / 256
    w, x = density(theta) / density(theta).sum(), {"x": embed(theta[None])}
    return limits({name: float(w @ q(0.0, x)) for name, q in OBSERVABLES.items()}, "quadrature")


@hookimpl
def sdaeverify_problems() -> list[object]:
    """Register the problem."""
    return [ellipse]
