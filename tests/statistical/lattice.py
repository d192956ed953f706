"""Increments with few values put x on a lattice: the law of 1(x > 1) tends to its limit with order 1/2."""

from dataclasses import replace
from typing import ClassVar

import numpy as np
import scipy

from facade import PlatenWeak2, gbm
from sdaeverify import SDE, TWO_POINT, Array, Claim, Increment, Law, Moment, Step

ABOVE = "x > 1"
OF_PLATEN = Claim(measure="weak", value=2.0, quantities=(ABOVE,), source="wrong: of smooth functions alone")
OF_EULER = Claim(measure="weak", value=1.0, quantities=(ABOVE,), source="wrong: of smooth functions alone")


def above(base: SDE, mean: float, deviation: float, bound: float) -> SDE:
    """Return a problem whose one observable is 1(x > 1), with its expectation at the end and nowhere else known.

    Parameters
    ----------
    base : SDE
        In one dimension.
    mean, deviation : float
        Of the normal variable that x is a function of.
    bound : float
        What this variable exceeds where x > 1.
    """
    source = "the normal law"

    def value(t: float) -> float:
        # Where t = 0 all is known: the start is a point.
        return float(scipy.special.ndtr((mean * t - bound) / (deviation * np.sqrt(t)))) if t else 0.0

    return replace(
        base,
        observables={ABOVE: lambda t, s: (s["x"][0] > 1.0).astype(float)},
        truths=(Moment(observable=ABOVE, value=value, source=source),),
        controls=(),
        chart=None,
        relaxation=np.inf,
        source=source,
    )


def gbm_above(a: float = 0.5, b: float = 0.6) -> SDE:
    """Geometric growth from .9, seen through a jump: P(x > 1).

    Parameters
    ----------
    a : float
        Growth rate, unit 1/time.
    b : float
        Volatility, unit 1/sqrt(time).

    Source
    ------
    Kloeden & Platen (1992), section 4.4, (4.6).
    """
    return above(gbm(a, b, x_0=0.9), a - 0.5 * b * b, b, -float(np.log(0.9)))


class PlatenAbove(PlatenWeak2):
    """Platen's scheme, which claims its order of P(x > 1) as well."""

    name: ClassVar[str] = "platen-lattice"
    claims: ClassVar[tuple[Claim, ...]] = (OF_PLATEN,)


class CoinEuler(PlatenWeak2):
    """Euler-Maruyama with +-sqrt(h) in place of dW, which claims its order of P(x > 1) as well."""

    name: ClassVar[str] = "em-lattice"
    law: ClassVar[Law] = TWO_POINT
    claims: ClassVar[tuple[Claim, ...]] = (OF_EULER,)

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the state x has shape (d, P)."""
        return Step(problem.euler(t, state, h, noise))
