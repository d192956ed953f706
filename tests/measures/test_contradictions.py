"""Nothing is verified in spite of what was seen: of paths that contradict one step, or of one step itself."""

from dataclasses import replace

import numpy as np
import pytest

from contradictions import (
    MILSTEIN,
    ONE,
    Clipped,
    EulerInStrip,
    ModestSRA1,
    bent_at_start,
    bent_drift,
    kinked,
    squared_motion,
    switched_late,
    switched_on_mesh,
    waves,
)
from facade import (
    SRA1,
    BalancedEuler,
    DisplacedEuler,
    ErrorObserver,
    EulerMaruyama,
    Milstein,
    PlatenWeak2,
    Roughness,
    StochasticTheta,
    Strong,
    StrongOrder,
    Study,
    TamedEuler,
    Weak,
    beside,
    delay_forced,
    double_well,
    gbm,
    judge_strong,
    of_smooth,
    plan,
    problem_spec,
    quantities_of,
    unlike,
)
from sdaeverify import Settings
from sdaeverify.measuring import (
    Estimate,
    Evidence,
    Opinion,
    PathTests,
    Reason,
    Snapshot,
    Tally,
    Verdict,
    decide,
    group_sums,
    guard,
    local_doubt,
    with_sample,
)
from sdaeverify_lab.planted._within import ScaledEuler
from sdaeverify_problems.fibres.fibre_linear import fibre_linear

LOCAL = Opinion(Verdict.VERIFIED, Reason("local order 1.000"), 1)
# One stage beyond all levels.
SETTINGS = Settings(paths=2048)
EVERY = {"first_levels": 20}


def controls(label):
    """Return a control of the problems here."""
    known = (BalancedEuler(), DisplacedEuler(), EulerMaruyama(), Milstein(), PlatenWeak2(), SRA1())
    return next(scheme for scheme in known if scheme.label == label)


def run(scheme, family, measure=None, settings=SETTINGS):
    """Return the result of a cell."""
    made = Study(plan([scheme], [problem_spec(family)], [measure or Strong()], controls), settings)
    for _ in made.run():
        pass
    return made.results()[0]


def verdicts(result):
    """Return the verdicts of a result."""
    return {finding.verdict for finding in result.findings}


@pytest.mark.long
@pytest.mark.parametrize(
    ("scheme", "family", "settings", "verdict"),
    [
        (ScaledEuler("part", 0.02, 0.06, of_drift=0.5, noise_share=0.5), gbm, SETTINGS, Verdict.REFUTED),
        (EulerInStrip(0.52, 1.15), waves, SETTINGS, Verdict.REFUTED),
        (EulerInStrip(1.01, 1.5), gbm, SETTINGS, Verdict.REFUTED),
        (ScaledEuler("step", 131, of_drift=0.0), gbm, Settings(paths=1024, levels=8, **EVERY), Verdict.REFUTED),
        (MILSTEIN, kinked, SETTINGS, Verdict.INCONCLUSIVE),
        (EulerMaruyama(), squared_motion, SETTINGS, Verdict.INCONCLUSIVE),
        (SRA1(), bent_drift, Settings(paths=2048, **EVERY), Verdict.INCONCLUSIVE),
        (SRA1(), bent_drift, Settings(paths=2048, levels=4), Verdict.INCONCLUSIVE),
        (EulerMaruyama(), kinked, SETTINGS, Verdict.VERIFIED),
    ],
    ids=lambda value: getattr(value, "name", getattr(value, "__name__", "")),
)
def test_paths_that_contradict_one_step_are_not_overruled(scheme, family, settings, verdict):
    """Where errors stay, grow or fall more slowly than one step says, the claim is refuted or left open."""
    assert verdicts(run(scheme, family, settings=settings)) == {verdict}


def test_a_start_on_a_kink_refutes_no_order_that_all_other_states_have():
    """Local orders are low at one state, where hardly any step begins: paths decide, which know no truth here."""
    assert verdicts(run(ModestSRA1(), bent_at_start)) == {Verdict.INCONCLUSIVE}


def test_a_law_that_drifts_away_late_is_not_verified():
    """Mean differences that grow with refinement are against a weak order, however small the coarse ones are."""
    result = run(ScaledEuler("step", 131, of_drift=0.0), gbm, Weak(), Settings(paths=1024, levels=8, **EVERY))

    assert Verdict.VERIFIED not in verdicts(result)


@pytest.mark.long
@pytest.mark.parametrize(
    ("scheme", "family", "measure", "excluded"),
    [
        (EulerMaruyama(), switched_late, Strong(), Verdict.VERIFIED),
        (StochasticTheta(), switched_on_mesh, Weak(), Verdict.REFUTED),
    ],
)
def test_a_jump_in_time_is_seen_between_the_steps_that_are_probed(scheme, family, measure, excluded):
    """Noise that jumps between two mesh points costs half an order along paths, and none in law: one step is bad."""
    assert excluded not in verdicts(run(scheme, family, measure))


