"""Constants of dissipative index-1 delay equations, and the step sizes for which they ensure mean-square stability.

For dx = f(x, v, y) dt + g(x, v, y) dW, 0 = u(x, v, y), v = x(t - tau), with a zero solution and all arguments,

    x^T f(x, 0, 0) <= -abar |x|^2,   |f - f'| <= al0 |x - x'| + al1 |v - v'| + al2 |y - y'|,
    |g|^2 <= be0 |x|^2 + be1 |v|^2 + be2 |y|^2,   |u_y^-1| <= L1,   |u_x| <= L2,   |u_v| <= L3,

(Qu, Huang, Liu 2010, (2.2) and (4.1)). With y = U(x, v), |U| <= L1 L2 |x| + L1 L3 |v|, they give

    2 x^T f + |g|^2 <= -lam0 |x|^2 + lam1 |v|^2,   C = lam0 - lam1,

and C > 0 is sufficient for E |x|^2 -> 0, not necessary (Theorem 4.1).
"""

from typing import NamedTuple

import numpy as np


class Dissipation(NamedTuple):
    """The constants of (4.1); all except abar are nonnegative.

    Attributes
    ----------
    abar, al0, al1, al2 : float
        Of the drift, per unit of time.
    be0, be1, be2 : float
        Of the squared diffusion, per unit of time.
    L1, L2, L3 : float
        Of the constraint.
    """

    abar: float
    al0: float
    al1: float
    al2: float
    be0: float
    be1: float
    be2: float
    L1: float
    L2: float
    L3: float

    @property
    def lam0(self) -> float:
        """lam0 = 2 abar - al1 - be0 - 2 al2 L1 L2 - al2 L1 L3 - 2 be2 L1^2 L2^2."""
        by_y = self.al2 * self.L1 * (2.0 * self.L2 + self.L3) + 2.0 * self.be2 * (self.L1 * self.L2) ** 2
        return 2.0 * self.abar - self.al1 - self.be0 - by_y

    @property
    def lam1(self) -> float:
        """lam1 = al1 + be1 + al2 L1 L3 + 2 be2 L1^2 L3^2."""
        return self.al1 + self.be1 + self.al2 * self.L1 * self.L3 + 2.0 * self.be2 * (self.L1 * self.L3) ** 2

    @property
    def C(self) -> float:
        """C = lam0 - lam1, a lower bound of the rate at which E |x|^2 would decay without delay."""
        return self.lam0 - self.lam1

    @property
    def K1(self) -> float:
        """K1 = al0 + al2 L1 L2, of |f| <= K1 |x| + K2 |v|."""
        return self.al0 + self.al2 * self.L1 * self.L2

    @property
    def K2(self) -> float:
        """K2 = al1 + al2 L1 L3."""
        return self.al1 + self.al2 * self.L1 * self.L3

    @property
    def without_y(self) -> "Dissipation":
        """Constants of the equation with y eliminated that these imply, with the same C, K1 and K2.

        An equation whose drift and constraint partly cancel has better constants.
        """
        by_x, by_v = self.L1 * self.L2, self.L1 * self.L3
        return Dissipation(
            abar=self.abar - self.al2 * by_x,
            al0=self.K1,
            al1=self.K2,
            al2=0.0,
            be0=self.be0 + 2.0 * self.be2 * by_x**2,
            be1=self.be1 + 2.0 * self.be2 * by_v**2,
            be2=0.0,
            L1=0.0,
            L2=0.0,
            L3=0.0,
        )

    def largest_step(self, theta: float) -> float:
        """Return h_0 = C/(2 (1 - theta)^2 (K1^2 + K2^2)), below which the theta method is stable by Theorem 4.2.

        The printed second branch, for B <= 0, needs B^2 >= 4 A and can never apply: x^T f <= -abar |x|^2 forces
        abar <= al0, hence B^2 <= 4 (1 - theta)^2 abar^2 <= 2 A.

        Parameters
        ----------
        theta : float
            In [0, 1].

        Returns
        -------
        float
            Infinite for theta = 1, 0 unless C > 0.
        """
        return self._quotient(2.0 * (1.0 - theta) ** 2 * (self.K1**2 + self.K2**2))

    def sharp_step(self, theta: float) -> float:
        """Return C/((1 - 2 theta) (K1 + K2)^2), which is never below h_0 and follows from the same constants.

        With X_n = x_n - theta h f_n, on any mesh,

            E |X_{n+1}|^2 - E |X_n|^2 = h E(2 x_n^T f_n + |g_n|^2) + (1 - 2 theta) h^2 E |f_n|^2 .

        It is sharp for dx = a x dt + c x dW with a < 0.

        Parameters
        ----------
        theta : float
            In [0, 1].

        Returns
        -------
        float
            Infinite for theta >= 1/2, 0 unless C > 0.
        """
        return self._quotient(max(0.0, 1.0 - 2.0 * theta) * (self.K1 + self.K2) ** 2)

    def _quotient(self, cost: float) -> float:
        if self.C <= 0.0:
            return 0.0
        return self.C / cost if cost > 0.0 else np.inf
