"""Problems on which terms show that vanish on all others: the terms are there, and the truths are right."""

from itertools import combinations

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp

from facade import SRI1W1, delay_growing, four_motions, growing_algebraic, product_force, three_motions, turning_frame
from sdaeverify import SDE, Array, Increment, Moment, Problem

CONSTRAINED = {"delay": delay_growing, "no delay": growing_algebraic}


def known(problem: Problem, name: str, t: float) -> float:
    """Return the known expectation of an observable."""
    (moment,) = (truth for truth in problem.truths if isinstance(truth, Moment) and truth.observable == name)
    return moment.value(t)


def matrices(problem: SDE, t: float) -> tuple[Array, Array]:
    """Return A, shape (2, 2), and all B_j, shape (l, 2, 2), of a linear system in the plane."""
    unit = np.eye(2)
    return problem.drift(t, unit), np.moveaxis(problem.diffusion(t, unit), 1, 0)


def change(f: np.ndarray, g: np.ndarray) -> float:
    """Return by how much two values differ, in parts of the first."""
    return float(np.abs(g - f).max() / np.abs(f).max())


@pytest.mark.parametrize("omega", [1.0, -2.5])
def test_moments_in_a_turning_frame_solve_their_equations(omega: float) -> None:
    """E x and E x x^T solve the linear equations whose matrices are read from the problem at each time."""
    problem = turning_frame(omega, 0.8, -0.3)

    def rates(t: float, m: Array) -> Array:
        A, B = matrices(problem, t)
        P = m[2:].reshape(2, 2)
        return np.concatenate([A @ m[:2], (A @ P + P @ A.T + sum(b @ P @ b.T for b in B)).ravel()])

    start = problem.initial(1)[:, 0]
    moments = solve_ivp(rates, (0.0, 1.3), [*start, *np.outer(start, start).ravel()], rtol=1e-11, atol=1e-13).y[:, -1]
    for name, value in zip(("x_1", "x_2", "x_1^2", "x_1 x_2", "x_1 x_2", "x_2^2"), moments, strict=True):
        assert known(problem, name, 1.3) == pytest.approx(value, rel=1e-8)


def test_the_second_moment_with_a_delay_solves_its_equation() -> None:
    """M = E x^2 obeys M' = 2 a M + b(t)^2 M(t - tau), interval by interval, and its integral from 0 on is right."""
    a, b, growth, tau = -0.7, 0.9, 1.1, 0.6
    problem = delay_growing(a, b, growth, tau, horizon=2.0)

    def rate(t: float) -> float:
        past = np.exp(2.0 * a * (t - tau)) if t <= tau else known(problem, "x^2", t - tau)
        return 2.0 * a * known(problem, "x^2", t) + (b * (1.0 + growth * t)) ** 2 * past

    for begin, end in ((0.0, 0.6), (0.6, 1.2), (1.2, 1.7)):
        first = 1.0 if begin == 0.0 else known(problem, "x^2", begin)
        assert known(problem, "x^2", end) - first == pytest.approx(quad(rate, begin, end, epsabs=1e-13)[0], rel=1e-9)


def test_the_solution_with_a_moving_constraint_is_that_of_its_equation() -> None:
    """On a short step the known solution agrees with a step of strong order 3/2 up to terms of order h^2."""
    problem, z = growing_algebraic(), np.random.default_rng(4).standard_normal((2, 1, 200))
    sde, x, rest = problem.view(SDE), np.full((1, 200), 1.7), []
    for h in (1e-2, 1e-4):
        noise = Increment(np.sqrt(h) * z[0], np.sqrt(h / 12.0) * z[1])
        new = SRI1W1().step(sde, x, 0.3, h, noise).state
        rest.append(np.abs(problem.pathwise.advance(x, 0.3, h, noise) - new).max())
    assert np.log(rest[0] / rest[1]) / np.log(100.0) > 1.9


def test_all_coefficients_turn_with_the_frame() -> None:
    """f(t), b_1(t) and b_2(t) are not 0, and the two noises do not commute."""
    problem = turning_frame()
    x = problem.initial(1)
    for coefficient in (problem.drift, *(lambda t, x, j=j: problem.diffusion(t, x)[:, j] for j in (0, 1))):
        assert change(coefficient(0.5, x), coefficient(0.6, x)) > 0.05
    _, (B_1, B_2) = matrices(problem, 0.5)
    assert np.abs(B_1 @ B_2 - B_2 @ B_1).max() > 0.05


def test_brackets_of_three_motions_are_independent() -> None:
    """No area of a pair can stand in for that of another."""
    _, B = matrices(three_motions(), 0.0)
    brackets = [(B[j] @ B[k] - B[k] @ B[j]).ravel() for j, k in combinations(range(3), 2)]
    assert np.linalg.svd(brackets, compute_uv=False).min() > 0.01


def test_two_pairs_of_four_motions_have_brackets_at_the_start() -> None:
    """The areas of the motions 1 and 2 move the state, and so do those of 3 and 4: the second moment has both."""
    problem = four_motions()
    _, B = matrices(problem, 0.0)
    x = problem.initial(1)[:, 0]
    first, second = ((B[j] @ B[k] - B[k] @ B[j]) @ x for j, k in ((0, 1), (2, 3)))
    assert np.abs(np.outer(first, second) + np.outer(second, first)).max() > 1e-3


def test_the_drift_bends_along_two_motions() -> None:
    """f(b_1, b_2) is (0, 0, c s^2)."""
    problem = product_force(c=3.0, s=0.5)
    x, B = problem.initial(1), problem.diffusion(0.0, problem.initial(1))

    def f(u: float, v: float) -> Array:
        return problem.drift(0.0, x + u * B[:, 0] + v * B[:, 1])[:, 0]

    mixed = (f(1.0, 1.0) - f(1.0, -1.0) - f(-1.0, 1.0) + f(-1.0, -1.0)) / 4.0
    np.testing.assert_allclose(mixed, [0.0, 0.0, 0.75], atol=1e-13)


@pytest.mark.parametrize("name", CONSTRAINED)
def test_the_constraint_moves(name: str) -> None:
    """At the same x and past, y is another one a little later."""
    problem, x = CONSTRAINED[name](), np.ones((1, 1))
    assert change(problem.eliminated(0.5, x, x), problem.eliminated(0.6, x, x)) > 0.01
