"""The one-step map between flat states, whatever the scheme's state looks like."""

from typing import Any, ClassVar, NamedTuple

import numpy as np
import pytest

from facade import EulerMaruyama, HalfExplicitEuler, gbm, pendulum
from probe import strong_cells as s
from probe.weak_cells import constant, equation
from sdaeverify import SDE, Array, HolonomicSDAE, Increment, Problem, Scheme, SchemeError, Step
from sdaeverify.probing import OneStep, cloud, step_nodes
from sdaeverify_lab.planted.projections import WrongExplicit
from sdaeverify_schemes.projections.explicit_projection_euler import ExplicitProjectionEuler

H, T = 0.01, 0.1


class Remembered(NamedTuple):
    x: Array
    last: Array


class Averaging(Scheme):
    """Euler-Maruyama that adds half of its last increment and leaves out half of the new one."""

    name: ClassVar[str] = "averaging"
    form: ClassVar[type[SDE]] = SDE

    def enter(self, problem: SDE, state: Array, t: float, h: float) -> Remembered:
        return Remembered(state, np.zeros_like(state))

    def parts(self, problem: SDE, state: Remembered) -> Any:
        return problem.parts(state.x)

    def step(self, problem: SDE, state: Remembered, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        kick = s.apply(problem.diffusion(t, state.x), noise.dW)
        return Step(Remembered(state.x + h * problem.drift(t, state.x) + 0.5 * (kick + state.last), kick))


def swapped(names: dict[str, slice]) -> SDE:
    return equation(lambda t, x: np.stack([x[1], -x[0]]), constant([0.0], [0.5]), [1.0, 2.0], names=names)


def noise_of(problem: Problem, states: int) -> Increment:
    return step_nodes(problem.noise_dim, 3).increment(H, states)


@pytest.mark.parametrize("problem", [gbm(), swapped({"p": slice(1, 2), "q": slice(0, 1)})], ids=["gbm", "swapped"])
def test_eulers_step_is_the_scheme_of_that_name(problem: SDE) -> None:
    """The map of Euler-Maruyama is x + f h + B dW, rows in the order of the equation whatever their names are."""
    step = OneStep(EulerMaruyama(), problem)
    x = np.repeat(cloud(problem, step.equation), 3, axis=1)
    noise = noise_of(problem, x.shape[1] // 3)

    assert not step.why_not_probed()
    assert np.array_equal(step(x, T, H, noise), step.euler(x, T, H, noise))


def test_a_structured_state_is_read_back() -> None:
    """Of a constrained problem, entering and reading give the same rows r, v and mu."""
    step = OneStep(HalfExplicitEuler(), pendulum())
    x = cloud(step.view, step.equation)

    assert not step.why_not_probed()
    assert list(step.names) == ["r", "v", "mu"]
    assert np.array_equal(step.read(step.enter(x, T, H)), x)


def test_memory_is_kept_between_steps_and_left_out_of_what_is_read() -> None:
    """Two steps with memory are not two steps that begin anew."""
    step, x = OneStep(Averaging(), gbm()), np.full((1, 3), 1.5)
    noise = noise_of(gbm(), 1)

    kept = step.advance(step.advance(step.enter(x, T, H), T, H, noise), T + H, H, noise)
    anew = step(step(x, T, H, noise), T + H, H, noise)

    assert "steps of a run differ" in step.why_not_probed()
    assert step.read(kept).shape == x.shape
    assert np.abs(step.read(kept) - anew).max() > 0.1 * np.sqrt(H)


class FirstSlope(Averaging):
    """Euler-Maruyama with the drift of the state that it entered, for ever."""

    name: ClassVar[str] = "first-slope"

    def enter(self, problem: SDE, state: Array, t: float, h: float) -> Remembered:
        """Remember the drift."""
        return Remembered(state, h * problem.drift(t, state))

    def step(self, problem: SDE, state: Remembered, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        kick = s.apply(problem.diffusion(t, state.x), noise.dW)
        return Step(state._replace(x=state.x + state.last + kick))


class LastSlope(FirstSlope):
    """The same with the drift of the state before."""

    name: ClassVar[str] = "last-slope"

    def step(self, problem: SDE, state: Remembered, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        return Step(super().step(problem, state, t, h, noise).state._replace(last=h * problem.drift(t, state.x)))


ROTATION = swapped({"p": slice(0, 1), "q": slice(1, 2)})


@pytest.mark.parametrize(
    "problem", [pytest.param(gbm(), id="gbm", marks=pytest.mark.long), pytest.param(ROTATION, id="rotation")]
)
def test_memory_that_is_never_renewed_is_no_error_of_one_step(problem: SDE) -> None:
    """It differs from what entering sets by what grows with the time of a run; memory of one step before does not."""
    assert "steps of a run differ" in OneStep(FirstSlope(), problem).why_not_probed()
    assert not OneStep(LastSlope(), problem).why_not_entered()


def on_ellipse() -> HolonomicSDAE:
    """Return a point on an ellipse whose velocity grows from 0 by noise: later steps have larger errors."""
    return HolonomicSDAE(
        force=lambda t, r, v: 0.0 * r,
        diffusion=lambda t, r, v: np.broadcast_to(np.eye(2)[..., None], (2, 2, r.shape[1])),
        constraint=lambda r: 0.25 * r[:1] ** 2 + r[1:] ** 2 - 1.0,
        position=np.array([0.0, 1.0]),
        velocity=np.array([0.0, 0.0]),
        noise_dim=2,
        horizon=1.0,
        source="test",
    )


@pytest.mark.long
def test_an_error_that_a_later_step_takes_back_is_no_error_of_one_step() -> None:
    """Velocities that are off by O(h) until they are projected are memory, also where those of a run grow."""
    assert "steps of a run differ" in OneStep(WrongExplicit(3, coriolis=-1.0), on_ellipse()).why_not_entered()
    assert not OneStep(ExplicitProjectionEuler(3), on_ellipse()).why_not_entered()


def test_memory_that_entering_does_not_set_is_refused() -> None:
    """A start with more memory than an entered state says why it cannot be probed."""

    class StartsLonger(Averaging):
        def start(self, problem: SDE, paths: int, h: float) -> Any:
            return np.zeros((2, paths))

    assert "memory" in OneStep(StartsLonger(), gbm()).why_not_probed()


@pytest.mark.parametrize("names", [{"q": slice(0, 1)}, {"q": slice(0, 2), "p": slice(1, 2)}])
def test_names_that_are_no_partition_of_the_rows_are_refused(names: dict[str, slice]) -> None:
    """Rows without a name, or with two, cannot be read back from named components."""
    assert "rows" in OneStep(EulerMaruyama(), swapped(names)).why_not_probed()


def test_a_problem_without_ito_equation_is_refused() -> None:
    """A form that offers no equation is told by name."""

    class Bare(Problem):
        pass

    step = OneStep(EulerMaruyama(), Bare(horizon=1.0, noise_dim=1, source="test"))

    assert "Bare" in step.why_not_probed()
    with pytest.raises(SchemeError, match="Bare"):
        assert step.equation
