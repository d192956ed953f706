"""Verdicts on strong order from errors whose law is known, without any simulation."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.special import stdtrit

from cells import claimant
from facade import SAMPLED, ErrorObserver, Strong, affine_constraint, gbm, path_tests
from sdaeverify import SDE, Claim, Settings
from sdaeverify.measuring import Evidence, Opinion, Reason, Snapshot, Tally, Verdict, guard

SETTINGS = Settings(paths=4000)
ONE = Claim(measure="strong", value=1.0, source="test")
H = np.array([1.0 / n for n in SETTINGS.steps])


def errors(order, *, paths=4000, limit=0.0, sizes=None):
    """Return signed errors of each level: a common size times h^order, beside a wrong limit."""
    z = np.random.default_rng(5).normal(size=paths) if sizes is None else sizes
    return [z * h**order + limit for h in H]


def health(**counts):
    """Return the counts of a run in which nothing went wrong but what is given."""
    zeros = np.zeros(SETTINGS.levels)
    every = {"failed": zeros, "lost": zeros, "truncated": zeros, "steps": np.full(SETTINGS.levels, 1e6)}
    return Tally(sums={**every, **{name: np.array(value, dtype=float) for name, value in counts.items()}})


def judged(levels, *, scheme=None, problem=None, health_of=None, settings=SETTINGS, blurred=None):
    """Return the finding on x at T."""
    paths = len(levels[0])
    chosen = replace(settings, paths=paths)
    observer = ErrorObserver({"x": np.zeros((1, paths))}, chosen)
    truth = {"x": np.ones((1, paths))}
    coarser = None if blurred is None else {"x": 1.0 + blurred[None]}
    observer.after_coarsest_step(Snapshot([{"x": 1.0 + level[None]} for level in levels], truth, coarser))
    problem = problem or gbm()
    evidence = Evidence(scheme or claimant(ONE), problem, problem, chosen, observer.tally(), health_of or health())
    return {finding.quantity: finding for finding in Strong().judge(evidence).findings}["x@T"]


def test_exact_power_law_gives_its_order():
    """Errors c h with one random size a path have slope 1 to rounding, with no spread."""
    finding = judged(errors(1.0))

    assert finding.verdict is Verdict.VERIFIED
    assert finding.estimate == pytest.approx(1.0, abs=1e-9)
    assert finding.details["contrast"] == pytest.approx(0.0, abs=1e-9)
    assert finding.details["asymptotic_order"] == pytest.approx(1.0, abs=1e-8)


UNRESOLVED = np.array([0.9, 0.88, 0.87, 0.85, 0.8, 0.7])


def of_two(slow, fast):
    """Return the finding on r at T from errors of r and v, both of which move by 1."""
    paths = len(slow[0])
    observer = ErrorObserver({name: np.zeros((1, paths)) for name in ("r", "v")}, replace(SETTINGS, paths=paths))
    levels = [{"r": 1.0 + r[None], "v": 1.0 + v[None]} for r, v in zip(slow, fast, strict=True)]
    observer.after_coarsest_step(Snapshot(levels, {name: np.ones((1, paths)) for name in ("r", "v")}, None))
    settings = replace(SETTINGS, paths=paths)
    evidence = Evidence(claimant(ONE), gbm(), gbm(), settings, observer.tally(), health())
    return {finding.quantity: finding for finding in Strong().judge(evidence).findings}["r@T"]


def scattered(sizes, paths=4000, seed=8):
    """Return errors that are independent at each level."""
    rng = np.random.default_rng(seed)
    return [size * rng.normal(size=paths) for size in sizes]


def off_by(shares):
    """Return errors of so large a part of what each path's solution moves."""
    sizes = 1.0 + 0.1 * np.random.default_rng(9).normal(size=4000)
    return [share * sizes for share in shares]


def on_all_paths(sizes):
    """Return errors that are the same on all paths."""
    return [np.full(4000, size) for size in sizes]


