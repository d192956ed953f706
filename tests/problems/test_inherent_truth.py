"""The fine reference of constrained mechanics: its order, against solutions in the angle, and what it asks for."""

from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pytest

from facade import _circle as circle
from facade import damped_pendulum, pendulum, pendulum_tangential, pendulum_velocity_noise
from sdaeverify import Array, HolonomicSDAE, Increment, ProblemError
from sdaeverify.measuring import Estimate, group_sums, jackknife
from sdaeverify.numerics import log_norms, slope_weights
from sdaeverify.probing import LevelNoise, Source, brownian_steps
from sdaeverify_problems._inherent_truth import inherent_truth, with_inherent_truth

PATHS, HORIZON, FITTED, FINE, FINEST = 240, 0.5, range(2, 6), 9, 11
# Halfway between order 3/2 and order 1, which is what a noise coefficient taken once a step would leave.
BETWEEN, CONFIDENCE = 1.25, 0.999

Advance = Callable[[Array, float, float, Increment], Array]


class Case(NamedTuple):
    """A problem, and its position, velocity and multiplier at the end, shape (5, P), by something else."""

    problem: HolonomicSDAE
    solution: Callable[[list[LevelNoise]], Array]


def run(advance: Advance, z: Array, noise: LevelNoise) -> Array:
    h = HORIZON / len(noise.dW)
    for n in range(len(noise.dW)):
        z = advance(z, n * h, h, noise.increment(n))
    return z


def by_angle(problem: HolonomicSDAE) -> Case:
    """Return a pendulum with its Ito-Taylor step in the angle."""
    truth = problem.pathwise
    assert truth is not None

    def solution(levels: list[LevelNoise]) -> Array:
        parts = truth.parts(HORIZON, run(truth.advance, truth.start(PATHS), levels[FINE]))
        return np.concatenate([parts[name] for name in ("r", "v", "mu")])

    return Case(problem, solution)


def heavy(mass: float, growth: float) -> Case:
    """Return the pendulum with masses (1, mass) and noise (1 + growth t) dw, and the trapezoidal rule in the angle.

    With dv = t domega - omega^2 r dt, M dv = a dt + B dw - r dmu and |r| = 1,

        <t, M t> domega = omega^2 <t, M r> dt + <t, a dt + B dw>,   dmu = <r, a dt + B dw> - <r, M dv>.
    """
    problem = damped_pendulum(mass=mass, horizon=HORIZON)
    grown = replace(
        problem,
        diffusion=lambda t, r, v: (1.0 + growth * t) * np.eye(2)[..., None],
        traits=frozenset(),
        truths=(),
    )
    M = np.diag([1.0, mass])

    def change(t: float, z: Array, h: float, dW: Array) -> Array:
        theta, omega, _ = z
        r, along = circle.normal(theta), circle.tangent(theta)
        push = h * (np.array([[0.0], [-1.0]]) - omega * along) + (1.0 + growth * t) * dW
        Mt, Mr = M @ along, M @ r
        domega = (h * omega**2 * (along * Mr).sum(axis=0) + (along * push).sum(axis=0)) / (along * Mt).sum(axis=0)
        dmu = (r * (push - Mt * domega + h * omega**2 * Mr)).sum(axis=0)
        return np.stack([h * omega, domega, dmu])

    def solution(levels: list[LevelNoise]) -> Array:
        z = np.repeat([[0.5], [0.5], [0.0]], PATHS, axis=1)
        noise, h = levels[FINEST].dW, HORIZON / 2**FINEST
        for n, dW in enumerate(noise):
            first = change(n * h, z, h, dW)
            z = z + 0.5 * (first + change((n + 1) * h, z + first, h, dW))
        return np.concatenate(list(circle.parts(HORIZON, z).values()))

    return Case(grown, solution)


CASES: dict[str, Callable[[], Case]] = {
    "pendulum": lambda: by_angle(pendulum(horizon=HORIZON)),
    "tangential": lambda: by_angle(pendulum_tangential(horizon=HORIZON)),
    "damped": lambda: by_angle(damped_pendulum(horizon=HORIZON)),
    "masses, noise that grows": lambda: heavy(2.5, 1.0),
}
ROWS = {"r": slice(0, 2), "v": slice(2, 4), "mu": slice(4, 5)}


def orders(case: Case, advance: Advance) -> dict[str, Estimate]:
    """Return the order of the mean error at the end, of each component."""
    levels = list(next(brownian_steps(Source(7, "inherent", 0, PATHS), case.problem.noise_dim, HORIZON, FINEST)))
    exact, start = case.solution(levels), np.concatenate(case.problem.initial(PATHS))
    errors = np.stack([run(advance, start, levels[k]) - exact for k in FITTED])
    weights, counts = -slope_weights(np.arange(len(FITTED), dtype=float)), group_sums(np.ones(PATHS))

    def order(distances: Array) -> Estimate:
        return jackknife(group_sums(distances), counts, lambda means: float(weights @ log_norms(means, 1.0)))

    return {name: order(np.linalg.norm(errors[:, rows], axis=1)) for name, rows in ROWS.items()}


@pytest.mark.parametrize("name", CASES)
def test_the_reference_is_of_order_three_halves(name: str) -> None:
    """Position, velocity and multiplier approach the solution in the angle nearer to order 3/2 than to order 1."""
    case = CASES[name]()

    for component, order in orders(case, inherent_truth(case.problem).advance).items():
        assert order.interval(CONFIDENCE)[0] > BETWEEN, (component, order)


def test_noise_that_depends_on_velocities_is_refused() -> None:
    """The reason names what is wrong, in one line."""
    with pytest.raises(ProblemError, match="does not depend on v"):
        inherent_truth(pendulum_velocity_noise())


def test_the_reference_is_put_before_other_truths() -> None:
    """A problem gets it as its pathwise truth, and keeps what else is known of it."""
    problem = replace(pendulum(), truths=pendulum().truths[1:])

    completed = with_inherent_truth(problem)

    assert completed.pathwise is completed.truths[0]
    assert completed.truths[1:] == problem.truths
