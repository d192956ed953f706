"""The solvability measure: a root at every step size, failures on paths, and shares without a claim."""

from typing import ClassVar

import numpy as np
import pytest

from facade import (
    QUICSORT,
    Entry,
    EulerMaruyama,
    HalfExplicitEuler,
    MilsteinAreas,
    PathCount,
    Solvability,
    StochasticTheta,
    Task,
    harmonic_langevin,
    levy_area,
    ou,
    pendulum,
    problem_spec,
    run_block,
)
from sdaeverify import Claim, Problem, Scheme, Settings
from sdaeverify.measuring import Evidence, Finding, Judgement, Tally, Verdict

SETTINGS = Settings(paths=256, levels=3)
EVERY_H = Claim(measure="solvability", value="every h", source="test")


class Claimant(HalfExplicitEuler):
    """The half-explicit scheme that claims a root for every h, with whatever truncation."""

    name: ClassVar[str] = "claimant"
    promises: ClassVar[tuple[Claim, ...]] = (EVERY_H,)


class InWords(Claimant):
    """The same that claims something unknown."""

    promises: ClassVar[tuple[Claim, ...]] = (Claim(measure="solvability", value="mostly", source="test"),)


def judged(
    scheme: Scheme, problem: Problem, without_root: tuple[int, ...] = (0, 0, 0), paths: int = 256
) -> Judgement:
    """Probe and judge a cell whose paths met so many steps without root."""
    measure = Solvability()
    assert measure.refuses(scheme, problem) == ""
    probed = measure.probe(scheme, problem, SETTINGS)
    counted = PathCount({"x": np.zeros((1, paths))}, SETTINGS).tally()
    health = Tally(sums={"without_root": np.array(without_root, dtype=float)})
    return measure.judge(Evidence(scheme, problem, problem, SETTINGS, probed.merge(counted), health))


def root(judgement: Judgement) -> Finding:
    (found,) = [finding for finding in judgement.findings if finding.quantity == "root"]
    return found


def test_truncation_of_the_theory_is_verified() -> None:
    """Theorem 3.4: with the theory's constants there is a root at all step sizes and states."""
    found = root(judged(HalfExplicitEuler(), pendulum()))

    assert (found.verdict, found.tier) == (Verdict.VERIFIED, 1)
    assert "a root at all 19 step sizes from 1e-06 to 1e+03" in str(found.reason)
    assert "|v| up to 1e+08" in str(found.reason)


@pytest.mark.parametrize("truncation", ["none", 2.0])
def test_missing_and_weak_truncation_are_refuted(truncation: str | float) -> None:
    """Without truncation, or with C_eta = 2, the claim is refuted by one step, and the state is named."""
    found = root(judged(Claimant(truncation=truncation), pendulum()))

    assert (found.verdict, found.tier) == (Verdict.REFUTED, 1)
    assert "the smallest h = " in str(found.reason)
    assert "where |r| = 1, |v| = " in str(found.reason)


def test_one_failure_on_a_path_refutes_what_the_probe_finds_nothing_against() -> None:
    """A single path without root is a counterexample, whatever the probed states say."""
    found = root(judged(HalfExplicitEuler(), pendulum(), (0, 1, 0)))

    assert (found.verdict, found.tier) == (Verdict.REFUTED, 3)
    assert "0.00391 at h = 0.0312" in str(found.reason)


def test_few_paths_do_not_guard() -> None:
    """With 40 paths nothing is verified."""
    assert root(judged(HalfExplicitEuler(), pendulum(), paths=40)).verdict is Verdict.INCONCLUSIVE


def test_words_that_mean_nothing_decide_nothing() -> None:
    """A claim in other words is not judged."""
    found = root(judged(InWords(), pendulum()))

    assert found.verdict is Verdict.INCONCLUSIVE
    assert "no test for the claimed value 'mostly'" in str(found.reason)


def test_shares_are_shown_without_a_claim() -> None:
    """Without a claim one step is not probed; the shares come with Clopper and Pearson's intervals at each level."""
    found = judged(HalfExplicitEuler(truncation="none"), pendulum(), (256, 26, 0))
    (finding,) = found.findings

    assert (finding.quantity, finding.verdict) == ("paths without root", Verdict.OUT_OF_SCOPE)
    assert "1 at h = 0.0625, 0.102 at h = 0.0312" in str(finding.reason)
    assert (finding.estimate, finding.high) == (1.0, 1.0)
    assert finding.low == pytest.approx(0.005 ** (1 / 256))
    assert [row.estimate for row in found.levels] == pytest.approx([1.0, 26 / 256, 0.0])
    assert [row.details["ci_high"] for row in found.levels][2] == pytest.approx(1.0 - 0.005 ** (1 / 256))


def test_schemes_that_solve_nothing_do_not_apply() -> None:
    """Euler-Maruyama has no equation to solve; the theta scheme has one, on any form."""
    assert "cannot fail" in Solvability().refuses(EulerMaruyama(), ou())
    assert Solvability().refuses(StochasticTheta(), ou()) == ""


def test_shares_of_a_run_are_those_of_the_failed_paths() -> None:
    """From omega_0 = 5 over T = 1 all paths fail at h >= 1/8 without truncation, none with it."""
    spec = problem_spec(pendulum, {"c_g": "0", "omega_0": "5", "horizon": "1"})
    schemes = (HalfExplicitEuler(truncation="none"), HalfExplicitEuler())
    task = Task(spec, tuple(Entry(scheme, (Solvability(),)) for scheme in schemes), SETTINGS)
    bare, truncated = run_block(task, 0)

    shares = bare.health.sums["without_root"] / 256.0
    assert shares[0] == 1.0
    assert 0.8 < shares[1] < 1.0
    assert 0.0 < shares[2] < 0.2
    assert not truncated.health.sums["without_root"].any()


def test_a_step_with_areas_is_asked_whether_it_solves_anything() -> None:
    """A scheme that uses K or Levy areas gets them, and is told apart from one whose steps can fail."""
    assert "cannot fail" in Solvability().refuses(MilsteinAreas(), levy_area())
    assert "cannot fail" in Solvability().refuses(QUICSORT(), harmonic_langevin())
