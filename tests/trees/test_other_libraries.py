"""Equations of classes on arrays of other libraries: a solver of such a library can be asked for order conditions."""

import numpy as np
import pytest

from facade import OF_SDES, RichEquation, Universal, related_equations
from sdaeverify_bridges.kit import why_not_bridged
from sdaeverify_bridges.sdeint import SDEInt
from sdaeverify_bridges.torchsde import TorchSDEStratonovich
from sdaeverify_orders import orders


def equations(kind):
    """Yield the equations that a scheme is put to for a class."""
    if kind.diagonal:
        yield RichEquation(2, tuple(kind.trees(2, 3))).sde
        return
    related = related_equations(kind, 2)
    pairs = (related.near, related.distant[0])
    yield from (each for pair in pairs for each in (pair.below, pair.above))
    yield from (Universal(kind.trees(2, 3), 2, kind.traits).sde,)


@pytest.mark.parametrize("stratonovich", [False, True])
@pytest.mark.parametrize("kind", OF_SDES, ids=lambda kind: kind.name)
def test_equations_of_a_class_run_on_other_arrays(kind, stratonovich):
    """No equation of a class leaves the functions of NumPy, in neither calculus."""
    assert {why_not_bridged(each, stratonovich=stratonovich) for each in equations(kind)} == {""}


def test_formulas_that_only_numpy_runs_are_found():
    """The check finds the fault that an assignment is."""
    sde = related_equations(OF_SDES[-1], 2).near.below

    def drift(_t, x):
        moved = np.zeros(x.shape)
        moved[0] = x[1]
        return moved

    object.__setattr__(sde, "drift", drift)
    assert "its drift works on NumPy arrays only" in why_not_bridged(sde)


def test_sdeint_with_areas_holds_its_order_for_three_motions():
    """With Levy areas itoSRI2 has strong order 1.0 for any noise of three motions, as is documented."""
    pytest.importorskip("sdeint", reason="needs the extra: pip install .[sdeint]")
    [strong] = orders(SDEInt("itoSRI2", areas=True), "general").table.query("measure == 'strong'").itertuples()
    assert (strong.verdict, strong.order) == ("verified", 1.0)


def test_milstein_without_derivatives_is_refuted_by_a_tree():
    """In Stratonovich's calculus the difference quotient of torchsde leaves half of B''(B, B) in the mean."""
    pytest.importorskip("torchsde", reason="needs the extra: pip install .[torchsde]")
    report = orders(TorchSDEStratonovich("milstein", grad_free=True), "scalar")
    assert [condition.name for condition in report.failing] == ["b1(b1,b1)"]
    assert set(report.table.verdict) == {"refuted"}
