"""For each guard a cell that is judged wrongly without it: a wrong scheme verified, or a right one refuted."""

from dataclasses import replace
from typing import Any, ClassVar, NamedTuple

from contradictions import bent_drift
from facade import (
    SRA1,
    BalancedEuler,
    EulerMaruyama,
    Heun,
    Invariant,
    Milstein,
    PlatenWeak2,
    StochasticTheta,
    Strong,
    Study,
    Weak,
    double_well,
    gbm,
    ou,
    plan,
    problem_spec,
)
from measures.test_coarse_steps import CELLS as COARSE
from measures.test_contradictions import controls, short_fibre
from measures.test_interpolated_lags import SecondOrder, between
from measures.test_lost_index import turning
from measures.test_named_observables import ROUGH
from measures.test_order_resolution import Deaf
from measures.test_taken_back import InTurns
from planted.memory_schemes import EverySoMany
from sdaeverify import SDE, Claim, HolonomicSDAE, Law, Scheme, Settings
from sdaeverify.measuring import Finding, Measure, Verdict
from sdaeverify.noise.laws import clipped_gaussian
from sdaeverify_planted.delays import SingleIteration
from sdaeverify_planted.mechanics import MultiplierSign
from sdaeverify_planted.projections import WrongExplicit
from sdaeverify_problems.nonlinear_constraint import nonlinear_constraint
from sdaeverify_problems.pendulums.damped_pendulum import damped_pendulum
from study.test_moments import Explicit
from study.test_problem_run import Remembering, noisier, small_noise

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
    """

    scheme: Scheme
    problem: Any
    measures: tuple[Measure, ...]
    wrong: Verdict
    paths: int = 1024
    levels: int = Settings().levels

    def findings(self) -> list[Finding]:
        """Return the findings of a run."""
        made = self.problem if hasattr(self.problem, "label") else problem_spec(self.problem)
        planned = plan([self.scheme], [made], self.measures, control)
        study = Study(planned, Settings(paths=self.paths, levels=self.levels))
        for _ in study.run():
            pass
        return [finding for finding in study.results()[0].findings if finding.claim is not None]

    def verdicts(self) -> dict[str, Verdict]:
        """Return the verdicts of a run by quantity."""
        return {finding.quantity: finding.verdict for finding in self.findings()}


def control(label: str) -> Scheme | None:
    """Return a control of the problems here."""
    return Heun() if label == "heun" else controls(label)


class ClippedMilstein(Milstein):
    """Milstein's scheme with increments clipped at sqrt(2 ln(1/h)): their variance lacks a part of order h."""

    name: ClassVar[str] = "clipped-milstein"
    law: ClassVar[Law] = clipped_gaussian(1.0)


class DeafMilstein(Milstein):
    """Milstein's scheme, declared to jump in the noise."""

    name: ClassVar[str] = "deaf-milstein"
    discontinuous_in_noise: ClassVar[bool] = True


class Unbiased(EulerMaruyama):
    """Euler-Maruyama of which a bias within 100 is claimed."""

    name: ClassVar[str] = "unbiased-euler"
    claims: ClassVar[tuple[Claim, ...]] = (Claim(measure="invariant", value="unbiased", bound=100.0, source=SOURCE),)


def digital() -> SDE:
    """Return growth, of which it is asked whether it is above 1."""
    return replace(gbm(), observables=ROUGH, truths=())


def another_noise() -> SDE:
    """Return growth with the truth of one with half as much noise again: the scheme is wrong for that."""
    return replace(gbm(), truths=(gbm(b=0.9).pathwise,), controls=())


def much_noise() -> SDE:
    """Return a martingale of heavy tails with the truth of one with a tenth more noise."""
    return replace(gbm(0.0, 2.0), truths=(gbm(0.0, 2.2).pathwise,), controls=())


def pendulum() -> HolonomicSDAE:
    """Return a damped pendulum without controls."""
    return replace(damped_pendulum(), controls=())


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
    "a pole within the horizon": GuardCell(StochasticTheta(), turning, (Strong(),), REFUTED),
    "a half-explicit step with a multiplier of the other sign": GuardCell(
        MultiplierSign(), pendulum, (Strong(), Weak()), VERIFIED
    ),
    "a projection with a wrong Coriolis term": GuardCell(
        WrongExplicit(3, coriolis=-1.0, counted=0.0), damped_pendulum, (Strong(),), VERIFIED, 2048
    ),
}
