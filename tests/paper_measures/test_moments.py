"""The moments measure: bounded, too large and not decided, from prescribed paths and from runs."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np
import pytest

from cells import claimant
from facade import (
    FACTOR,
    Entry,
    EulerMaruyama,
    Growth,
    HalfExplicitEuler,
    MomentObserver,
    Moments,
    Task,
    ou,
    pendulum,
    problem_spec,
    run_block,
)
from facade import moments_EDGES as EDGES
from sdaeverify import Array, Claim, HolonomicSDAE, Scheme, Settings
from sdaeverify.measuring import Evidence, Finding, Judgement, Snapshot, Tally, Verdict, packed

SETTINGS = Settings(paths=2048, levels=3)
BOUNDED = Claim(measure="moments", value="bounded", source="test")
STEADY = packed("growth", Growth(np.array([0.1, 0.05]), np.array([2.0, 2.0]), np.ones(2), np.array(9.0)))
WILD = packed("growth", Growth(np.array([0.1, 0.05]), np.array([10.0, 20.0]), np.ones(2), np.array(9.0)))
NOTHING = Tally()
CLAIMANT = claimant(BOUNDED)
IN_WORDS = claimant(Claim(measure="moments", value="small", source="test"))
SIZES = 1.0 + 0.2 * np.random.default_rng(5).standard_normal(2048)


@dataclass(frozen=True)
class Untruncated(HalfExplicitEuler):
    """The half-explicit scheme without truncation that claims bounded moments."""

    truncation: str | float = "none"

    name: ClassVar[str] = "untruncated"
    promises: ClassVar[tuple[Claim, ...]] = (BOUNDED,)


def judged(
    x: Callable[[int], Array],
    probed: Tally = NOTHING,
    truth: Array = SIZES,
    scheme: Scheme = CLAIMANT,
    without_root: int = 0,
) -> Judgement:
    """Return the rows of paths whose sizes are given as a function of the level, and of the truth."""
    problem, levels = ou(), range(SETTINGS.levels)
    observer = MomentObserver(problem, {"x": np.zeros((1, len(truth)))}, SETTINGS)
    observer.after_coarsest_step(Snapshot([{"x": x(level)[None]} for level in levels], {"x": truth[None]}, None))
    health = Tally(sums={"without_root": np.full(len(levels), float(without_root))})
    tally = observer.tally().merge(probed)
    with np.errstate(all="ignore"):
        return Moments().judge(Evidence(scheme, problem, problem, SETTINGS, tally, health, 1e-5))


def finding(*arguments: Any, **named: Any) -> Finding:
    (found,) = judged(*arguments, **named).findings
    return found


def test_bounded_growth_in_one_step_verifies() -> None:
    """What one step bounds is verified, guarded by the paths."""
    found = finding(lambda level: SIZES, STEADY)

    assert (found.verdict, found.tier) == (Verdict.VERIFIED, 1)
    assert found.estimate == pytest.approx(1.0)
    assert found.details["growth_rate"] == 2.0


def test_paths_alone_verify_what_cannot_be_probed() -> None:
    """Where the map cannot be probed, light-tailed moments within the factor are verified by the paths."""
    found = finding(lambda level: 1.2 * SIZES)

    assert (found.verdict, found.tier) == (Verdict.VERIFIED, 3)
    assert 1.5 < found.low < found.estimate < found.high < 2.0


def test_unbounded_growth_in_one_step_is_never_verified() -> None:
    """Right moments on all paths do not verify what rare paths may break; nor do more paths."""
    found = finding(lambda level: SIZES, WILD)

    assert (found.verdict, found.settled) == (Verdict.INCONCLUSIVE, True)
    assert "rare paths" in str(found.reason)


@pytest.mark.parametrize("probed", [NOTHING, WILD, STEADY])
def test_moments_that_are_too_large_are_refuted(probed: Tally) -> None:
    """Paths three times too large at one level are refuted, even where one step would be bounded."""
    found = finding(lambda level: SIZES * (3.0 if level == 1 else 1.0), probed)

    assert (found.verdict, found.tier) == (Verdict.REFUTED, 3)
    assert "more paths are large at h = 0.0625" in str(found.reason)


@pytest.mark.parametrize("far", [1e6, np.inf, np.nan])
def test_few_paths_that_explode_refute(far: float) -> None:
    """Five of 2048 paths at 1e6, or at infinity, are more than Markov's inequality allows; no mean is needed."""
    found = finding(lambda level: np.where(np.arange(2048) < 5, far, SIZES))

    assert found.verdict is Verdict.REFUTED


def test_heavy_tails_are_refuted_by_shares() -> None:
    """Moments that are infinite, P(V > s) = s^(-1/2), have no interval and are told by the share of large values."""
    u = (np.arange(2048) + 0.5) / 2048
    found = finding(lambda level: 2.0 * np.roll(u, 7 * level) ** -0.5)

    assert found.verdict is Verdict.REFUTED


def test_heavy_tails_within_the_factor_are_not_verified_by_paths() -> None:
    """One path that carries the moment is no evidence of a bounded one, and none against it."""
    found = finding(lambda level: np.where(np.arange(2048) < 1, 9.0, SIZES))

    assert found.verdict is Verdict.INCONCLUSIVE


