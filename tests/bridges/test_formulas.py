"""When two problems have the same formulas, so that what is compiled for one serves the other."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from bridges.equations import curved
from facade import angle_pendulum, gbm, ou
from sdaeverify_bridges.kit import Formulas


@pytest.mark.parametrize("family", [gbm, ou, angle_pendulum, curved], ids=lambda family: family.__name__)
def test_problem_built_anew_has_the_same_formulas(family):
    """Two objects with the same parameters are one key."""
    assert Formulas(family()) == Formulas(family())
    assert len({Formulas(family()), Formulas(family())}) == 1


@pytest.mark.parametrize(
    ("one", "other"),
    [(gbm(a=0.5), gbm(a=0.25)), (curved(1.0), curved(2.0)), (curved(1.0), curved(1)), (gbm(), ou())],
    ids=["value", "closure", "kind of number", "equation"],
)
def test_other_formulas_are_another_key(one, other):
    """A number in a closure counts, and so does its type."""
    assert Formulas(one) != Formulas(other)


def test_what_no_step_depends_on_does_not_count():
    """The horizon is none of a step's formulas."""
    assert Formulas(curved(horizon=1.0)) == Formulas(curved(horizon=2.0))


def test_view_of_a_problem_is_a_key():
    """The first-order system of Langevin dynamics is found again, though its functions are in a closure of it."""
    assert Formulas(angle_pendulum().ito()) == Formulas(angle_pendulum().ito())
    assert Formulas(angle_pendulum(c=2.0).ito()) != Formulas(angle_pendulum().ito())


def with_drift(drift):
    """Return an equation with another drift."""
    return Formulas(replace(curved(), drift=drift))


def scaled(factor, t, x):
    """Return a multiple of a state."""
    return factor * x


def test_arrays_and_partial_functions_count_by_value():
    """Equal arguments that were bound are equal, others are not."""
    one, other = (with_drift(partial(scaled, np.array([factor]))) for factor in (1.0, 2.0))

    assert one == with_drift(partial(scaled, np.array([1.0])))
    assert one != other


class Unknown:
    """A thing that cannot be compared by value."""

    def __call__(self, t, x):
        return -x


def test_what_cannot_be_compared_counts_by_identity():
    """Two of them may differ: what is compiled for one does not serve the other."""
    drift = Unknown()

    assert with_drift(drift) == with_drift(drift)
    assert with_drift(drift) != with_drift(Unknown())


def recursive():
    """Return a drift whose closure holds itself."""

    def drift(t, x, depth=1):
        return -x if depth == 0 else drift(t, x, depth - 1)

    return drift


def test_function_in_its_own_closure_ends():
    """A recursive function is a key like any other."""
    assert with_drift(recursive()) == with_drift(recursive())
