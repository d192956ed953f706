"""The projection-based Euler schemes against closed forms, an independent solver and what their source reports."""

from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
import pytest
from scipy.optimize import root

from schemes.local_order import strong_order
from sdaeverify import SDE, HolonomicSDAE, HolonomicState, Increment, ParameterError, Scheme
from sdaeverify.arrays import Array
from sdaeverify.contracts.scheme import Step
from sdaeverify.probe.local.weak_defects import local_weak
from sdaeverify.probe.local.weak_order import weak_order
from sdaeverify_problems import _circle as circle
from sdaeverify_problems.damped_pendulum import damped_pendulum
from sdaeverify_problems.fibre_clamped import fibre_clamped
from sdaeverify_problems.fibre_free import fibre_free
from sdaeverify_problems.pendulum import pendulum
from sdaeverify_problems.pendulum_velocity_noise import pendulum_velocity_noise
from sdaeverify_schemes._new_normals import NORMALS, onto_constraint
from sdaeverify_schemes.euler_maruyama import EulerMaruyama
from sdaeverify_schemes.explicit_projection_euler import ExplicitProjectionEuler
from sdaeverify_schemes.semi_implicit_projection_euler import SemiImplicitProjectionEuler

EPS = np.finfo(float).eps
T = 0.3
EXPLICIT, OLD, NEW = ExplicitProjectionEuler(), SemiImplicitProjectionEuler(), SemiImplicitProjectionEuler("new")
ALL = pytest.mark.parametrize("scheme", [EXPLICIT, OLD, NEW], ids=lambda scheme: scheme.label)


def move(scheme: Scheme, problem: HolonomicSDAE, state: HolonomicState, h: float, dW: Array) -> Step:
    """Make one step from time T; paths without root may divide by zero, as they may in a run."""
    with np.errstate(all="ignore"):
        return scheme.prepare(problem, h)(scheme.enter(problem, state, T, h), T, Increment(dW, None))


class Angles(NamedTuple):
    """One step on the circle."""

    theta: Array
    omega: Array
    impulse: Array


def closed_form(scheme: Scheme, start: Angles, c_g: float, h: float, dW: Array) -> Angles:
    """Return the step in angle form: theta+ = theta + phi with tan(phi) = h omega.

    The velocity before its projection is v + h a + dW - l^ r, with l^ = <r, h a + dW> + h omega^2 for the explicit
    scheme, and <r, dW> or 0 for the semi-implicit one. Of this, omega+ = <t+, .> and l = <r+, .>.
    """
    theta, omega = start.theta, start.omega
    r, t = circle.normal(theta), circle.tangent(theta)
    end = theta + np.arctan(h * omega)
    gravity = np.array([[0.0], [-h * c_g]])
    first = 0.0 * theta
    if scheme == EXPLICIT:
        first = (r * (gravity + dW)).sum(axis=0) + h * omega**2
    elif scheme == OLD:
        first = (r * dW).sum(axis=0)
    x = omega * t + gravity + dW - first * r
    new_r, new_t = circle.normal(end), circle.tangent(end)
    return Angles(end, (x * new_t).sum(axis=0), first + (x * new_r).sum(axis=0))


@ALL
@pytest.mark.parametrize("h", [1e-5, 1e-2, 0.3, 1.0])
def test_a_step_on_the_circle_has_a_closed_form(scheme: Scheme, h: float) -> None:
    """Position, velocity, multiplier and eta = sqrt(1 + (h omega)^2) - 1 are those of the angle form."""
    rng = np.random.default_rng(12)
    omega = np.linspace(-4.0, 4.0, 41)
    start = Angles(rng.uniform(-3, 3, 41), omega, rng.standard_normal(41))
    dW = np.sqrt(h) * rng.standard_normal((2, 41))
    state = HolonomicState(circle.normal(start.theta), omega * circle.tangent(start.theta), start.impulse[None])

    step = move(scheme, pendulum(), state, h, dW)
    expected = closed_form(scheme, start, 1.0, h, dW)

    # Rounding is amplified by the factor eta of the last update in tangential directions.
    error = 64 * EPS * (1.0 + np.abs(h * omega)) ** 2 * (1.0 + np.abs(expected.impulse) + np.abs(expected.omega))
    assert not step.failed.any()
    assert np.all(np.abs(step.state.r - circle.normal(expected.theta)) <= error)
    assert np.all(np.abs(step.state.v - expected.omega * circle.tangent(expected.theta)) <= error)
    assert np.all(np.abs(step.state.mu[0] - start.impulse - expected.impulse) <= error)
    assert np.all(np.abs(step.outputs["eta"][0] - (np.hypot(1.0, h * omega) - 1.0)) <= error)


