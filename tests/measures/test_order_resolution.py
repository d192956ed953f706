"""Orders that paths alone decide: what a term of a lower order may be of the error at the finest step."""

from dataclasses import dataclass
from math import inf, nan
from typing import Any, ClassVar

import numpy as np
import pytest

from cells import claimant
from facade import (
    SRA1,
    SRI1W1,
    BalancedEuler,
    DisplacedEuler,
    EulerMaruyama,
    HeunAdditive,
    Milstein,
    PlatenWeak2,
    Strong,
    Study,
    gbm,
    growing_volatility,
    lower_term_weights,
    ou,
    plan,
    problem_spec,
    resolve_order,
)
from sdaeverify import SDE, Array, Claim, Increment, Settings, Step
from sdaeverify.measuring import Estimate, Evidence, Kind, Order, PathTests, Reason, Tally, Verdict, decide
from sdaeverify.numerics import apply

H = 2.0 ** -np.arange(3.0, 8.0)
X = np.log2(H)


@dataclass(frozen=True)
class ScaledMilstein(Milstein):
    """Milstein's scheme with a factor on its iterated integral; of strong order 1/2 unless the factor is 1."""

    factor: float = 1.0

    name: ClassVar[str] = "scaled-milstein"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        euler = state + h * problem.drift(t, state) + apply(problem.diffusion(t, state), noise.dW)
        right: Any = super().step(problem, state, t, h, noise).state
        return Step(euler + self.factor * (right - euler))


class Deaf(ScaledMilstein):
    """The same, saying that its step jumps as a function of the noise, so that one step is not probed."""

    name: ClassVar[str] = "deaf-milstein"
    discontinuous_in_noise: ClassVar[bool] = True


class Loose(ScaledMilstein):
    """The same, saying that a low order of one step does not bound its order."""

    name: ClassVar[str] = "loose-milstein"
    local_order_is_global: ClassVar[bool] = False


@dataclass(frozen=True)
class OneAndAHalf(SRA1):
    """SRA1 with a factor on the shift of its second stage, not probed; of strong order 1 unless the factor is 1."""

    factor: float = 1.0

    name: ClassVar[str] = "deaf-sra1"
    discontinuous_in_noise: ClassVar[bool] = True

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        x, mean = state, noise.time_integral(h) / h
        f, later = problem.drift(t, x), problem.diffused(t + h, x, mean)
        y = x + 0.75 * h * f + 1.5 * self.factor * later
        kick = problem.diffused(t + h, x, noise.dW) - later + problem.diffused(t, x, mean)
        return Step(x + h / 3.0 * (f + 2.0 * problem.drift(t + 0.75 * h, y)) + kick)


CONTROLS = (
    BalancedEuler(),
    DisplacedEuler(),
    EulerMaruyama(),
    HeunAdditive(),
    Milstein(),
    PlatenWeak2(),
    SRA1(),
    SRI1W1(),
)


def controls(label):
    """Return a shipped control of the problems here."""
    return next(scheme for scheme in CONTROLS if scheme.label == label)


def findings(scheme, family, settings=None):
    """Return the findings of a run on strong order."""
    made = Study(plan([scheme], [problem_spec(family)], [Strong()], controls), settings or Settings())
    for _ in made.run():
        pass
    return made.results()[0].findings


@pytest.mark.sweep(others="slow")
@pytest.mark.long
@pytest.mark.parametrize(
    ("scheme", "family"),
    [
        (Deaf(factor=0.96), gbm),
        (Loose(factor=0.96), gbm),
        (Deaf(factor=1.04), gbm),
        (Loose(factor=1.05), growing_volatility),
        (Deaf(factor=0.94), growing_volatility),
        (OneAndAHalf(factor=0.99), ou),
        (OneAndAHalf(factor=1.02), ou),
    ],
)
def test_a_wrong_coefficient_is_not_verified_by_paths(scheme, family):
    """Errors of a lower order that those of the claimed one hide on coarse steps show on finer ones."""
    assert Verdict.VERIFIED not in {found.verdict for found in findings(scheme, family)}


