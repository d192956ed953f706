"""Truths of problems with a penalty, for the least and the largest stiffness that there are."""

import numpy as np
import pytest

from facade import load_registry
from sdaeverify import InvariantMean, Moment

REGISTRY = load_registry([])
FAMILIES = ("affine-constraint", "exponential-strip", "orthogonal-group", "penalised-sphere", "stiefel", "tube-torus")


def known(name: str, eps: float) -> dict[str, float]:
    """Return the moments at a time, and the invariant means, that a problem knows."""
    truths = REGISTRY.problems[name].thing(eps=eps).truths
    moments = {f"E {t.observable}": float(t.value(0.4)) for t in truths if isinstance(t, Moment)}
    return moments | {t.observable: float(t.value) for t in truths if isinstance(t, InvariantMean)}


@pytest.mark.parametrize("name", FAMILIES)
def test_extreme_stiffness_has_finite_truths(name: str) -> None:
    """Nothing overflows, and for small eps the limit is there."""
    small, smaller, large, limit = (known(name, eps) for eps in (1e-12, 1e-300, 1e300, 0.0))

    assert np.isfinite([*small.values(), *smaller.values(), *large.values()]).all()
    assert smaller.keys() == small.keys()
    for value in limit.keys() & small.keys():
        assert [small[value], smaller[value]] == pytest.approx(2 * [limit[value]], abs=1e-8)