def test_the_explicit_scheme_heats_up() -> None:
    """Without force and noise omega+ = omega sqrt(1 + (h omega)^2), which no friction balances at high velocities."""
    omega, h, problem = np.array([0.5, 2.0, 8.0]), 0.25, pendulum(c_g=0.0)
    theta = np.array([0.1, 1.0, -2.0])
    state = HolonomicState(circle.normal(theta), omega * circle.tangent(theta), np.zeros((1, 3)))

    speed = {
        s.label: np.linalg.norm(move(s, problem, state, h, np.zeros((2, 3))).state.v, axis=0) for s in (EXPLICIT, OLD)
    }

    assert speed[EXPLICIT.label] == pytest.approx(omega * np.hypot(1.0, h * omega), rel=1e-13)
    assert speed[OLD.label] == pytest.approx(omega / np.hypot(1.0, h * omega), rel=1e-13)
    assert not any(claim.measure == "invariant" for claim in EXPLICIT.promises)


def residual(scheme: Scheme, body: Any, path: int, h: float, dW: Array, z: Array) -> Array:
    """Return the defects of a step in all unknowns (r+, v+, eta, l^, l) of one path at once."""
    n, m, M = len(body.mass), len(body.state.mu), body.mass
    r, v = body.state.r[:, path], body.state.v[:, path]
    r_new, v_new, eta, first, second = np.split(z, [n, 2 * n, 2 * n + m, 2 * n + 2 * m])
    D, D_new = body.jacobian(r), body.jacobian(r_new)
    kick = body.problem.diffusion(T, r[:, None], v[:, None])[..., 0] @ dW[:, path]
    early, late = (body.problem.force(t, x[:, None], v[:, None])[:, 0] for t, x in ((T, r), (T + h, r_new)))
    impulse, pushed = h * late + kick, D.T @ first
    leading = first
    if scheme == EXPLICIT:
        impulse = h * early + kick
        leading = D @ np.linalg.solve(M, impulse + pushed) + h * body.curvature(v, v)
    elif scheme == OLD:
        leading = D @ np.linalg.solve(M, kick + pushed)
    return np.concatenate(
        [
            M @ (r_new - r - h * v) - D_new.T @ eta,
            M @ (v_new - v) - impulse - pushed - D_new.T @ second,
            body.constraint(r_new[:, None])[:, 0],
            leading,
            D_new @ v_new,
        ]
    )


@ALL
def test_a_step_solves_the_coupled_system(body: Any, scheme: Scheme) -> None:
    """With a full mass matrix and explicit time, all unknowns are the solution of all equations by another solver."""
    h, m = 0.02, len(body.state.mu)
    dW = np.sqrt(h) * np.random.default_rng(2).standard_normal((2, 6))

    step = move(scheme, body.problem, body.state, h, dW)

    assert not step.failed.any()
    for p in range(6):
        start = np.concatenate([body.state.r[:, p], body.state.v[:, p], np.zeros(3 * m)])
        solved = root(lambda z, p=p: residual(scheme, body, p, h, dW, z), start, tol=1e-13)
        r, v, eta, first, second = np.split(solved.x, np.cumsum([len(body.mass), len(body.mass), m, m]))
        size = np.linalg.norm(body.mass, 2) * (1.0 + np.abs(solved.x).max())
        assert np.abs(residual(scheme, body, p, h, dW, solved.x)).max() <= 1e-12 * size
        assert np.abs(step.state.r[:, p] - r).max() <= 1e-12 * size
        assert np.abs(step.state.v[:, p] - v).max() <= 1e-12 * size
        assert np.abs(step.outputs["eta"][:, p] - eta).max() <= 1e-11 * size
        assert np.abs(step.state.mu[:, p] - first - second).max() <= 1e-12 * size


