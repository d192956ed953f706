"""Claims of uniform convergence: verdicts from errors whose law is known, and from small runs."""

import re
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
import pytest

from cells import claimant
from facade import (
    SAMPLED,
    Entry,
    EulerMaruyama,
    HalfExplicitEuler,
    Strong,
    Task,
    gbm,
    ou,
    pendulum,
    problem_spec,
    run_block,
)
from sdaeverify import SDE, Claim, Pathwise, Settings, Step
from sdaeverify.measures.uniform import Uniform, UniformObserver
from sdaeverify.measuring import Evidence, Snapshot, Tally, Verdict

SETTINGS = Settings(paths=4000)
H = np.array([1.0 / n for n in SETTINGS.steps])
SIZES = np.abs(np.random.default_rng(5).normal(size=4000)) + 0.5
ON_GRID, IN_TIME = "x on the grid", "x in continuous time"
# Of a slope over four levels, whose logarithms to base 2 are off by 2^-20/ln 2 each: the weights add up to 0.8.
DIGITS = 0.8 * 2.0**-SAMPLED / np.log(2.0)
# In the first block a scheme that breaks its contract is not run.
LATER = 2
CONVERGES = Claim(measure="uniform", value="converges", source="test")


@dataclass(frozen=True)
class Claiming(EulerMaruyama):
    """Euler-Maruyama with a drift that is off by a constant and by a power of h, and a factor at the diffusion."""

    off: float = 0.0
    slow: float = 0.0
    power: float = 0.3
    strength: float = 1.0

    name: ClassVar[str] = "claiming"
    claims: ClassVar[tuple[Claim, ...]] = (CONVERGES,)

    def step(self, problem, state, t, h, noise):
        new = EulerMaruyama().step(problem, state, t, h, noise._replace(dW=self.strength * noise.dW)).state
        return Step(new + h * (self.off + self.slow * h**self.power) * state)


def health(**counts):
    """Return the counts of a run in which nothing went wrong but what is given."""
    zeros = np.zeros(SETTINGS.levels)
    every = {"failed": zeros, "lost": zeros, "truncated": zeros, "steps": np.full(SETTINGS.levels, 1e6)}
    return Tally(sums={**every, **{name: np.array(value, dtype=float) for name, value in counts.items()}})


def judge(grid, between=None, *, value="converges", quantities=(), problem=None, health_of=None):
    """Return the findings for errors on the grid and in continuous time, given as functions of h times a size."""
    observer = UniformObserver(gbm(), {"x": np.zeros((1, 4000))}, SETTINGS)
    levels = [{"x": 1.0 + SIZES[None] * grid(h)} for h in H]
    observer.after_coarsest_step(Snapshot(levels, {"x": np.ones((1, 4000))}, None))
    observer.between.squares[0] = [(SIZES * (between or np.sqrt)(h)) ** 2 for h in H[:4]]
    problem = problem or gbm()
    scheme = claimant(Claim(measure="uniform", value=value, quantities=quantities, source="test"))
    evidence = Evidence(scheme, problem, problem, SETTINGS, observer.tally(), health_of or health())
    judged = Uniform().judge(evidence)
    return {finding.quantity: finding for finding in judged.findings}, tuple(judged.levels)


def run(scheme, family=gbm, settings=None, *, probed=True):
    """Return the findings of the last block, of 1024 paths, at a level of significance that it can reach."""
    settings = settings or Settings(paths=2048, block=1024)
    spec = problem_spec(family)
    (lane,) = run_block(Task(spec, (Entry(scheme, (Uniform(),)),), settings), LATER)
    assert not lane.errors[0]
    problem = spec.build()
    view = problem.view(scheme.form)
    tally = lane.tallies[0].merge(Uniform().probe(scheme, view, settings)) if probed else lane.tallies[0]
    evidence = Evidence(scheme, problem, view, settings, tally, lane.health)
    return {finding.quantity: finding for finding in Uniform().judge(evidence).findings}


