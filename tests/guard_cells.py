"""For each guard a cell that is judged wrongly without it: a wrong scheme verified, or a right one refuted."""

from dataclasses import replace
from math import inf
from typing import Any, ClassVar, NamedTuple

from adaptive.solving import verdicts as verdicts_of_errors
from adaptive.test_judging import falling, made
from contradictions import TooMuchNoise, bent_drift
from facade import (
    SRA1,
    BalancedEuler,
    Case,
    EulerMaruyama,
    Heun,
    Invariant,
    Milstein,
    PlatenWeak2,
    StochasticTheta,
    Strong,
    Study,
    TamedEuler,
    Weak,
    double_well,
    gbm,
    growing_volatility,
    harmonic_langevin,
    ou,
    plan,
    problem_spec,
    send,
    spiral,
)
from measures.test_coarse_steps import CELLS as COARSE
from measures.test_contradictions import controls, short_fibre
from measures.test_interpolated_lags import SecondOrder, between
from measures.test_lost_index import turning
from measures.test_named_observables import ROUGH
from measures.test_order_resolution import Deaf
from measures.test_taken_back import InTurns
from planted.memory_schemes import EverySoMany
from sdaeverify import SDE, Claim, Law, Moment, Scheme, Settings
from sdaeverify.measuring import Finding, Measure, Verdict
from sdaeverify_lab.planted.delays import SingleIteration
from sdaeverify_lab.planted.projections import WrongExplicit
from sdaeverify_problems.nonlinear_constraint import nonlinear_constraint
from sdaeverify_problems.pendulums.damped_pendulum import damped_pendulum
from study.test_moments import Explicit
from study.test_problem_run import Remembering, noisier, small_noise
from units import in_units, langevin_in_units

SOURCE = "tests/guard_cells"


class GuardCell(NamedTuple):
    """A scheme on a problem.

    Attributes
    ----------
    scheme : Scheme
    problem : callable
        Function of the problem.
    measures : tuple of Measure
        The first one's verdicts count.
    wrong : Verdict
        The verdict that some of its claims have without the guard alone.
    paths : int
    levels : int
    resolution : float
        Largest share of the limit that a gate accepts to be overlooked.
    """

    scheme: Scheme
    problem: Any
    measures: tuple[Measure, ...]
    wrong: Verdict
    paths: int = 1024
    levels: int = Settings().levels
    resolution: float = inf

    def findings(self) -> list[Finding]:
        """Return the findings of a run."""
        made = self.problem if hasattr(self.problem, "label") else problem_spec(self.problem)
        planned = plan([self.scheme], [made], self.measures, control)
        study = Study(planned, Settings(paths=self.paths, levels=self.levels))
        for _ in study.run():
            pass
        found = (send(finding, Case(resolution=self.resolution)) for finding in study.results()[0].findings)
        return [finding for finding in found if finding.claim is not None]

    def verdicts(self) -> dict[str, Verdict]:
        """Return the verdicts of a run by quantity."""
        return {finding.quantity: finding.verdict for finding in self.findings()}


class ErrorCell(NamedTuple):
    """Errors of an adaptive solver of the size tau^(1/2) that share their normals, and a mean that stays.

    Attributes
    ----------
    mean : float
    wrong : Verdict
        The verdict that the rate in tau has without the guard.
    """

    mean: float
    wrong: Verdict

    def verdicts(self) -> dict[str, Verdict]:
        """Return the verdict of the claimed rate."""
        found = verdicts_of_errors(made(falling(0.5, mean=self.mean)))
        return {"x": Verdict(found["tolerance", "x"])}


def control(label: str) -> Scheme | None:
    """Return a control of the problems here."""
    return Heun() if label == "heun" else controls(label)


class ClippedMilstein(Milstein):
    """Milstein's scheme with increments clipped at sqrt(2 ln(1/h)): their variance lacks a part of order h."""

    name: ClassVar[str] = "clipped-milstein"
    law: ClassVar[Law] = Law.clipped_gaussian(1.0)


class DeafMilstein(Milstein):
    """Milstein's scheme, declared to jump in the noise."""

    name: ClassVar[str] = "deaf-milstein"
    discontinuous_in_noise: ClassVar[bool] = True


