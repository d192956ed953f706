"""What a fibre says of itself as a problem."""

import numpy as np
import pytest

from problems.test_fibre_force import C, D
from sdaeverify.contracts.specs import matrix_specs
from sdaeverify.numerics import is_analytic
from sdaeverify_problems._chain import clamped_chain
from sdaeverify_problems._fibre import Fibre
from sdaeverify_problems._fibre_problem import fibre_problem, is_resolved, mild
from sdaeverify_problems._hanging_fibre import hanging_fibre
from sdaeverify_problems.fibre_clamped import fibre_clamped
from sdaeverify_problems.fibre_free import fibre_free

CHAIN = clamped_chain(3, 2)


@pytest.mark.parametrize("family", [fibre_clamped, fibre_free])
def test_default_fibre_has_additive_noise_and_a_reference(family):
    """C and D are the identity, so that the noise is additive and the solution on a path known."""
    problem = family()

    assert "additive-noise" in problem.traits
    assert problem.pathwise.order == 1.5


def test_drag_that_depends_on_the_place_leaves_the_milstein_term_zero():
    """Noise that depends on positions is not additive, but its Milstein term vanishes."""
    problem = fibre_problem(Fibre(chain=CHAIN, C=C), 0.01)

    assert "vanishing-milstein-term" in problem.traits
    assert "additive-noise" not in problem.traits
    assert problem.pathwise is not None


def test_turbulence_that_depends_on_velocities_has_neither():
    """Nothing is said of the noise, and there is no reference of order 3/2."""
    problem = fibre_problem(Fibre(chain=CHAIN, D=D), 0.01)

    assert not problem.traits & {"vanishing-milstein-term", "additive-noise"}
    assert problem.pathwise is None


def reference_growth(alpha, horizon):
    """Return the largest factor by which 512 steps 1 + h A + (h A)^2/2 of the hanging fibre multiply a mode."""
    fibre = hanging_fibre(Fibre(chain=clamped_chain(7, 2), alpha=alpha), 1.0)
    z = horizon / 512 * np.linalg.eigvals(fibre.generator)
    return (np.abs(1 + z + z * z / 2) ** 512).max()


def test_reference_is_attached_where_it_is_stable():
    """With alpha = 0.4 it is up to time 0.25, and no longer where it would grow by more than a factor e."""
    horizons = np.geomspace(0.05, 5.0, 41)
    attached = [horizon for horizon in horizons if is_resolved(fibre_of(0.4), horizon)]

    assert fibre_clamped(alpha=0.4, horizon=0.25).pathwise is not None
    assert fibre_clamped(alpha=0.4, horizon=2.0).pathwise is None
    assert max(reference_growth(0.4, horizon) for horizon in attached) < np.e
    assert reference_growth(0.4, 2.0) > 1e3


@pytest.mark.parametrize("family", [fibre_clamped, fibre_free])
def test_fibres_have_controls_where_explicit_steps_are_stable(family):
    """Those in the matrix have them; with the source's parameters the explicit controls diverge at every level."""
    (spec,) = matrix_specs(family)

    assert spec.build().controls
    assert family().controls == ()


def test_controls_are_explicit_steps_that_do_not_grow():
    """Where a fibre is called mild, 256 explicit steps of the hanging fibre grow by less than a factor e."""
    cases = [(alpha, horizon) for alpha in (0.4, 1.0, 4.0) for horizon in np.geomspace(1e-3, 1.0, 13)]
    kind = [case for case in cases if mild(fibre_of(case[0]), case[1])]

    assert 0 < len(kind) < len(cases)
    for alpha, horizon in kind:
        z = horizon / 256 * np.linalg.eigvals(hanging_fibre(fibre_of(alpha), 1.0).generator)
        assert (np.abs(1 + z) ** 256).max() < np.e


def fibre_of(alpha):
    return Fibre(chain=clamped_chain(7, 2), alpha=alpha)


def test_default_problems_can_be_differentiated_by_complex_steps():
    """Force and flow of the registered problems take no real part."""
    for problem in (fibre_clamped(), fibre_free(d=3)):
        r, v, _ = problem.initial(1)
        n = len(r)
        assert is_analytic(lambda z, p=problem, n=n: p.force(0.0, z[:n], z[n:]), np.concatenate([r, v + 0.1]))


def test_bound_of_the_constraint_leaves_no_step_without_truncation():
    """C_g of the default fibre makes C_eta = 1/(4 C_g^3) smaller than 1e-7: truncation by the theory is unusable."""
    problem = fibre_clamped()

    assert 1 / (4 * problem.constraint_bound**3) < 1e-7