def blind():
    """Return a problem without truth: a scheme is its own reference."""
    plain = gbm()
    return SDE(drift=plain.drift, diffusion=plain.diffusion, start=[1.0], noise_dim=1, horizon=1.0, source="test")


ON_THEIR_WAY = 0.1 * 2.0 ** -np.cumsum([0.0, 0.1, 0.15, 0.25, 0.5, 0.8])
# In units of what the solution moves.
COMES_UP, STAYS_OFF = (0.999, 0.995, 0.989, 0.979, 0.963, 0.938), (0.999, 0.959, 0.939, 0.929, 0.924, 0.9215)
FEW, LOST = {"health_of": health(truncated=[1, 1, 1, 1, 0, 0])}, {"health_of": health(failed=[1] * 6, lost=[1] * 6)}
# The truth is not half an order better than the claim.
ROUGH = {"problem": replace(gbm(), truths=(replace(gbm().pathwise, order=1.0),)), "blurred": np.zeros(4000)}
OPEN, RIGHT, WRONG = Verdict.INCONCLUSIVE, Verdict.VERIFIED, Verdict.REFUTED
# Errors, what else is given, the verdict, and what the reason says.
CASES = {
    "an order of 1/2": (errors(0.5), {}, WRONG, "claim 1.0"),
    "an interval around claim - margin": (scattered(H**0.8, 400, 6), {}, OPEN, "paths would decide"),
    **{f"a limit off by {off}": (errors(1.0, limit=off), {}, WRONG, "") for off in (0.02, 0.3, 0.9, 3.0)},
    "steps that do not resolve the solution": (
        scattered(UNRESOLVED),
        {},
        OPEN,
        "still changes as h is halved",
    ),
    "one that comes up by more with each halving": (off_by(COMES_UP), {}, OPEN, "take finer steps"),
    "one that stays off": (off_by(STAYS_OFF), {}, WRONG, ""),
    "local orders on their way to the claim": (
        scattered(ON_THEIR_WAY, 800, 9),
        {},
        OPEN,
        "the order still rises, to",
    ),
    "local orders that are not": (scattered(0.1 * H**0.45, 800, 9), {}, WRONG, ""),
    "too few levels": (
        errors(1.0),
        FEW,
        OPEN,
        "fewer than 3 step sizes can be fitted: truncated steps at 4 step sizes",
    ),
    "paths that are lost at every level": (errors(1.0), LOST, Verdict.DIVERGED, ""),
    "rounding": (errors(0.0, sizes=np.full(4000, 1e-15)), {}, RIGHT, "exact to round-off"),
    "nothing, of its own reference": (errors(0.0, sizes=np.zeros(4000)), {"problem": blind()}, OPEN, ""),
    "a right order towards its own limit": (
        errors(1.0),
        {"problem": blind()},
        OPEN,
        "unless a Pathwise truth is attached",
    ),
    "one that noise hides": (
        scattered(H**1.05, 400, 6),
        {"problem": blind()},
        OPEN,
        "unless a Pathwise truth is attached",
    ),
    "a low one that noise hides": (scattered(H**0.65, 200, 6), {"problem": blind()}, OPEN, "would decide (--paths)"),
    "a low order towards its own limit": (errors(0.5), {"problem": blind()}, WRONG, ""),
    "a rough truth": (errors(1.0), ROUGH, OPEN, "needs an order of at least 1.5"),
    "sixty paths": (errors(1.0, paths=60), {}, OPEN, "100 paths"),
}


@pytest.mark.parametrize(("levels", "given", "verdict", "reason"), CASES.values(), ids=CASES)
def test_errors_of_a_known_law_have_their_verdict(levels, given, verdict, reason):
    """Against a claim of order 1."""
    finding = judged(levels, **given)

    assert finding.verdict is verdict
    assert reason in str(finding.reason)


