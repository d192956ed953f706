"""The base of bridges, with NumPy in the place of another library."""

from pathlib import Path
from typing import ClassVar

import numpy as np
import pytest

from bridges.equations import curved
from facade import EulerMaruyama, MissingLibraryError, gbm, noncommuting, ou
from sdaeverify import SDE, Increment
from sdaeverify_bridges.kit import Bridge, Coefficients, Library, stratonovich_drift, why_not_bridged

COMPILED = []
NOISE = Increment(np.array([[0.3, -0.7, 0.0]]), np.array([[0.1, 0.2, -0.1]]))


class Bridged(Bridge):
    """Euler-Maruyama, as if of a library."""

    name: ClassVar[str] = "bridged"
    library: ClassVar[Library] = Library("numpy", np.__version__, "")

    def compiled(self, problem):
        COMPILED.append(problem)
        equation = Coefficients(problem, np)

        def step(x, t, h, dW):
            return x + h * equation.drift(t, x) + np.einsum("dlp,lp->dp", equation.diffusion(t, x), dW)

        return step


@pytest.mark.parametrize("family", [gbm, ou, curved], ids=lambda family: family.__name__)
def test_step_is_that_of_the_library(family):
    """The library sees the problem's formulas and the increment of the step."""
    x = np.array([[1.0, -2.0, 0.5]])

    found, expected = (s.step(family(), x, 0.5, 0.25, NOISE).state for s in (Bridged(), EulerMaruyama()))
    np.testing.assert_allclose(found, expected, rtol=1e-15)


def test_step_is_compiled_once():
    """Neither another step size, nor a problem that was built anew, nor another number of paths compiles it again."""
    COMPILED.clear()
    for rate, h, paths in ((3.0, 0.25, 3), (3.0, 0.125, 3), (3.0, 0.25, 2), (4.0, 0.25, 3)):
        problem = curved(rate)
        Bridged().prepare(problem, h)(problem.initial(paths), 0.0, Increment(NOISE.dW[:, :paths], None))

    assert len(COMPILED) == 2


def test_stratonovich_drift_of_growth():
    """For dx = a x dt + b x dW it is (a - b^2/2) x."""
    x = np.array([[1.0, -2.0]])

    np.testing.assert_allclose(stratonovich_drift(gbm(0.5, 0.6), 0.0, x), (0.5 - 0.18) * x, rtol=1e-15)


def test_stratonovich_drift_of_several_noises():
    """For dx = A x dt + sum B_j x dW_j it is (A - sum B_j^2/2) x."""
    problem, x = noncommuting(), np.array([[1.0, 0.0], [0.0, 1.0]])
    B = problem.diffusion(0.0, x)
    squares = sum(B[:, j] @ B[:, j] for j in (0, 1))

    np.testing.assert_allclose(
        Coefficients(problem, np, stratonovich=True).drift(0.0, x),
        problem.drift(0.0, x) - 0.5 * squares,
        rtol=1e-14,
    )


def equation(drift):
    """Return an equation with a drift."""
    return SDE(
        drift=drift,
        diffusion=lambda t, x: x[:, None],
        start=[1.0],
        noise_dim=1,
        horizon=1.0,
        source="a test",
    )


@pytest.mark.parametrize(
    ("drift", "reason"),
    [
        (lambda t, x: -np.asarray(x), "its drift works on NumPy arrays only: TypeError: makes a NumPy array"),
        (lambda t, x: -x if x[0, 0] > 0.0 else x, "its drift works on NumPy arrays only: TypeError: branches"),
        (lambda t, x: -x * float(t), "its drift works on NumPy arrays only: TypeError"),
    ],
    ids=["array", "branch", "float"],
)
def test_formula_for_numpy_alone_is_a_reason(drift, reason):
    """A problem whose formulas another library cannot run is refused, and the reason says which and why."""
    assert why_not_bridged(equation(drift)).startswith(reason)
    assert Bridged().refuses(equation(drift)).startswith(reason)


def test_formula_with_functions_of_numpy_is_none():
    """Other formulas are no reason."""
    assert not why_not_bridged(curved(), stratonovich=True)


def test_diffusion_without_derivative_has_no_stratonovich_drift():
    """A solver of Stratonovich equations refuses it."""
    problem = SDE(
        drift=lambda t, x: -x,
        diffusion=lambda t, x: np.abs(x)[:, None],
        start=[1.0],
        noise_dim=1,
        horizon=1.0,
        source="a test",
    )

    assert "not analytic" in why_not_bridged(problem, stratonovich=True)
    assert not why_not_bridged(problem)


def test_missing_library_says_what_to_install():
    """The plugin of a library that is not there cannot be loaded, and the reason helps."""
    library = Library.find("a_library_that_is_not_there", extra="missing")

    with pytest.raises(MissingLibraryError, match=r"is not installed; pip install 'sdaeverify\[missing\]'"):
        library.require()
    assert str(library) == "a_library_that_is_not_there not installed"


def test_library_that_is_there_is_named_with_its_version():
    """Its version goes into what determines evidence."""
    library = Library.find("numpy")

    library.require()
    assert str(library) == f"numpy {np.__version__}"


def test_the_page_of_bridges_names_what_no_bridge_sees():
    """Its first section says that a driver loop outside of any step is not seen."""
    page = (Path(__file__).parents[2] / "docs" / "how-to" / "bridge.md").read_text(encoding="utf-8")
    shipped = " ".join(page.split("## Write a bridge")[0].split())

    assert "A bridge calls one step of a solver. A driver loop outside of any step is not seen:" in shipped
