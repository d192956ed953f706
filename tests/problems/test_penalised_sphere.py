"""Dynamics around the sphere: printed values, the semigroup of the equation on a chart, and the invariant density."""

from typing import Any

import numpy as np
import pytest
from scipy.linalg import expm

from problems.generator import generator, observed
from sdaeverify import ConstrainedLangevin, InvariantMean, Moment, ParameterError
from sdaeverify.arrays import Array
from sdaeverify.probe.operator.basis import chart_basis
from sdaeverify.probe.operator.chart_equation import generator as matrix
from sdaeverify.testing.checks.differences import SECOND_ERROR
from sdaeverify_problems._pulled_law import invariant_means, on_the_sphere
from sdaeverify_problems._radial_law import RadialLaw
from sdaeverify_problems.penalised_sphere import penalised_sphere

# d = 3, sigma = 1, f = 0, t = 1.
MEANS = {
    1e-8: 0.367879454967,
    1e-4: 0.368017396072,
    1e-3: 0.369258995829,
    1e-2: 0.381671414778,
    0.1: 0.502164483698,
    1.0: 1.0073036256266,
    10.0: 1.2262197192427,
}
# d = 3, k = 3, sigma = 1: E x_1 and E |x|^2.
PULLED = {
    0.0: (0.671636489980, 1.0),
    1e-3: (0.674355473622, 1.006023066421),
    1e-2: (0.698838717288, 1.060965161519),
    0.1: (0.944892652217, 1.683467795665),
    1.0: (3.5, 15.5),
}
DIGITS = 6e-13


@pytest.mark.parametrize("eps", MEANS)
def test_means_are_those_printed(eps: float) -> None:
    """E X_1 for seven values of eps, to all digits of the formula sheet."""
    assert RadialLaw(eps, 3, 1.0).harmonic(1, 1.0) == pytest.approx(MEANS[eps], abs=DIGITS)


def test_the_limit_is_the_decay_of_spherical_harmonics() -> None:
    """For eps = 0 and next to it a polynomial of degree l decays at the rate sigma^2 l (l + d - 2)/2."""
    for degree, rate in ((1, 0.72), (2, 1.8)):
        limit, near = (RadialLaw(eps, 5, 0.6).harmonic(degree, 0.7) for eps in (0.0, 1e-300))
        assert limit == pytest.approx(np.exp(-rate * 0.7), rel=1e-14)
        assert near == pytest.approx(limit, rel=1e-13)


@pytest.mark.parametrize("eps", PULLED)
def test_means_with_a_pull_are_those_printed(eps: float) -> None:
    """E x_1 and E |x|^2 under the invariant law for k = 3, to all digits of the formula sheet."""
    known = invariant_means(eps, 3, 1.0, 1.5)
    assert (known["x_1"], known["|x|^2"]) == pytest.approx(PULLED[eps], abs=DIGITS)


@pytest.mark.parametrize(("d", "value"), [(2, 0.674454805453), (3, 0.593766834992)])
def test_means_on_the_sphere_at_a_time_are_those_printed(d: int, value: float) -> None:
    """E cos theta after t = 1 from a right angle to the pull, pull = 1.5."""
    diffusion = on_the_sphere(d, 1.0, 1.5)
    assert diffusion.expectation(lambda u: u, 0.0, 1.0) == pytest.approx(value, abs=DIGITS)
    assert diffusion.mean(lambda u: u) == pytest.approx(invariant_means(0.0, d, 1.0, 1.5)["x_1"], rel=1e-12)


CASES: dict[str, dict[str, Any]] = {
    "free": {"eps": 0.025, "pull": 0.0},
    "damped and turning": {"eps": 0.025, "pull": 0.0, "damping": 2.0, "spin": 3.0},
    "limit": {"eps": 0.0, "pull": 0.0},
    "limit, turning": {"eps": 0.0, "pull": 0.0, "spin": 3.0},
    "limit, pulled": {"eps": 0.0, "pull": 1.5},
}


def by_semigroup(problem: ConstrainedLangevin, name: str, t: float) -> float:
    """Return an expectation by the exponential of the equation's generator in functions of the chart."""
    assert problem.chart is not None
    basis = chart_basis(problem.chart, 25, 24)
    here = basis.values(problem.chart.read(problem.initial(1)))[:, 0]
    coefficients = basis.project(observed(problem, name)(problem.chart.embed(basis.nodes)))
    return float(here @ expm(t * matrix(problem.ito(), problem.chart, basis)) @ coefficients)


