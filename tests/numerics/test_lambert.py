"""Lambert's function of a number that is known by its logarithm."""

import numpy as np
import pytest
import scipy

from sdaeverify.numerics import lambert_of_log


@pytest.mark.parametrize("negative", [False, True])
@pytest.mark.parametrize("logarithm", [-700.0, -30.0, -3.0, -1.5, -0.9, 0.0, 2.0, 50.0, 700.0])
def test_it_is_the_principal_branch(logarithm: float, negative: bool) -> None:
    """Where z itself does not overflow it is scipy's W_0, on both sides of the branch point -1/e."""
    z = (-1.0 if negative else 1.0) * np.exp(logarithm)
    assert lambert_of_log(logarithm, negative) == pytest.approx(complex(scipy.special.lambertw(z)), rel=1e-13)


@pytest.mark.parametrize("negative", [False, True])
def test_it_solves_its_equation_where_numbers_overflow(negative: bool) -> None:
    """It is the w of w + log w = log z, for z of the size e^5000."""
    w = lambert_of_log(5000.0, negative)
    assert w + np.log(w) == pytest.approx(5000.0 + (1j * np.pi if negative else 0.0), rel=1e-14)
