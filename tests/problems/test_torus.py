"""The torus with two constraint functions: geometry by differences, invariant means by other quadratures."""

import numpy as np
import pytest

from facade import TABLE, torus, tube_torus
from sdaeverify import InvariantMean
from sdaeverify_problems.tori._law import surface_means

TUBE = {1e-4: 4.12185292876, 1e-3: 4.11666192383, 5e-3: 4.09698964507, 1e-2: 4.07825595135}
TUBE |= {0.1: 3.99560411632, 1.0: 3.96986196332, 10.0: 3.96695018393}


def known(problem):
    return {truth.observable: truth.value for truth in problem.truths if isinstance(truth, InvariantMean)}


def test_the_constrained_means_are_the_printed_ones():
    """E |x|^2 and E x_1 to all digits, and the variance of |x|^2."""
    means = surface_means(25.0)

    assert means["|x|^2"] == pytest.approx(4.122449934351530, abs=4e-15)
    assert means["x_1"] == pytest.approx(2.010383321067417, abs=4e-15)
    assert means["|x|^4"] - means["|x|^2"] ** 2 == pytest.approx(0.0299899522885, abs=1e-13)
    assert known(torus(0.0)) == known(tube_torus(0.0)) == {name: means[name] for name in ("|x|^2", "x_1")}


@pytest.mark.parametrize("eps", TUBE)
def test_means_around_the_tube_are_the_printed_ones(eps):
    """E |x|^2 to the digits printed."""
    assert known(tube_torus(eps))["|x|^2"] == pytest.approx(TUBE[eps], abs=5.1e-12)


@pytest.mark.parametrize("eps", TABLE)
def test_the_table_is_known_for_its_stiffness_only(eps):
    """Ten values of eps, with stiffness 25, and the limit for any."""
    assert known(torus(eps))["|x|^2"] == TABLE[eps][0]
    assert known(torus(eps, 26.0)) == {}
    assert torus(eps, 26.0).relaxation == np.inf