@pytest.mark.parametrize("case", CASES)
def test_moments_are_those_of_the_semigroup(case: str) -> None:
    """Angle and log |x| know nothing of harmonic polynomials or of Cox, Ingersoll and Ross."""
    problem, t = penalised_sphere(**CASES[case]), 0.08
    moments = [truth for truth in problem.truths if isinstance(truth, Moment)]

    assert moments
    for moment in moments:
        # The basis is sharp to about 1e-9 for eps = 0.025, whose spread of log |x| is 0.1.
        assert moment.value(t) == pytest.approx(by_semigroup(problem, moment.observable, t), abs=1e-7)


def test_another_equation_has_another_semigroup() -> None:
    """The comparison sees a spin of 0.1 that the truth does not know of."""
    problem, other = penalised_sphere(0.025, pull=0.0), penalised_sphere(0.025, pull=0.0, spin=0.1)
    (first, *_) = [truth for truth in problem.truths if isinstance(truth, Moment)]

    assert abs(first.value(0.08) - by_semigroup(other, "x_1", 0.08)) > 1e-3


def around(eps: float, pull: float) -> tuple[Array, Array]:
    """Return points of the plane, and weights of |x|^(1 + 1/eps) exp(-|x|^2/(2 eps) + 2 pull x_1) there."""
    width = np.sqrt(0.5 * eps)
    r, theta = np.linspace(max(1e-3, 1.0 - 12 * width), 1.5 + 12 * width, 2000), 2 * np.pi * np.arange(64) / 64
    x = np.stack([np.outer(r, np.cos(theta)).ravel(), np.outer(r, np.sin(theta)).ravel()])
    radius = np.hypot(*x)
    log = (2.0 + 1.0 / eps) * np.log(radius) - radius**2 / (2.0 * eps) + 2.0 * pull * x[0]
    weights = np.exp(log - log.max())
    return x, weights / weights.sum()


@pytest.mark.parametrize("pull", [0.0, 1.0])
@pytest.mark.parametrize("eps", [0.02, 0.05])
def test_invariant_means_are_those_of_the_density(eps: float, pull: float) -> None:
    """Means are those of the density, and the generator's images have mean 0 under it."""
    problem, (x, weights) = penalised_sphere(eps, pull=pull), around(eps, pull)
    for truth in problem.truths:
        if isinstance(truth, InvariantMean):
            value = observed(problem, truth.observable)
            image = generator(problem, value, x)
            assert truth.value == pytest.approx(weights @ value(x), abs=1e-10)
            assert abs(weights @ image) <= SECOND_ERROR * (1.0 + weights @ np.abs(image))


def test_the_generator_notices_another_density() -> None:
    """The density of another pull is not invariant."""
    problem, (x, weights) = penalised_sphere(0.05, pull=1.0), around(0.05, 1.05)
    image = generator(problem, observed(problem, "x_1"), x)

    assert abs(weights @ image) > 1e-3


@pytest.mark.parametrize("eps", [1e-300, 1e300])
@pytest.mark.parametrize("pull", [0.0, 1.0])
def test_extreme_stiffness(eps: float, pull: float) -> None:
    """Truths are finite; where next to nothing holds a pulled solution, there are none."""
    problem = penalised_sphere(eps, pull=pull)

    assert bool(problem.truths) == (eps < 1.0 or not pull)
    for truth in problem.truths:
        assert np.isfinite(truth.value(0.1) if isinstance(truth, Moment) else truth.value)


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        ({"eps": -0.1}, "eps must be finite and not negative, got -0.1"),
        ({"eps": float("nan")}, "eps must be finite and not negative, got nan"),
        ({"d": 1}, "d must be at least 2, got 1"),
        ({"damping": -1.0}, "damping must be finite and not negative, got -1.0"),
        ({"pull": 1.0, "spin": 1.0}, "no closed form is known with pull and damping or spin"),
    ],
)
def test_bad_parameters_are_named(parameters: dict[str, Any], message: str) -> None:
    """One line says which parameter it is."""
    with pytest.raises(ParameterError, match=message):
        penalised_sphere(**parameters)