# Errors whose figures alone would say something else: what they show, the verdict, and what the reason says.
MISLEADING = {
    "an interval above the bound, and wider than the margin": (
        [np.exp(2.0 * z) * h**3 for z, h in zip(scattered(np.ones(6), 100, 7), H, strict=True)],
        lambda found: found.low > 0.8,
        OPEN,
        "paths would decide",
    ),
    "a plateau that the slope does not see": (
        errors(1.0, limit=5e-4, sizes=np.ones(4000)),
        lambda found: found.low > 0.8,
        WRONG,
        "wrong limit",
    ),
    "a h + b h^2, which level off above the claimed order": (
        on_all_paths(H + 6.0 * H**2),
        lambda found: found.details["contrast"] < -0.05,
        OPEN,
        "",
    ),
    "h/(1 + 60 h), of order 1 late": (
        on_all_paths(H / (1.0 + 60.0 * H)),
        lambda found: found.high < 0.8,
        OPEN,
        "still rises",
    ),
}


@pytest.mark.parametrize(("levels", "shows", "verdict", "reason"), MISLEADING.values(), ids=MISLEADING)
def test_no_single_figure_decides(levels, shows, verdict, reason):
    """The slope, its interval and the contrast are heeded together."""
    finding = judged(levels)

    assert shows(finding)
    assert finding.verdict is verdict
    assert reason in str(finding.reason)


def test_own_reference_bias_is_that_of_the_method():
    """Over the four finest levels of order 1, three halvings bias the slope by at most 0.056 (coherent errors)."""
    # The slope of log2(1 - 2^(l - 6)) against -l on levels l = 0 to 3.
    assert judged(errors(1.0), problem=blind()).details["bias_bound"] == pytest.approx(0.0557, abs=1e-4)


def test_one_component_that_is_not_resolved_speaks_for_all():
    """What a velocity drives has no order before the velocity has one; where it is resolved, a low order refutes."""
    held = of_two(errors(0.2, sizes=np.full(4000, 0.1)), scattered(UNRESOLVED))
    resolved = of_two(errors(0.2, sizes=np.full(4000, 0.1)), errors(1.0))

    assert held.verdict is Verdict.INCONCLUSIVE
    assert "the error of v" in str(held.reason)
    assert resolved.verdict is Verdict.REFUTED


@pytest.mark.parametrize("kind", ["failed", "truncated"])
def test_coarse_levels_that_went_wrong_are_not_fitted(kind):
    """A coarse level with failed paths or truncated steps is left out of the fit and named."""
    levels = errors(1.0)
    levels[1] = levels[1] * 100.0

    finding = judged(levels, health_of=health(**{kind: [0, 3, 0, 0, 0, 0]}))

    assert finding.verdict is Verdict.VERIFIED
    assert "at 1 step size" in str(finding.reason)


@pytest.mark.parametrize("kind", ["failed", "truncated", "lost"])
@pytest.mark.parametrize("bad", [[0, 0, 0, 0, 0, 3], [0, 0, 0, 0, 3, 0], [0, 0, 0, 0, 1, 1]])
def test_fine_levels_that_went_wrong_leave_nothing_to_verify(kind, bad):
    """What goes wrong at a finer step than another is no matter of too coarse a step: no order is told."""
    counts = {"failed": bad, "lost": bad} if kind == "lost" else {kind: bad}

    finding = judged(errors(1.0), health_of=health(**counts))

    assert finding.verdict is (Verdict.DIVERGED if kind == "lost" and bad[-1] else Verdict.INCONCLUSIVE)


def test_standing_still_is_not_exact_on_a_solution_that_does_not_move():
    """Where the true solution stays at its start, agreement shows nothing."""
    still = replace(gbm(), start=[0.0], truths=(replace(gbm().pathwise, start=lambda paths: np.zeros((1, paths))),))
    settings = replace(SETTINGS, paths=400)
    observer = ErrorObserver({"x": np.ones((1, 400))}, settings)
    same = {"x": np.ones((1, 400))}
    observer.after_coarsest_step(Snapshot([same] * 6, same, None))

    findings = Strong().judge(Evidence(claimant(ONE), still, still, settings, observer.tally(), health())).findings

    assert {finding.verdict for finding in findings} == {Verdict.INCONCLUSIVE}


