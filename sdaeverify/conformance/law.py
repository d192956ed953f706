"""The law of a run on dx = c dt + S dW: how its mean and its covariance grow, without sampling.

Where a run's state is affine in all the noise that drives it, X_N = m_N + sum_j R_{N,j} xi_j with independent xi_j of
variance 1, the response R_{N,j} is what the j-th variable alone changes, and

    E X_N = m_N,    Cov X_N = R_N R_N^T.

Only growth from step N to step 2 N is compared with that of the solution, E X = m(t) and Cov X = t A A^T: a scheme
that remembers the last increments begins without them.
"""

from itertools import islice
from typing import NamedTuple

import numpy as np

from ..arrays import Array, Parts
from ..contracts.scheme import Scheme
from ..noise.brownian import Increment
from ..numerics.statistics import EPS
from ..probe.step.nodes import SEED
from .trivial import Trivial
from .trivial_run import parts_along

STEPS = 32
# A response that is affine to rounding is off by less than this part of itself.
AFFINE = 1e-6


class LawError(NamedTuple):
    """By how much a law grows wrongly.

    Attributes
    ----------
    quantity : str
        The mean or the covariance, whichever is further off.
    share : float
        Error of the growth, in units of the solution's.
    rounding : float
        What rounding explains of it.
    """

    quantity: str
    share: float
    rounding: float


class Moments(NamedTuple):
    """Mean, shape (d,), and covariance, shape (d, d), of a state."""

    mean: Array
    covariance: Array

    def since(self, before: "Moments") -> "Moments":
        """Return by how much they have grown."""
        return Moments(self.mean - before.mean, self.covariance - before.covariance)


def law_error(scheme: Scheme, trivial: Trivial, h: float) -> LawError | None:
    """Compare the growth of mean and covariance of a scheme's steps with that of the solution.

    Parameters
    ----------
    scheme : Scheme
    trivial : Trivial
        A problem with noise.
    h : float

    Returns
    -------
    LawError or None
        None where the scheme's state is not affine in its noise: nothing is known of its law.
    """
    known = list(trivial.solution(0.0, np.zeros((trivial.problem.noise_dim, 1))))
    noises, probe = _unit_noises(scheme, trivial, h)
    run = parts_along(scheme, trivial.problem, h, noises)
    states = [_stacked(parts, known) for parts in islice(run, STEPS - 1, None, STEPS)]
    found = [_moments(state, probe) for state in states]
    if any(moments is None for moments in found):
        return None
    half, end = (moments for moments in found if moments is not None)
    grown = end.since(half)
    right = _solution(trivial, known, 2 * STEPS * h).since(_solution(trivial, known, STEPS * h))
    variance = float(np.diag(right.covariance).max())
    mean = np.abs(grown.mean - right.mean).max() / (np.abs(right.mean).max() + np.sqrt(variance))
    covariance = np.abs(grown.covariance - right.covariance).max() / variance
    rounding = 64.0 * EPS * len(noises) * (1.0 + float(np.abs(states[-1]).max()) / np.sqrt(variance))
    return LawError(*max(("the covariance", covariance), ("the mean", mean), key=lambda pair: pair[1]), rounding)


def _unit_noises(scheme: Scheme, trivial: Trivial, h: float) -> tuple[list[Increment], Array]:
    """Return noise of J + 2 paths and the variables xi of the last, shape (J,).

    The first path has none of the J variables, the next ones have one of them each, and the last has all.
    """
    fields, l = 1 + ("H" in scheme.noise), trivial.problem.noise_dim
    size = 2 * STEPS * fields * l
    probe = np.random.Generator(np.random.Philox(key=SEED)).standard_normal(size)
    xi = np.concatenate([np.zeros((size, 1)), np.eye(size), probe[:, None]], axis=1)
    xi = xi.reshape(2 * STEPS, fields, l, size + 2)
    areas = [np.sqrt(h / 12.0) * part[1] if fields > 1 else None for part in xi]
    return [Increment(np.sqrt(h) * part[0], area) for part, area in zip(xi, areas, strict=True)], probe


def _moments(x: Array, probe: Array) -> Moments | None:
    """Return mean and covariance from the states of all paths, shape (d, J + 2)."""
    mean, response = x[:, 0], x[:, 1:-1] - x[:, :1]
    expected = mean + response @ probe
    if not np.abs(x[:, -1] - expected).max() <= AFFINE * np.abs(response).max():
        return None
    return Moments(mean, response @ response.T)


def _solution(trivial: Trivial, known: list[str], t: float) -> Moments:
    l = trivial.problem.noise_dim
    x = _stacked(trivial.solution(t, np.sqrt(t) * np.eye(l, l + 1, k=1)), known)
    response = x[:, 1:] - x[:, :1]
    return Moments(x[:, 0], response @ response.T)


def _stacked(parts: Parts, known: list[str]) -> Array:
    return np.concatenate([parts[name] for name in known])