def growing_mean():
    """Return fast geometric growth of which only the mean is looked at."""
    whole = gbm(2.0, 1.0)
    return replace(whole, observables={"x": whole.observables["x"]}, truths=whole.truths[:2])


@pytest.mark.long
def test_finer_levels_are_drawn_until_paths_and_one_step_agree():
    """The error of a tamed mean far below the true one falls too slowly on coarse levels, and not on finer ones."""
    few, more = (run(TamedEuler(), growing_mean, Weak(), Settings(paths=paths)) for paths in (1024, 8192))

    assert verdicts(few) == {Verdict.INCONCLUSIVE}
    assert "paths do not agree with the claim" in str(few.findings[0].reason)
    assert verdicts(more) == {Verdict.VERIFIED}
    assert len(more.levels) > Settings().levels


@pytest.mark.parametrize(
    ("settings", "stages"),
    [
        (Settings(), (-2, 0, 1, 2, 3)),
        (Settings(paths=2047), (-2, 0)),
        (Settings(paths=256, first_levels=6), (0,)),
        (Settings(paths=2048, coarsest=2**18, levels=3), (0,)),
    ],
)
def test_no_stage_costs_more_than_all_paths_on_all_levels(settings, stages):
    """Paths are halved where steps are, as long as they are enough to decide by themselves."""
    cost = settings.paths * settings.steps[-1]

    assert settings.stages == stages
    for stage in stages:
        drawn = settings.at(stage)
        assert drawn.levels == settings.levels + stage
        assert drawn.paths * drawn.steps[-1] <= cost
        assert stage < 1 or drawn.paths >= 1024


def test_what_is_held_back_stays_suspicious():
    """Few paths, coarse steps and heavy tails take the power to refute from what is seen, and nothing else."""
    tests = PathTests(1.0, 1e-9, Reason("order 0.1"), limit=1e-9)

    assert tests.held("coarse steps").against == 1e-9
    assert with_sample(tests, 256, heavy=True).against == 1e-9
    assert with_sample(tests.held("coarse"), 256, heavy=False).against == 1e-9
    assert (with_sample(tests, 256, heavy=False).refuted, with_sample(tests, 256, heavy=True).refuted) == (0.001, 1.0)


@pytest.mark.parametrize(
    ("slope", "corrected", "alike"),
    [(1.0, 1.0, True), (0.85, 0.95, True), (0.85, 0.85, False), (0.7, 1.0, False), (0.95, 0.8, True)],
)
def test_orders_look_like_a_claim_that_they_are_near_or_tend_to(slope, corrected, alike):
    """Below claim - margin an order is unlike the claim; nearer to that than to the claim unless it tends to more."""
    found = unlike(ONE.value, Estimate(slope, 0.005), Estimate(corrected, 0.005))

    assert (found > 0.01) is alike


def evidence(paths=1024):
    """Return evidence of so many paths, and of nothing else."""
    return Evidence(
        EulerMaruyama(), gbm(), gbm(), SETTINGS, Tally(sums={"paths": group_sums(np.ones(paths))}), Tally()
    )


def test_a_suspicion_that_cannot_refute_forbids_to_verify():
    """The guard asks for more, says what it has seen, and leaves the claim open."""
    found = guard(LOCAL, PathTests(1.0, 1.0, Reason("order 0.1"), suspected=1e-4), evidence())

    assert (found.verdict, found.settled) == (Verdict.INCONCLUSIVE, False)
    assert "paths do not agree with the claim at these step sizes: order 0.1" in str(found.reason)


def test_paths_alone_do_not_verify_what_they_speak_against():
    """Nor does an earlier look, or a correction of its p-value."""
    found = decide(PathTests(1e-9, 1.0, Reason("order 0.85"), suspected=1e-4), evidence())

    assert (found.verdict, found.p_verified) == (Verdict.INCONCLUSIVE, 1.0)
    assert found.speaks_against


@pytest.mark.parametrize(
    ("claim", "rough", "verdict"),
    [
        (0.5, Roughness("drift", lipschitz=True), Verdict.VERIFIED),
        (1.0, Roughness("drift", lipschitz=True), Verdict.INCONCLUSIVE),
        (0.5, Roughness("drift", lipschitz=False), Verdict.INCONCLUSIVE),
        (1.0, None, Verdict.VERIFIED),
    ],
)
def test_local_orders_verify_nothing_that_needs_smoother_coefficients(monkeypatch, claim, rough, verdict):
    """Order 1/2 needs Lipschitz coefficients, and more needs derivatives."""
    monkeypatch.setattr("sdaeverify.verdicts.opinions.rough_coefficient", lambda view: rough)

    assert of_smooth(LOCAL, claim, evidence()).verdict is verdict