def test_small_solutions_are_no_rounding():
    """Rounding is told from the solution's own size: errors of a tiny solution are errors."""
    tiny = 1e-13
    observer = ErrorObserver({"x": np.zeros((1, 4000))}, SETTINGS)
    truth = np.full((1, 4000), tiny)
    levels = [{"x": truth * (1.0 + level[None])} for level in errors(0.5)]
    observer.after_coarsest_step(Snapshot(levels, {"x": truth}, None))

    findings = Strong().judge(Evidence(claimant(ONE), gbm(), gbm(), SETTINGS, observer.tally(), health())).findings

    assert {finding.verdict for finding in findings} == {Verdict.REFUTED}


def test_levels_at_round_off_are_not_fitted():
    """A level whose error is rounding is left out, so that it cannot flatten the slope."""
    levels = [np.maximum(np.abs(level), 1e-14) for level in errors(6.0)]

    finding = judged(levels)

    assert "round-off at" in str(finding.reason)
    assert finding.estimate == pytest.approx(6.0, abs=0.05)


def test_error_of_the_reference_widens_the_interval():
    """What half the reference's resolution would change, over 2^q - 1, is added on either side."""
    problem = replace(gbm(), truths=(replace(gbm().pathwise, order=1.5),))
    shift = np.full(4000, 2e-4)

    finding = judged(errors(1.0), problem=problem, blurred=shift)

    assert finding.details["bias_bound"] > 0.0
    assert finding.high - finding.low > 2.0 * finding.details["bias_bound"]


def test_the_error_of_a_truth_that_makes_the_finest_steps_is_bounded():
    """At half its resolution the truth is what the finest steps make: that bounds its error, no slope does."""
    problem, levels = replace(gbm(), truths=(replace(gbm().pathwise, order=1.5),)), errors(2.0)

    finding = judged(levels, problem=problem, blurred=levels[-1])

    # A part 1/(2^1.5 - 1) of the finest error is the truth's own, and a quarter of that at each level before.
    shares = 4.0 ** -np.arange(4.0)[::-1] / (2.0**1.5 - 1.0)
    expected = float(np.array([0.3, 0.1, 0.1, 0.3]) @ -np.log2(1.0 - shares))
    assert finding.details["bias_bound"] == pytest.approx(expected)


def test_heavy_tails_do_not_refute_a_small_sample():
    """With heavy tails and fewer than 800 paths a deviation is inconclusive."""
    sizes = np.r_[np.full(399, 1e-3), 5.0]
    levels = errors(0.3, sizes=sizes)

    finding = judged(levels)

    assert finding.details["heavy_tails"]
    assert finding.verdict is not Verdict.REFUTED


def test_no_claim_no_verdict():
    """Without a claim the order is measured, and nothing is judged."""
    finding = judged(errors(1.0), scheme=claimant())

    assert finding.verdict is Verdict.OUT_OF_SCOPE
    assert finding.estimate == pytest.approx(1.0, abs=1e-9)
    assert finding.claim is None


LOCAL = Opinion(Verdict.VERIFIED, Reason("local order 1.000"), 1)


@pytest.mark.parametrize(
    ("paths", "p_refuted", "verdict", "settled"),
    [
        (256, 0.5, Verdict.VERIFIED, True),
        (256, 0.001, Verdict.INCONCLUSIVE, False),
        (2048, 1e-9, Verdict.REFUTED, True),
        (64, 0.5, Verdict.INCONCLUSIVE, True),
    ],
)
def test_a_local_order_needs_paths_that_do_not_speak_against_it(paths, p_refuted, verdict, settled):
    """Suspicious paths leave it open and ask for more of them; significant ones refute; too few guard nothing."""
    tally = Tally(sums={"paths": np.full(20, paths / 20)})
    evidence = Evidence(claimant(ONE), gbm(), gbm(), SETTINGS, tally, health(), level=1e-6)

    decision = guard(LOCAL, path_tests.PathTests(1.0, p_refuted, Reason("order 0.1")), evidence)

    assert (decision.verdict, decision.settled) == (verdict, settled)


