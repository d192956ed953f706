"""The square root process of Cox, Ingersoll and Ross, whose solution is nonnegative."""

import numpy as np

from sdaeverify import SDE, Domain, InvariantMean, Moment, hookimpl, on_request

from ._arguments import check_not_negative, check_positive
from ._known import moments, monomials

SOURCE = "Cox, Ingersoll & Ross 1985, (17) to (20)"


@on_request
def cir(kappa: float = 1.0, theta: float = 1.0, sigma: float = 0.5, x_0: float = 1.0, horizon: float = 1.0) -> SDE:
    """Square root process: dx = kappa (theta - x) dt + sigma sqrt(x) dW, in x >= 0.

    The solution reaches 0 if and only if sigma^2 > 2 kappa theta, that is if Feller's condition is violated. Then the
    diffusion is not Lipschitz at states that solutions reach, and orders of schemes are lower than for smooth
    coefficients. Mean and variance are

        E x = theta + (x_0 - theta) q,  Var x = sigma^2 (1 - q) [x_0 q + theta (1 - q)/2]/kappa,  q = e^{-kappa t},

    and the invariant law is a gamma law with the mean theta and the variance theta sigma^2/(2 kappa).

    Parameters
    ----------
    kappa : float
        Rate of mean reversion, unit 1/time, positive.
    theta : float
        Mean under the invariant law, positive.
    sigma : float
        Volatility, unit 1/sqrt(time), not negative.
    x_0 : float
        Initial value, not negative.
    horizon : float
        Final time.

    Source
    ------
    Cox, Ingersoll & Ross (1985), A theory of the term structure of interest rates, Econometrica 53, 385.
    """
    check_positive(kappa=kappa, theta=theta)
    check_not_negative(sigma=sigma, x_0=x_0)
    spread = 0.5 * theta * sigma**2 / kappa
    return SDE(
        drift=lambda t, x: kappa * (theta - x),
        diffusion=lambda t, x: sigma * np.sqrt(np.maximum(x, 0.0))[:, None],
        diffusion_derivative=lambda t, x, y: 0.5 * sigma * (y / np.sqrt(np.maximum(x, 0.0)))[:, None],
        start=[x_0],
        noise_dim=1,
        horizon=horizon,
        domain=Domain.orthant(),
        traits=frozenset({"diagonal-noise"}),
        observables=monomials("x", "x^2"),
        truths=(
            *known_moments(kappa, theta, sigma, x_0),
            InvariantMean(observable="x", value=theta, source=SOURCE),
            InvariantMean(observable="x^2", value=theta**2 + spread, source=SOURCE),
        ),
        relaxation_time=1.0 / kappa,
        units="x dimensionless, time in the unit of 1/kappa",
        source=SOURCE,
    )


def known_moments(kappa: float, theta: float, sigma: float, x_0: float) -> tuple[Moment, ...]:
    """Return E x and E x^2 as functions of time.

    Parameters
    ----------
    kappa, theta, sigma, x_0 : float
        Parameters of the problem.
    """

    def mean(t: float) -> float:
        return float(theta + (x_0 - theta) * np.exp(-kappa * t))

    def square(t: float) -> float:
        q = np.exp(-kappa * t)
        variance = sigma**2 / kappa * (1.0 - q) * (x_0 * q + 0.5 * theta * (1.0 - q))
        return float(mean(t) ** 2 + variance)

    return moments({"x": mean, "x^2": square}, SOURCE)


@hookimpl
def sdaeverify_problems() -> list[object]:
    """Register the problem."""
    return [cir]
