"""Brent's method against scipy, to the last bit."""

from math import cos, exp, inf, nan

import numpy as np
import pytest
from scipy.optimize import brentq

from sdaeverify.numerics.roots import find_root

CASES = [
    (lambda x: x**3 - 2.0, 0.0, 2.0),
    (lambda x: cos(x) - x, -1.0, 3.0),
    (lambda x: exp(x) - 1e-9, -40.0, 5.0),
    (lambda x: -1.0 if x < 0.3 else 1.0, 0.0, 1.0),
    (lambda x: 1e-200 * (x - 0.1) ** 5, -1.0, 2.0),
    (lambda x: np.float64(np.clip(1e6 * (x - 0.7), -3.0, 1.0)), 0.0, 1.0),
    (lambda x: inf if x > 0.2 else -1e-3, 0.0, 1.0),
    (lambda x: x, 0.0, 1.0),
    (lambda x: x, -1.0, 0.0),
]


@pytest.mark.parametrize("tolerance", [1e-15, 1e-6])
@pytest.mark.parametrize("case", CASES)
def test_the_steps_are_those_of_scipy(case, tolerance):
    """Places and values at which the function is asked are the same, and so is the root."""
    function, low, high = case
    asked = {find_root: [], brentq: []}

    def of(method):
        def noted(x):
            asked[method].append(float(x))
            return function(x)

        return method(noted, low, high, xtol=tolerance, rtol=tolerance)

    assert of(find_root) == of(brentq)
    assert [*dict.fromkeys(asked[find_root])] == [*dict.fromkeys(asked[brentq])]


def test_random_functions():
    """Polynomials with a root between the ends."""
    rng = np.random.default_rng(1)
    for _ in range(200):
        p = np.polynomial.Polynomial(rng.standard_normal(6))
        low, high = -rng.random() * 3.0, rng.random() * 3.0
        if p(low) * p(high) < 0.0:
            assert find_root(p, low, high, xtol=1e-15, rtol=1e-15) == brentq(p, low, high, xtol=1e-15, rtol=1e-15)


@pytest.mark.parametrize("function", [lambda _: 1.0, lambda _: nan], ids=["one sign", "no number"])
def test_there_is_no_root(function):
    """Ends between which no root is known are refused."""
    with pytest.raises(ValueError, match="value"):
        find_root(function, 0.0, 1.0, xtol=1e-9, rtol=1e-9)
