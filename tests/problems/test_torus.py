"""The torus with two constraint functions: geometry by differences, invariant means by other quadratures."""

import numpy as np
import pytest
from scipy.integrate import dblquad

from problems.generator import generator, observed
from sdaeverify import ParameterError
from sdaeverify.forms.truths import InvariantMean
from sdaeverify.testing.checks.differences import FIRST_ERROR, first
from sdaeverify_problems._torus_geometry import Quartic, Tube, surface_chart
from sdaeverify_problems._torus_law import surface_means, tube_means
from sdaeverify_problems.torus import TABLE, torus
from sdaeverify_problems.tube_torus import tube_torus

POINTS = np.array([[2.3, 1.6, 0.4], [0.2, -1.1, 1.9], [0.3, 0.7, -0.6]])
TUBE = {1e-4: 4.12185292876, 1e-3: 4.11666192383, 5e-3: 4.09698964507, 1e-2: 4.07825595135}
TUBE |= {0.1: 3.99560411632, 1.0: 3.96986196332, 10.0: 3.96695018393}


def known(problem):
    return {truth.observable: truth.value for truth in problem.truths if isinstance(truth, InvariantMean)}


def test_the_polynomial_has_the_printed_form():
    """The factors multiply to (|x|^2 + R^2 - r^2)^2 - 4 R^2 (x_1^2 + x_2^2)."""
    printed = ((POINTS**2).sum(axis=0) + 8.0) ** 2 - 36.0 * (POINTS[:2] ** 2).sum(axis=0)

    assert np.allclose(Quartic().zeta(POINTS)[0], printed, rtol=1e-14)


@pytest.mark.parametrize("zeta", [Quartic(), Tube()])
def test_closed_derivatives_are_those_of_differences(zeta):
    """Gradient, contraction and Laplacian follow from the constraint function."""
    units = [np.broadcast_to(unit[:, None], POINTS.shape) for unit in np.eye(3)]
    g = np.stack([first(zeta.zeta, POINTS, unit)[0] for unit in units])
    H = np.stack([first(zeta.jacobian, POINTS, unit)[0] for unit in units])
    w = np.cos(1.0 + POINTS)

    assert np.abs(zeta.jacobian(POINTS)[0] - g).max() <= FIRST_ERROR * 200
    assert np.abs(zeta.second(POINTS, w[:, None]) - np.einsum("ijp,jp->ip", H, w)).max() <= FIRST_ERROR * 200
    assert np.abs(zeta.laplacians(POINTS)[0] - np.einsum("iip->p", H)).max() <= FIRST_ERROR * 200


def test_the_gradient_of_the_gram_determinant_has_a_part_along_the_surface():
    """On the quartic torus it is tangential, too; on the tube it is a multiple of g, which the multiplier absorbs."""
    quartic, tube = (problem.near(POINTS) for problem in (torus(), tube_torus()))

    assert np.allclose(tube.fixman, 2.0 * tube.J.Dg[0] / (tube.J.Dg[0] ** 2).sum(axis=0), rtol=1e-12)
    assert np.abs(quartic.fixman - quartic.normal(quartic.fixman)).max() > 0.1


def test_the_constrained_means_are_the_printed_ones():
    """E |x|^2 and E x_1 to all digits, and the variance of |x|^2."""
    means = surface_means(25.0)

    assert means["|x|^2"] == pytest.approx(4.122449934351530, abs=4e-15)
    assert means["x_1"] == pytest.approx(2.010383321067417, abs=4e-15)
    assert means["|x|^4"] - means["|x|^2"] ** 2 == pytest.approx(0.0299899522885, abs=1e-13)
    assert known(torus(0.0)) == known(tube_torus(0.0)) == {name: means[name] for name in ("|x|^2", "x_1")}


