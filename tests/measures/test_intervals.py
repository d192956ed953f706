"""Strong orders on each interval of the delay."""

from typing import Any, ClassVar

import numpy as np
import pytest

from facade import SAMPLED, PlatenWeak2, StochasticTheta, delay_test, gbm
from sdaeverify import DelaySDAE, Increment, Settings, Step, verify
from sdaeverify.measures.intervals import GIVEN_PAST, IntervalObserver, Intervals
from sdaeverify.measuring import Evidence, Snapshot, Tally, Verdict

PATHS = 400
SETTINGS = Settings(paths=PATHS, coarsest=4, levels=4)


def health() -> Tally:
    """Return the counts of a run in which nothing went wrong."""
    zeros = np.zeros(SETTINGS.levels)
    counts = {"failed": zeros, "lost": zeros, "truncated": zeros, "steps": np.full(SETTINGS.levels, 1e6)}
    return Tally(sums=counts)


def noted(*orders: float) -> Tally:
    """Return what is noted on two delays of two steps each, with errors of one order on each interval."""
    z = np.random.default_rng(5).normal(size=(1, PATHS))
    observer = IntervalObserver(1.0, 0.5, {"x": np.zeros((1, PATHS))}, SETTINGS)
    for order in np.repeat(orders, 2):
        levels = [{"x": 1.0 + z * (0.5 / 2**level) ** order} for level in range(SETTINGS.levels)]
        observer.after_coarsest_step(Snapshot(levels, {"x": np.ones((1, PATHS))}, None))
    return observer.tally()


def test_each_interval_has_its_own_order() -> None:
    """Errors of order 1 up to the first delay are not mixed with those of order 1/2 after it."""
    problem = delay_test(horizon=2.0)
    evidence = Evidence(StochasticTheta(), problem, problem, SETTINGS, noted(1.0, 0.5), health())
    found = {each.quantity: each for each in Intervals().judge(evidence).findings}
    # Sums over paths are noted with so many binary digits.
    assert found["x up to tau"].estimate == pytest.approx(1.0, abs=2.0**-SAMPLED)
    assert found["x up to 2 tau"].estimate == pytest.approx(0.5, abs=2.0**-SAMPLED)


def test_a_low_order_up_to_the_first_delay_is_refuted() -> None:
    """The same claim of order 1 that set IV keeps there, by paths alone."""
    problem = delay_test(horizon=2.0)
    assert "delayed-noise" in problem.traits
    evidence = Evidence(StochasticTheta(), problem, problem, SETTINGS, noted(0.5, 0.5), health())
    found = {each.quantity: each for each in Intervals().judge(evidence).findings}
    assert found["x up to tau"].claim is not None
    assert found["x up to tau"].claim.value.least == 1.0
    assert found["x up to tau"].verdict is Verdict.REFUTED


def test_consistency_given_the_past_is_a_finding_of_its_own() -> None:
    """Theorem 3.1, verified by probing."""
    problem, measure = delay_test(horizon=2.0), Intervals()
    tally = measure.probe(StochasticTheta(), problem, SETTINGS)
    evidence = Evidence(StochasticTheta(), problem, problem, SETTINGS, tally, health())
    (found,) = (each for each in measure.judge(evidence).findings if each.quantity == GIVEN_PAST)
    assert found.verdict is Verdict.VERIFIED
    assert found.estimate == pytest.approx(0.5, abs=0.05)


def test_what_makes_no_sense_is_refused() -> None:
    """No delay, a run within the first delay, and increments that are not Brownian."""
    measure = Intervals()
    assert measure.refuses(StochasticTheta(), gbm()) == "the problem has no delay"
    assert "within the first delay" in measure.refuses(StochasticTheta(), delay_test(horizon=1.0))
    assert "not Brownian" in measure.refuses(PlatenWeak2(), delay_test())
    assert measure.refuses(StochasticTheta(), delay_test()) == ""


class Still(StochasticTheta):
    """Stays where it is: exact against itself."""

    name: ClassVar[str] = "still"

    def step(self, problem: DelaySDAE, state: Any, t: float, h: float, noise: Increment) -> Step:
        """Make no step."""
        return Step(state)


@pytest.mark.long
def test_exact_steps_are_verified_though_no_exact_solution_is_known() -> None:
    """Up to the first delay one step and paths are exact to round-off; who stands still agrees with itself alone."""
    found = verify([StochasticTheta(), Still()], "delay-martingale", "intervals", paths=64, block=64).verdicts
    rows = {row.scheme: row for row in found[found.quantity == "x up to tau"].itertuples()}

    assert rows["stochastic-theta"].verdict == "verified"
    assert rows["stochastic-theta"].reason.endswith("exact to round-off at all 6 step sizes.")
    assert "still" not in rows or rows["still"].verdict != "verified"
    assert "refuted" in set(found[found.scheme == "still"].verdict)