@ALL
def test_constraints_hold_after_many_steps(body: Any, scheme: Scheme) -> None:
    """After 60 steps g(r) and Dg(r) v are rounding errors of one step."""
    state, rng = scheme.enter(body.problem, body.state, 0.0, 0.01), np.random.default_rng(6)
    stepper = scheme.prepare(body.problem, 0.01)
    for n in range(60):
        state = stepper(state, 0.01 * n, Increment(0.1 * rng.standard_normal((2, 6)), None)).state

    for value, scale in body.problem.residuals(scheme.parts(body.problem, state)).values():
        assert np.all(np.abs(value) <= 16 * EPS * np.maximum(1.0, scale))


def newton(body: Any, y: Array) -> Array:
    """Return the root of one path by Newton's method with all of its matrix, as the source has it."""
    n, m, M, units = len(y), len(body.state.mu), body.mass, np.eye(len(y))
    r, eta = y, np.zeros(m)
    for _ in range(40):
        D = body.jacobian(r)
        H = np.array([[eta @ body.curvature(a, b) for b in units] for a in units])
        matrix = np.block([[M - H, -D.T], [D, np.zeros((m, m))]])
        F = np.concatenate([M @ (r - y) - D.T @ eta, body.constraint(r[:, None])[:, 0]])
        update = np.linalg.solve(matrix, F)
        r, eta = r - update[:n], eta - update[n:]
    return r


@pytest.mark.parametrize("h", [0.01, 0.1, 0.3, 1.0])
def test_the_projection_finds_the_root_of_newton_s_method(body: Any, h: float) -> None:
    """From distances up to the size of the body, it ends where Newton's method does, and fails on no path."""
    v = np.random.default_rng(8).standard_normal((len(body.mass), 6))
    y = body.state.r + h * body.problem.tangent(body.problem.linearised(body.state.r), v)[0]

    new = onto_constraint(body.problem, y)

    assert new.found.all()
    for p in range(6):
        assert np.abs(new.r[:, p] - newton(body, y[:, p])).max() <= 10 * NORMALS


def test_the_root_is_nearest_in_the_norm_of_the_mass_matrix(body: Any) -> None:
    """Moved along the constraint in any direction, the point found is further from where it came from."""
    y = body.state.r + 0.5 * body.state.v

    new = onto_constraint(body.problem, y)

    def distance(r: Array) -> Array:
        return np.einsum("ip,ij,jp->p", r - y, body.mass, r - y)

    assert new.found.all()
    for direction in np.eye(len(y)):
        along = body.problem.tangent(new.J, np.repeat(direction[:, None], 6, axis=1))[0]
        moved = along[:, np.newaxis] * np.array([-1e-3, 1e-3])[:, None]
        for shifted in np.moveaxis(moved, 1, 0):
            near = onto_constraint(body.problem, new.r + shifted)
            far = np.linalg.norm(shifted, axis=0) > 1e-5
            assert np.all(distance(near.r)[far] > distance(new.r)[far])


def test_a_point_on_the_constraint_stays() -> None:
    """The projection of a point of the manifold is the point itself, with eta = 0."""
    r = circle.normal(np.linspace(-3.0, 3.0, 7))

    new = onto_constraint(pendulum(), r)

    assert new.found.all()
    assert np.abs(new.r - r).max() <= 2 * EPS
    assert np.abs(new.eta).max() <= 2 * EPS


@ALL
def test_a_path_without_root_keeps_its_state_and_leaves_its_neighbours_alone(scheme: Scheme) -> None:
    """From the centre of the circle, or from no number, there is no direction: these paths are counted and stay."""
    h, problem = 0.1, pendulum()
    theta = np.array([1.0, 0.0, 2.0, 3.0])
    r, v = circle.normal(theta), 0.3 * circle.tangent(theta)
    v[:, 1], v[:, 3] = -r[:, 1] / h, np.nan
    state, dW = HolonomicState(r, v, np.ones((1, 4))), np.full((2, 4), 0.1)
    calm = state._replace(v=np.where([False, True, False, True], 0.1, v))

    step, alone = (move(scheme, problem, start, h, dW) for start in (state, calm))

    assert step.failed.tolist() == [False, True, False, True]
    parts = scheme.parts(problem, step.state)
    for name, value in state._asdict().items():
        assert np.array_equal(parts[name][:, 1::2], value[:, 1::2], equal_nan=True)
        assert np.array_equal(parts[name][:, ::2], scheme.parts(problem, alone.state)[name][:, ::2])


