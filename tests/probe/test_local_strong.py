"""Local strong orders: those of correct schemes are found, those of planted wrong ones are refused."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import pytest

from facade import (
    ACCURACY,
    SRA1,
    EulerMaruyama,
    HalfExplicitEuler,
    LocalStrong,
    MilsteinAreas,
    StrongOrder,
    angle_pendulum,
    circle,
    double_well,
    gbm,
    judge_strong,
    levy_area,
    local_strong,
    ou,
    pendulum,
    strong_orders,
    why_not_local_order,
)
from probe import strong_cells as s
from probe.linear_cells import TwoPoint
from probe.weak_cells import constant, equation, scheme
from sdaeverify import SDE, Array, Increment, Problem, Scheme, Step
from sdaeverify.measuring import Kind, Opinion, Verdict, packed, unpacked

INF = float("inf")
R, V, MU = range(3)


def found(scheme: Scheme, problem: Problem) -> StrongOrder:
    """Return the order of the full state, from evidence that was stored in between."""
    view = problem.view(scheme.form)
    assert view is not None
    assert not why_not_local_order(scheme, view)
    record = unpacked("local", LocalStrong, packed("local", local_strong(scheme, view)))
    assert record is not None
    return s.probed(scheme, view)[-1]._replace(order=strong_orders(record)[-1].order)


def opinion(scheme: Scheme, problem: Problem, claim: float) -> Opinion:
    return judge_strong(found(scheme, problem), claim, sharp=scheme.local_order_is_global)


def exact_gbm(problem: SDE, x: Array, h: float, noise: Increment) -> Array:
    return x * np.exp((0.5 - 0.18) * h + 0.6 * noise.dW)


def exact_law_ou(problem: SDE, x: Array, h: float, noise: Increment) -> Array:
    return np.exp(-h) * x + 0.7 * np.sqrt(-np.expm1(-2.0 * h) / (2.0 * h)) * noise.dW


CORRECT: dict[str, tuple[Scheme, Problem, float]] = {
    "exact gbm": (s.Formula(exact_gbm), gbm(), INF),
    "exact in law on ou": (s.Formula(exact_law_ou), ou(), 1.0),
    "cayley on the circle": (s.Formula(s.cayley), circle(), 1.0),
    "sra1 on the pendulum": (SRA1(), angle_pendulum(), 2.0),
    "sra1 with noise in a position": (SRA1(), double_well(), 1.5),
    "half-explicit on the pendulum": (HalfExplicitEuler(), pendulum(), 1.0),
}


@pytest.mark.parametrize("cell", CORRECT)
def test_the_order_of_a_correct_scheme_is_found(cell: str) -> None:
    """The local order is the known strong order within 0.02, and a claim of it is verified."""
    scheme, problem, expected = CORRECT[cell]

    order = found(scheme, problem)

    assert order.compared
    assert order.departure == ""
    assert order.order == pytest.approx(expected, abs=ACCURACY)
    assert judge_strong(order, min(expected, 3.0)).verdict is Verdict.VERIFIED
    if np.isfinite(expected):
        assert judge_strong(order, expected + 0.5).verdict is Verdict.REFUTED


INCONSISTENT: dict[str, tuple[Scheme, Problem]] = {
    "euler without Ito correction": (s.Formula(s.no_correction), gbm()),
    "euler, variance + 1 %": (s.Formula(lambda p, x, h, n: s.euler(p, x, h, n, strength=1.01**0.5)), gbm()),
    "euler, drift x 0.98": (s.Formula(lambda p, x, h, n: s.euler(p, x, h, n, drift=0.98)), gbm()),
    "half-explicit, variance + 1 %": (s.Altered(HalfExplicitEuler(), s.velocity_noise), pendulum()),
}


@pytest.mark.parametrize("cell", INCONSISTENT)
def test_a_step_of_another_equation_is_inconsistent(cell: str) -> None:
    """Whatever is claimed, a step whose mean or noise is wrong is refuted."""
    scheme, problem = INCONSISTENT[cell]

    answer = opinion(scheme, problem, 0.5)

    assert answer.verdict is Verdict.REFUTED
    assert answer.reason.has(Kind.INCONSISTENT)
    assert "at 512 of 512 points" in str(answer.reason)


TOO_LOW: dict[str, tuple[Scheme, Problem, float, float]] = {
    "milstein, sign": (s.Formula(s.milstein(-0.5)), gbm(), 1.0, 0.5),
    "milstein, factor .45": (s.Formula(s.milstein(0.45)), gbm(), 1.0, 0.5),
    "sra1, H doubled": (s.WithAreas(s.sra1(2.0)), angle_pendulum().view(SDE), 1.5, 1.0),
    "euler with small noise": (EulerMaruyama(), gbm(b=0.1), 1.0, 0.5),
}


@pytest.mark.parametrize("cell", TOO_LOW)
def test_a_lower_order_than_claimed_is_refuted(cell: str) -> None:
    """A wrong correction term leaves the step consistent and its order too low."""
    scheme, problem, claim, expected = TOO_LOW[cell]

    order, answer = found(scheme, problem), opinion(scheme, problem, claim)

    assert order.order == pytest.approx(expected, abs=0.02)
    assert answer.verdict is Verdict.REFUTED
    assert not answer.reason.has(Kind.INCONSISTENT)


def test_a_fixed_direction_of_projection_is_refuted() -> None:
    """Onto the circle along an axis, the order 1 of the nearest point is lost."""
    assert opinion(s.Formula(s.radially), circle(), 1.0).verdict is Verdict.VERIFIED
    wrong = opinion(s.Formula(s.along_an_axis), circle(), 1.0)
    assert wrong.verdict is Verdict.REFUTED
    assert not wrong.reason.has(Kind.INCONSISTENT)


def test_clipped_noise_is_consistent_with_the_variance_that_it_has_left() -> None:
    """Clipping at a multiple of sqrt(h) leaves out a fixed part of the variance; at sqrt(|log h|) it does not."""
    fixed = opinion(s.Formula(s.milstein(0.5, clip=2.5)), gbm(), 1.0)
    assert fixed.verdict is Verdict.REFUTED

    def rule(problem: SDE, x: Array, h: float, noise: Increment) -> Array:
        return s.milstein(0.5, clip=np.sqrt(4.0 * abs(np.log(h))))(problem, x, h, noise)

    order = found(s.Formula(rule), gbm())
    assert order.order == pytest.approx(1.0, abs=0.02)


def test_the_multiplier_is_an_output_of_its_own() -> None:
    """An error in mu alone leaves r and v verified; an error in v reaches all of them."""
    kinds = {"mu": s.multiplier_noise, "v": s.velocity_noise}
    wrong = {name: s.Altered(HalfExplicitEuler(), kind) for name, kind in kinds.items()}

    verdicts = {
        name: [judge_strong(s.probed(scheme, pendulum())[part], 1.0).verdict for part in (R, V, MU)]
        for name, scheme in wrong.items()
    }

    reached = local_strong(wrong["mu"], pendulum()).reached.tolist()
    assert reached == [[1.0, 1.0, 0.0], [1.0, 1.0, 0.0], [1.0, 1.0, 1.0]]
    assert verdicts["mu"] == [Verdict.VERIFIED, Verdict.VERIFIED, Verdict.REFUTED]
    assert verdicts["v"] == [Verdict.REFUTED] * 3


def test_bounded_increments_have_no_local_strong_order() -> None:
    """Two of them make no increment of a longer step."""
    assert "two-point" in why_not_local_order(TwoPoint(s.euler), gbm())
    assert not why_not_local_order(s.Formula(s.euler), gbm())


def test_an_inconsistency_at_few_states_refutes() -> None:
    """A drift that is wrong at the largest states only is that of another equation."""

    def rule(problem: SDE, x: Array, h: float, noise: Increment) -> Array:
        return s.euler(problem, x, h, noise) + 0.1 * h * (x > 3.5)

    order = found(s.Formula(rule), gbm())

    assert "off by" in order.departure
    assert judge_strong(order, 0.5).verdict is Verdict.REFUTED


def stops_early(tolerance: float) -> Scheme:
    """Return drift-implicit Euler on ou, solved up to an error of this size."""

    def rule(problem: SDE, x: Array, h: float, noise: Increment) -> Array:
        exact = (x + 0.7 * noise.dW) / (1.0 + h)
        return exact + tolerance * np.sin(1e5 * exact)

    return s.Formula(rule)


@pytest.mark.parametrize("tolerance", [1e-7, 1e-8])
def test_the_tolerance_of_a_solver_is_seen_and_left_out(tolerance: float) -> None:
    """A scheme whose solver stops too early keeps its order where the steps are long enough."""
    order = found(stops_early(tolerance), ou())
    answer = judge_strong(order, 1.0)

    assert order.order == pytest.approx(1.0, abs=0.05)
    assert answer.verdict is Verdict.VERIFIED
    assert 4.0**-8 < order.plateau_h < 4.0**-2
    assert "left out because of a solver's tolerance" in str(answer.reason)


@pytest.mark.parametrize("exponent", np.linspace(-11.0, -6.0, 5))
def test_no_tolerance_of_a_solver_is_taken_for_a_wrong_equation(exponent: float) -> None:
    """Wherever the plateau begins, below 1e-6 the scheme is not refuted."""
    assert opinion(stops_early(10.0**exponent), ou(), 1.0).verdict is not Verdict.REFUTED


def test_a_wrong_noise_does_not_pass_for_a_tolerance() -> None:
    """A relative error of 1e-4 of the noise has defects that are smaller than a plateau may be, and is refuted."""
    strength = 1.0 + 1e-4

    answer = opinion(s.Formula(lambda p, x, h, n: s.euler(p, x, h, n, strength=strength)), ou(), 0.5)

    assert answer.reason.has(Kind.INCONSISTENT)


def test_the_waiver_leaves_a_defect_that_is_taken_back_undecided() -> None:
    """A low local order is left to the paths; a wrong drift is refuted all the same."""
    low = opinion(s.NotSharp(s.milstein(0.45)), gbm(), 1.0)
    wrong = opinion(s.NotSharp(lambda p, x, h, n: s.euler(p, x, h, n, drift=0.98)), gbm(), 0.5)

    assert [low.verdict, wrong.verdict] == [Verdict.INCONCLUSIVE, Verdict.REFUTED]


def many_noises(strength: float) -> tuple[Scheme, SDE]:
    """Return a scheme and a problem with so many noises that a rule of the fifth degree is too large."""
    problem = equation(
        lambda t, x: -x, lambda t, x: np.full((1, 9, 1), 0.2) * (1.0 + 0.5 * x[:, None]), [1.0], noise_dim=9
    )
    return s.Formula(lambda p, x, h, n: s.euler(p, x, h, n, strength=strength)), problem


def test_many_noises_resolve_means() -> None:
    """With nine motions the orders of means are known, too, and noise that is a little wrong is refuted."""
    order = found(*many_noises(1.0))
    wrong = opinion(*many_noises(1.005), 0.5)

    assert order.means
    assert order.p1 == pytest.approx(2.0, abs=0.02)
    assert order.order == pytest.approx(0.5, abs=0.02)
    assert judge_strong(order, 0.5).verdict is Verdict.VERIFIED
    assert judge_strong(order, 1.0).verdict is Verdict.REFUTED
    assert wrong.reason.has(Kind.INCONSISTENT)


@dataclass(frozen=True)
class OtherAreas(MilsteinAreas):
    """Milstein's scheme with areas that are too large or too small."""

    factor: float = 1.0

    name: ClassVar[str] = "other-areas"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        return super().step(problem, state, t, h, noise._replace(A=self.factor * noise.A))


