"""Invariant laws of f = -stiffness (x - (R - r, 0, 0)), sigma^2 = 2, on the torus and around it.

In coordinates around the axis and the core circle, x = (rho cos phi, rho sin phi, s sin theta) with
rho = R + s cos theta, exp(-V) is integrated over phi in closed form. The remaining integrand is smooth, narrow, and
periodic in theta.
"""

import numpy as np
import scipy

from sdaeverify import Array, ParameterError

from ._geometry import RADIUS, TUBE

CENTRE = RADIUS - TUBE
# On the axis and beyond, the density is less than e^{-2 stiffness}, which is negligible even for SMALLEST. The
# trapezoidal rule in theta has the error e^{-NODES^2/(2 stiffness)}.
SMALLEST, LARGEST, NODES = 16.0, 2500.0, 512
# Trapezoidal rule in log s for a width w: its error is e^{-2 pi^2 FINE^2}. The integrand is negligible beyond
# REACH w, or where a power has decreased by e^{-FALLEN}.
FINE, REACH, FALLEN = 3.0, 9.0, 36.0


def check_drift(stiffness: float) -> None:
    """Check that the stiffness of the drift is in the range of the quadratures.

    Raises
    ------
    ParameterError
        If the quadratures would not be exact.
    """
    if not SMALLEST <= stiffness <= LARGEST:
        raise ParameterError(f"stiffness must be between {SMALLEST:g} and {LARGEST:g}, got {stiffness!r}")


def surface_means(stiffness: float) -> dict[str, float]:
    """Return the means under exp(-V) dsigma_M on the surface, dsigma_M = r rho dtheta dphi."""
    return _means(stiffness, np.zeros(1), np.zeros(1))


def tube_means(stiffness: float, eps: float) -> dict[str, float]:
    """Return the means under exp(-V) s^{1 + r^2/(2 eps)} exp(-s^2/(4 eps)) dx, dx = rho s ds dtheta dphi."""
    width = 1.0 / np.sqrt(stiffness + 1.0 / eps)
    lowest = REACH * width + FALLEN / (3.0 + 0.5 * TUBE**2 / eps)
    u = np.arange(-lowest, min(REACH * width, np.log(RADIUS / TUBE)), width / FINE)
    # The logarithm of s^{r^2/(2 eps)} exp(-s^2/(4 eps)) up to a constant, s = r e^u.
    kept = 0.5 * TUBE**2 / eps * (u - 0.5 * np.expm1(2.0 * u))
    return _means(stiffness, u, kept + 3.0 * u)


def _means(stiffness: float, u: Array, log: Array) -> dict[str, float]:
    s, theta = TUBE * np.exp(u), 2.0 * np.pi * np.arange(NODES) / NODES
    rho, height = RADIUS + np.outer(s, np.cos(theta)), np.outer(s, np.sin(theta))
    z = stiffness * CENTRE * rho
    log = log[:, None] - 0.5 * stiffness * ((rho - CENTRE) ** 2 + height**2)
    weights = np.exp(log - log.max()) * np.maximum(rho, 0.0) * scipy.special.i0e(z)
    square, defect = rho**2 + height**2, 0.5 * TUBE**2 * np.expm1(2.0 * u)[:, None]
    values = {
        "|x|^2": square,
        "|x|^4": square**2,
        "x_1": rho * scipy.special.i1e(z) / scipy.special.i0e(z),
        "zeta": defect,
        "zeta^2": defect**2,
    }
    return {name: float((weights * value).sum() / weights.sum()) for name, value in values.items()}
