"""Test functions of the weak tests against their names."""

import numpy as np
import pytest

from facade import test_functions as phi
from sdaeverify.numerics import jacobian

SPECIAL = {
    "sin(sum x)": lambda x: np.sin(x.sum(axis=0)),
    "exp(-|x|^2/2)": lambda x: np.exp(-0.5 * (x**2).sum(axis=0)),
}


def read(name, x):
    """Evaluate a function by its name."""
    if name in SPECIAL:
        return SPECIAL[name](x)
    factors = [part.split("^") for part in name.split()]
    return np.prod([x[int(base[1:]) - 1] ** int(*power or [1]) for base, *power in factors], axis=0)


@pytest.mark.parametrize(("d", "count"), [(1, 3 + 3), (2, 9 + 4), (3, 19 + 5), (4, 14 + 6), (5, 20 + 7)])
def test_each_function_is_what_it_is_called(d, count):
    """Monomials to degree 3 in up to 3 variables, to degree 2 beyond, fourth powers, a sine and a bell."""
    x = np.random.default_rng(d).standard_normal((d, 7))
    names, values = phi.names(d), phi.values(x)
    assert len(set(names)) == len(names) == count
    assert values == pytest.approx(np.stack([read(name, x) for name in names]))


def test_they_can_be_differentiated_by_complex_steps():
    """Their slopes are what rounding errors of a state are multiplied with."""
    x = np.array([[0.3], [-0.8]])
    slopes = dict(zip(phi.names(2), jacobian(phi.values, x)[..., 0], strict=True))
    assert slopes["x1 x1 x2"] == pytest.approx([2 * 0.3 * -0.8, 0.09])
    assert slopes["x2^4"] == pytest.approx([0.0, -4 * 0.8**3])
    assert slopes["sin(sum x)"] == pytest.approx([np.cos(0.5)] * 2)