class DeafBalancedEuler(BalancedEuler):
    """Balanced Euler, declared to jump in the noise, so that paths alone decide."""

    name: ClassVar[str] = "deaf-balanced-euler"
    discontinuous_in_noise: ClassVar[bool] = True


class DeafTamedEuler(TamedEuler):
    """Tamed Euler, declared to jump in the noise."""

    name: ClassVar[str] = "deaf-tamed-euler"
    discontinuous_in_noise: ClassVar[bool] = True


class Unbiased(EulerMaruyama):
    """Euler-Maruyama of which a bias within 100 is claimed."""

    name: ClassVar[str] = "unbiased-euler"
    claims: ClassVar[tuple[Claim, ...]] = (Claim(measure="invariant", value="unbiased", bound=100.0, source=SOURCE),)


def growth_of_its_own() -> SDE:
    """Return growth without controls."""
    return replace(gbm(), controls=())


def digital() -> SDE:
    """Return growth, of which it is asked whether it is above 1."""
    return replace(gbm(), observables=ROUGH, truths=())


def another_noise() -> SDE:
    """Return growth with the truth of one with half as much noise again: the scheme is wrong for that."""
    return replace(gbm(), truths=(gbm(b=0.9).pathwise,), controls=())


def much_noise() -> SDE:
    """Return a martingale of heavy tails with the truth of one with a tenth more noise."""
    return replace(gbm(0.0, 2.0), truths=(gbm(0.0, 2.2).pathwise,), controls=())


def slow_spiral() -> SDE:
    """Return a spiral in a unit of time of 10^-6 of its own."""
    return replace(in_units(spiral(), time=1e6), controls=())


def pulled() -> SDE:
    """Return an Ornstein-Uhlenbeck process with a strong pull."""
    return replace(ou(14.0, 0.5), controls=())


def falling_growth() -> SDE:
    """Return growth that falls by a factor of e^31 within the horizon."""
    return replace(gbm(-31.0, 0.1), controls=())


def fast_growth() -> SDE:
    """Return growth by a factor of e^40."""
    return replace(gbm(40.0, 0.5), controls=())


def growth() -> SDE:
    """Return growth by a factor of e^6."""
    return replace(gbm(6.0, 0.5), controls=())


def growth_of_means() -> SDE:
    """Return growth by a factor of e^8 of which the means alone are known."""
    whole = gbm(16.0, 1.0, horizon=0.5)
    return replace(whole, controls=(), truths=tuple(each for each in whole.truths if isinstance(each, Moment)))


def loud_well() -> SDE:
    """Return a double well with so much noise that balanced Euler loses paths on long steps."""
    return replace(double_well(6.0, 1.0), controls=())


def falling_volatility() -> SDE:
    """Return an equation with a strong pull, whose volatility grows in time."""
    return replace(growing_volatility(-10.0, 1.0, 3.0), controls=())


def slightly_noisier() -> SDE:
    """Return growth with the truth of one with a hundredth more noise."""
    return replace(gbm(), truths=(gbm(b=0.606).pathwise,), controls=())


def another_growth() -> SDE:
    """Return growth with the truth of one that is slower by a tenth: a wrong limit for every scheme."""
    return replace(gbm(2.5, 0.5), truths=(gbm(2.25, 0.5).pathwise,), controls=())


def slow_oscillator() -> SDE:
    """Return an oscillator in units of 1e-8 of its positions and of 1e-7 of its time."""
    return replace(langevin_in_units(harmonic_langevin(), scale=1e8, time=1e7).ito(), controls=())


