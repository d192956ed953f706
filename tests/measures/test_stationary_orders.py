"""Orders of stationary means without sampling, on shipped problems: limits that are right, symmetries, stiffness."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import pytest

from facade import (
    BAOAB,
    EulerMaruyama,
    UniformExpansion,
    UniformlyAccurate,
    affine_constraint,
    angle_pendulum,
    double_well,
    exponential_strip,
    operator_findings,
    operator_orders,
    ou,
    stationary_record,
)
from sdaeverify import Claim, Settings, Step
from sdaeverify.measuring import Evidence, Finding, Tally, Verdict


@dataclass(frozen=True)
class FirstOrder(BAOAB):
    """BAOAB whose Ornstein-Uhlenbeck step is of order 1: with c = 1 - gamma h, or with variance 1 - c."""

    linear: bool = True
    order: float = 2.0

    @property
    def promises(self):
        """The claim that is tested."""
        return (Claim(measure="invariant", value=self.order, source="test"),)

    def step(self, problem, state, t, h, noise):
        """Make one step."""
        n, gamma = problem.noise_dim, problem.friction
        exact = np.exp(-gamma * h)
        c, variance = (1.0 - gamma * h, (1.0 - exact**2) / 2.0) if self.linear else (exact, 1.0 - exact)
        p = state[n:] + 0.5 * h * problem.force(state[:n])
        middle = c * p + problem.strength * np.sqrt(variance / (gamma * h)) * noise.dW
        q = state[:n] + 0.5 * h * (p + middle)
        return Step(np.concatenate([q, middle + 0.5 * h * problem.force(q)]))


@dataclass(frozen=True)
class Loud(EulerMaruyama):
    """Euler-Maruyama with five per cent too much noise, or with the exact variance on dx = -theta x dt + sigma dW."""

    exact: float = 0.0
    claims: ClassVar = (Claim(measure="invariant", value=1.0, source="test"),)

    def step(self, problem, state, t, h, noise):
        """Make one step."""
        factor = np.sqrt(1.0 - 0.5 * self.exact * h) if self.exact else 1.05
        return super().step(problem, state, t, h, noise._replace(dW=factor * noise.dW))


@dataclass(frozen=True)
class Right(EulerMaruyama):
    """Euler-Maruyama with an order that is claimed for all equations."""

    claims: ClassVar = Loud.claims


def findings(scheme, problem) -> dict[str, Finding]:
    """Return what is found without sampling."""
    settings, view = Settings(tests_reserved=1), scheme.view_of(problem)
    evidence = Evidence(scheme, view, view, settings, Tally(), Tally(), level=settings.level)
    record = stationary_record(evidence)
    assert record is not None
    return {found.quantity: found for found in operator_findings(evidence, record, operator_orders(record, view))}


def verdicts(scheme, problem) -> dict[str, Verdict]:
    """Return the verdicts alone."""
    return {name: found.verdict for name, found in findings(scheme, problem).items()}


@pytest.mark.parametrize("linear", [True, pytest.param(False, marks=pytest.mark.slow)])
def test_a_right_limit_of_order_one_is_called_an_order(linear):
    """The order 1 of a linear friction or variance verifies a claim of 1, and refutes one of 2 as what it is."""
    problem = angle_pendulum()
    first, second = (findings(FirstOrder(linear, order), problem) for order in (1.0, 2.0))
    for name in ("cos q", "cos^2 q", "p^2"):
        assert first[name].verdict is Verdict.VERIFIED
        assert second[name].verdict is Verdict.REFUTED
        assert second[name].estimate == pytest.approx(1.0, abs=1e-3)
        assert "order 1.00 of the error of the stationary mean" in str(second[name].reason)
        assert "wrong limit" not in str(second[name].reason)


@pytest.mark.parametrize("scheme", [Right(), Loud()], ids=["right", "loud"])
@pytest.mark.parametrize(
    ("problem", "fixed"),
    [(double_well, {"x"}), pytest.param(angle_pendulum, {"sin q", "p"}, marks=pytest.mark.slow)],
)
def test_means_that_a_symmetry_fixes_tell_nothing(scheme, problem, fixed):
    """They are uninformative for right and wrong schemes alike, whose other means tell them apart."""
    found = verdicts(scheme, problem())
    assert {name for name, verdict in found.items() if verdict is Verdict.NOT_APPLICABLE} == fixed
    wrong = Verdict.REFUTED in found.values()
    assert wrong == isinstance(scheme, Loud)
    assert wrong or {found[name] for name in set(found) - fixed} == {Verdict.VERIFIED}


def test_exactness_that_no_symmetry_explains_is_verified():
    """A scheme with the exact variance of dx = -x dt + 0.7 dW has no error in x^2; odd means tell nothing."""
    found = findings(Loud(exact=1.0), ou(1.0, 0.7))
    odd = {name for name, each in found.items() if each.verdict is Verdict.NOT_APPLICABLE}
    assert odd == {"x", "x^3"}
    assert {found[name].verdict for name in set(found) - odd} == {Verdict.VERIFIED}
    assert found["x^2"].estimate == np.inf


@pytest.mark.parametrize(
    "scheme",
    [
        UniformlyAccurate(),
        *(pytest.param(each, marks=pytest.mark.slow) for each in (UniformlyAccurate(theta=1.0), EulerMaruyama())),
    ],
)
def test_steps_follow_the_stiffness(scheme):
    """On a flat with eps = 0.01 the step sizes go on to eps/64, and order 1 is verified."""
    found = findings(scheme, affine_constraint(eps=0.01))
    assert found["x_1^2"].verdict is found["|zeta|^2"].verdict is Verdict.VERIFIED
    assert not any(each.verdict is Verdict.REFUTED for each in found.values())


@pytest.mark.slow
def test_what_no_step_size_resolves_is_not_refuted():
    """With eps = 1e-5 no step size that is used resolves the fastest time: what looks wrong is left open."""
    found = findings(Loud(), affine_constraint(eps=1e-5))
    assert not {Verdict.REFUTED, Verdict.VERIFIED} & {each.verdict for each in found.values()}


@pytest.mark.slow
@pytest.mark.parametrize("eps", [0.01, 0.003, 0.001])
@pytest.mark.parametrize("scheme", [UniformlyAccurate(), UniformlyAccurate(theta=1.0), UniformExpansion()])
def test_uniform_schemes_have_order_one_on_the_strip(scheme, eps):
    """Errors of t stay at 0.005 for steps above eps and have order 1 below."""
    found = verdicts(scheme, exponential_strip(eps=eps))
    assert set(found.values()) <= {Verdict.VERIFIED, Verdict.NOT_APPLICABLE}
    assert found["t"] is Verdict.VERIFIED
