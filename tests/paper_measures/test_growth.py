"""Growth of E V in one step: the generator's closed forms, bounded and unbounded rates."""

import numpy as np
import pytest

from cells import Formula
from facade import (
    EulerMaruyama,
    Growth,
    HalfExplicitEuler,
    HeunAdditive,
    double_well,
    growth,
    judge_growth,
    lyapunov,
    noncommuting,
    ou,
    pendulum,
    pendulum_velocity_noise,
)
from sdaeverify import SDE, Array, HolonomicSDAE, Increment, Scheme
from sdaeverify.measuring import Verdict, packed, unpacked
from sdaeverify.numerics import apply, norm
from sdaeverify.probing import extreme_states


def found(scheme: Scheme, problem: HolonomicSDAE | SDE) -> Growth:
    """Return the rates, from evidence that was stored in between."""
    record = unpacked("kept", Growth, packed("kept", growth(scheme, problem)))
    assert record is not None
    return record


def verdict(scheme: Scheme, problem: HolonomicSDAE | SDE) -> Verdict:
    return judge_growth(found(scheme, problem), problem.horizon).verdict


def test_v_is_the_energy_norm() -> None:
    """V = 1 + (|r|^2 + v^T M v)^2, and 1 + |x|^4 for an equation."""
    M = np.array([[2.0, 0.5], [0.5, 1.0]])
    parts = {"r": np.array([[1.0], [2.0]]), "v": np.array([[3.0], [-1.0]]), "mu": np.array([[9.0]])}
    heavy = HolonomicSDAE(
        force=lambda t, r, v: 0.0 * v, diffusion=lambda t, r, v: np.eye(2)[..., None], mass=M,
        constraint=lambda r: (r[:1] - 1.0), position=[1.0, 0.0], velocity=[0.0, 0.0], horizon=1.0, noise_dim=2,
        source="made up",
    )  # fmt: skip

    assert lyapunov(heavy, parts) == pytest.approx([1.0 + (5.0 + 18.0 - 3.0 + 1.0) ** 2])
    assert lyapunov(ou(), {"x": np.array([[3.0], [4.0]])}) == pytest.approx([1.0 + 5.0**4])


def test_rate_of_the_free_pendulum_is_its_generator() -> None:
    """V = 1 + (1 + s)^2, s = omega^2, d omega = dw: LV/V = (2 + 6 s)/V, the supremum over the states as h -> 0."""
    problem = pendulum(c_g=0.0)
    s = norm(extreme_states(problem, problem.ito())[2:4]) ** 2
    rate = found(HalfExplicitEuler(), problem).rate

    assert rate[-1] == pytest.approx(((2.0 + 6.0 * s) / (1.0 + (1.0 + s) ** 2)).max(), rel=1e-4)


def test_rate_of_a_geometric_speed_is_its_generator() -> None:
    """With d omega = -(gamma/2) ... = sigma omega dW, LV/V -> 6 sigma^2 at large speeds, from below."""
    rate = found(HalfExplicitEuler(), pendulum_velocity_noise(sigma=1.0)).rate

    assert 6.0 <= rate[-1] <= 6.5


def test_rate_of_euler_on_a_linear_equation() -> None:
    """Ornstein-Uhlenbeck contracts large states: the rate is the generator's at small ones."""
    problem = ou()
    x = extreme_states(problem, problem)[0]
    theta = -problem.drift(0.0, np.ones((1, 1)))[0, 0]
    sigma = problem.diffusion(0.0, np.ones((1, 1)))[0, 0, 0]
    generator = (-4.0 * theta * x**4 + 6.0 * sigma**2 * x**2) / (1.0 + x**4)

    assert found(EulerMaruyama(), problem).rate[-1] == pytest.approx(generator.max(), rel=1e-3)


@pytest.mark.parametrize("truncation", ["theory", 0.5, 0.9])
@pytest.mark.parametrize("problem", [pendulum(omega_0=5.0), pendulum_velocity_noise()])
def test_truncated_steps_are_bounded(problem: HolonomicSDAE, truncation: str | float) -> None:
    """The truncated scheme is semi-stable on all states; V is bounded whatever h."""
    assert verdict(HalfExplicitEuler(truncation=truncation), problem) is Verdict.VERIFIED


def test_lipschitz_equations_are_bounded() -> None:
    """Euler-Maruyama on linear equations, several motions and schemes that use areas included."""
    assert verdict(EulerMaruyama(), ou()) is Verdict.VERIFIED
    assert verdict(EulerMaruyama(), noncommuting()) is Verdict.VERIFIED
    assert verdict(HeunAdditive(), ou()) is Verdict.VERIFIED


def many_motions(count: int) -> SDE:
    """Return dx = sigma dW in R^2 with many Brownian motions."""
    B = np.linspace(-1.0, 1.0, 2 * count).reshape(2, count, 1)
    return SDE(
        drift=lambda t, x: -x, diffusion=lambda t, x: B, start=[0.3, 0.2], horizon=1.0, noise_dim=count, source="test"
    )


def test_many_motions_have_a_rule_of_their_own() -> None:
    """With 40 Brownian motions the rate is still the generator's: -4 |x|^4 + 2 |x|^2 tr Q + 4 x^T Q x over V."""
    problem = many_motions(40)
    x = extreme_states(problem, problem)
    B = problem.diffusion(0.0, x)[..., 0]
    Q, s = B @ B.T, (x * x).sum(axis=0)
    generator = (-4.0 * s**2 + 2.0 * s * np.trace(Q) + 4.0 * np.einsum("ip,ij,jp->p", x, Q, x)) / (1.0 + s**2)

    assert found(EulerMaruyama(), problem).rate[-1] == pytest.approx(generator.max(), rel=1e-2)


def half_a_power(problem: SDE, x: Array, h: float, noise: Increment) -> Array:
    return np.asarray(x * (1.0 + np.sqrt(h)) + apply(problem.diffusion(0.0, x), noise.dW))


@pytest.mark.parametrize(
    ("scheme", "problem", "words"),
    [
        (HalfExplicitEuler(truncation="none"), pendulum(), "has no root"),
        (EulerMaruyama(), double_well(), "c ~ h^-"),
        (Formula(half_a_power), ou(), "c ~ h^-0.5"),
        (Formula(lambda problem, x, h, noise: x / (np.abs(noise.dW) > 0.1)), ou(), "E[V] is infinite"),
    ],
)
def test_unbounded_growth_decides_nothing(scheme: Scheme, problem: HolonomicSDAE | SDE, words: str) -> None:
    """No root far out, superlinear drift, factors 1 + sqrt(h): moments may or may not be bounded."""
    opinion = judge_growth(found(scheme, problem), problem.horizon)

    assert opinion.verdict is Verdict.INCONCLUSIVE
    assert words in str(opinion.reason)
