"""Fine references: their order, against schemes that share no formula with them, and what they ask for."""

from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pytest

from facade import (
    SRA1,
    angle_pendulum,
    damped_pendulum,
    double_well,
    double_well_langevin,
    ellipse,
    pendulum,
    pendulum_tangential,
)
from facade import _circle as circle
from facade import pendulum_velocity_noise as velocity_noise
from sdaeverify import SDE, Array, Increment, Pathwise, Problem, ProblemError
from sdaeverify.measuring import group_sums, jackknife
from sdaeverify.numerics import log_norms, slope_weights
from sdaeverify.studying import Brownian, LevelNoise, Source
from sdaeverify_problems._inherent_truth import inherent_truth, with_inherent_truth

PATHS, HORIZON, FITTED, FINE, FINEST = 240, 0.5, range(2, 6), 8, 11
# Halfway between order 3/2 and order 1, which is what any one missing term of a step would leave.
BETWEEN, CONFIDENCE = 1.25, 0.999
ROWS = {"r": slice(0, 2), "v": slice(2, 4), "mu": slice(4, 5), "x": slice(0, 2)}
# Force and noise of a pendulum over a step, in Stratonovich's sense: (t, v, along, h, dW) -> (2, P).
Push = Callable[[float, Array, Array, float, Array], Array]
DOWN = np.array([[0.0], [-1.0]])


class Case(NamedTuple):
    """References of a problem, its state at the end by something else, and components that they approach."""

    references: tuple[Pathwise, ...]
    noise_dim: int
    end: Callable[[list[LevelNoise]], Array]
    components: tuple[str, ...] = ("r", "v", "mu")


def run(advance: Callable[[Array, float, float, Increment], Array], z: Array, noise: LevelNoise) -> Array:
    h = HORIZON / len(noise.dW)
    for n in range(len(noise.dW)):
        z = advance(z, n * h, h, noise.increment(n))
    return z


def end_of(truth: Pathwise, noise: LevelNoise) -> Array:
    return np.concatenate(list(truth.parts(HORIZON, run(truth.advance, truth.start(PATHS), noise)).values()))


def trapezoidal(push: Push, mass: float = 1.0) -> Callable[[list[LevelNoise]], Array]:
    """Return the trapezoidal rule with a predictor in the angle, for masses (1, mass).

    With dv = t domega - omega^2 r dt, M dv = a dt + B dw - r dmu and |r| = 1,

        <t, M t> domega = omega^2 <t, M r> dt + <t, a dt + B dw>,   dmu = <r, a dt + B dw> - <r, M dv>.
    """
    M = np.diag([1.0, mass])

    def change(t: float, z: Array, h: float, dW: Array) -> Array:
        theta, omega, _ = z
        r, along = circle.normal(theta), circle.tangent(theta)
        force, Mt, Mr = push(t, omega * along, along, h, dW), M @ along, M @ r
        domega = (h * omega**2 * (along * Mr).sum(axis=0) + (along * force).sum(axis=0)) / (along * Mt).sum(axis=0)
        return np.stack([h * omega, domega, (r * (force - Mt * domega + h * omega**2 * Mr)).sum(axis=0)])

    def end(levels: list[LevelNoise]) -> Array:
        z, h = np.repeat([[0.5], [0.5], [0.0]], PATHS, axis=1), HORIZON / 2**FINEST
        for n, dW in enumerate(levels[FINEST].dW):
            first = change(n * h, z, h, dW)
            z = z + 0.5 * (first + change((n + 1) * h, z + first, h, dW))
        return np.concatenate(list(circle.parts(HORIZON, z).values()))

    return end


def constrained(problem: Problem, push: Push, mass: float = 1.0) -> Case:
    """Return a pendulum with its reference in the angle, if it has one, and that of the inherent equation."""
    known = () if problem.pathwise is None else (problem.pathwise,)
    return Case((*known, inherent_truth(problem)), problem.noise_dim, trapezoidal(push, mass))