VERIFIED, REFUTED = Verdict.VERIFIED, Verdict.REFUTED
GROUP = COARSE["differences of means grow before they fall"]
NOISE = COARSE["noise goes up and down within a step"]
CELLS = {
    "SRA1 with a kink in the drift": GuardCell(SRA1(), bent_drift, (Strong(),), VERIFIED, 2048, 4),
    "Milstein with clipped increments": GuardCell(ClippedMilstein(), gbm, (Strong(),), VERIFIED, 2048),
    "trapezoidal rule with a lag between mesh points": GuardCell(SecondOrder(), between, (Weak(),), VERIFIED),
    "Heun with a drift of every second step": GuardCell(EverySoMany(), ou, (Weak(),), VERIFIED),
    "three-point increments and a digital observable": GuardCell(PlatenWeak2(), digital, (Weak(),), VERIFIED, 2048),
    "balanced Euler on a stiff fibre": GuardCell(BalancedEuler(), short_fibre, (Strong(),), REFUTED),
    "explicit and implicit Euler in turns": GuardCell(InTurns(), ou, (Weak(),), REFUTED),
    "balanced Euler in slow time, along paths": GuardCell(
        BalancedEuler(), slow_oscillator, (Strong(),), REFUTED, 256
    ),
    "balanced Euler in slow time, in law": GuardCell(BalancedEuler(), slow_spiral, (Weak(),), REFUTED),
    "balanced Euler with a strong pull, 40 paths": GuardCell(BalancedEuler(), pulled, (Strong(),), REFUTED, 40),
    "Milstein on growth that falls fast": GuardCell(DeafMilstein(), falling_growth, (Strong(),), REFUTED, 256),
    "balanced Euler on a loud double well": GuardCell(DeafBalancedEuler(), loud_well, (Strong(),), REFUTED, 512, 4),
    "tamed Euler on fast growth": GuardCell(DeafTamedEuler(), fast_growth, (Strong(),), REFUTED, 256),
    "tamed Euler on growth, in law": GuardCell(DeafTamedEuler(), growth, (Weak(),), REFUTED),
    "balanced Euler with a growing volatility": GuardCell(
        BalancedEuler(), falling_volatility, (Strong(),), REFUTED, 512, 8
    ),
    "tamed Euler and means that grow fast": GuardCell(TamedEuler(), growth_of_means, (Weak(),), REFUTED, 512, 8),
    "Euler-Maruyama with the truth of slower growth": GuardCell(EulerMaruyama(), another_growth, (Weak(),), VERIFIED),
    "errors of a rate of 1/2 with a mean that stays": ErrorCell(0.02, VERIFIED),
    "another noise, and a gate that asks for a hundredth": GuardCell(
        EulerMaruyama(), slightly_noisier, (Weak(),), VERIFIED, 1024, resolution=0.01
    ),
    "Milstein with 0.96 of its integral": GuardCell(Deaf(factor=0.96), gbm, (Strong(),), VERIFIED, 2048),
    "one Newton iteration with a delay": GuardCell(SingleIteration(), nonlinear_constraint, (Strong(),), VERIFIED),
    "a bound of 100 for a bias": GuardCell(Unbiased(), ou, (Invariant(),), VERIFIED),
    "balanced Euler on the orthogonal group": GuardCell(*GROUP[:2], GROUP[2:], REFUTED),
    "Heun with noise that oscillates within a step": GuardCell(*NOISE[:2], NOISE[2:], REFUTED),
    "another noise, 64 paths": GuardCell(EulerMaruyama(), another_noise, (Weak(),), VERIFIED, 64),
    "another noise, 128 paths": GuardCell(EulerMaruyama(), another_noise, (Strong(),), VERIFIED, 128),
    "another noise and heavy tails, 128 paths": GuardCell(EulerMaruyama(), much_noise, (Strong(),), VERIFIED, 128),
    "Euler-Maruyama with the truth of another noise": GuardCell(DeafMilstein(), noisier, (Strong(),), REFUTED, 2048),
    "order 1/2 with small noise": GuardCell(Remembering(), small_noise, (Strong(),), VERIFIED, 2048),
    "Euler-Maruyama with a cubic drift": GuardCell(Explicit(), double_well, (Strong(),), VERIFIED),
    "a pole within the horizon": GuardCell(StochasticTheta(), turning, (Weak(),), REFUTED),
    "Milstein with a millionth of too much noise": GuardCell(
        TooMuchNoise(), growth_of_its_own, (Strong(), Weak()), VERIFIED, 256
    ),
    "a projection with a wrong Coriolis term": GuardCell(
        WrongExplicit(3, coriolis=-1.0, counted=0.0), damped_pendulum, (Strong(),), VERIFIED, 2048
    ),
}
