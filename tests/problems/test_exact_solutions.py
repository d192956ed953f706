"""The exact solutions of geometric Brownian motion and of the Ornstein-Uhlenbeck process."""

from decimal import Decimal, localcontext

import numpy as np
import pytest

from facade import exponential_integral

EPS = np.finfo(float).eps


def rounding(z: float) -> float:
    """Return what summing 16 values of the kernel e^{-zq} rounds: a few eps each of the largest one.

    The factor 12 |q - 1/2| <= 6 of beta is the largest that multiplies them.
    """
    return 16 * 8 * EPS * max(1.0, float(np.exp(-z)))


def closed_forms(z: float) -> tuple[float, ...]:
    """Return Var Y / h, Cov(Y, dW) / h, Cov(Y, H) / h and the share of Var Y / h that neither explains, to 16 digits.

    For Y = int e^{-a(h-s)} dW(s) and z = a h, Var Y = (1 - e^{-2ah}) / (2a); Cov(Y, dW) = (1 - e^{-ah}) / a; and, H
    having the kernel q - 1/2 with q = (h-s)/h, Cov(Y, H) = h { [1 - (1 + z) e^{-z}] / z^2 - (1 - e^{-z}) / (2z) }.
    """
    with localcontext() as context:
        context.prec = 80
        x = Decimal(z)
        once, twice = (-x).exp(), (-2 * x).exp()
        variance, with_dW = (1 - twice) / (2 * x), (1 - once) / x
        with_H = (1 - (1 + x) * once) / x**2 - (1 - once) / (2 * x)
        return tuple(map(float, (variance, with_dW, with_H, variance - with_dW**2 - 12 * with_H**2)))


@pytest.mark.parametrize("z", [1e-12, -1e-8, 1e-3, -0.3, 0.05, 0.5, 1.0, -2.0, 4.0, -4.0])
def test_the_exponential_integral_has_its_covariances(z: float) -> None:
    """Variance and covariances with dW and H of alpha dW + beta H + rho sqrt(h) xi are the closed forms.

    The remainder's deviation rho, about z^2 / 27, is right to rounding of the kernel and not of its square root.
    """
    alpha, beta, rho = exponential_integral(z)
    variance, with_dW, with_H, left = closed_forms(z)
    error = rounding(z)

    assert abs(alpha - with_dW) <= error
    assert abs(beta / 12 - with_H) <= error / 12
    assert abs(alpha**2 + beta**2 / 12 + rho**2 - variance) <= 4 * error * max(1.0, with_dW)
    assert abs(rho - np.sqrt(left)) <= error
