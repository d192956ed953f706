"""The angle of a pendulum with friction and noise.

dtheta = omega dt,   domega = (-c sin theta - gamma omega) dt + sigma dbeta.
"""

from typing import NamedTuple

import numpy as np
import scipy

from sdaeverify import Array, Increment, ParameterError

from ..curves._circle import normal, tangent


class Rotor(NamedTuple):
    """Constants of the equation.

    Attributes
    ----------
    c : float
        Gravity, unit 1/time^2.
    gamma : float
        Friction, unit 1/time.
    sigma : float
        Noise amplitude, unit 1/time^(3/2).
    """

    c: float
    gamma: float
    sigma: float

    @property
    def kT(self) -> float:
        """Temperature sigma^2/(2 gamma), the invariant variance of omega."""
        return self.sigma**2 / (2.0 * self.gamma)

    @property
    def relaxation(self) -> float:
        """Estimated relaxation time 2/gamma + gamma/max(|c|, kT).

        The first term estimates the linear motion at small friction, the second one the slow motion at large
        friction.
        """
        return 2.0 / self.gamma + self.gamma / max(abs(self.c), self.kT)

    def cosines(self) -> tuple[float, float]:
        """Return the invariant means of cos theta, I_1/I_0 (k), and of cos^2 theta, (1 + I_2/I_0 (k))/2, k = c/kT.

        The invariant law is von Mises', of density ~ exp(k cos theta), and omega is independent of it.
        """
        k = self.c / self.kT
        scaled = scipy.special.ive([0, 1, 2], k)
        return float(scaled[1] / scaled[0]), float(0.5 * (1.0 + scaled[2] / scaled[0]))

    def taylor(self, z: Array, h: float, dbeta: Array, integral: Array) -> Array:
        """Return (theta, omega), shape (2, P), after one Ito-Taylor step of strong order 3/2.

        Parameters
        ----------
        z : ndarray, shape (2, P)
        h : float
        dbeta, integral : ndarray, shape (P,)
            Increment and time integral of the Brownian motion beta.
        """
        theta, omega = z
        a = -self.c * np.sin(theta) - self.gamma * omega
        rate = -self.c * np.cos(theta) * omega - self.gamma * a
        turned = theta + omega * h + 0.5 * a * h**2 + self.sigma * integral
        return np.stack([turned, omega + a * h + self.sigma * (dbeta - self.gamma * integral) + 0.5 * h**2 * rate])

    def on_the_circle(self, z: Array, h: float, noise: Increment) -> Array:
        """Return (theta, omega, mu), shape (3, P), after such a step with dbeta = <t, dw>, dmu = ... + sigma <r, dw>.

        With I = int (w - w_n) ds and J = h dw - I, the rotation of the frame adds -sigma omega <r, J> to omega, and

            mu+ = mu + m h + sigma <r, dw> + sigma omega <t, J> + 2 sigma omega <t, I>
                     + (h^2/2) (sigma^2 + 2 omega a - c omega sin theta),     m = c cos theta + omega^2.
        """
        (theta, omega, mu), sigma = z, self.sigma
        r, t = normal(theta), tangent(theta)
        I = noise.time_integral(h)
        J = h * noise.dW - I
        tI, rJ, tJ = (t * I).sum(axis=0), (r * J).sum(axis=0), (t * J).sum(axis=0)
        angles = self.taylor(z[:2], h, (t * noise.dW).sum(axis=0), tI) - np.stack([0.0 * rJ, sigma * omega * rJ])
        a = -self.c * np.sin(theta) - self.gamma * omega
        curved = sigma**2 + 2.0 * omega * a - self.c * omega * np.sin(theta)
        mean = (self.c * np.cos(theta) + omega**2) * h + 0.5 * h**2 * curved
        kick = sigma * ((r * noise.dW).sum(axis=0) + omega * (tJ + 2.0 * tI))
        return np.concatenate([angles, (mu + mean + kick)[None]])


def damped_rotor(c: float, gamma: float, sigma: float) -> Rotor:
    """Return a rotor that has an invariant law.

    Raises
    ------
    ParameterError
        If friction or noise is not positive.
    """
    if not (gamma > 0.0 and sigma > 0.0):
        raise ParameterError("friction and noise must be positive: there is no invariant law otherwise")
    return Rotor(c, gamma, sigma)
