"""Where du/dy becomes singular along the run: no scheme is to blame, and the reason says so."""

from typing import ClassVar

import numpy as np
import pytest

from facade import EulerMaruyama, LaggedAlgebraicTheta, StochasticTheta
from sdaeverify import DelaySDAE, DelayState, Increment, Problem, Scheme, Step, verify
from sdaeverify.probing import OneStep


def turning(tau: float = 0.0, horizon: float = 1.0, pull: float = 0.0) -> DelaySDAE:
    """Return 0 = (0.7 - t) y - x: y has a pole at t = 0.7, where the solution ends."""
    return DelaySDAE(
        drift=lambda t, x, v, y: -x + pull * y,
        diffusion=lambda t, x, v, y: 0.3 * x[:, None],
        constraint=lambda t, x, v, y: (0.7 - t) * y - x,
        algebraic=1,
        delay=tau,
        history=lambda t: [1.0],
        noise_dim=1,
        horizon=horizon,
        observables={"x": lambda t, s: s["x"][0]},
        source="made up",
    )


def fold() -> DelaySDAE:
    """Return 0 = y^2 - x with x on its way to 0."""
    return DelaySDAE(
        drift=lambda t, x, v, y: -1.0 + 0.0 * x,
        diffusion=lambda t, x, v, y: 0.3 + 0.0 * x[:, None],
        constraint=lambda t, x, v, y: y * y - x,
        algebraic=[1.0],
        delay=0.0,
        history=lambda t: [1.0],
        noise_dim=1,
        horizon=1.0,
        source="made up",
    )


class WrongRoot(StochasticTheta):
    """y is off by one part in a million, wherever there is a root."""

    name: ClassVar[str] = "planted-wrong-root"
    form: ClassVar[tuple[type[Problem], ...]] = (DelaySDAE,)

    def step(self, problem: DelaySDAE, state: DelayState, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        step = super().step(problem, state, t, h, noise)
        return step._replace(state=step.state._replace(y=step.state.y * (1.0 + 1e-6)))


@pytest.mark.long
@pytest.mark.parametrize("tau", [0.0, 0.3])
@pytest.mark.parametrize("scheme", [StochasticTheta(), LaggedAlgebraicTheta()])
def test_a_lost_index_is_the_reason_and_refutes_nothing(scheme: Scheme, tau: float) -> None:
    """A held path left residuals of 1.8, and the right scheme was refuted by drift."""

    def lost() -> DelaySDAE:
        return turning(tau)

    found = verify([scheme], [lost], "drift", paths=40, block=40, levels=3, max_looks=1).verdicts

    assert set(found.verdict) == {"inconclusive"}
    assert found.reason.str.contains("du/dy becomes singular, on 40 paths, on average at t = 0.719").all()


@pytest.mark.long
@pytest.mark.parametrize("pull", [0.0, 0.1])
def test_explicit_schemes_do_not_step_over_a_pole(pull: float) -> None:
    """Euler-Maruyama of the equation without y went on beyond t = 0.7 and was verified at T = 1."""

    def lost() -> DelaySDAE:
        return turning(pull=pull)

    found = verify([EulerMaruyama()], [lost], ["strong", "weak"], paths=256, max_looks=1).verdicts
    claimed = found[found.claim != ""]

    assert len(claimed) >= 3
    assert set(claimed.verdict) == {"inconclusive"}
    assert claimed.reason.str.contains("du/dy becomes singular, on 256 paths, on average at t = 0.75").all()


def test_explicit_schemes_are_verified_before_the_pole() -> None:
    """The same equation up to T = 1/2 has a solution."""

    def early() -> DelaySDAE:
        return turning(pull=0.1, horizon=0.5)

    found = verify([EulerMaruyama()], [early], "strong", paths=256, max_looks=1).verdicts

    assert set(found.verdict) == {"verified"}


@pytest.mark.long
def test_no_step_beyond_the_pole_refutes_a_right_scheme() -> None:
    """The local order of the theta scheme was 0, where its steps were probed at times without a solution."""
    found = verify([StochasticTheta()], [turning], "strong", paths=40, block=40, levels=3, max_looks=1).verdicts

    assert set(found.verdict) == {"inconclusive"}
    assert found.reason.str.contains("du/dy becomes singular").all()


def test_the_index_is_that_of_the_start() -> None:
    """Behind the pole there is an y, and det du/dy has another sign; at the pole there is none."""
    problem, x = turning(), np.array([[1.0, 2.0]])

    assert not problem.without_index(0.69, x, x).any()
    assert problem.without_index(0.71, x, x).all()
    assert fold().without_index(0.5, np.array([[0.5, -0.5]]), x).tolist() == [False, True]
    assert not EulerMaruyama().view_of(problem).without_index(0.71, x, x).any()


@pytest.mark.long
def test_a_wrong_root_is_refuted_before_the_index_is_lost() -> None:
    """What a path violates while it has a root counts."""
    found = verify([WrongRoot()], [turning], "drift", paths=40, block=40, levels=3, max_looks=1).verdicts

    assert set(found.verdict) == {"refuted"}


def test_a_fold_ends_the_solution_as_well() -> None:
    """Where x comes down to 0, no y is found; where it stays away from 0, one is."""
    problem, x = fold(), np.array([[1.0, 0.01, 1e-4]])
    noise = Increment(np.array([[0.0, 0.0, 0.1]]), None)

    lost = problem.index_lost(0.0, 0.1, {"x": x, "y": np.sqrt(x)}, noise)

    assert lost.tolist() == [False, True, True]
    assert not problem.index_lost(0.0, 0.1, {"x": x}, noise).any()


def test_a_constraint_in_time_is_entered_at_its_time() -> None:
    """The y is that of time t, not of time 0: one step of the right scheme did not follow the equation."""
    problem, t = turning(pull=0.1, horizon=0.5), 0.2
    x = np.array([[1.0, 2.0]])

    state = OneStep(StochasticTheta(), problem).enter(x, t, 0.01)

    np.testing.assert_allclose(state.y, x / (0.7 - t), rtol=1e-12)