def proportional(sigma: float, gamma: float) -> Case:
    """Return the pendulum whose noise depends on velocities; omega itself is exact."""
    problem = velocity_noise(sigma=sigma, gamma=gamma, horizon=HORIZON)
    end = trapezoidal(lambda t, v, along, h, dW: v * (sigma * dW - (gamma + 0.5 * sigma**2) * h))
    return Case((problem.pathwise,), 1, end, ("r", "mu"))


def tangential() -> Case:
    """Return the reference in the angle, where position and velocity are exact."""
    truth = pendulum_tangential(horizon=HORIZON).pathwise
    return Case((truth,), 1, trapezoidal(lambda t, v, along, h, dW: along * dW), ("mu",))


def growing(growth: float, mass: float) -> Case:
    """Return the damped pendulum with masses and the noise (1 + growth t) dw."""
    problem = replace(
        damped_pendulum(mass=mass, horizon=HORIZON),
        diffusion=lambda t, r, v: (1.0 + growth * t) * np.eye(2)[..., None],
        traits=frozenset(),
        truths=(),
    )
    return constrained(problem, lambda t, v, along, h, dW: h * (DOWN - v) + (1.0 + growth * t) * dW, mass)


def unconstrained(problem: Problem, by_scheme: bool) -> Case:
    """Return a reference, to be compared with a Runge-Kutta scheme or, on a curve, with itself on finer noise."""
    truth, view, scheme = problem.pathwise, problem.view(SDE), SRA1()

    def end(levels: list[LevelNoise]) -> Array:
        if not by_scheme:
            return end_of(truth, levels[FINE])
        step = scheme.prepare(view, HORIZON / 2**FINE)
        return run(lambda x, t, h, noise: step(x, t, noise).state, problem.initial(PATHS), levels[FINE])

    return Case((truth,), 1, end, ("x",))


CASES: dict[str, Callable[[], Case]] = {
    "pendulum": lambda: constrained(pendulum(horizon=HORIZON), lambda t, v, along, h, dW: h * DOWN + dW),
    "damped": lambda: constrained(damped_pendulum(horizon=HORIZON), lambda t, v, along, h, dW: h * (DOWN - v) + dW),
    "masses, noise that grows": lambda: growing(1.0, 2.5),
    "tangential": tangential,
    "proportional": lambda: proportional(0.6, 0.4),
    "double well": lambda: unconstrained(double_well(), by_scheme=True),
    "angle pendulum": lambda: unconstrained(angle_pendulum(), by_scheme=True),
    "double well, Langevin": lambda: unconstrained(double_well_langevin(), by_scheme=True),
    "ellipse, delta": lambda: unconstrained(ellipse("delta"), by_scheme=False),
}


# One along the truth and one of a scheme; the others are made like one of these.
FAST = {"pendulum", "double well"}


@pytest.mark.parametrize(
    "name", [name if name in FAST else pytest.param(name, marks=pytest.mark.long) for name in CASES]
)
def test_references_are_of_order_three_halves(name: str) -> None:
    """What is not exact approaches the other solution nearer to order 3/2 than to order 1."""
    case = CASES[name]()
    levels = list(next(Brownian(Source(7, name, 0, PATHS), case.noise_dim, HORIZON, FINEST).steps()))
    end, weights = case.end(levels), -slope_weights(np.arange(len(FITTED), dtype=float))
    for reference in case.references:
        errors = np.stack([end_of(reference, levels[k]) - end for k in FITTED])
        for component in case.components:
            distances = group_sums(np.linalg.norm(errors[:, ROWS[component]], axis=1))
            order = jackknife(
                distances, group_sums(np.ones(PATHS)), lambda means: float(weights @ log_norms(means, 1.0))
            )
            assert order.interval(CONFIDENCE)[0] > BETWEEN, (reference.source, component, order)


def test_noise_that_depends_on_velocities_is_refused() -> None:
    """The reason names what is wrong, in one line."""
    with pytest.raises(ProblemError, match="does not depend on v"):
        inherent_truth(velocity_noise())


def test_the_reference_is_put_before_other_truths() -> None:
    """A problem gets it as its pathwise truth, and keeps what else is known of it."""
    problem = replace(pendulum(), truths=pendulum().truths[1:])

    completed = with_inherent_truth(problem)

    assert completed.pathwise is completed.truths[0]
    assert completed.truths[1:] == problem.truths
