"""A guard has power: paths that could not show an error that a claim forbids guard nothing."""

from dataclasses import replace
from functools import partial
from typing import ClassVar

import numpy as np
import pytest

from facade import MeanObserver, StochasticTheta, delay_test, mean_order, means_of, path_tests
from sdaeverify import SDE, Claim, Moment, Scheme, Settings, Step, verify
from sdaeverify.measuring import Estimate, Evidence, Opinion, Reason, Snapshot, Tally, Verdict, decide, guard
from sdaeverify.numerics import apply, second_directional

LOCAL = Opinion(Verdict.VERIFIED, Reason("local weak order 1.000"), 1)
KNOWN, WRONG = 0.7503, 0.376


def evidence_of(paths: int, mean: float, spread: float) -> Evidence:
    """Return evidence on x of set II at T = 4: of paths with one mean and errors of order 1."""
    settings = Settings(paths=paths)
    truth = Moment(observable="x", value=lambda t: KNOWN, source="known")
    problem = replace(delay_test("II", horizon=4.0), truths=(truth,))
    x = mean + spread * np.random.default_rng(11).standard_normal(paths)
    levels = [{"x": (x + 0.02 * h)[None], "y": 0.0 * x[None]} for h in 1.0 / np.array(settings.steps)]
    observer = MeanObserver(problem, levels[0], settings)
    observer.after_coarsest_step(Snapshot(levels, {}, None))
    zeros = np.zeros(settings.levels)
    health = Tally(sums={"failed": zeros, "lost": zeros, "truncated": zeros, "steps": zeros + 1e6})
    return Evidence(StochasticTheta(0.0), problem, problem, settings, observer.tally(), health, level=settings.level)


def decision(paths: int, mean: float, spread: float):
    evidence = evidence_of(paths, mean, spread)
    claim = next(claim for claim in StochasticTheta().claims if claim.measure == "weak")
    with np.errstate(all="ignore"):
        tests = mean_order(evidence, means_of(evidence)["x"], claim).tests
    return guard(LOCAL, tests, evidence), tests


def test_few_paths_do_not_guard_a_mean_with_a_wide_spread():
    """256 paths of spread 1.5 could not tell .376 from .750: the verdict waits for paths and says how many."""
    for mean in (KNOWN, WRONG):
        found, tests = decision(256, mean, 1.5)
        assert found.verdict is Verdict.INCONCLUSIVE
        assert not found.settled
        assert tests.blind > 1.0
        assert "would" in str(found.reason)


def test_with_the_paths_that_were_asked_for_the_mean_is_guarded():
    """Then the right mean is verified, and the wrong one refuted."""
    _, tests = decision(256, KNOWN, 1.5)
    enough = int(2 ** np.ceil(np.log2(256 * tests.blind)))

    assert decision(enough, KNOWN, 1.5)[0].verdict is Verdict.VERIFIED
    assert decision(4 * enough, WRONG, 1.5)[0].verdict is Verdict.REFUTED


def test_an_error_that_the_guard_is_said_to_see_is_seen():
    """At a growth of 1, an error of the size shows with the probability of the confidence."""
    one = Estimate(0.0, 0.1)
    needed = 0.1 * 2.0 * 2.5394831906222883  # twice the 99 % quantile of t with 19 degrees of freedom

    assert one.growth_to_see(1.001 * needed, 0.99) == 1.0
    assert one.growth_to_see(0.5 * needed, 0.99) == pytest.approx(4.0)
    assert one.growth_to_see(needed, 0.99, bias=0.5 * needed) == pytest.approx(4.0)
    assert np.isinf(one.growth_to_see(0.0, 0.99))
    assert np.isinf(Estimate(0.0, np.nan).growth_to_see(1.0, 0.99))


def test_a_guard_that_no_paths_can_help_is_settled():
    """Without a finite growth nothing more is asked for, and nothing is verified."""
    tests = path_tests.PathTests(1.0, 1.0, Reason(), blind=np.inf)
    found = guard(LOCAL, tests, evidence_of(256, KNOWN, 0.1))

    assert found.verdict is Verdict.INCONCLUSIVE
    assert found.settled
    assert "nor could more" in str(found.reason)


