"""Dynamics around the sphere: printed values, the semigroup of the equation on a chart, and the invariant density."""

import pytest

from sdaeverify_problems.spheres._pulled_law import invariant_means, on_the_sphere
from sdaeverify_problems.spheres._radial_law import RadialLaw

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
