"""Sufficient conditions of mean-square stability: printed constants, no random equation or scheme against them."""

import numpy as np
import pytest

from facade import delay_test
from probe.theta_cells import SETS, Linear, is_stable
from sdaeverify import Dissipation

# In parts of a bound; where there is none, in parts of the delay.
BELOW = (0.1, 0.6, 1.0 - 1e-6)
ANY = (0.01, 0.3, 3.0, 100.0)


def random_cell(rng: np.random.Generator) -> Linear:
    """Return a test equation with C > 0, by a margin between a thousandth and ten times what has to be outweighed."""
    b, c, d, l, q = rng.standard_normal(5) * rng.exponential(1.0, 5) * (rng.random(5) < 0.7)
    load = abs(b) + abs(l) + abs(q) + 0.5 * (abs(c) + abs(d)) ** 2
    return Linear(-(load + 0.1) * (1.0 + 10.0 ** rng.uniform(-3.0, 1.0)), b, c, d, l, q)


def sweep(count: int, seed: int, widened: float = 1.0) -> tuple[int, int]:
    """Return in how many of so many random equations the theorem on the equation, and those on schemes, fail."""
    rng = np.random.default_rng(seed)
    equations = schemes = 0
    for _ in range(count):
        cell, theta = random_cell(rng), rng.choice([0.0, rng.uniform(0.0, 0.5), rng.uniform(0.5, 1.0), 1.0])
        assert cell.dissipation.C > 0.0
        equations += cell.equation.stable is not True
        bounds = cell.dissipation.largest_step(theta), widened * cell.dissipation.sharp_step(theta)
        sizes = {part * bound for bound in bounds if bound < np.inf for part in BELOW}
        sizes |= set(ANY) if bounds[1] == np.inf else set()
        schemes += any(is_stable(cell.step(theta, h), cell.mesh(h)) is not True for h in sizes)
    return equations, schemes


@pytest.mark.parametrize(
    ("name", "C"), [("I", 1.0), ("II", -4.0), ("III", -24.2), ("IV", 7.0), ("V", -9.0), ("VI", 2.6)]
)
def test_margins_of_the_six_sets(name: str, C: float) -> None:
    """-2a - 2|b| - (|c| + |d|)^2 - 2(|q| + |l|), which is lam0 - lam1."""
    found = SETS[name].dissipation
    a, b, c, d, l, q, _ = SETS[name]
    assert pytest.approx(-2.0 * a - 2.0 * abs(b) - (abs(c) + abs(d)) ** 2 - 2.0 * (abs(q) + abs(l))) == C
    assert pytest.approx(C, abs=1e-13) == found.C


def test_bounds_of_the_step_size() -> None:
    """Printed h_0 of sets IV and VI; without (4.1) nothing is promised, for theta = 1 everything."""
    assert SETS["IV"].dissipation.largest_step(0.0) == pytest.approx(0.0389, abs=0.5e-4)
    assert SETS["VI"].dissipation.largest_step(0.5) == pytest.approx(0.1967, abs=0.5e-4)
    assert SETS["IV"].dissipation.largest_step(1.0) == np.inf
    assert SETS["IV"].dissipation.sharp_step(0.5) == np.inf
    assert SETS["II"].dissipation.largest_step(1.0) == SETS["II"].dissipation.sharp_step(0.5) == 0.0


def test_all_constants_enter() -> None:
    """With every constant its own prime: lam0, lam1, C and K by hand."""
    found = Dissipation(2000.0, 2.0, 3.0, 5.0, 7.0, 11.0, 0.5, 2.0, 3.0, 5.0)
    assert found.lam0 == 4000.0 - 3.0 - 7.0 - 60.0 - 50.0 - 36.0
    assert found.lam1 == 3.0 + 11.0 + 50.0 + 100.0
    assert found.C == 4000.0 - 6.0 - 7.0 - 11.0 - 160.0 - 136.0
    assert (found.K1, found.K2) == (32.0, 53.0)
    assert found.largest_step(0.5) == pytest.approx(found.C / (0.5 * (32.0**2 + 53.0**2)))
    assert found.sharp_step(0.25) == pytest.approx(found.C / (0.5 * 85.0**2))


def test_eliminating_y_keeps_what_the_constants_promise() -> None:
    """Of random constants, C, K1 and K2 are those of the equation with y; be2 counts for x and v."""
    for k in np.random.default_rng(4).exponential(1.0, (20, 10)):
        found = Dissipation(*k)
        plain = found.without_y
        np.testing.assert_allclose((plain.C, plain.K1, plain.K2), (found.C, found.K1, found.K2), rtol=1e-12)
        assert (plain.al2, plain.be2) == (0.0, 0.0)


def test_set_iii_is_dissipative_with_y_eliminated() -> None:
    """C = 22 - 2.2 - 4 = 15.8 in place of -24.2, and below its bounds steps on the linear equation are stable."""
    known = delay_test("III").without_y().dissipation
    assert known is not None
    assert pytest.approx(15.8) == known.C
    assert known.sharp_step(0.0) == pytest.approx(15.8 / 12.1**2)
    cell = SETS["III"]
    sizes = {theta: min(known.sharp_step(theta), 100.0) for theta in (0.0, 0.2, 0.5, 1.0)}
    assert all(
        is_stable(cell.step(theta, part * h), cell.mesh(part * h)) for theta, h in sizes.items() for part in BELOW
    )


@pytest.mark.parametrize("theta", [0.0, 0.3])
def test_the_sharpened_bound_is_attained(theta: float) -> None:
    """Dx = a x dt + c x dW is stable a millionth below it and unstable a millionth above."""
    cell = Linear(-2.0, 0.0, 1.0, 0.0)
    bound = cell.dissipation._replace(al2=0.0).sharp_step(theta)
    for h, stable in ((bound * (1.0 - 1e-6), True), (bound * (1.0 + 1e-6), False)):
        assert is_stable(cell.step(theta, h), cell.mesh(h)) is stable


def test_random_equations_and_schemes_obey_the_theorems() -> None:
    """Below both bounds and, from theta = 1/2 on, at any step size, shorter or longer than the delay."""
    assert sweep(12, seed=2) == (0, 0)


def test_a_bound_that_is_too_large_is_refuted() -> None:
    """The sharpened bound times 3 fails somewhere on the same kind of sets."""
    assert sweep(12, seed=2, widened=3.0)[1] > 0
