"""The torus with core radius R and tube radius r, as the zeros of two functions, and by two angles."""

from typing import NamedTuple

import numpy as np

from sdaeverify import Angle, Array, Chart

from ..spheres._unit_sphere import squared_norm

RADIUS, TUBE = 3.0, 1.0


class Quartic(NamedTuple):
    """zeta = (|x|^2 + R^2 - r^2)^2 - 4 R^2 rho^2 with rho^2 = x_1^2 + x_2^2, a polynomial of degree four.

    With a = |x|^2 + R^2 - r^2 and D = diag(1, 1, 0): g = 4 a x - 8 R^2 D x and H = 8 x x^T + 4 a Id - 8 R^2 D.

    Attributes
    ----------
    R, r : float
    """

    R: float = RADIUS
    r: float = TUBE

    def zeta(self, x: Array) -> Array:
        """Return zeta = (s^2 - r^2) ((rho + R)^2 + x_3^2 - r^2), shape (1, P), a form without cancellation."""
        rho, height = axial(x), x[2] ** 2
        inner, outer = ((rho + sign * self.R) ** 2 + height - self.r**2 for sign in (-1.0, 1.0))
        return np.asarray(inner * outer)[None]

    def diagonal(self, x: Array) -> Array:
        """Return the diagonal of 4 a Id - 8 R^2 D, shape (3, P)."""
        a = 4.0 * (squared_norm(x) + self.R**2 - self.r**2)
        across = a - 8.0 * self.R**2
        return np.stack([across, across, a])

    def jacobian(self, x: Array) -> Array:
        """Return g^T, shape (1, 3, P)."""
        return np.asarray(self.diagonal(x) * x)[None]

    def second(self, x: Array, A: Array) -> Array:
        """Return H A_1, shape (3, P)."""
        w = A[:, 0]
        return np.asarray(8.0 * x * (x * w).sum(axis=0) + self.diagonal(x) * w)

    def laplacians(self, x: Array) -> Array:
        """Return tr H = 8 |x|^2 + 12 a - 16 R^2, shape (1, P)."""
        return np.asarray(8.0 * squared_norm(x) + self.diagonal(x).sum(axis=0))[None]


class Tube(NamedTuple):
    """zeta = (s^2 - r^2)/2, s the distance from the core circle: g = x - R e_rho, G = s^2, grad ln G = 2 g/s^2.

    Attributes
    ----------
    R, r : float
    """

    R: float = RADIUS
    r: float = TUBE

    def zeta(self, x: Array) -> Array:
        """Return zeta, shape (1, P)."""
        return np.asarray(0.5 * ((axial(x) - self.R) ** 2 + x[2] ** 2 - self.r**2))[None]

    def jacobian(self, x: Array) -> Array:
        """Return g^T, shape (1, 3, P)."""
        return np.asarray(x - self.R * outward(x))[None]

    def second(self, x: Array, A: Array) -> Array:
        """Return H A_1 with H = Id - (R/rho) (D - e_rho e_rho^T), shape (3, P)."""
        w, e = A[:, 0], outward(x)
        level = np.stack([w[0], w[1], 0.0 * w[2]])
        return np.asarray(w - self.R / axial(x) * (level - e * (e * w).sum(axis=0)))

    def laplacians(self, x: Array) -> Array:
        """Return tr H = 3 - R/rho, shape (1, P)."""
        return np.asarray(3.0 - self.R / axial(x))[None]


def axial(x: Array) -> Array:
    """Return rho, the distance from the axis, shape (P,)."""
    return np.asarray(np.sqrt(x[0] ** 2 + x[1] ** 2))


def outward(x: Array) -> Array:
    """Return e_rho, the unit vector away from the axis, shape (3, P)."""
    rho = axial(x)
    return np.stack([x[0] / rho, x[1] / rho, 0.0 * rho])


def surface_chart() -> Chart:
    """Return the chart with the angle theta around the core circle, 0 outside, and phi around the axis."""

    def embed(z: Array) -> Array:
        rho = RADIUS + TUBE * np.cos(z[0])
        return np.stack([rho * np.cos(z[1]), rho * np.sin(z[1]), TUBE * np.sin(z[0])])

    def read(x: Array) -> Array:
        return np.stack([np.arctan2(x[2], axial(x) - RADIUS), np.arctan2(x[1], x[0])])

    return Chart(axes=(Angle(), Angle()), embed=embed, read=read)
