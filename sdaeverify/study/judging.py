"""From the evidence on a problem to the results of its cells."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from ..contracts.finding import Finding, Kind, LevelFinding, Opinion, Reason, Verdict
from ..contracts.measure import Evidence
from ..contracts.scheme import Scheme
from ..contracts.settings import Settings
from ..contracts.tally import Tally
from ..errors import FAULTS, one_line
from ..measures.judge import lost_index
from ..simulate.behaviour import Behaviour, differing
from ..simulate.ensemble import LaneEvidence
from .controlled import ControlEvidence, ControlVerdicts, Objection, heed_controls
from .plan import Cell, ProblemPlan

CONTRACT = "contract and exactness (T0)"


@dataclass(frozen=True)
class CellEvidence:
    """What is known of a cell.

    Attributes
    ----------
    sampled, probed : Tally
        From paths, and without sampling.
    health : Tally
        Of the scheme's steps.
    seconds : float
        Time of the scheme on this problem, all its measures together.
    paths : int
    error, violation : str
        Why there is no evidence: what was raised, or which contract is broken; empty if there is some.
    behaviour : Behaviour or None
        What scheme and problem did; None if that is not known.
    lack : Verdict
        What an `error` is: one indeed, or that nothing was run.
    """

    sampled: Tally = field(default_factory=Tally)
    probed: Tally = field(default_factory=Tally)
    health: Tally = field(default_factory=Tally)
    seconds: float = 0.0
    paths: int = 0
    error: str = ""
    violation: str = ""
    behaviour: Behaviour | None = None
    lack: Verdict = Verdict.ERROR

    @property
    def refused(self) -> bool:
        """Whether nothing can be measured."""
        return bool(self.error or self.violation)

    def merged(self, lane: LaneEvidence, index: int) -> "CellEvidence":
        """Return the evidence with that of one more block; the first error stays."""
        return CellEvidence(
            self.sampled.merged(lane.tallies[index]),
            self.probed.merged(lane.probes[index]),
            self.health.merged(lane.health),
            self.seconds + lane.seconds,
            self.paths + lane.paths,
            self.error or lane.errors[index] or differing(self.behaviour, lane.behaviour),
            self.violation or lane.violation,
            self.behaviour or lane.behaviour,
        )


Evidences = Mapping[tuple[Scheme, str], CellEvidence]


@dataclass(frozen=True)
class CellResult:
    """What became of a cell.

    Attributes
    ----------
    cell : Cell
    findings : tuple of Finding
        At least one: a cell that was not measured has a single one with the reason.
    levels : tuple of LevelFinding
    health : Tally
    paths : int
    seconds : float
        Time of the scheme on this problem, all its measures together.
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


def without_evidence(cell: Cell, verdict: Verdict, reason: str) -> CellResult:
    """Return the result of a cell without evidence."""
    return CellResult(cell, (Finding(quantity="", verdict=verdict, reason=Reason(reason)),))


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
        # The logarithm of an error that is exactly zero is not a defect; the measures look at what comes out.
        with np.errstate(all="ignore"):
            judgement = cell.measure.judge(_evidence(plan, cell, settings, known))
            findings = tuple(heed_controls(finding, cell.scheme, controls) for finding in judgement.findings)
            findings = tuple(_before_the_end(finding, known) for finding in findings)
    except FAULTS as error:
        return without_evidence(cell, Verdict.ERROR, f"measure {cell.measure.name}: {one_line(error)}")
    assert plan.problem is not None
    findings = (*findings, *_unmet(cell, findings))
    return CellResult(
        cell, findings, judgement.levels, known.health, known.paths, known.seconds, plan.problem.horizon
    )


def control_verdicts(plan: ProblemPlan, settings: Settings, evidences: Evidences) -> ControlVerdicts:
    """Return what the controls of a problem have against verdicts.

    Parameters
    ----------
    plan : ProblemPlan
    settings : Settings
    evidences : mapping of (Scheme, str) to CellEvidence
        By scheme and name of the measure, those of the controls included.

    Returns
    -------
    ControlVerdicts
    """
    known = {cell: evidences[cell.scheme, cell.measure.name] for cell in plan.control_cells}
    evidence = {cell: _of_control(plan, cell, settings, found) for cell, found in known.items()}
    return ControlVerdicts(plan.controls, evidence)


def _of_control(
    plan: ProblemPlan, cell: Cell, settings: Settings, known: CellEvidence
) -> ControlEvidence | Objection:
    if known.error:
        return Objection(f"was not measured: {known.error}", known.lack)
    if known.violation:
        return Objection(f"breaks a contract: {known.violation}")
    whole = _evidence(plan, cell, settings, known)
    return ControlEvidence(replace(whole, tally=known.sampled), whole)


def _of_violation(cell: Cell, known: CellEvidence) -> CellResult:
    claim = next((claim for claim in cell.scheme.promises if claim.measure == cell.measure.name), None)
    verdict = Verdict.REFUTED if claim else Verdict.OUT_OF_SCOPE
    opinion = Opinion(verdict, Reason(known.violation), tier=0)
    finding = Finding(quantity="", claim=claim, method=CONTRACT, **opinion._asdict())
    return CellResult(cell, (finding,), seconds=known.seconds)


def _before_the_end(finding: Finding, known: CellEvidence) -> Finding:
    """Return a finding on a run that the solution does not last for: only paths refute, nothing is verified."""
    end = lost_index(known.health.sums)
    by_paths = finding.verdict is Verdict.REFUTED and finding.tier == 3
    if not end or by_paths or finding.verdict not in {Verdict.VERIFIED, Verdict.REFUTED}:
        return finding
    reason = finding.reason if finding.reason.has(Kind.LOST_INDEX) else finding.reason.then(end)
    return replace(finding, verdict=Verdict.INCONCLUSIVE, reason=reason, p_verified=1.0, p_refuted=1.0)


def _evidence(plan: ProblemPlan, cell: Cell, settings: Settings, known: CellEvidence) -> Evidence:
    assert plan.problem is not None
    assert cell.seen is not None
    tally = known.sampled.merged(known.probed)
    return Evidence(cell.scheme, plan.problem, cell.seen, settings, tally, known.health, settings.level)


def _unmet(cell: Cell, findings: tuple[Finding, ...]) -> Iterator[Finding]:
    """Yield a finding for each quantity that a claim names and the cell does not have."""
    found = {finding.quantity.partition("@")[0] for finding in findings}
    for claim in cell.scheme.promises:
        for quantity in claim.quantities if claim.measure == cell.measure.name else ():
            if quantity not in found:
                reason = f"claimed, but there is no {quantity} here; there are {', '.join(sorted(found))}"
                yield Finding(quantity=quantity, verdict=Verdict.OUT_OF_SCOPE, reason=Reason(reason))