def test_skipped_steps_are_those_of_the_inherent_equation(body: Any) -> None:
    """A step without projection is Euler-Maruyama's for the inherent SDE: the Coriolis term has its sign."""
    h, view = 0.05, body.problem.view(SDE)
    dW = np.sqrt(h) * np.random.default_rng(2).standard_normal((2, 6))
    x = np.concatenate(body.state[:2])

    step = move(ExplicitProjectionEuler(skip=1), body.problem, body.state, h, dW)
    expected = EulerMaruyama().step(view, x, T, h, Increment(dW, None)).state

    assert np.abs(np.concatenate(step.state[:2]) - expected).max() <= 64 * EPS * (1.0 + np.abs(expected).max())
    assert step.state.skipped.tolist() == [[1.0] * 6]


def test_an_unprojected_step_has_the_value_computed_by_hand() -> None:
    """At theta = 0, omega = 2, h = 1/4, c_g = 1, without noise: v^ = (2, 1) and mu^ = 5/4.

    h a = (0, -1/4) and -h grad g G^{-1} D^2 g(v, v) = -h omega^2 r = (0, 1), r = (0, -1); P a = 0.
    """
    state = HolonomicState(np.array([[0.0], [-1.0]]), np.array([[2.0], [0.0]]), np.zeros((1, 1)))

    step = move(ExplicitProjectionEuler(skip=1), pendulum(), state, 0.25, np.zeros((2, 1)))

    assert step.state.r[:, 0].tolist() == [0.5, -1.0]
    assert step.state.v[:, 0].tolist() == [2.0, 1.0]
    assert step.state.mu[:, 0].tolist() == [1.25]


@pytest.mark.parametrize("skip", [0, 1, 4])
def test_projections_come_after_so_many_skipped_steps(skip: int) -> None:
    """The constraints hold at every (n + 1)-th step, and at no other; what a step took is counted there."""
    scheme, problem, h = ExplicitProjectionEuler(skip=skip), pendulum(), 0.02
    state, stepper, rng = scheme.start(problem, 5, h), scheme.prepare(problem, h), np.random.default_rng(3)
    exact, counted = [], []
    for n in range(15):
        step = stepper(state, n * h, Increment(np.sqrt(h) * rng.standard_normal((2, 5)), None))
        state = step.state
        exact.append(bool(np.abs(problem.constraint(state.r)).max() <= 4 * EPS))
        counted.append(bool((step.costs["projection_iterations"] > 0).all()))

    assert exact == [n % (skip + 1) == skip for n in range(15)]
    assert counted == exact


def test_a_failed_projection_is_tried_again_in_the_next_step() -> None:
    """The path that failed is still due, the other one has begun to skip again."""
    scheme, problem, h = ExplicitProjectionEuler(skip=1), pendulum(), 0.1
    theta = np.array([1.0, 0.0])
    r, v = circle.normal(theta), 0.3 * circle.tangent(theta)
    v[:, 1] = -r[:, 1] / h
    state = scheme.enter(problem, HolonomicState(r, v, np.zeros((1, 2))), 0.0, h)._replace(skipped=np.ones((1, 2)))
    with np.errstate(all="ignore"):
        step = scheme.step(problem, state, 0.0, h, Increment(np.zeros((2, 2)), None))
        again = scheme.step(problem, step.state, h, h, Increment(np.zeros((2, 2)), None))

    assert step.failed.tolist() == again.failed.tolist() == [False, True]
    assert step.state.skipped.tolist() == [[0.0, 1.0]]
    assert again.state.skipped.tolist() == [[1.0, 1.0]]
    assert np.abs(problem.constraint(again.state.r)[0, 0]) > 1e-5


def defects(problem: HolonomicSDAE, state: HolonomicState, h: float, dW: Array) -> list[float]:
    """Return the largest |g| and |Dg v| before the first projection, after four steps with given unit increments."""
    scheme = ExplicitProjectionEuler(skip=4)
    state, stepper = scheme.enter(problem, state, T, h), scheme.prepare(problem, h)
    for n in range(4):
        state = stepper(state, T + n * h, Increment(np.sqrt(h) * dW[n], None)).state
    parts = scheme.parts(problem, state)
    return [float(np.abs(value).max()) for value, _ in problem.residuals(parts).values()]


