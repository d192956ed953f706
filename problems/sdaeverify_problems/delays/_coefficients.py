"""Coefficients of the test problem of Qu, Huang & Liu (2010), (5.1), with the paper's six sets."""

from typing import NamedTuple

from sdaeverify import Dissipation


class Coefficients(NamedTuple):
    """Coefficients a, b, c, d, l and q, in units of 1/time or 1/sqrt(time)."""

    a: float
    b: float
    c: float
    d: float
    l: float
    q: float

    @property
    def dissipation(self) -> Dissipation:
        """Constants of (4.1) with L_1 = 1."""
        a, b, c, d, l, q = self
        mixed = abs(c * d)
        return Dissipation(
            abar=-a,
            al0=abs(a),
            al1=abs(b),
            al2=1.0,
            be0=c * c + mixed,
            be1=d * d + mixed,
            be2=0.0,
            L1=1.0,
            L2=abs(q),
            L3=abs(l),
        )

    @property
    def dissipation_without_y(self) -> Dissipation:
        """Constants of dx = ((a + q) x + b v + l sin v) dt + (c x + d v) dW."""
        a, b, c, d, l, q = self
        return Coefficients(a + q, abs(b) + abs(l), c, d, 0.0, 0.0).dissipation.without_y


SETS = {
    "I": Coefficients(-1.0, 0.0, 1.0, 0.0, 0.0, 0.0),
    "II": Coefficients(-1.0, 1.0, 1.0, 1.0, 0.0, 0.0),
    "III": Coefficients(-1.0, 1.0, 1.0, 1.0, 0.1, -10.0),
    "IV": Coefficients(-8.0, 2.0, 0.0, 1.0, 1.0, 1.0),
    "V": Coefficients(-4.0, 1.0, 0.0, 3.0, 1.0, 2.0),
    "VI": Coefficients(-4.0, 1.0, 0.0, 1.0, 0.2, 1.0),
}
