"""The explicit expansion against the uniformly accurate step, in the mean over all atoms of the noise."""

from itertools import pairwise

import numpy as np
import pytest

from facade import UniformExpansion, UniformlyAccurate
from schemes.rough_constraints import D, langevin, points
from sdaeverify import Array, ConstraintGeometry
from sdaeverify.probing import step_nodes

EXPANSION, INTEGRATOR = UniformExpansion(xi="three-point"), UniformlyAccurate(xi="three-point")
STIFF = 10.0 ** np.arange(-9.0, 2.0, 2.0)


def means(x: Array, x0: Array, weights: Array) -> Array:
    """Return the means of all first and second moments of x - x_0 over the atoms."""
    moved = (x - np.repeat(x0, len(weights), axis=1)).reshape(D, -1, len(weights))
    second = np.einsum("isn,jsn,n->ijs", moved, moved, weights).reshape(D * D, -1)
    return np.concatenate([moved @ weights, second])


def difference(q: int, h: float, geometry: object = ConstraintGeometry) -> float:
    """Return the largest difference of a mean over all eps, from states as far from the manifold as solutions are."""
    nodes, on, largest = step_nodes(D, 0, law=EXPANSION.law), points(q, 0.0), 0.0
    for eps in STIFF:
        problem = langevin(q, float(eps), geometry=geometry)
        for side in (-0.5, 0.0, 0.5):
            x = on + side * np.sqrt(min(eps, h)) * langevin(q, 1.0).near(on).J.transposed(np.ones((q, on.shape[1])))
            wide, noise = np.repeat(x, len(nodes.weights), axis=1), nodes.increment(h, x.shape[1])
            ends = [scheme.step(problem, wide, 0.0, h, noise) for scheme in (EXPANSION, INTEGRATOR)]
            both = [means(end.state, x, nodes.weights) for end in ends]
            assert not ends[1].failed.any()
            largest = max(largest, float(np.abs(both[0] - both[1]).max()))
    return largest


def order(q: int, geometry: object = ConstraintGeometry) -> float:
    """Return the order in h, between h = 4^-5 and 4^-7, of the supremum over eps."""
    sizes = [difference(q, 4.0**-n, geometry) for n in (5, 6, 7)]
    return float(np.mean([np.log(a / b) / np.log(4.0) for a, b in pairwise(sizes)]))


@pytest.mark.sweep
@pytest.mark.parametrize("q", [1, 2, 3])
def test_means_agree_up_to_three_halves(q: int) -> None:
    """First and second moments of a step differ by O(h^(3/2)) uniformly in eps, Propositions 3.3 and 3.7."""
    assert order(q) > 1.45