def test_between_projections_the_constraints_are_off_by_local_errors(body: Any) -> None:
    """With a fixed number of skipped steps, g is of size h^2 and Dg v of size h^(3/2)."""
    dW = np.random.default_rng(4).standard_normal((4, 2, 6))

    coarse, fine = (defects(body.problem, body.state, h, dW) for h in (4.0**-9, 4.0**-10))

    orders = [float(np.log(a / b) / np.log(4.0)) for a, b in zip(coarse, fine, strict=True)]
    # The next term is h^(1/2) smaller: 2^-9 of the leading one, times what it is larger by.
    assert orders == pytest.approx([2.0, 1.5], abs=0.02)


ORDERS = [
    (EXPLICIT, damped_pendulum, 1.0),
    (EXPLICIT, pendulum_velocity_noise, 0.5),
    (ExplicitProjectionEuler(skip=1), damped_pendulum, 1.0),
    (ExplicitProjectionEuler(skip=3), pendulum_velocity_noise, 0.5),
    (OLD, damped_pendulum, 1.0),
    (OLD, pendulum_velocity_noise, 0.5),
    (NEW, damped_pendulum, 1.0),
    (NEW, pendulum_velocity_noise, 0.5),
]


@pytest.mark.parametrize(("scheme", "family", "order"), ORDERS, ids=lambda x: getattr(x, "label", None))
def test_local_orders_are_those_claimed(scheme: Scheme, family: Any, order: float) -> None:
    """A step is of the strong order that is claimed and no better, multiplier included, and of weak order 1."""
    problem = family()
    found, weak = strong_order(scheme, problem), weak_order(local_weak(scheme, problem))

    assert found.consistent
    assert found.order == pytest.approx(order, abs=0.06)
    assert np.min(weak.orders, where=weak.settled, initial=np.inf) == pytest.approx(1.0, abs=0.07)


def never(r: Array) -> Array:
    """Stand in for what a structured problem should not be asked for."""
    raise AssertionError("a dense matrix was asked for")


