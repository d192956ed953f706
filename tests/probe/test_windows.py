"""Windows of stable step sizes: boundaries in closed form, windows that are no interval, and what is not decided."""

import numpy as np
import pytest

from facade import (
    EulerMaruyama,
    Milstein,
    StabilityRecord,
    StochasticTheta,
    brackets,
    crossings,
    describe_windows,
    find_undecided,
    linear_test,
    signs,
    smallest_boundary,
    stable_windows,
    why_not_stability,
)
from facade import stability_stability as stability
from probe import linear_cells as c
from sdaeverify import SDE, Array, Increment, Scheme
from sdaeverify.measuring import packed, unpacked

INF = float("inf")
EQUATIONS = ((-10.0, 2.0), (-2.0, 1.0), (-1.0, 0.5), (-4.0, 2.5))


def found(scheme: Scheme, problem: SDE, *sizes: float) -> StabilityRecord:
    """Return the evidence after it was stored."""
    view = problem.view(scheme.form)
    assert view is not None
    assert why_not_stability(scheme, view) == ""
    record = unpacked("stability", StabilityRecord, packed("stability", stability(scheme, view, sizes)))
    assert record is not None
    return record


# The fast tests try each theta on one equation, in turn.
THETAS = [0.0, 0.25, 0.4, 0.49, 0.499]
PAIRS = [
    pytest.param(theta, a, b, marks=() if (i + j) % len(EQUATIONS) == 0 else pytest.mark.long)
    for i, theta in enumerate(THETAS)
    for j, (a, b) in enumerate(EQUATIONS)
]


@pytest.mark.sweep
@pytest.mark.parametrize(("theta", "a", "b"), PAIRS)
def test_the_theta_method_is_stable_up_to_its_boundary(theta: float, a: float, b: float) -> None:
    """Stable for h < -(2a + b^2)/(a^2 (1 - 2 theta)) and for no other h; theta = .499 is told from 1/2."""
    record = found(StochasticTheta(theta=theta), linear_test(a, b))
    ((low, high),) = record.windows
    assert low == 0.0
    assert high == pytest.approx(-(2 * a + b * b) / (a * a * (1 - 2 * theta)), rel=1e-12)


@pytest.mark.sweep
@pytest.mark.parametrize(("a", "b"), EQUATIONS)
@pytest.mark.parametrize("theta", [0.5, 1.0])
def test_the_theta_method_is_stable_everywhere_from_one_half_on(a: float, b: float, theta: float) -> None:
    """No boundary between 1e-3 and 1e3."""
    record = found(StochasticTheta(theta=theta), linear_test(a, b))
    assert record.windows == [(0.0, INF)]
    assert describe_windows(record.windows) == "all h"
    assert record.scan.h[0] <= 1e-3
    assert record.scan.h[-1] >= 1e3 * (1.0 - 1e-12)


@pytest.mark.sweep
@pytest.mark.parametrize(("a", "b"), EQUATIONS)
def test_milstein_is_stable_up_to_its_boundary(a: float, b: float) -> None:
    """Stable for h < -(2a + b^2)/(a^2 + b^4/2)."""
    ((low, high),) = found(Milstein(), linear_test(a, b)).windows
    assert low == 0.0
    assert high == pytest.approx(-(2 * a + b * b) / (a * a + 0.5 * b**4), rel=1e-12)


def test_all_windows_are_reported() -> None:
    """A step that is stable for h < 1/2 and for 2 < h < 3."""
    record = found(c.Formula(c.two_windows), c.linear(-1.0, [0.5]))
    assert record.boundaries == pytest.approx([0.5, 2.0, 3.0], rel=1e-12)
    assert record.windows == [(0.0, record.boundaries[0]), tuple(record.boundaries[1:])]
    assert describe_windows(record.windows) == "h < 0.5; 2 < h < 3"
    assert smallest_boundary(record.windows) == record.boundaries[0]


def test_slow_and_fast_equations_are_scanned_in_their_own_time() -> None:
    """Rates of 1e6 and of 1e-6 move the boundary to 7.5e-7 and to 7.5e5."""
    for rate in (1e6, 1e-6):
        ((_, high),) = found(EulerMaruyama(), linear_test(-2.0 * rate, float(np.sqrt(rate)))).windows
        assert high == pytest.approx(0.75 / rate, rel=1e-12)


