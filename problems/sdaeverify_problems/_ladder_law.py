"""The normal law of the node voltages of a resistor-capacitor ladder with thermal noise.

    C dx = (j - G x) dt + N dW,    N N^T = 2 kT G,    j = G (U, U),

so that the invariant law of x has mean (U, U) and covariance kT C^{-1}, by the fluctuation-dissipation relation.
"""

from typing import NamedTuple

import numpy as np
import scipy

from sdaeverify import Array, Chart, Line, Truth

from ._known import monomial, normal_means, normal_truths

SOURCE = "variation of constants, and the fluctuation-dissipation relation"


PRODUCTS = {"e_1": (0,), "e_2": (1,), "e_1^2": (0, 0), "e_1 e_2": (0, 1), "e_2^2": (1, 1)}
OBSERVABLES = {name: monomial(name.replace("e", "x")) for name in PRODUCTS}


class Ladder(NamedTuple):
    """Parameters of the ladder: two capacitances, a 2 x 2 conductance matrix, the source voltage U and kT.

    Attributes
    ----------
    C, G : ndarray
    U, kT : float
    """

    C: Array
    G: Array
    U: float
    kT: float

    @property
    def rates(self) -> Array:
        """-C^{-1} G."""
        return np.asarray(-self.G / self.C[:, None])

    @property
    def limit(self) -> tuple[Array, Array]:
        """Mean and covariance of the invariant law."""
        return np.full(2, self.U), np.diag(self.kT / self.C)

    @property
    def relaxation(self) -> float:
        """Time in which the mean's deviation from U decays by a factor e."""
        return float(-1.0 / np.linalg.eigvals(self.rates).real.max())

    @property
    def chart(self) -> Chart | None:
        """The voltages as coordinates; None without thermal noise."""
        if not self.kT:
            return None
        axes = tuple(Line(self.U, float(np.sqrt(self.kT / C))) for C in self.C)
        return Chart(axes=axes, embed=lambda z: z, read=lambda x: x)

    def law(self, t: float) -> tuple[Array, Array]:
        """Return mean and covariance at time t, if all voltages are 0 at time 0."""
        change, (m, P) = scipy.linalg.expm(self.rates * t), self.limit
        return m - change @ m, P - change @ P @ change.T


def truths(ladder: Ladder) -> tuple[Truth, ...]:
    """Return the expectations of all observables at every time and under the invariant law."""
    return normal_truths(normal_means(PRODUCTS), ladder.law, ladder.limit, SOURCE)
