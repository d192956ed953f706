"""Laws of a scheme's increments: Gaussian, Gaussian without its far tails, or atoms that share its first moments.

Atoms are coupled to the Brownian increment by its quantiles, so that a scheme that uses them runs on the same paths
as every other. Sums of such variables are not the variables of a longer step: these schemes have a weak order only.
With them H is +-sqrt(h/12), a sign for each Brownian motion that is independent of dW: what schemes of weak order 2
need in place of the double integrals of noises that do not commute.

A normal variable clipped at A_h = sqrt(2 p |ln h|), Milstein & Tretyakov (2004), section 1.3, is bounded, too, and so
close to the one it is coupled to that it counts as normal: their mean square distance is exp(-A_h^2/2) = h^p at most.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import scipy

from ..arrays import Array
from .brownian import Increment

# P(|N| <= QUANTILE) = 2/3 for a standard normal N.
QUANTILE = 0.967421566101701
# Quantiles of the normal law at which a coupling is looked at, ends of intervals on which it is constant at most, and
# rounding of moments that are sums of decimal numbers.
QUANTILES, EDGES, SUMMED = 20_000, 64, 1e-9


class Law(NamedTuple):
    """The law of each component of the increments that a scheme is given.

    Attributes
    ----------
    name : str
    couple : callable, ndarray -> ndarray
        The variable of unit variance as a function of a standard normal.
    values, weights : tuple of float
        Atoms of unit variance and their probabilities; empty for the normal law.
    clip : float
        p of a normal variable that is clipped at A_h; 0 for none. The unit of h is the problem's unit of time.
    """

    name: str
    couple: Callable[[Array], Array]
    values: tuple[float, ...] = ()
    weights: tuple[float, ...] = ()
    clip: float = 0.0

    @property
    def bounded(self) -> bool:
        """Whether it takes finitely many values, its atoms."""
        return bool(self.values)

    def atoms(self, motions: int, *, areas: bool) -> list[tuple[Array, Array]]:
        """Return values and weights of each independent variable of a step, in units of its standard deviation."""
        of_dW, of_H = ((np.array(law.values), np.array(law.weights)) for law in (self, TWO_POINT))
        return [of_dW] * motions + [of_H] * (motions if areas else 0)

    def most(self, *, paths: bool) -> float:
        """Return the largest order that a clipped variable allows, along paths or in law; infinite for all others.

        Its mean square distance from a normal one is about h^p, and so is what its variance lacks. The former adds up
        to an error of size h^(p/2) on a path, the latter to one of size h^p in law.
        """
        return (0.5 * self.clip if paths else self.clip) if self.clip else np.inf

    def bound(self, h: float) -> float:
        """Return A_h for a clipped variable, but no less than at h = 1/e: long steps, too, have noise."""
        return float(np.sqrt(2.0 * self.clip * max(1.0, -np.log(h)))) if self.clip else np.inf

    def increment(self, noise: Increment, h: float) -> Increment:
        """Return the increment of a step of size h with this law, coupled to a Brownian one."""
        if self.clip:
            reach = np.sqrt(h) * self.bound(h)
            return noise._replace(dW=np.clip(noise.dW, -reach, reach))
        if not self.bounded:
            return noise
        H = None if noise.H is None else np.sqrt(h / 12.0) * _two_point(noise.H)
        return noise._replace(dW=np.sqrt(h) * self.couple(noise.dW / np.sqrt(h)), H=H)


def why_unusable(law: Law) -> str:
    """Return why a law cannot be given to a scheme, or an empty string.

    Atoms are the law: their mean is 0 and their variance 1, and `couple` takes each of them with its probability. A
    variable without atoms is the normal one, clipped or not: rules for other means are not known.

    Parameters
    ----------
    law : Law
    """
    x = scipy.special.ndtri((np.arange(QUANTILES) + 0.5) / QUANTILES)[None]
    coupled = np.asarray(law.couple(x.copy()))
    if coupled.shape != x.shape:
        return f"its couple expects to return as many numbers as it is given, got shape {coupled.shape}"
    if not law.bounded:
        if np.array_equal(coupled, x):
            return ""
        return (
            "its couple is another variable than the normal one and it has no atoms: give their values and weights, "
            "or shape dW in the step and set discontinuous_in_noise"
        )
    return "it is clipped and has atoms: leave one of them out" if law.clip else _why_unlike(law, coupled)


def _why_unlike(law: Law, coupled: Array) -> str:
    """Return that atoms are no standard variable, or that coupled quantiles of the normal law are not these atoms."""
    values, weights = np.array(law.values), np.array(law.weights)
    if values.shape != weights.shape or not (weights > 0.0).all() or abs(weights.sum() - 1.0) > SUMMED:
        return "weights expects a positive number for each atom, of sum 1"
    mean, variance = float(weights @ values), float(weights @ values**2)
    if max(abs(mean), abs(variance - 1.0)) > SUMMED:
        return f"its atoms have mean {mean:.4g} and second moment {variance:.4g}, expected 0 and 1"
    taken = np.isclose(coupled[0], values[:, None], rtol=SUMMED, atol=SUMMED)
    shares = taken.mean(axis=1)
    if not taken.any(axis=0).all():
        return f"its couple returns {coupled[0][~taken.any(axis=0)][0]:.6g}, which is none of its atoms"
    off = int(np.argmax(np.abs(shares - weights)))
    if abs(shares[off] - weights[off]) > EDGES / QUANTILES:
        found = f"its couple takes the atom {values[off]:.4g} with probability {shares[off]:.4g}"
        return f"{found}, its weight is {weights[off]:.4g}"
    return ""


def _normal(x: Array) -> Array:
    return x


def _three_point(x: Array) -> Array:
    return np.asarray(np.sqrt(3.0) * np.sign(x) * (np.abs(x) > QUANTILE))


def _two_point(x: Array) -> Array:
    return np.where(x < 0.0, -1.0, 1.0)


def clipped_gaussian(p: float) -> Law:
    """Return the law of normal variables that are clipped at A_h = sqrt(2 p |ln h|)."""
    return Law("clipped-gaussian", _normal, clip=p)


GAUSSIAN = Law("gaussian", _normal)
THREE_POINT = Law("three-point", _three_point, (-(3.0**0.5), 0.0, 3.0**0.5), (1 / 6, 2 / 3, 1 / 6))
TWO_POINT = Law("two-point", _two_point, (-1.0, 1.0), (0.5, 0.5))