@pytest.mark.parametrize(
    ("factor", "verdict"), [(1.0, Verdict.VERIFIED), (1.02, Verdict.REFUTED), (0.9, Verdict.REFUTED)]
)
def test_areas_have_nodes(factor: float, verdict: Verdict) -> None:
    """A part of the area that is lost or too much leaves the order 1/2, which no margin of the order 1 hides."""
    order = found(OtherAreas(factor), levy_area())
    assert judge_strong(order, 1.0, margin=0.2).verdict is verdict


def test_a_map_that_breaks_down_at_small_steps_has_no_order() -> None:
    """What is not finite at the finest step is neither verified nor refuted."""

    def rule(problem: SDE, x: Array, h: float, noise: Increment) -> Array:
        return s.euler(problem, x, h, noise) * (1.0 if h > 1e-4 else np.nan)

    order = found(s.Formula(rule), gbm())

    assert np.isnan(order.order)
    assert judge_strong(order, 0.5).verdict is Verdict.INCONCLUSIVE


def test_a_crossover_that_is_still_falling_is_not_verified() -> None:
    """Noise so small that its order 1/2 comes up only at the finest steps: a claim of order 1 stays open."""
    order = found(EulerMaruyama(), gbm(b=0.004))

    assert order.order > 0.5
    assert judge_strong(order, 1.0).verdict is not Verdict.VERIFIED