@pytest.mark.parametrize(
    ("scheme", "family"),
    [
        (Deaf(), gbm),
        *(
            pytest.param(*each, marks=pytest.mark.long)
            for each in ((Deaf(), growing_volatility), (OneAndAHalf(), ou))
        ),
    ],
)
def test_a_right_coefficient_is_verified_by_paths(scheme, family):
    """The share of a term of half an order less is below a tenth, and is shown."""
    for found in findings(scheme, family):
        assert found.verdict is Verdict.VERIFIED
        assert found.tier == 3
        assert 0.0 <= found.order_resolution < 0.1


def test_one_step_needs_no_order_resolution():
    """Where one step decides, paths only guard it."""
    assert {str(found.order_resolution) for found in findings(Milstein(), gbm)} == {"nan"}


@pytest.mark.parametrize("order", [0.5, 1.0, 2.5])
@pytest.mark.parametrize("share", [0.0, 0.02, 0.1])
def test_weights_find_the_share_of_the_lower_term(order, share):
    """For errors b h^p (1 - s + s u^(-1/2)), u = h/h_L, to the second order in s."""
    u = H / H[-1]
    y = np.log2(3.0 * H**order * (1.0 - share + share * u**-0.5))

    assert lower_term_weights(X) @ (y - order * X) == pytest.approx(share, abs=0.5 * share**2 + 1e-12)


def test_weights_do_not_see_the_next_term():
    """A factor exp(c h) leaves the share as it is."""
    assert lower_term_weights(X) @ (2.0 * H) == pytest.approx(0.0, abs=1e-12)


ONE = Claim(measure="strong", value=1.0, source="test")
EVIDENCE = Evidence(
    claimant(ONE), gbm(), gbm(), Settings(), Tally(sums={"paths": np.full(20, 64.0)}), Tally(), level=1e-6
)
SHOWN = PathTests(1e-9, 1.0, Reason("order"))


def resolved(share, tests=SHOWN, bias=0.0):
    """Return the tests of order 1 with the share of a lower term."""
    return resolve_order(tests, Order(1.0), share, EVIDENCE, bias)


@pytest.mark.parametrize(
    ("share", "bias", "verified"),
    [
        (Estimate(0.0, 0.02), 0.0, 1e-9),
        (Estimate(-0.5, 0.02), 0.0, 1e-9),
        # t_19(0.99) = 2.539
        (Estimate(0.049, 0.02), 0.0, 1e-9),
        (Estimate(0.050, 0.02), 0.0, 1.0),
        (Estimate(0.049, 0.02), 0.01, 1.0),
        (Estimate(0.0, inf), 0.0, 1.0),
        (Estimate(nan, nan), 0.0, 1.0),
    ],
)
def test_a_tenth_of_the_error_is_the_most_for_a_lower_term(share, bias, verified):
    """By the upper end of a one-sided interval; a share that is not known is too large."""
    assert resolved(share, bias=bias).verified == verified


def test_more_paths_decide_a_small_share_and_finer_steps_a_large_one():
    """A share below a tenth asks for paths, a larger one for finer steps."""
    small, large = (decide(resolved(share), EVIDENCE) for share in (Estimate(0.05, 0.03), Estimate(0.2, 0.03)))

    assert small.reason.has(Kind.MORE_PATHS)
    # (2.539 * 0.03/0.05)^2 = 2.32 times 1280 paths.
    assert small.reason.paths == 3000.0
    assert large.reason.has(Kind.FINER)
    assert not small.settled
    assert not large.settled
    assert {small.p_verified, large.p_verified} == {1.0}


def test_a_share_that_is_not_excluded_is_not_verified_by_all_tests_of_a_run():
    """An order that is not significant at one look has no p-value for it either."""
    assert resolved(Estimate(0.3, 0.1), SHOWN._replace(verified=1e-3)).verified == 1.0
