"""Judgement: from the evidence on a problem to the results of its cells.

No claim is verified if the controls of a problem fail, because the problem does not discriminate then. Paths refute
no claim if they also refute a scheme that is known to be right, because then the problem is wrong, most likely its
truth.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache

import numpy as np

from ..contracts.claimed import AT_H, Order
from ..contracts.finding import (
    SAMPLED,
    UNMEASURED,
    Finding,
    Judgement,
    Kind,
    LevelFinding,
    Method,
    Opinion,
    Reason,
    Verdict,
)
from ..contracts.measure import Evidence
from ..contracts.scheme import AT_T, Claim, Scheme, is_about
from ..contracts.settings import Settings
from ..contracts.tally import Tally
from ..errors import FAULTS, UsageError, with_traceback
from ..forms.controls import deciding
from ..simulate.ensemble import Behaviour, SchemeEvidence
from ..store.behaviour import differing
from ..verdicts.fitted_levels import lost_index
from ..verdicts.moments import why_moments_diverge
from ..verdicts.rules import Case, Objection, send
from .plan import Cell, ControlPlan, Pair, ProblemPlan, claims_of, promises_of

CONTRACT = Method("contract and exactness", 0)


class ControlVerdicts:
    """Objections of a problem's controls to verdicts on other schemes.

    Each answer is computed once, because many findings rest on the same controls.

    Parameters
    ----------
    plans : tuple of ControlPlan
        Of one problem.
    evidence : mapping of Cell to Evidence or Objection
        Evidence on each cell of the controls that can be run, or the reason why there is none.
    """

    def __init__(self, plans: tuple[ControlPlan, ...], evidence: Mapping[Cell, Evidence | Objection]) -> None:
        self.plans, self.evidence = plans, evidence
        self._objection, self._against = cache(self._find_objection), cache(self._p_values)

    def case(self, finding: Finding, scheme: Scheme) -> Case:
        """Return the objections of the controls to a finding on a claim of an order.

        Parameters
        ----------
        finding : Finding
        scheme : Scheme
            The scheme that makes the claim; as a control it is not used against itself.
        """
        claim, by_paths = finding.claim, finding.tier == SAMPLED
        if claim is None or not isinstance(claim.value, Order):
            return Case()
        suspicion = self._suspicion(finding, scheme) if by_paths else ""
        if finding.verdict is Verdict.REFUTED:
            return Case(suspicion=suspicion)
        # The margin belongs to the tested claim: the controls are tested with the same margin.
        return Case(suspicion=suspicion, objection=self._objection(claim.measure, claim.value, by_paths))

    def _suspicion(self, finding: Finding, scheme: Scheme) -> str:
        """Return why paths cannot refute a claim; empty if they can, or are not close to doing so.

        A finding that is not refuted yet may become so by the correction over all tests of the run. It is compared
        with the control at the level of the whole run.
        """
        assert finding.claim is not None
        known = [plan for plan in self.plans if plan.control.measure == finding.claim.measure and not plan.missing]
        others = [plan for plan in known if plan.positive is not None and plan.positive.scheme.label != scheme.label]
        for plan in others:
            level = 0.0 if finding.verdict is Verdict.REFUTED else self._level(plan)
            if _p_against(finding) <= level and self._against(plan).get(finding.quantity, 1.0) <= level:
                control = plan.control
                return f"{control.positive}, known to have order {control.order}, is refuted here as well"
        return ""

    def _level(self, plan: ControlPlan) -> float:
        """Return the level of a whole run; 0 if there is no evidence on the positive control."""
        assert plan.positive is not None
        known = self.evidence[plan.positive]
        return 0.0 if isinstance(known, Objection) else 1.0 - known.settings.confidence

    def _find_objection(self, measure: str, order: Order, by_paths: bool) -> Objection | None:
        """Return why the controls do not allow an order to be verified, by paths alone or all tiers, or None."""
        claim = Claim(measure=measure, value=order, source="control")
        plans = [plan for plan in reversed(self.plans) if plan.control.measure == measure]
        declared = {plan.control.order: plan for plan in plans}
        asked = [declared[known] for known in deciding(declared, order.least)]
        if not asked:
            beyond = f"the problem declares no control of {claim.measure} order {order.least} or more"
            reason = f"{beyond}, so that it can only verify lower orders"
            return Objection(reason) if declared else None
        if asked[0].missing:
            return Objection(asked[0].missing, Verdict.ERROR if asked[0].failed else Verdict.INCONCLUSIVE)
        return self._not_told_apart(asked, claim, by_paths=by_paths)

    def _not_told_apart(self, plans: Sequence[ControlPlan], claim: Claim, *, by_paths: bool) -> Objection | None:
        """Return why controls do not separate the claimed order from lower ones; None if they do.

        `plans` begins with the control of the next declared order at or above the claim. If the claim lies between
        two declared orders, the control of the lower one follows.
        """
        above, *below = plans
        positive = self._verdicts(above.positive, claim, by_paths=by_paths)
        if isinstance(positive, Objection):
            return positive
        if Verdict.VERIFIED not in positive or Verdict.REFUTED in positive:
            return Objection(f"the positive control {above.control.positive} is not verified")
        lower = {above.control.negative: above.negative, **{plan.control.positive: plan.positive for plan in below}}
        found = [self._verdicts(cell, claim, by_paths=by_paths) for cell in lower.values()]
        if any(Verdict.REFUTED in verdicts for verdicts in found if not isinstance(verdicts, Objection)):
            return None
        # A control that was not measured is not a control that was not refuted.
        if (unknown := next((verdicts for verdicts in found if isinstance(verdicts, Objection)), None)) is not None:
            return unknown
        if len(lower) == 1:
            return Objection(f"the negative control {above.control.negative} is not refuted")
        return Objection(f"none of the controls of lower order is refuted: {', '.join(lower)}")

    def _verdicts(self, cell: Cell | None, claim: Claim, *, by_paths: bool) -> set[Verdict] | Objection:
        """Return the verdicts on a control, empty if it cannot be run, or the reason why it has no evidence."""
        if cell is None:
            return set()
        known = self.evidence[cell]
        if isinstance(known, Objection):
            return known._replace(reason=f"the control {cell.scheme.label} {known.reason}")
        found = _findings(cell, claim, replace(known, tally=known.along_paths, probed=None) if by_paths else known)
        # An order is claimed for smooth functions; a finding on a discontinuous one does not count for or against
        # others.
        return {_of_known_order(finding) for finding in found if not finding.reason.has(Kind.NOT_SMOOTH)}

    def _p_values(self, plan: ControlPlan) -> dict[str, float]:
        """Return the p-values of the tests against the order of a positive control, by quantity."""
        assert plan.positive is not None
        claim = Claim(measure=plan.control.measure, value=plan.control.order, source="control")
        known = self.evidence[plan.positive]
        found = () if isinstance(known, Objection) else _findings(plan.positive, claim, known)
        return {each.quantity: _p_against(each) for each in found}


def _of_known_order(finding: Finding) -> Verdict:
    """Return the verdict on a control; that it has no lower order is known, and need not be resolved by paths."""
    return Verdict.VERIFIED if finding.reason.has(Kind.LOWER_ORDER) else finding.verdict


def _p_against(finding: Finding) -> float:
    """Return the p-value of the test against a claim; 0 if it is refuted already."""
    return 0.0 if finding.verdict is Verdict.REFUTED else finding.p_refuted


def _findings(cell: Cell, claim: Claim, known: Evidence) -> tuple[Finding, ...]:
    judgement: Judgement = cell.measure.judge(replace(known, claims=(claim,)))
    return judgement.findings


@dataclass(frozen=True)
class CellEvidence:
    """Evidence on a cell.

    Attributes
    ----------
    sampled, probed : Tally
        From paths, and without sampling.
    health : Tally
        Counts of the scheme's steps.
    seconds, path_seconds : float
        Time of the scheme on this problem, for all its measures together, and the part of it spent on paths.
    paths : int
    error, violation : str
        Why there is no evidence: the exception, or the violated contract; empty if there is evidence.
    behaviour : Behaviour or None
        Behaviour of scheme and problem; None if it is unknown.
    lack : Verdict
        Verdict if `error` is set: an error indeed, or not run.
    """

    sampled: Tally = field(default_factory=Tally)
    probed: Tally = field(default_factory=Tally)
    health: Tally = field(default_factory=Tally)
    seconds: float = 0.0
    path_seconds: float = 0.0
    paths: int = 0
    error: str = ""
    violation: str = ""
    behaviour: Behaviour | None = None
    lack: Verdict = Verdict.ERROR

    @property
    def whole(self) -> Tally:
        """Evidence from paths and without sampling, merged."""
        return self.sampled.merge(self.probed)

    @property
    def refused(self) -> bool:
        """Whether the cell has no measurable quantity."""
        return bool(self.error or self.violation)

    @property
    def without_paths(self) -> "CellEvidence":
        """The evidence without paths; the total time still includes the paths."""
        return replace(self, sampled=Tally(), health=Tally(), path_seconds=0.0, paths=0)

    def merge(self, found: SchemeEvidence, index: int) -> "CellEvidence":
        """Return the evidence merged with that of one more block; the first error is kept."""
        return CellEvidence(
            self.sampled.merge(found.tallies[index]),
            self.probed.merge(found.probes[index]),
            self.health.merge(found.health),
            self.seconds + found.seconds,
            self.path_seconds + (found.seconds if found.paths else 0.0),
            self.paths + found.paths,
            self.error or found.errors[index] or differing(self.behaviour, found.behaviour),
            self.violation or found.violation,
            self.behaviour or found.behaviour,
        )


# Settings of the paths of a cell, and the evidence on it.
Known = tuple[Settings, CellEvidence]


@dataclass(frozen=True)
class CellResult:
    """Result of a cell.

    Attributes
    ----------
    cell : Cell
    findings : tuple of Finding
        At least one: a cell that was not measured has a single finding with the reason.
    levels : tuple of LevelFinding
    health : Tally
    paths : int
    seconds, path_seconds : float
        Time of the scheme on this problem, for all its measures together, and the part of it spent on paths.
    horizon : float
        Final time, in the problem's unit of time.
    """

    cell: Cell
    findings: tuple[Finding, ...]
    levels: tuple[LevelFinding, ...] = ()
    health: Tally = field(default_factory=Tally)
    paths: int = 0
    seconds: float = 0.0
    horizon: float = float("nan")
    path_seconds: float = 0.0

    @property
    def step_seconds(self) -> float:
        """Mean time of a step on a path, observers included; NaN if there are no paths."""
        steps = float(self.health.sums["steps"].sum()) if "steps" in self.health.sums else 0.0
        return self.path_seconds / steps if steps else float("nan")


def without_evidence(cell: Cell, verdict: Verdict, error: str) -> CellResult:
    """Return the result of a cell without evidence.

    Parameters
    ----------
    cell : Cell
    verdict : Verdict
        Of the whole cell. The finding names the first claim of the cell, which stays open.
    error : str
        Reason in the first line; the traceback, if there was an exception, in the following ones.
    """
    claim = next(iter(claims_of(cell)), None) if verdict in UNMEASURED else None
    line, _, traceback = error.partition("\n")
    details = {"traceback": traceback} if traceback else {}
    finding = Finding(quantity="", verdict=verdict, reason=Reason(line), claim=claim, details=details)
    return CellResult(cell, (finding,))


def excluded_cells(plan: ProblemPlan) -> list[CellResult]:
    """Return the results of the cells that cannot be run."""
    return [without_evidence(cell, cell.verdict, cell.reason) for cell in plan.cells if cell.verdict is not None]


def judge_cell(
    plan: ProblemPlan, cell: Cell, settings: Settings, known: CellEvidence, controls: ControlVerdicts
) -> CellResult:
    """Judge a cell.

    Parameters
    ----------
    plan : ProblemPlan
    cell : Cell
    settings : Settings
    known : CellEvidence
    controls : ControlVerdicts
        Of the problem.

    Returns
    -------
    CellResult
    """
    if known.violation:
        return _of_violation(cell, known)
    if known.error:
        return without_evidence(cell, Verdict.ERROR, known.error)
    try:
        # The logarithm of an error of exactly zero is not a defect; the measures handle the infinite result.
        with np.errstate(all="ignore"):
            judgement = cell.measure.judge(_evidence(plan, cell, settings, known))
            levels = _checked_levels(tuple(judgement.levels), known)
            end, looks = lost_index(known.health.sums), len(settings.ends)
            found = ((finding, controls.case(finding, cell.scheme)) for finding in judgement.findings)
            findings = tuple(
                send(finding, case._replace(end=end, looks=looks, diverges=_diverges(cell, finding, known)))
                for finding, case in found
            )
    except FAULTS as error:
        return without_evidence(cell, Verdict.ERROR, f"measure {cell.measure.name}: {with_traceback(error)}")
    assert plan.problem is not None
    findings = (*findings, *_missing_quantities(cell, findings))
    times = known.seconds, plan.problem.horizon, known.path_seconds
    return CellResult(cell, findings, levels, known.health, known.paths, *times)


def _checked_levels(levels: tuple[LevelFinding, ...], known: CellEvidence) -> tuple[LevelFinding, ...]:
    """Return the rows of levels of a measure; raise if one names a level that no path was simulated on."""
    count = len(known.health.sums.get("steps", ()))
    for row in levels:
        if row.level is not None and not 0 <= row.level < count:
            raise UsageError(f"its row of {row.quantity} names level {row.level}, expected 0 to {count - 1} or None")
    return levels


def _diverges(cell: Cell, finding: Finding, known: CellEvidence) -> str:
    return why_moments_diverge(finding.claim, cell.measure, known.probed)


def control_verdicts(plan: ProblemPlan, known: Mapping[Pair, Known]) -> ControlVerdicts:
    """Return the objections of a problem's controls to verdicts.

    Parameters
    ----------
    plan : ProblemPlan
    known : mapping of (Scheme, str) to (Settings, CellEvidence)
        Settings of the paths and evidence, by scheme and name of the measure, controls included.

    Returns
    -------
    ControlVerdicts
    """
    evidence = {cell: _of_control(plan, cell, *known[cell.pair]) for cell in plan.control_cells}
    return ControlVerdicts(plan.controls, evidence)


def _of_control(plan: ProblemPlan, cell: Cell, settings: Settings, known: CellEvidence) -> Evidence | Objection:
    if known.error:
        line = known.error.partition("\n")[0]
        return Objection(f"was not measured: {line}", known.lack)
    if known.violation:
        return Objection(f"breaks a contract: {known.violation}")
    return _evidence(plan, cell, settings, known)


def _of_violation(cell: Cell, known: CellEvidence) -> CellResult:
    claim = next(iter(claims_of(cell)), None)
    verdict = Verdict.REFUTED if claim else Verdict.OUT_OF_SCOPE
    opinion = Opinion(verdict, Reason(known.violation), tier=0)
    finding = Finding(quantity="", claim=claim, method=CONTRACT, **opinion._asdict())
    return CellResult(cell, (finding,), seconds=known.seconds)


def _evidence(plan: ProblemPlan, cell: Cell, settings: Settings, known: CellEvidence) -> Evidence:
    assert plan.problem is not None
    assert cell.seen is not None
    fixed = cell.scheme, plan.problem, cell.seen, settings
    return Evidence(*fixed, known.whole, known.health, settings.level, probed=known.probed, sampled=known.sampled)


def _missing_quantities(cell: Cell, findings: tuple[Finding, ...]) -> Iterator[Finding]:
    """Yield a finding for each quantity that a claim names and the cell lacks."""
    found = {finding.quantity for finding in findings}
    for claim in promises_of(cell):
        for quantity in claim.quantities:
            if not any(is_about(name, quantity) for name in found):
                known = sorted({name.partition(AT_H)[0].removesuffix(AT_T) for name in found})
                reason = f"the scheme has a claim about {quantity}; measured here: {', '.join(known)}"
                yield Finding(quantity=quantity, verdict=Verdict.OUT_OF_SCOPE, reason=Reason(reason))
