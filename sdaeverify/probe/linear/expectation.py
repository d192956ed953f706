"""The operator P -> E A P A^T of a step in Gaussian noise, by rules that are refined until two of them agree.

1. Products of Gauss-Hermite rules with 5, 9, 15, 25 and 41 nodes a normal: steps that are smooth in the noise.
2. One normal: panels of [-9.5, 9.5], bisected until they agree: kinks and jumps anywhere.
3. Two normals: products of Gauss-Legendre rules on either side of 0, with 32 and 41 nodes: kinks at 0.
"""

from collections.abc import Iterable
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from ...arrays import Array
from ..step.nodes import SEED, Nodes
from ..step.step_noise import StepNoise
from .affine import relative
from .bisection import bisected
from .linear_map import MemoryStep, factors_at
from .second_moments import Operator

LADDER = (5, 9, 15, 25, 41)
SPLIT = (32, 41)
AGREEMENT = 1e-12
TRIALS = 3


class Expectation(NamedTuple):
    """An operator by two rules.

    Attributes
    ----------
    operator : Operator
    coarser : Operator or None
        By the coarser rule: the operator itself where the two agree to 1e-12 or the rule is exact, None where there
        are too many normals for two rules.
    """

    operator: Operator
    coarser: Operator | None

    @property
    def disagreement(self) -> float:
        """How much the two rules disagree, relative."""
        if self.coarser is self.operator:
            return 0.0
        return np.inf if self.coarser is None else disagreement(self.operator, self.coarser)


def expectation(step: MemoryStep, noise: StepNoise, *, kinks: bool = True) -> Expectation:
    """Return the operator of a step.

    Parameters
    ----------
    step : MemoryStep
    noise : StepNoise
    kinks : bool
        Whether kinks are looked for where smooth rules do not agree.

    Returns
    -------
    Expectation
    """
    found = _climbed(step, noise, (noise.rule(count) for count in LADDER))
    if found.coarser is found.operator or not kinks:
        return found
    if noise.normals == 1:
        return _bisected(step, noise)
    split = _climbed(step, noise, (noise.split_rule(count) for count in SPLIT))
    return min(found, split, key=lambda pair: pair.disagreement)


def disagreement(a: Operator, b: Operator) -> float:
    """Return the largest difference of two operators' values at some random positive matrices, relative."""
    trials = _positive(a.dimension)
    values = [np.stack([operator(P) for P in trials]) for operator in (a, b)]
    return relative((values[0] - values[1]).reshape(-1, 1), values[0].reshape(-1, 1))


def factors_of(step: MemoryStep, noise: StepNoise, x: Array) -> Array:
    """Return [[R, r], [0, 1]] where the normals are x, shape (k + 1, k + 1, K)."""
    return factors_at(step, noise.nodes(x, np.ones(x.shape[1])))


def _climbed(step: MemoryStep, noise: StepNoise, rules: Iterable[Nodes | None]) -> Expectation:
    """Return the first rule that agrees with the one before, else the last two; rules that are too large are None."""
    x = noise.simplex()
    found = Expectation(Operator(factors_of(step, noise, x), np.full(x.shape[1], 1.0 / x.shape[1])), None)
    for place, nodes in enumerate(rules):
        if nodes is None:
            break
        finer = Operator(factors_at(step, nodes), nodes.weights)
        found = Expectation(finer, found.operator if place else None)
        if found.disagreement <= AGREEMENT:
            return Expectation(finer, finer)
    return found


def _bisected(step: MemoryStep, noise: StepNoise) -> Expectation:
    def integrals(factors: Array, weights: Array) -> Array:
        return np.asarray(np.einsum("aipq,bipq,pq->abp", factors, factors, weights, optimize=True))

    found = bisected(lambda z: factors_of(step, noise, z[None]), integrals)
    finer, coarser = Operator(found.values, found.weights), Operator(found.coarse_values, found.coarse_weights)
    return Expectation(finer, finer if disagreement(finer, coarser) <= AGREEMENT else coarser)


@lru_cache(maxsize=64)
def _positive(n: int) -> Array:
    G = np.random.Generator(np.random.Philox(key=SEED + 5)).standard_normal((TRIALS, n, n))
    return G @ G.swapaxes(1, 2)
