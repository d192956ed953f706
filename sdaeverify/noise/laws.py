"""Laws of a scheme's increments: Gaussian, Gaussian with clipped tails, or discrete with the same first moments.

A discrete variable is coupled to the Brownian increment by quantiles, so that a scheme that uses it runs on the same
paths as every other. A sum of such variables is not the variable of a longer step: these schemes have a weak order
only. H is then +-sqrt(h/12), with a sign for each Brownian motion independent of dW: schemes of weak order 2 need it
in place of the double integrals of noncommutative noise.

A normal variable clipped at A_h = sqrt(2 p |ln h|), Milstein & Tretyakov (2004), section 1.3, is bounded, too. It
counts as normal, because its mean square distance from the normal variable it is coupled to is at most exp(-A_h^2/2)
= h^p.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import scipy

from ..arrays import Array
from .brownian import Increment

# P(|N| <= QUANTILE) = 2/3 for a standard normal N.
QUANTILE = 0.967421566101701
# Number of quantiles of the normal law at which a coupling is checked; most intervals on which it may be constant;
# rounding of moments that are sums of decimal numbers.
QUANTILES, EDGES, SUMMED = 20_000, 64, 1e-9


class Law(NamedTuple):
    """Law of each component of the increments of a scheme.

    Attributes
    ----------
    name : str
    couple : callable, ndarray -> ndarray
        Maps a standard normal to the variable of unit variance.
    values, weights : tuple of float
        Atoms of the variable of unit variance, and their probabilities; empty for a normal law.
    clip : float
        Parameter p of a normal variable clipped at A_h; 0 if not clipped. h is in the problem's unit of time.
    """

    name: str
    couple: Callable[[Array], Array]
    values: tuple[float, ...] = ()
    weights: tuple[float, ...] = ()
    clip: float = 0.0

    @classmethod
    def clipped_gaussian(cls, p: float) -> "Law":
        """Return the law of normal variables clipped at A_h = sqrt(2 p |ln h|)."""
        return cls("clipped-gaussian", _normal, clip=p)

    @property
    def bounded(self) -> bool:
        """Whether the law is discrete, with finitely many atoms."""
        return bool(self.values)

    def atoms(self, motions: int, *, areas: bool) -> list[tuple[Array, Array]]:
        """Return values and weights of each independent variable of a step, in units of its standard deviation."""
        of_dW, of_H = ((np.array(law.values), np.array(law.weights)) for law in (self, TWO_POINT))
        return [of_dW] * motions + [of_H] * (motions if areas else 0)

    def most(self, *, paths: bool) -> float:
        """Return the largest order that a clipped variable allows, on paths or in law; infinite for other laws.

        Its mean square distance from a normal variable is about h^p, and so is the loss of variance. The former adds
        up to an error of size h^(p/2) on a path, the latter to one of size h^p in law.
        """
        return (0.5 * self.clip if paths else self.clip) if self.clip else np.inf

    def bound(self, h: float) -> float:
        """Return A_h of a clipped variable, at least its value at h = 1/e, so that long steps have noise, too."""
        return float(np.sqrt(2.0 * self.clip * max(1.0, -np.log(h)))) if self.clip else np.inf

    def increment(self, noise: Increment, h: float) -> Increment:
        """Return the increment of a step of size h with this law, coupled to a Brownian increment."""
        if self.clip:
            reach = np.sqrt(h) * self.bound(h)
            return noise._replace(dW=np.clip(noise.dW, -reach, reach))
        if not self.bounded:
            return noise
        H = None if noise.H is None else np.sqrt(h / 12.0) * _two_point(noise.H)
        return noise._replace(dW=np.sqrt(h) * self.couple(noise.dW / np.sqrt(h)), H=H)


def why_unusable(law: Law) -> str:
    """Return why a scheme cannot use a law, or an empty string.

    A discrete law must have mean 0 and variance 1, and `couple` must take each atom with its probability. A law
    without atoms must be the normal one, clipped or not, because quadrature rules for other laws are not known.

    Parameters
    ----------
    law : Law
    """
    x = scipy.special.ndtri((np.arange(QUANTILES) + 0.5) / QUANTILES)[None]
    coupled = np.asarray(law.couple(x.copy()))
    if coupled.shape != x.shape:
        return f"its couple must return an array of the shape it is given, got shape {coupled.shape}"
    if not law.bounded:
        if np.array_equal(coupled, x):
            return ""
        return (
            "its couple changes the normal variable, but it has no atoms: give their values and weights, "
            "or transform dW in the step and set discontinuous_in_noise"
        )
    return "it is clipped and has atoms: leave one of them out" if law.clip else _why_unlike(law, coupled)


def _why_unlike(law: Law, coupled: Array) -> str:
    """Return why atoms have wrong moments or differ from `couple` at normal quantiles, or an empty string."""
    values, weights = np.array(law.values), np.array(law.weights)
    if values.shape != weights.shape or not (weights > 0.0).all() or abs(weights.sum() - 1.0) > SUMMED:
        return "weights expects one positive number per atom, with sum 1"
    mean, variance = float(weights @ values), float(weights @ values**2)
    if max(abs(mean), abs(variance - 1.0)) > SUMMED:
        return f"its atoms have mean {mean:.4g} and second moment {variance:.4g}, expected 0 and 1"
    taken = np.isclose(coupled[0], values[:, None], rtol=SUMMED, atol=SUMMED)
    shares = taken.mean(axis=1)
    if not taken.any(axis=0).all():
        return f"its couple returns {coupled[0][~taken.any(axis=0)][0]:.6g}, which is not one of its atoms"
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


GAUSSIAN = Law("gaussian", _normal)
THREE_POINT = Law("three-point", _three_point, (-(3.0**0.5), 0.0, 3.0**0.5), (1 / 6, 2 / 3, 1 / 6))
TWO_POINT = Law("two-point", _two_point, (-1.0, 1.0), (0.5, 0.5))
