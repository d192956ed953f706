"""One step for every eps: orders of right schemes and of wrong ones, and what the nodes are exact for."""

import numpy as np
import pytest

from facade import (
    ConstrainedEuler,
    UniformDefects,
    UniformExpansion,
    UniformlyAccurate,
    exponential_strip,
    penalised_sphere,
    sphere_product,
    tube_torus,
    uniform_defects,
    why_not_uniform_defects,
)
from paper_measures.stiff_cells import AFFINE, Rootless
from sdaeverify.probing import last_orders

pytestmark = pytest.mark.long

STRIP, SPHERE = exponential_strip(), penalised_sphere(d=3)


def orders(record: UniformDefects) -> tuple[float, float]:
    """Return the least orders of what one step differs by from two half steps, and from Euler's."""
    pairs = ((record.halves, record.floor), (record.euler, record.nearly))
    halves, euler = (last_orders(record.h, size, floor, np.ones(len(record.h))).order for size, floor in pairs)
    return float(halves.min()), float(euler.min())


TORUS = pytest.param(tube_torus(), marks=pytest.mark.slow)


@pytest.mark.parametrize("problem", [AFFINE, STRIP, SPHERE, TORUS], ids=["flat", "strip", "sphere", "tube"])
@pytest.mark.parametrize("scheme", [UniformlyAccurate(), UniformlyAccurate(theta=1.0), UniformExpansion()])
def test_the_local_weak_error_has_order_three_halves(scheme, problem):
    """O(h^(3/2)) for every eps, Propositions 3.3 and 3.7, and not less: the bound is sharp."""
    halves, euler = orders(uniform_defects(scheme, problem))

    assert halves == pytest.approx(1.5, abs=0.01)
    assert euler > 1.9


def test_a_scheme_that_ignores_eps_does_not_follow_the_equation():
    """Half steps of constrained Euler agree with its steps to second order; Euler's step is another."""
    halves, euler = orders(uniform_defects(ConstrainedEuler(), SPHERE))

    assert halves > 1.9
    assert euler == pytest.approx(0.5, abs=0.02)


def test_nodes_of_normal_variables_serve_as_well_as_atoms():
    """Four nodes in place of nine: the defects are those of all atoms but for terms of size h^2."""
    few, all_ = (uniform_defects(UniformlyAccurate(xi=xi), STRIP) for xi in ("gaussian", "three-point"))

    assert np.all(np.abs(few.halves - all_.halves)[:, -1] <= 10.0 * few.h[-1] ** 2 + few.floor[:, -1])


def test_pairs_without_defects_are_told():
    """Two steps of four three-point variables have 6561 atoms."""
    assert "too many values" in why_not_uniform_defects(UniformlyAccurate(xi="three-point"), sphere_product())
    assert why_not_uniform_defects(UniformlyAccurate(), sphere_product()) == ""


def test_steps_without_root_are_counted():
    """The share of them is told for each step size."""
    record = uniform_defects(Rootless(longer=1e-4), AFFINE)

    assert np.array_equal(record.failed > 0.0, record.h > 1e-4)
    assert record.failed.max() == pytest.approx(0.1, abs=0.02)