@pytest.mark.parametrize("family", [fibre_clamped, fibre_free])
@pytest.mark.parametrize("scheme", [EXPLICIT, ExplicitProjectionEuler(skip=1), OLD, NEW], ids=lambda s: s.label)
def test_a_fibre_is_asked_for_no_matrix(scheme: Scheme, family: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    """Steps of a chain use its products and tridiagonal systems alone, so that they cost O(N)."""
    problem = family()
    h = problem.horizon / 64
    state, stepper = scheme.start(problem, 3, h), scheme.prepare(problem, h)
    rng = np.random.default_rng(1)
    object.__setattr__(problem, "jacobian", never)
    object.__setattr__(problem, "diffusion", never)
    for n in range(4):
        dW = np.sqrt(h) * rng.standard_normal((problem.noise_dim, 3))
        step = stepper(state, n * h, Increment(dW, None))
        state = step.state

    assert not step.failed.any()
    assert np.isfinite(state.v).all()
    assert np.abs(problem.constraint(state.r)).max() <= 64 * EPS * problem.dimension


class Skipping(NamedTuple):
    """What 101 or 201 skipped steps cost and leave: averages over space, time and paths."""

    iterations: float
    length: float
    velocity: float


def skipping(n: int, steps: int) -> Skipping:
    """Run the clamped fibre with little noise, h = 2.5e-5, and a projection after every n skipped steps."""
    problem, h, paths = fibre_clamped(alpha=4.0, beta=1e-4), 2.5e-5, 4
    scheme, rng = ExplicitProjectionEuler(skip=n), np.random.default_rng(5)
    state, stepper = scheme.start(problem, paths, h), scheme.prepare(problem, h)
    updates, squares = [], np.zeros(2)
    for k in range(steps):
        step = stepper(state, k * h, Increment(np.sqrt(h) * rng.standard_normal((problem.noise_dim, paths)), None))
        state = step.state
        assert not step.failed.any()
        if np.isfinite(counted := step.costs["projection_iterations"]).all():
            updates.append(float(counted.mean()))
        found = problem.residuals(scheme.parts(problem, state)).values()
        squares += [float((residual.value**2).mean()) for residual in found]
    return Skipping(float(np.mean(updates)), *np.sqrt(squares / steps))


@pytest.mark.slow
def test_projections_of_a_fibre_can_be_skipped_for_many_steps() -> None:
    """As the source's Fig. 4.3 has it: under two updates a projection beyond n = 100, and defects that grow slowly.

    In n skipped steps the length drifts like n and the hidden constraint no faster.
    """
    few, many = skipping(101, 4080), skipping(203, 4080)

    assert few.iterations < 2.0
    assert many.iterations < 2.0
    assert 1e-10 < few.length < many.length < 2.2 * few.length < 1e-6
    assert 1e-9 < few.velocity < many.velocity < 2.2 * few.velocity < 1e-5


@pytest.mark.parametrize("skip", [-1, 1.5, True, "3"])
def test_numbers_of_skipped_steps_that_make_no_sense_are_refused(skip: Any) -> None:
    """They are refused in words that name the parameter."""
    with pytest.raises(ParameterError, match=r"skip must be at least 0|skip .*a whole number"):
        ExplicitProjectionEuler(skip=skip)


def test_a_projector_that_does_not_exist_is_refused() -> None:
    """It is refused in words that name the two there are."""
    with pytest.raises(ParameterError, match="old or new, got 'now'"):
        SemiImplicitProjectionEuler(noise_projector="now")


def test_exact_constraints_are_claimed_only_where_every_step_is_projected() -> None:
    """With skipped steps, an order in h is claimed in place of round-off."""
    promised = {s.label: [str(c) for c in s.promises if c.measure == "drift"] for s in (EXPLICIT, OLD, NEW)}
    (skipped,) = (c for c in ExplicitProjectionEuler(skip=2).promises if c.measure == "drift")

    assert set(map(tuple, promised.values())) == {("round-off",)}
    assert skipped.value.least == 1.0


@pytest.mark.parametrize("make", [pendulum, lambda: fibre_clamped(alpha=4.0, N=3)])
@pytest.mark.parametrize("scheme", [EXPLICIT, OLD], ids=lambda s: s.label)
def test_newton_finds_the_point_that_the_gram_matrix_does(make: Any, scheme: Scheme) -> None:
    """Both solve the same equations, the Gram matrix up to a part of r; each count has a name of its own."""
    problem, h = make(), 1e-3
    other, dW = replace(scheme, solver="newton"), np.sqrt(h) * np.random.default_rng(2).standard_normal((2, 5))
    dW = np.resize(dW, (problem.noise_dim, 5))
    state = scheme.start(problem, 5, h)
    for n in range(4):
        one, two = (each.prepare(problem, h)(state, n * h, Increment(dW, None)) for each in (scheme, other))
        state = one.state
        assert np.abs(one.state.r - two.state.r).max() <= 2.0 * NORMALS * np.abs(one.state.r).max()

    assert list(one.costs) == ["projection_iterations"]
    assert list(two.costs) == ["newton_iterations"]
    assert not two.failed.any()
    assert two.costs["newton_iterations"].max() <= one.costs["projection_iterations"].max() + 1


def test_a_tolerance_ends_the_projection_and_the_claim_of_exact_constraints() -> None:
    """A loose tolerance saves iterations and leaves a defect of its size; exact constraints are claimed without."""
    problem, h = fibre_clamped(alpha=4.0), 1e-3
    noise = Increment(np.sqrt(h) * np.random.default_rng(4).standard_normal((problem.noise_dim, 20)), None)
    for solver in ("gram", "newton"):
        exact, loose = (ExplicitProjectionEuler(solver=solver, tolerance=size) for size in (0.0, 1e-4))
        state = exact.start(problem, 20, h)
        for _ in range(3):
            state = exact.step(problem, state, 0.0, h, noise).state
        steps = [each.step(problem, state, 0.0, h, noise) for each in (exact, loose)]
        counts = [next(iter(step.costs.values())).sum() for step in steps]
        assert counts[1] < counts[0]
        assert np.abs(problem.constraint(steps[0].state.r)).max() < 1e-12
        assert np.abs(problem.constraint(steps[1].state.r)).max() > 1e-12
        assert not steps[1].failed.any()
        assert [any(str(claim) == "round-off" for claim in each.promises) for each in (exact, loose)] == [
            True,
            False,
        ]


@pytest.mark.parametrize("given", [{"solver": "frozen"}, {"tolerance": -1.0}, {"tolerance": float("nan")}])
@pytest.mark.parametrize("scheme", [ExplicitProjectionEuler, SemiImplicitProjectionEuler])
def test_projections_that_do_not_exist_are_refused(scheme: Any, given: dict[str, Any]) -> None:
    """Two iterations are known, and tolerances from 0 to 1."""
    with pytest.raises(ParameterError, match=r"solver must be gram or newton|tolerance .*must be"):
        scheme(**given)