@pytest.mark.parametrize("order", [0.3, 0.5, 1.0])
def test_errors_that_fall_verify_convergence(order):
    """Whatever the rate, a fall towards the right limit is convergence, and the reason says what it cannot show."""
    found, _ = judge(lambda h: h**order)

    assert found[ON_GRID].verdict is Verdict.VERIFIED
    assert found[ON_GRID].estimate == pytest.approx(order, abs=DIGITS)
    assert re.search(r"; shows limit errors from [\d.e-]+", str(found[ON_GRID].reason))


def test_a_wrong_limit_refutes_convergence():
    """Errors that level off while successive differences fall are no convergence."""
    found, _ = judge(lambda h: h + 0.5)

    assert found[ON_GRID].verdict is Verdict.REFUTED
    assert str(found[ON_GRID].reason).startswith("wrong limit")


def test_a_wrong_limit_on_the_grid_speaks_for_continuous_time_too():
    """Between grid points the scheme is compared with itself, so that only the grid tells of the limit."""
    found, _ = judge(lambda h: h + 0.5)

    assert found[IN_TIME].verdict is not Verdict.VERIFIED


def test_errors_that_grow_refute_convergence():
    """Errors that grow as h is halved are no convergence."""
    found, _ = judge(lambda h: h**-0.5)

    assert found[ON_GRID].verdict is Verdict.REFUTED


@pytest.mark.parametrize(
    "bent", [lambda h: h + 30.0 * h**2, lambda h: np.sqrt(h) + 5.0 * h, lambda h: h / (1.0 + 60.0 * h)]
)
def test_coarse_steps_refute_no_convergence(bent):
    """A bend in the errors, which fall as fast as their differences but for it, is no wrong limit."""
    found, _ = judge(bent)

    assert found[ON_GRID].verdict is not Verdict.REFUTED


def test_a_plateau_that_begins_to_show_leaves_it_open():
    """Errors twice as large as their limit still fall, but no more like their differences: nothing is decided."""
    found, _ = judge(lambda h: h + H[-1])

    assert found[ON_GRID].verdict is Verdict.INCONCLUSIVE
    assert "limit not confirmed" in str(found[ON_GRID].reason)


def test_a_fall_too_slow_to_tell_is_left_open():
    """Errors like h^0.05 neither fall visibly nor grow."""
    found, _ = judge(lambda h: h**0.05)

    assert found[ON_GRID].verdict is Verdict.INCONCLUSIVE


def test_truncated_levels_may_verify():
    """The theorem is about the scheme with its truncation: such levels are fitted, and named."""
    found, _ = judge(lambda h: h, health_of=health(truncated=[9, 9, 9, 9, 9, 9]))

    assert found[ON_GRID].verdict is Verdict.VERIFIED
    assert "truncated steps at 6 step sizes" in str(found[ON_GRID].reason)


def test_truncated_levels_refute_nothing():
    """Where steps are truncated, errors that do not fall say nothing of the limit of small steps."""
    found, _ = judge(lambda h: h**-0.5, health_of=health(truncated=[9, 9, 9, 9, 9, 9]))

    assert found[ON_GRID].verdict is Verdict.INCONCLUSIVE


def test_failed_levels_are_left_out():
    """With failed paths at the finest level there is nothing to judge."""
    found, _ = judge(lambda h: h, health_of=health(failed=[0, 0, 0, 0, 0, 1]))

    assert {finding.verdict for finding in found.values()} == {Verdict.INCONCLUSIVE}


def test_without_a_truth_the_limit_is_not_known():
    """A scheme that is compared with itself converges to something."""
    plain = gbm()
    blind = SDE(drift=plain.drift, diffusion=plain.diffusion, start=[1.0], noise_dim=1, horizon=1.0, source="test")

    found, _ = judge(lambda h: h, problem=blind)

    assert {finding.verdict for finding in found.values()} == {Verdict.INCONCLUSIVE}


def test_exactness_is_convergence():
    """Errors at rounding on the grid verify convergence there, and the limit in continuous time."""
    found, _ = judge(lambda h: 1e-16, health_of=health())

    assert str(found[ON_GRID].reason) == "exact to round-off at all 6 step sizes"
    assert {finding.verdict for finding in found.values()} == {Verdict.VERIFIED}


