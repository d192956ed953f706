"""The truths of every registered problem belong to this problem."""

from collections.abc import Callable

import numpy as np
import pytest
from numpy.polynomial import Chebyshev

from conformance.cells import Promise, draw
from conformance.differences import SECOND_ERROR, first, second
from sdaeverify.arrays import Array, Parts
from sdaeverify.forms import SDE, DelaySDAE, HolonomicSDAE, Problem
from sdaeverify.noise import Increment
from sdaeverify.numerics import apply
from sdaeverify.specs import ProblemSpec
from sdaeverify.truths import Moment

EPS = np.finfo(float).eps


def initial_parts(problem: Problem, paths: int = 1) -> Parts:
    return problem.parts(problem.initial(paths))


def flow(problem: Problem, x: Array) -> tuple[Array, Array]:
    """Return drift and diffusion of all named components at time 0, with the multiplier's where there is one."""
    if isinstance(problem, DelaySDAE):
        return delay_flow(problem)
    if not isinstance(problem, HolonomicSDAE):
        view = problem.view(SDE)
        return view.drift(0.0, x), np.broadcast_to(view.diffusion(0.0, x), (len(x), view.noise_dim, 1))
    n, view = problem.dimension, problem.view(SDE)
    r, v = x[:n], x[n : 2 * n]
    Dg, J = problem.dg(r), problem.linearised(r)
    kicks = problem.inverse_mass(np.broadcast_to(problem.diffusion(0.0, r, v), (n, problem.noise_dim, 1)))
    columns = [-J.gram(J).solve(apply(Dg, kick)) for kick in np.moveaxis(kicks, 1, 0)]
    rate = problem.inherent_multiplier(J, r, v, np.broadcast_to(problem.force(0.0, r, v), r.shape))
    drift = np.concatenate([view.drift(0.0, x[: 2 * n]), rate])
    return drift, np.concatenate([view.diffusion(0.0, x[: 2 * n]), np.stack(columns, axis=1)])


def delay_flow(problem: DelaySDAE) -> tuple[Array, Array]:
    """Return drift and diffusion of x and y at time 0, y being U(x, v) and v moving along the history."""
    start, v, e = problem.initial(1), problem.past(-problem.delay), 2.0**-10
    f = problem.drift(0.0, start.x, v, start.y)
    g = np.broadcast_to(problem.diffusion(0.0, start.x, v, start.y), (len(f), problem.noise_dim, 1))
    if not problem.constraints:
        return f, g

    def of_x(x: Array) -> Array:
        return problem.eliminated(0.0, x, v if problem.delay else x)

    columns = list(np.moveaxis(g, 1, 0))
    slope = first(of_x, start.x, f) + 0.5 * sum(second(of_x, start.x, column) for column in columns)
    if problem.delay:
        # The histories are affine.
        along = (problem.past(e - problem.delay) - v) / e
        slope = slope + first(lambda z: problem.eliminated(0.0, start.x, z), v, along)
    kicks = np.stack([first(of_x, start.x, column) for column in columns], axis=1)
    return np.concatenate([f, slope]), np.concatenate([g, kicks])


def observed(problem: Problem, name: str) -> Callable[[Array], Array]:
    """Return an observable at time 0 as a function of all components in one array."""
    sizes = {part: len(value) for part, value in initial_parts(problem).items()}
    ends = dict(zip(sizes, np.cumsum(list(sizes.values())), strict=True))

    def value(x: Array) -> Array:
        return problem.observables[name](0.0, {part: x[ends[part] - sizes[part] : ends[part]] for part in sizes})

    return value


def rate_at_the_start(moment: Moment, horizon: float) -> float:
    """Return the derivative at time 0, from an interpolation in the first part of the horizon.

    Expectations need not be analytic at time 0: what is singular at a distance r shows like e^{-r^2/(2t)}.
    """
    line = Chebyshev.interpolate(
        lambda times: np.array([moment.value(float(t)) for t in times]), 10, domain=[0.0, horizon / 32]
    )
    return float(line.deriv()(0.0))


