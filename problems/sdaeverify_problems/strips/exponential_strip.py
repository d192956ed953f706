"""A line with a constraint function that grows along it, which is sensitive to errors in the tangential terms."""

import numpy as np

from sdaeverify import Chart, ConstrainedLangevin, Line, hookimpl, in_matrix

from .. import _controls as controls
from .._arguments import check_least, check_not_negative, check_positive
from .._brief import PENALISED
from ._geometry import StripConstraint
from ._truths import Strip, observables


@in_matrix({"q": 2, "horizon": 0.125}, schemes=PENALISED, measures=("weak",))
def exponential_strip(
    eps: float = 0.25, q: int = 1, alpha: float = 1.0, kappa: float = 1.0, c: float = 0.5, horizon: float = 0.5
) -> ConstrainedLangevin:
    """Langevin dynamics of x = (t, n), n in R^q, zeta = e^{alpha t} n, f = (-kappa (t - c), -kappa n), sigma = 1.

    In the limit X is an Ornstein-Uhlenbeck process along the line n = 0, which does not depend on alpha. For eps > 0,
    grad ln det G and the stiff drift have components along the line: with D = 1 + alpha^2 |n|^2

        grad ln det G = (2 q alpha, 2 alpha^2 n/D),    g G^{-1} zeta = (alpha |n|^2, n)/D.

    Parameters
    ----------
    eps : float
        Stiffness parameter, unit time.
    q : int
        Number of constraints, at least 1.
    alpha : float
        Growth of the constraint, unit 1/length, positive.
    kappa : float
        Rate of the drift, unit 1/time, positive.
    c : float
        Value of t at which the drift vanishes.
    horizon : float
        Final time.

    Source
    ------
    Laurent (2022), (1.2) and (1.4), with a constraint in whose equations no term vanishes.
    """
    check_not_negative(eps=eps)
    check_positive(alpha=alpha, kappa=kappa)
    check_least(1, q=q)
    strip, constraint = Strip(eps, q, alpha, kappa, 1.0, c), StripConstraint(alpha)
    centre = np.array([c, *np.zeros(q)])[:, None]
    chart = strip_chart(strip) if q == 1 or eps == 0.0 else None
    return ConstrainedLangevin(
        eps=eps,
        family=lambda other: exponential_strip(other, q, alpha, kappa, c, horizon),
        drift=lambda x: kappa * (centre - x),
        strength=1.0,
        constraint=constraint.zeta,
        jacobian=constraint.jacobian,
        second=constraint.second,
        start=np.zeros(1 + q),
        horizon=horizon,
        controls=(controls.STATIONARY_PAIR if chart else controls.ADDITIVE) if eps else controls.GENERAL,
        observables=observables(limit=eps == 0.0),
        truths=strip.truths(),
        chart=chart,
        traits=frozenset() if eps else frozenset({"normal-milstein-term"}),
        relaxation_time=1.0 / kappa,
        units="length and time so that alpha and kappa are what they are and the noise has strength 1",
        source="Laurent 2022, (1.2) and (1.4), on a strip around a line",
    )


def strip_chart(strip: Strip) -> Chart:
    """Return the chart with coordinates t and arsinh(alpha n)/alpha, for q = 1, or t alone in the limit.

    The equation is singular at n = i/alpha; in this coordinate the singularity is further away from the real axis.
    """
    means = strip.invariant_means()
    along = Line(means["t"], strip.sigma / float(np.sqrt(2.0 * strip.kappa)))
    if strip.eps:
        across, alpha = Line(0.0, means["|n|^2"] ** 0.5), strip.alpha
        return Chart(
            axes=(along, across),
            embed=lambda z: np.stack([z[0], np.sinh(alpha * z[1]) / alpha]),
            read=lambda x: np.stack([x[0], np.arcsinh(alpha * x[1]) / alpha]),
        )
    return Chart(axes=(along,), embed=lambda z: np.eye(1 + strip.q)[:, :1] * z, read=lambda x: x[:1])


@hookimpl
def sdaeverify_problems() -> list[object]:
    """Register the problem."""
    return [exponential_strip]