def test_the_constrained_means_agree_with_adaptive_quadrature():
    """Over both angles, without Bessel functions, for another stiffness."""
    stiffness = 16.0

    def integral(q):
        def density(phi, theta):
            rho, height = 3.0 + np.cos(theta), np.sin(theta)
            V = 0.5 * stiffness * (rho**2 + height**2 - 4.0 * rho * np.cos(phi) + 4.0)
            return q(rho, height, phi) * rho * np.exp(-V)

        return dblquad(density, 0.0, 2.0 * np.pi, -np.pi, np.pi, epsabs=1e-11, epsrel=1e-11)[0]

    total = integral(lambda rho, height, phi: 1.0)
    square = integral(lambda rho, height, phi: rho**2 + height**2) / total
    assert known(torus(0.0, stiffness))["|x|^2"] == pytest.approx(square, rel=1e-8)
    assert known(torus(0.0, stiffness))["x_1"] == pytest.approx(
        integral(lambda rho, height, phi: rho * np.cos(phi)) / total, rel=1e-8
    )


@pytest.mark.parametrize("eps", TUBE)
def test_means_around_the_tube_are_the_printed_ones(eps):
    """E |x|^2 to the digits printed."""
    assert known(tube_torus(eps))["|x|^2"] == pytest.approx(TUBE[eps], abs=5.1e-12)


def tube_law(problem, eps):
    """Return nodes in space and the weights of the density, over two angles and s, a quarter of it by symmetry."""
    z = 0.02 + 0.05 * np.arange(50), np.pi + 0.07 * (0.5 + np.arange(24)), 0.035 * (0.5 + np.arange(26))
    s, theta, phi = (part.ravel() for part in np.meshgrid(*z, indexing="ij"))
    rho = 3.0 + s * np.cos(theta)
    x = np.stack([rho * np.cos(phi), rho * np.sin(phi), s * np.sin(theta)])
    V = 12.5 * ((x - problem.initial(1)) ** 2).sum(axis=0)
    weights = rho * s * np.exp(-V + (1.0 + 0.5 / eps) * np.log(s) - (s * s - 1.0) / (4.0 * eps))
    return x, weights / weights.sum()


def test_the_equation_around_the_tube_leaves_its_density_alone():
    """The generator's image of every observable has mean 0 for the right eps only."""
    eps = 0.05
    problem = tube_torus(eps)
    x, weights = tube_law(problem, eps)
    for name in problem.observables:
        assert abs(weights @ generator(problem, observed(problem, name), x)) < 1e-6, name
    assert abs(weights @ generator(tube_torus(0.06), observed(problem, "|x|^2"), x)) > 1e-3


@pytest.mark.parametrize("eps", TABLE)
def test_the_table_is_known_for_its_stiffness_only(eps):
    """Ten values of eps, with stiffness 25, and the limit for any."""
    assert known(torus(eps))["|x|^2"] == TABLE[eps][0]
    assert known(torus(eps, 26.0)) == {}
    assert torus(eps, 26.0).relaxation == np.inf


def test_the_table_tends_to_the_limit():
    """E |x|^2 to its digits at eps = 1e-6, where the slope at 0 is -1.09."""
    limit = surface_means(25.0)

    assert TABLE[1e-6][0] == pytest.approx(limit["|x|^2"] - 1.09e-6, abs=1.5e-8)
    assert TABLE[1e-6][1] == pytest.approx(limit["x_1"], abs=6e-7)


@pytest.mark.parametrize("eps", [1e-300, 1e-8, 1e300])
def test_extreme_stiffness(eps):
    """Means stay finite, and tend to those of the limit."""
    means = tube_means(25.0, eps)

    assert np.isfinite(list(means.values())).all()
    assert abs(means["|x|^2"] - surface_means(25.0)["|x|^2"]) <= min(6.0 * eps, 0.2) + 1e-14


def test_the_chart_is_the_surface():
    """Both constraint functions vanish on it."""
    x = surface_chart().embed(np.array([[0.3, 2.0, -2.5], [1.0, -3.0, 0.2]]))

    assert np.abs(Quartic().zeta(x)).max() < 1e-13
    assert np.abs(Tube().zeta(x)).max() < 1e-14


@pytest.mark.parametrize("given", [{"eps": -1.0}, {"eps": np.nan}, {"stiffness": 1.0}, {"stiffness": np.inf}])
def test_bad_parameters_are_named(given):
    """One line each."""
    for problem in (torus, tube_torus):
        with pytest.raises(ParameterError, match=next(iter(given))) as caught:
            problem(**given)
        assert "\n" not in str(caught.value)