def test_promised_moments_are_of_observables(promise: Promise) -> None:
    """A moment names one of the problem's observables, and has a source."""
    assert promise.moment.observable in promise.spec.build().observables
    assert promise.moment.source.strip()


def test_promised_moments_start_at_the_initial_state(promise: Promise) -> None:
    """At time 0 the expectation is the observable's value."""
    problem = promise.spec.build()
    value = problem.observables[promise.moment.observable](0.0, initial_parts(problem))

    assert promise.moment.value(0.0) == pytest.approx(value[0], rel=16 * EPS, abs=16 * EPS)


def test_promised_moments_are_finite_numbers(promise: Promise) -> None:
    """At every time of the horizon the expectation is one finite number."""
    for t in np.linspace(0.0, promise.spec.build().horizon, 9):
        value = promise.moment.value(float(t))
        assert np.ndim(value) == 0
        assert np.isfinite(value)


def test_promised_moments_start_with_the_rate_of_the_generator(promise: Promise) -> None:
    """At time 0 the expectation of an observable q changes at the rate Dq f + (1/2) sum_j D^2 q(B_j, B_j).

    The interpolated derivative at an end is wrong by at most the sum of squares 10 * 21 / 6 of the Chebyshev
    derivatives there, times 2 / (T/64), times the rounding errors of the values.
    """
    problem = promise.spec.build()
    q = observed(problem, promise.moment.observable)
    x = np.concatenate(list(initial_parts(problem).values()))
    drift, diffusion = flow(problem, x)
    rate = first(q, x, drift) + 0.5 * sum(second(q, x, B) for B in np.moveaxis(diffusion, 1, 0))
    size = 1.0 + abs(float(rate[0])) + abs(promise.moment.value(problem.horizon))

    assert rate[0] == pytest.approx(
        rate_at_the_start(promise.moment, problem.horizon), abs=(SECOND_ERROR + 1e5 * EPS) * size
    )


def test_a_solution_starts_at_the_initial_state(solved: ProblemSpec) -> None:
    """The truth on a path knows components of the problem, and has them right at time 0."""
    problem = solved.build()
    assert problem.pathwise is not None
    known = problem.pathwise.parts(0.0, problem.pathwise.start(3))
    start = initial_parts(problem, 3)

    assert known
    assert known.keys() <= start.keys()
    for name, value in known.items():
        assert value.shape == start[name].shape
        assert np.all(np.abs(value - start[name]) <= 4 * EPS * np.maximum(1.0, np.abs(start[name])))


@pytest.mark.parametrize("paths", [1, 3])
def test_a_solution_goes_on_as_it_began(solved: ProblemSpec, paths: int) -> None:
    """A step of the truth keeps its shape and leaves its inputs alone."""
    problem = solved.build()
    truth, h = problem.pathwise, problem.horizon / 8
    assert truth is not None
    z, noise = truth.start(paths), draw(problem.noise_dim, paths, h)
    noise = noise._replace(xi=np.ones((truth.extra_normals, paths)) if truth.extra_normals else None)
    before = z.copy(), noise.dW.copy(), noise.H.copy()

    new = truth.advance(z, 0.0, h, noise)

    assert new.shape == z.shape
    assert np.isfinite(new).all()
    assert all(np.array_equal(a, b) for a, b in zip((z, noise.dW, noise.H), before, strict=True))


def test_a_solution_stands_still_without_time_and_noise(solved: ProblemSpec) -> None:
    """A step of no length changes nothing."""
    problem = solved.build()
    truth, none = problem.pathwise, np.zeros((problem.noise_dim, 1))
    assert truth is not None
    z = truth.start(1)

    extra = np.ones((truth.extra_normals, 1)) if truth.extra_normals else None
    assert np.array_equal(truth.advance(z, 0.0, 0.0, Increment(none, none, extra)), z)
