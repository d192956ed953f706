"""Algorithms of sdeint as schemes; skipped where it is not installed."""

import numpy as np
import pytest

from bridges.equations import PATHS, H, curved, drawn, shifted
from facade import hyperbolic_pair, noncommuting
from sdaeverify import Increment
from sdaeverify_bridges.kit import Coefficients
from sdaeverify_bridges.sdeint import SDEInt

pytest.importorskip("sdeint", reason="needs the extra: pip install .[sdeint]")


@pytest.mark.parametrize("algorithm", ["itoSRI2", "stratSRS2"])
@pytest.mark.parametrize("family", [curved, hyperbolic_pair, noncommuting], ids=lambda family: family.__name__)
def test_paths_at_once_are_paths_one_by_one(algorithm, family):
    """Rows of paths in the place of numbers give what sdeint gives for one path, with numbers."""
    import sdeint  # noqa: PLC0415 - it may be missing

    problem, scheme = family(), SDEInt(algorithm, areas=True)
    x = shifted(problem)
    l = problem.noise_dim
    noise = drawn(problem, H, PATHS)._replace(A=np.full((l * (l - 1) // 2, PATHS), 0.1))
    found = scheme.step(problem, x, 0.5, H, noise).state

    name, shift = ("J", 0.5 * H) if scheme.stratonovich else ("I", 0.0)
    integrals = noise.double_integrals(H) + shift * np.eye(l)[..., None]
    equation = Coefficients(problem, np, scheme.stratonovich)

    def drift(y, t):
        return equation.drift(t, y[:, None])[:, 0]

    def diffusion(y, t):
        return equation.diffusion(t, y[:, None])[..., 0]

    for path in range(PATHS):
        given = {"dW": noise.dW[None, :, path], name: integrals[None, ..., path]}
        alone = getattr(sdeint, algorithm)(drift, diffusion, x[:, path], np.array([0.5, 0.5 + H]), **given)[-1]
        np.testing.assert_allclose(found[:, path], alone, rtol=1e-13)


def test_areas_that_are_not_there_are_refused():
    """Without areas an algorithm is for noise that needs none; with them it asks for them."""
    assert SDEInt("itoSRI2").refuses(noncommuting())
    assert not SDEInt("itoSRI2").refuses(hyperbolic_pair())
    assert SDEInt("itoSRI2", areas=True).noise == {"dW", "A"}


def test_one_brownian_motion_needs_no_areas():
    """With and without them the step is the same."""
    problem, noise = curved(), Increment(np.array([[0.3, -0.2]]), None)
    x = problem.initial(2)

    one, other = (SDEInt("itoSRI2", areas=areas).step(problem, x, 0.0, H, noise).state for areas in (False, True))
    np.testing.assert_array_equal(one, other)