@pytest.mark.parametrize(
    ("value", "quantities", "verdict"),
    [
        (0.5, (), Verdict.VERIFIED),
        (1.0, (), Verdict.OUT_OF_SCOPE),
        (1.0, (ON_GRID, IN_TIME), Verdict.REFUTED),
    ],
)
def test_an_order_is_judged_as_an_order(value, quantities, verdict):
    """An order is put to both quantities, each with its own errors; above 1/2, to time only where that is named."""
    found, _ = judge(lambda h: h, value=value, quantities=quantities)

    assert found[ON_GRID].verdict is Verdict.VERIFIED
    assert found[IN_TIME].verdict is verdict


def test_an_unknown_claim_is_not_guessed():
    """A word that the measure does not know decides nothing."""
    found, _ = judge(lambda h: h, value="arrives")

    assert "no test for the claimed value 'arrives'" in str(found[ON_GRID].reason)


def test_slopes_of_higher_moments_stand_beside():
    """Those of p = 2 and p = 4 have columns of their own, in the verdicts and at each level."""
    found, levels = judge(lambda h: h**0.7)

    assert found[ON_GRID].details["order_L2"] == pytest.approx(0.7, abs=DIGITS)
    assert found[ON_GRID].details["order_L4"] == pytest.approx(0.7, abs=DIGITS)
    norm = H[0] ** 0.7 * (SIZES**4).mean() ** 0.25
    assert levels[0].details["estimate_L4"] == pytest.approx(norm, rel=2.0**-SAMPLED)
    assert [row.level for row in levels if row.quantity == IN_TIME] == [0, 1, 2, 3]


def test_errors_of_the_finest_level_widen_the_interval():
    """Errors c of which the finest level's error is a share may be off by that share, either way at each level."""
    found, _ = judge(lambda h: 0.25 * h, between=lambda h: h)

    shares = 0.25 * H[-1] / H[:4]
    expected = np.array([0.3, 0.1, 0.1, 0.3]) @ -np.log2(1.0 - shares)
    assert found[IN_TIME].details["bias_bound"] == pytest.approx(expected, rel=1e-9)


def test_convergence_in_continuous_time_rests_on_the_grid_for_its_finest_paths():
    """Where the finest level is itself as far off, distances from it converge if its own errors do, and only then."""
    right, _ = judge(np.sqrt, between=lambda h: 0.8 * np.sqrt(h))
    wrong, _ = judge(lambda h: np.sqrt(h) + 3.0, between=lambda h: 0.8 * np.sqrt(h))

    assert right[IN_TIME].details["bias_bound"] > 0.3
    assert right[IN_TIME].verdict is Verdict.VERIFIED
    assert wrong[IN_TIME].verdict is not Verdict.VERIFIED


def test_the_interpolant_is_compared_at_the_quarters_of_a_step():
    """With x(t) = t^2 at the grid times of each level, the chord of a step is off by at most h^2/4, in its middle."""
    settings = Settings(paths=40, levels=5, coarsest=2, block=40)
    observer = UniformObserver(gbm(), {"x": np.zeros((1, 40))}, settings)
    for coarse in range(2):
        for level, steps in enumerate(settings.steps):
            inside = steps // 2
            for step in range(coarse * inside + 1, (coarse + 1) * inside + 1):
                assert step in observer.wanted[level] or level == 3
                if step in observer.wanted[level]:
                    observer.after_step(level, step, {"x": np.full((1, 40), (step / steps) ** 2)})

    noted = np.sqrt(observer.between.squares)

    assert noted.shape == (1, 3, 40)
    assert np.allclose(noted[0], (0.25 / np.array([4.0, 16.0, 64.0]))[:, None], rtol=1e-12)
    assert max(len(held) for held in observer.between.ahead) == 1


def brownian_motion():
    """Return dx = dW with its solution."""
    truth = Pathwise(
        start=lambda paths: np.zeros((1, paths)),
        advance=lambda z, t, h, noise: z + noise.dW,
        parts=lambda t, z: {"x": z},
        source="test",
    )
    one = np.ones((1, 1, 1))
    return SDE(
        drift=lambda t, x: np.zeros_like(x),
        diffusion=lambda t, x: one,
        start=[0.0],
        noise_dim=1,
        horizon=1.0,
        truths=(truth,),
        source="test",
    )