def test_moments_within_the_factor_are_not_refuted() -> None:
    """At 1.8 times the solution's size the moment is ten times too large, and still within 2^4."""
    assert finding(lambda level: 1.8 * SIZES, STEADY).verdict is Verdict.VERIFIED
    assert finding(lambda level: 1.8 * SIZES, WILD).verdict is Verdict.INCONCLUSIVE


def test_paths_without_root_are_not_verified_by_paths() -> None:
    """A path that stood still has another moment than the scheme's."""
    found = finding(lambda level: SIZES, without_root=1)

    assert found.verdict is Verdict.INCONCLUSIVE
    assert "steps without root" in str(found.reason)


@pytest.mark.parametrize("truth", [np.where(np.arange(2048) < 1, 1e3, SIZES), np.full(2048, np.nan)])
def test_an_unknown_moment_of_the_solution_decides_nothing_by_paths(truth: Array) -> None:
    """Where the solution's moment rests on few paths, or is not known, there is nothing to compare with."""
    found = finding(lambda level: 10.0 * SIZES, truth=truth)

    assert found.verdict is Verdict.INCONCLUSIVE
    assert "moment of the exact solution" in str(found.reason)


def test_few_paths_ask_for_more() -> None:
    """256 paths refute at no deep level: a suspicion asks for more, and so does it of a guard."""
    found = finding(lambda level: 4.0 * SIZES[:256], STEADY, truth=SIZES[:256])

    assert (found.verdict, found.settled) == (Verdict.INCONCLUSIVE, False)


@pytest.mark.slow
def test_false_alarms_are_rare() -> None:
    """Moments at exactly the bound, light or heavy-tailed, are refuted in none of 200 samples at level 1e-5."""
    rng, alarms = np.random.default_rng(11), 0
    for _ in range(200):
        truth = np.exp(0.1 * rng.standard_normal(1024))
        V = FACTOR * (1.0 + truth**4) * rng.gamma(0.1, 10.0, 1024)
        alarms += finding(lambda level: np.maximum(V - 1.0, 0.0) ** 0.25, WILD, truth).verdict is Verdict.REFUTED  # noqa: B023

    assert alarms == 0


def test_other_words_and_no_claim() -> None:
    """A claim in other words is not judged; a cell without one is refused, so that nothing is sampled."""
    assert finding(lambda level: SIZES, scheme=IN_WORDS).verdict is Verdict.INCONCLUSIVE
    assert "no claim" in Moments().refuses(EulerMaruyama(), ou())
    assert "no claim" in Moments().refuses(HalfExplicitEuler(truncation="none"), pendulum())
    assert Moments().refuses(HalfExplicitEuler(), pendulum()) == ""


def test_levels_show_moments_and_tails() -> None:
    """Each level has its moment with its error, the ratio, and the tail's index and largest share."""
    rows = judged(lambda level: 2.0 ** (0.25 * level) * SIZES).levels

    V = 1.0 + SIZES**4
    assert rows[0].estimate == pytest.approx(V.mean(), rel=1e-4)
    assert [row.details["ratio"] for row in rows] == pytest.approx(
        [(1.0 + 2.0**level * SIZES**4).mean() / V.mean() for level in range(3)], rel=1e-4
    )
    assert rows[0].details["largest_share"] == pytest.approx(V.max() / V.sum())


def test_the_observer_keeps_the_largest_value_over_time() -> None:
    """V is the maximum over the coarsest grid; what the truth does not know is NaN."""
    observer = MomentObserver(ou(), {"x": np.ones((1, 40))}, SETTINGS)
    for size in (3.0, 2.0):
        observer.after_coarsest_step(Snapshot([{"x": np.full((1, 40), size)}] * 3, {"y": np.ones((1, 40))}, None))
    tally = observer.tally()

    assert observer.worst[:3] == pytest.approx(82.0)
    assert np.isnan(observer.worst[3]).all()
    assert tally.sums["histogram"].shape == (4, len(EDGES) - 1)
    assert (tally.sums["histogram"].sum(axis=1) == 40).all()


def run(scheme: Scheme, problem: Callable[..., HolonomicSDAE], **parameters: str) -> Finding:
    """Run one block of a cell and judge it."""
    settings = replace(SETTINGS, paths=1024, block=1024)
    spec, measure = problem_spec(problem, parameters), Moments()
    task = Task(spec, (Entry(scheme, (measure,)),), settings)
    lanes = [run_block(task, block)[0] for block in range(settings.blocks)]
    view: Any = spec.build()
    tally, health = lanes[0].probes[0], Tally()
    for lane in lanes:
        assert lane.errors == ("",)
        tally, health = tally.merge(lane.tallies[0]), health.merge(lane.health)
    with np.errstate(all="ignore"):
        (found,) = measure.judge(Evidence(scheme, view, view, settings, tally, health, 1e-5)).findings
    return found


@pytest.mark.slow
def test_the_untruncated_scheme_heats() -> None:
    """From omega_0 = 5 without truncation moments at coarse h are refuted; with it they are bounded."""
    fast = {"omega_0": "5", "horizon": "1"}

    assert run(Untruncated(), pendulum, **fast).verdict is Verdict.REFUTED
    truncated = run(HalfExplicitEuler(), pendulum, **fast)
    assert truncated.verdict is Verdict.VERIFIED
    assert truncated.high < 1.5