def test_heavy_tails_are_suspicious_all_the_same():
    """What is too heavy-tailed to refute with few paths asks for more of them, and lets no local order pass."""
    tally = Tally(sums={"paths": np.full(20, 400 / 20)})
    evidence = Evidence(claimant(ONE), gbm(), gbm(), SETTINGS, tally, health(), level=1e-2)
    tests = path_tests.with_sample(path_tests.PathTests(1.0, 1e-9, Reason("order 0.1"), 1.0), 400, heavy=True)

    decision = guard(LOCAL, tests, evidence)

    assert tests.refuted == 1.0
    assert (decision.verdict, decision.settled) == (Verdict.INCONCLUSIVE, False)


def test_a_local_refutation_needs_no_paths():
    """What one step shows, no sample can take back."""
    evidence = Evidence(claimant(ONE), gbm(), gbm(), SETTINGS, Tally(), health())

    assert guard(Opinion(Verdict.REFUTED, tier=1), path_tests.PathTests.none(""), evidence).verdict is Verdict.REFUTED


def test_the_relative_error_at_the_end_is_a_mean_of_ratios():
    """Each path's error is divided by its own solution, per component and for all together, with a t-interval."""
    rng = np.random.default_rng(3)
    settings = replace(SETTINGS, paths=400)
    truth = {"a": rng.uniform(1.0, 3.0, (2, 400)), "b": rng.uniform(1.0, 3.0, (1, 400))}
    levels = [{name: part * (1.0 + h * (name == "a")) for name, part in truth.items()} for h in H]
    observer = ErrorObserver(truth, settings)
    observer.after_coarsest_step(Snapshot(levels, truth, None))

    rows = Strong().judge(Evidence(claimant(), gbm(), gbm(), settings, observer.tally(), health())).levels

    relative = {(row.quantity, row.level): row.details for row in rows if "relative" in row.details}
    a, b = ((truth[name] ** 2).sum(axis=0) for name in "ab")
    ratios = H[2] * np.sqrt(a / (a + b))
    groups = ratios.reshape(20, 20).mean(axis=0)
    half = stdtrit(19, 0.95) * groups.std(ddof=1) / np.sqrt(20)
    assert {quantity for quantity, _ in relative} == {"a@T", "b@T", "state@T"}
    assert relative["a@T", 2]["relative"] == pytest.approx(H[2], rel=1e-12)
    assert relative["b@T", 2]["relative"] == 0.0
    assert relative["state@T", 2]["relative"] == pytest.approx(ratios.mean(), rel=2.0**-SAMPLED)
    assert relative["state@T", 2]["relative_low"] == pytest.approx(ratios.mean() - half, rel=4.0 * 2.0**-SAMPLED)
    assert relative["state@T", 2]["relative_high"] == pytest.approx(ratios.mean() + half, rel=4.0 * 2.0**-SAMPLED)


def test_a_solution_that_ends_at_zero_has_no_finite_relative_error():
    """Where the solution is 0, the error is infinitely large beside it: said, not hidden."""
    observer = ErrorObserver({"x": np.ones((1, 400))}, replace(SETTINGS, paths=400))
    level, end = {"x": np.full((1, 400), 0.1)}, {"x": np.zeros((1, 400))}
    observer.after_coarsest_step(Snapshot([level] * 6, end, None))

    assert np.isinf(observer.tally().sums["relative x@T"]).all()


def test_no_slope_is_fitted_across_the_stiffness_parameter() -> None:
    """Errors that stand still while h > eps are held against no order: the levels with h > eps are left out."""
    problem = affine_constraint(eps=float(H[2]) * 1.01, horizon=1.0)
    levels = [np.where(h > problem.eps, 1.0, h / problem.eps) * np.ones(4000) for h in H]
    found = judged([level * np.random.default_rng(1).normal(size=4000) for level in levels], problem=problem)
    assert "steps longer than the fastest time at 2 step sizes" in str(found.reason)
    assert found.estimate == pytest.approx(1.0, abs=1e-6)