def test_a_brownian_path_is_off_its_interpolant_by_bridges():
    """What the interpolant misses on N steps is sqrt(h) times the largest of N bridges at their quarters."""
    steps = 16
    settings = Settings(paths=2048, block=1024, coarsest=steps, levels=3)
    (lane,) = run_block(Task(problem_spec(brownian_motion), (Entry(Claiming(), (Uniform(),)),), settings), LATER)
    W = np.cumsum(np.random.default_rng(11).standard_normal((4000, steps, 4)), axis=2) / np.sqrt(4.0 * steps)

    bridges = np.abs(W - W[..., -1:] * np.arange(1, 5) / 4).max(axis=(1, 2))

    one, two = lane.tallies[0].sums["continuous x"][:, 0, 1:3].sum(axis=0) / lane.paths
    se = np.sqrt((two - one**2) / lane.paths + bridges.var() / len(bridges))
    assert abs(one - bridges.mean()) < 4.0 * se


def test_noting_between_grid_points_changes_no_error_on_the_grid():
    """The errors on the grid are those of the strong measure, to the last bit."""
    settings = Settings(paths=120, levels=4, block=60)
    entry = Entry(HalfExplicitEuler("none"), (Strong(), Uniform()))
    (lane,) = run_block(Task(problem_spec(pendulum), (entry,), settings), 1)

    strong, uniform = lane.tallies
    assert np.array_equal(strong.sums["error v"], uniform.sums["error v"][..., :3])
    assert {"continuous r", "continuous v", "continuous mu", "continuous state"} <= uniform.sums.keys()


@pytest.mark.parametrize(("off", "strength"), [(0.5, 1.0), (0.0, 1.2)])
def test_a_wrong_drift_or_diffusion_is_refuted_by_paths_alone(off, strength):
    """A scheme that tends to another equation is told by its errors, without a look at single steps."""
    found = run(Claiming(off=off, strength=strength), probed=False)

    assert found[ON_GRID].verdict is Verdict.REFUTED
    assert str(found[ON_GRID].reason).startswith("wrong limit")


@pytest.mark.parametrize("wrong", [{"off": 0.002}, {"strength": 1.005}])
def test_a_limit_too_near_for_paths_is_refuted_by_one_step(wrong):
    """A little too much drift or noise leaves no trace in the errors, and shows in one step."""
    scheme = Claiming(**wrong)

    by_paths, by_steps = run(scheme, probed=False), run(scheme)

    assert by_paths[ON_GRID].verdict is Verdict.VERIFIED
    assert by_steps[ON_GRID].verdict is Verdict.REFUTED
    assert by_steps[ON_GRID].tier == 1


def test_convergence_of_order_three_tenths_is_verified():
    """A drift that is off by a multiple of h^0.3 converges slowly, and is told to converge."""
    found = run(Claiming(slow=3.0))

    assert found[ON_GRID].verdict is Verdict.VERIFIED
    assert found[ON_GRID].high < 0.45


def test_only_who_claims_it_is_sampled():
    """A scheme without a claim in force here is refused, with the reason."""
    elsewhere = replace(CONVERGES, when=frozenset({"additive-noise"}))

    class Elsewhere(Claiming):
        claims = (elsewhere,)

    assert Uniform().refuses(EulerMaruyama(), gbm()) == "no claim about uniform convergence here"
    assert Uniform().refuses(Elsewhere(), gbm())
    assert not Uniform().refuses(Elsewhere(), ou())
    assert not Uniform().refuses(Claiming(), gbm())


def test_components_that_the_truth_does_not_know_are_named():
    """A claim about everything is left open for a component that nothing can be compared with."""

    def silent():
        problem = pendulum()
        truth = problem.pathwise

        def parts(t, z):
            return {name: value for name, value in truth.parts(t, z).items() if name != "mu"}

        return replace(problem, truths=(replace(truth, parts=parts),))

    class Holonomic(HalfExplicitEuler):
        claims: ClassVar[tuple[Claim, ...]] = (CONVERGES,)

    found = run(Holonomic("none"), silent, Settings(paths=160, levels=3, block=40), probed=False)

    assert str(found["mu on the grid"].reason) == "the problem's truth does not provide mu"
    assert "mu in continuous time" not in found
