"""The exponential strip: printed means, its closed forms, and the balance that a missing term would break."""

import pytest

from facade import exponential_strip
from sdaeverify import InvariantMean

# (q, eps): E t and E |n|^2 for alpha = kappa = sigma = 1, c = 1/2.
PRINTED = {
    (1, 1e-3): (0.50025062506, 5.0049974750e-4),
    (1, 1e-2): (0.50256253722, 5.0497245314e-3),
    (1, 0.1): (0.53101697298, 0.054466124327),
    (1, 1.0): (0.79187250843, 0.39593625422),
    (2, 1e-3): (0.50050175112, 1.0015002423e-3),
    (2, 1e-2): (0.50517605140, 1.0150171144e-2),
    (2, 0.1): (0.56763487269, 0.11425312905),
    (2, 1.0): (1.13896751423, 0.81948375711),
}


def limits(eps: float, q: int = 1, **parameters: float) -> dict[str, float]:
    problem = exponential_strip(eps, q, **parameters)
    return {truth.observable: truth.value for truth in problem.truths if isinstance(truth, InvariantMean)}


@pytest.mark.parametrize(("q", "eps"), PRINTED)
def test_means_are_those_printed(q: int, eps: float) -> None:
    """E t and E |n|^2 agree with the formula sheet to its eleven digits."""
    known = limits(eps, q)
    assert known["t"] == pytest.approx(PRINTED[q, eps][0], abs=6e-12)
    assert known["|n|^2"] == pytest.approx(PRINTED[q, eps][1], rel=1e-10)