SURE = Opinion(Verdict.VERIFIED, Reason("order 1.0"), 3, p_verified=1e-9, p_refuted=1.0)


def test_paths_do_not_verify_what_one_step_speaks_against():
    """Where one step says nothing paths decide; what it speaks against stays open, with both reasons."""
    silent, against = beside(local_doubt("nothing"), SURE), beside(local_doubt("much", against=True), SURE)

    assert silent.verdict is Verdict.VERIFIED
    assert (against.verdict, against.p_verified) == (Verdict.INCONCLUSIVE, 1.0)
    assert str(against.reason) == "much, although order 1.0"
    assert against.speaks_against
    assert not silent.speaks_against


RIGHT = StrongOrder(1.0, 1.5, 2.0, typical=1.0, plateau_h=0.0, means=True, ahead=1.0)


@pytest.mark.parametrize(
    ("changes", "sharp", "against"),
    [
        ({"order": 0.93, "ahead": 0.88}, True, True),
        ({"order": -2.2, "ahead": -4.9}, True, True),
        ({"order": 0.85, "ahead": 0.85}, True, True),
        ({"order": 0.5, "ahead": 0.5}, False, False),
        ({"order": 0.5, "ahead": 0.95}, True, False),
        ({"means": False}, True, False),
        ({"compared": False}, True, False),
    ],
)
def test_one_step_that_says_nothing_is_told_from_one_that_speaks_against_a_claim(changes, sharp, against):
    """Orders that fall or have settled below a claim, and states that are missed, speak against it."""
    found = judge_strong(RIGHT._replace(**changes), 1.0, margin=0.2, sharp=sharp)

    assert found.verdict is Verdict.INCONCLUSIVE
    assert found.speaks_against is against


def test_a_step_that_misses_the_equation_at_few_states_is_not_verified_by_paths():
    """Coefficients clipped at |x| = 2 are seen by one step, and hardly ever by paths in a double well."""
    result = run(Clipped(), double_well)

    assert Verdict.VERIFIED not in verdicts(result)
    assert "-0.51 from one step" in str(result.findings[0].reason)


def short_fibre():
    """Return a fibre whose fastest time is just resolved on the third level."""
    return fibre_linear(alpha=12.6, beta=0.138, Dr=0.0206, N=6, flow=2.56, horizon=0.0284)


@pytest.mark.long
def test_a_limit_that_only_coarse_steps_contradict_is_not_refuted():
    """Differences fall faster than errors on steps that are just short enough, and as fast on the finest ones."""
    assert verdicts(run(BalancedEuler(), short_fibre, settings=Settings(paths=1024))) == {Verdict.INCONCLUSIVE}


def fast_forcing():
    """Return a delay equation whose forcing is not resolved on the coarse levels."""
    return delay_forced(a=-0.767, B=-3.81, q=0.388, amplitude=2.16, omega=9.47, sigma=1.06, tau=0.371, horizon=3.01)


@pytest.mark.long
def test_a_slope_of_mean_differences_refutes_nothing_that_one_step_verifies():
    """A difference that is small by accident spoils it: the claim is left open, and finer levels are asked for."""
    found = verdicts(run(StochasticTheta(), fast_forcing, Weak(), Settings(paths=1024)))

    assert found <= {Verdict.VERIFIED, Verdict.INCONCLUSIVE}


@pytest.mark.parametrize(("limit", "rises"), [(0.02, False), (0.1, False), (0.0, None)])
def test_contrasts_fall_towards_a_wrong_limit(limit, rises):
    """Errors level off further with each halving; towards the right one they do not."""
    observer = ErrorObserver({"x": np.zeros((1, 4000))}, replace(SETTINGS, paths=4000))
    sizes = np.abs(np.random.default_rng(4).normal(size=4000))
    h = 1.0 / np.array(SETTINGS.steps)
    levels = [{"x": 1.0 + (sizes * each + limit)[None]} for each in h]
    observer.after_coarsest_step(Snapshot(levels, {"x": np.ones((1, 4000))}, None))
    known = Evidence(EulerMaruyama(), gbm(), gbm(), replace(SETTINGS, paths=4000), observer.tally(), Tally())
    rise = next(q for q in quantities_of(known) if q.name == "x").contrast_rise(np.arange(2, 6))

    assert rise.value == pytest.approx(0.0, abs=1e-9) if rises is None else rise.value < 0.0