@pytest.mark.parametrize(("drawn", "growth", "settled"), [(512, 1.9, False), (512, 2.1, True), (256, 5.0, False)])
def test_the_last_look_is_saved_where_half_of_all_paths_say_that_all_are_too_few(drawn, growth, settled):
    """Both where paths decide and where they guard, and not before half of the paths are drawn."""
    evidence = replace(evidence_of(drawn, KNOWN, 0.1), settings=Settings(paths=1024))

    assert decide(path_tests.PathTests(1.0, 1.0, Reason(), growth), evidence).settled is settled
    assert guard(LOCAL, path_tests.PathTests(1.0, 1.0, Reason(), blind=growth), evidence).settled is settled


@pytest.mark.parametrize(("growth", "told"), [(1.01, "1100"), (2.1, "2200"), (10.0, "11000"), (1e3, "1100000")])
def test_paths_that_would_decide_are_rounded_up(growth, told):
    """A run of 1024 paths is never told that 1000 would decide, and which option takes the number."""
    assert str(decided(growth).reason) == f"about {told} paths would decide (--paths)"


def decided(growth, **tests):
    """Return what is said of 1024 paths that reject nothing but what is given."""
    evidence = replace(evidence_of(1024, KNOWN, 0.1), settings=Settings(paths=1024))
    return decide(path_tests.PathTests.none("", growth)._replace(**tests), evidence)


def test_more_paths_than_a_run_takes_are_not_asked_for():
    """10^9 is the most of --paths."""
    assert str(decided(1e7).reason) == "more than 1e+09 paths, the maximum of --paths, would be needed"
    guarded = guard(LOCAL, path_tests.PathTests(1.0, 1.0, Reason(), blind=1e7), evidence_of(1024, KNOWN, 0.1))
    assert str(guarded.reason).endswith(
        "1024 paths cannot exclude a violation, nor could 1e+09, the maximum of --paths"
    )


def test_a_sample_that_is_large_enough_by_its_figures_asks_for_no_more_paths():
    """An order told from the bound that is open all the same; the number would be that of the run, rounded up."""
    assert str(decided(1.0).reason) == ""
    assert str(decided(1.0, refuted=0.01).reason) == "more paths would decide (--paths)"
    doubted = decided(1.0, verified=0.0, suspected=0.004)
    assert doubted.verdict is Verdict.INCONCLUSIVE
    assert "(p = 0.004): finer steps would decide (--levels)" in str(doubted.reason)


def test_a_truth_that_is_lacking_is_asked_for_in_place_of_paths():
    """Sampling goes on as it would, as more paths may still refute; no number of them is named."""
    found = decided(5.0, remedy=path_tests.ask_for_truth("a Moment of x"))
    assert "unless a Moment of x is attached to the problem" in str(found.reason)
    assert "paths would decide" not in str(found.reason)
    assert decided(5.0).settled is found.settled


class ItoTaylor(Scheme):
    """The step of strong order 3/2 that is the truth of `double-well`."""

    name: ClassVar[str] = "ito-taylor"
    form: ClassVar[type] = SDE
    noise: ClassVar[frozenset[str]] = frozenset({"dW", "H"})
    claims: ClassVar[tuple[Claim, ...]] = (
        Claim(measure="strong", value=1.5, source="Kloeden & Platen 1992, (10.4.5)", sense="in probability"),
    )

    def step(self, problem, state, t, h, noise):
        """Make one step for a drift that does not depend on time."""
        x, Df, Z = state, problem.derivative_of_drift(t, state), noise.time_integral(h)
        f = problem.drift(t, x) + 0.0 * x
        columns = (column + 0.0 * x for column in np.swapaxes(problem.diffusion(t, x), 0, 1))
        bent = sum(second_directional(partial(problem.drift, t), x, b, b) for b in columns)
        moved = x + h * f + problem.diffused(t, x, noise.dW) + apply(Df, problem.diffused(t, x, Z) + 0.0 * x)
        return Step(moved + 0.5 * h * h * (apply(Df, f) + 0.5 * bent))


def test_a_scheme_whose_step_is_that_of_the_truth_is_verified():
    """There is no slope at half the resolution of the truth; the one at full resolution guards all the same."""
    found = verify(ItoTaylor(), "double-well", "strong", paths=256, jobs=1).verdicts

    assert set(found.verdict) == {"verified"}