def test_all_memory_of_a_two_step_scheme_counts_and_what_nothing_depends_on_does_not() -> None:
    """Adams-Bashforth is stable for h |a| < 1; the growing random walk beside it is not seen."""
    record = found(c.AdamsBashforth(), c.linear(-2.0, [0.0]), 0.1)
    assert record.boundaries == pytest.approx([0.5], rel=1e-12)
    # The larger root of z^2 - (1 - 3/10) z - 1/10.
    assert record.run.rho == pytest.approx([(0.35 + np.sqrt(0.35**2 + 0.1)) ** 2], rel=1e-12)


def test_a_scheme_that_loses_its_root_or_has_a_pole_is_not_decided_there() -> None:
    """Neither counts as stable."""
    record = found(c.Formula(c.implicit_in_noise), c.linear(-3.0, [1.0]))
    infinite = np.isfinite(record.scan.pole)
    assert infinite[5:].all()
    assert (record.scan.sign[infinite] == 0).all()
    assert smallest_boundary(record.windows) <= record.scan.h[infinite][0]


def test_growth_by_rare_noise_is_not_taken_for_stability() -> None:
    """The exact step of growth: E x^2 grows like exp(h/4), while long steps shrink all likely paths."""
    record = found(c.exact_growth(-1.0, 1.5), c.linear(-1.0, [1.5]), 100.0)
    assert record.windows == []
    assert record.run.rho[0] < 1e-20
    # What is left out is the second moment itself.
    assert record.run.error[0] == pytest.approx(np.exp(25.0), rel=1e-10)
    assert (record.scan.sign[record.scan.h < 5.0] == 1).all()


def rotation(problem: SDE, x: Array, h: float, noise: Increment) -> Array:
    turn = np.array([[1.0, 0.5 * h], [-0.5 * h, 1.0]])
    return np.linalg.solve(turn.T, turn @ x)


def test_a_conservative_scheme_is_marginal_everywhere() -> None:
    """The midpoint rule on a rotation has rho = 1: neither stable nor unstable."""
    record = found(c.Formula(rotation), c.linear([[0.0, 1.0], [-1.0, 0.0]], [np.zeros((2, 2))]))
    assert (record.scan.sign == 0).all()
    assert len(find_undecided(record.scan.sign)) == len(record.scan.h)
    assert describe_windows(record.windows) == "none"


def test_signs_need_ten_times_the_error() -> None:
    """And at least 1e-9."""
    rho = np.array([0.5, 1.0 - 5e-10, 1.0 + 2e-9, 0.99, 0.99])
    assert signs(rho, np.array([0.0, 0.0, 0.0, 0.002, 0.0005])).tolist() == [-1, 0, 1, 0, -1]


def test_a_crossing_on_the_grid_is_a_crossing_and_a_wide_gap_is_none() -> None:
    """One undecided place between two signs is a boundary; two of them, or one between equal signs, stay open."""
    h, sign = np.array([1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0]), np.array([-1, 0, 1, 0, 1, 0, 0])
    assert brackets(sign) == [(0, 2)]
    assert find_undecided(sign).tolist() == [3, 5, 6]
    roots = crossings(lambda size: size / 2.0, h, sign)
    assert roots == pytest.approx([2.0], rel=1e-14)
    assert stable_windows(h, sign, roots) == [(0.0, roots[0])]

    gap = np.array([-1, -1, 0, 0, 1, 1, -1])
    assert brackets(gap) == [(5, 6)]
    assert stable_windows(h, gap, np.array([50.0])) == [(0.0, 2.0), (50.0, INF)]
    assert describe_windows(stable_windows(h, gap, np.array([50.0]))) == "h < 2; h > 50"


def test_crossings_pass_over_radii_that_are_zero_infinite_or_unknown() -> None:
    """The logarithm of 0, and of what overflows, does not stop the search."""

    def radius(size: float) -> float:
        return 0.0 if size < 1.9 else INF if size > 3.0 else float("nan") if size > 2.5 else size / 2.0

    roots = crossings(radius, np.array([1.0, 4.0]), np.array([-1, 1]))
    assert roots == pytest.approx([2.0], abs=0.1)


def test_a_jump_at_a_step_size_of_the_scan_is_a_crossing() -> None:
    """A step whose lag is rounded to the mesh jumps at parts of the delay; e^(log .1) is not .1."""
    h = np.array([0.05, 0.1, 0.2])

    found = crossings(lambda size: 0.5 if size <= 0.1 else 2.0, h, np.array([-1, -1, 1]))

    assert found == pytest.approx([0.1], rel=1e-14)