@pytest.mark.parametrize(("layer", "verdict"), [(1e-5, Verdict.INCONCLUSIVE), (0.0, Verdict.REFUTED)])
def test_a_layer_at_few_states_that_steps_still_miss_decides_nothing(layer: float, verdict: Verdict) -> None:
    """A defect there is of order 1 while h is above the layer's own time, and 3/2 below; without layer it stays 1."""

    def rule(problem: SDE, x: Array, h: float, noise: Increment) -> Array:
        return s.euler(problem, x, h, noise) + 10.0 * (x > 1.2) * h * noise.dW / (np.sqrt(h) + np.sqrt(layer))

    order = found(s.Formula(rule), ou())

    assert order.order < 0.8
    assert order.typical == pytest.approx(1.0, abs=0.05)
    assert judge_strong(order, 1.0).verdict is verdict


def test_the_unit_of_time_does_not_matter() -> None:
    """The same equation over a horizon of a millionth has the same order."""
    fast = equation(lambda t, x: -1e6 * x, lambda t, x: 1e3 * x[:, None], [1.0], horizon=1e-6)

    assert found(EulerMaruyama(), fast).order == pytest.approx(0.5, abs=0.02)


def test_a_step_is_asked_at_its_time() -> None:
    """A drift that depends on time is taken at both half steps; with the wrong time a step is inconsistent."""
    problem = equation(lambda t, x: np.sin(7.0 * t) + 0.0 * x, constant([0.3]), [1.0])

    late = scheme(lambda p, x, t, h, n: x + h * p.drift(2.0 * t, x) + 0.3 * n.dW)

    assert found(EulerMaruyama(), problem).order == pytest.approx(1.0, abs=0.02)
    assert opinion(late, problem, 0.5).reason.has(Kind.INCONSISTENT)


def test_an_order_within_the_margin_of_its_claim_is_not_refuted() -> None:
    """Half an order too low refutes a claim with the usual margin, and decides nothing where the margin is wider."""
    order = found(EulerMaruyama(), gbm())

    assert judge_strong(order, 1.0, margin=0.2).verdict is Verdict.REFUTED
    assert judge_strong(order, 1.0, margin=0.6).verdict is Verdict.INCONCLUSIVE


@pytest.mark.parametrize(
    ("known", "told"),
    [({"order": 1.0, "p2": 1.5}, "the mean error is not resolved"), ({}, "hides its error")],
)
def test_orders_that_are_not_known_are_not_told(known: dict[str, float], told: str) -> None:
    """A reason names the orders of the defects that are numbers."""
    unknown = StrongOrder(np.nan, np.nan, np.nan, typical=1.0, plateau_h=0.0, means=False, ahead=1.0)

    reason = judge_strong(unknown._replace(**known), 1.0).reason

    assert told in reason.text
    assert "nan" not in reason.text
    assert not reason.text.endswith("; ")
