"""One problem in progress: look by look, with more paths for the cells that are not decided yet.

Paths begin on few, coarse levels. These suffice if one step has decided, so that paths only guard its verdict,
and if nothing is claimed. All levels are used for the other cells: those that paths alone decide, and those that the
guards leave open. If paths still contradict one step on all levels, finer levels are added until both agree or the
finest level is reached.
"""

from collections import defaultdict
from collections.abc import Collection, Iterable, Iterator
from dataclasses import dataclass, field, replace

from ..contracts.claimed import Exact, Order
from ..contracts.finding import SAMPLED, Finding, Kind, Verdict
from ..contracts.measure import Measure
from ..contracts.scheme import Scheme
from ..contracts.settings import Settings
from ..contracts.stages import SCREENING
from ..errors import FAULTS, one_line
from ..simulate.ensemble import Behaviour, SchemeEvidence, Task
from ..store.files import Opened
from ..verdicts.rules import Case, send
from .agreement import agreeing
from .judging import CellEvidence, CellResult, excluded_cells, without_evidence
from .look_judgement import LookJudgement, look_judgement
from .plan import Cell, Pair, ProblemPlan, entries_of

# Looks at guards on one stage: the number of paths that would decide is unknown then, so finer steps are tried.
GUARD_LOOKS = 2


# Compare by identity; comparing all fields would make list lookups slow.
@dataclass(eq=False)
class CellRun:
    """A cell in progress.

    Attributes
    ----------
    cell : Cell
    evidence : CellEvidence
    result : CellResult or None
        As judged at the last look.
    stage : int
        Stage whose levels its paths have; see `Settings.stages`.
    finer : bool
        Whether it waits for the levels of the next stage.
    min_paths : int
        Minimum number of paths on finer levels, equal to the number that contradicted the one-step result on coarser
        levels.
    exhausted : bool
        Whether a stage ended without a decision and the next stage would not help.
    halted : str
        Why no further look is taken; empty if further looks are possible.
    """

    cell: Cell
    evidence: CellEvidence = field(default_factory=CellEvidence)
    result: CellResult | None = None
    stage: int = 0
    finer: bool = False
    min_paths: int = 0
    exhausted: bool = False
    halted: str = ""

    @property
    def final_evidence(self) -> CellEvidence:
        """The evidence; if the cell was halted, evidence with the reason as its error."""
        return replace(self.evidence, error=self.halted, lack=Verdict.NOT_RUN) if self.halted else self.evidence

    @property
    def settled(self) -> bool:
        """Whether no more paths are needed."""
        if self.exhausted or self.halted:
            return True
        if self.result is None or self.result.paths < self.min_paths:
            return False
        return all(finding.settled for finding in self.result.findings)

    @property
    def asking(self) -> bool:
        """Whether more paths are needed on the present levels."""
        return not (self.settled or self.finer)

    @property
    def pathless(self) -> bool:
        """Whether paths are of no use: the cell has no measurable quantity, or its measure samples none."""
        return self.evidence.refused or _draws_none(self.cell.measure)


class ProblemRun:
    """All cells of a problem, with the cells of its controls.

    Parameters
    ----------
    plan : ProblemPlan
    settings : Settings

    Attributes
    ----------
    stage : int
        Number of levels of the paths relative to the settings; see `Settings.stages`.
    sampled : Settings
        Settings of the stage.
    look : int
        Number of looks taken on the stage.
    pairs : (int, int)
        Number of schemes, and number of schemes that are settled.
    screened : bool
        Whether the evidence without paths has been found.
    behaviour : dict of Scheme to set of (Behaviour or None, tuple of (str, str))
        Behaviour of scheme and problem in the evidence, and the files that their code has opened.
    """

    def __init__(self, plan: ProblemPlan, settings: Settings) -> None:
        self.plan, self.settings = plan, settings
        self.runs = [CellRun(cell) for cell in plan.runnable]
        known = {run.cell.pair for run in self.runs}
        self.controls = [CellRun(cell) for cell in plan.control_cells if cell.pair not in known]
        self.excluded = excluded_cells(plan)
        self.screened, self.stages = False, list(settings.stages)
        self.behaviour: dict[Scheme, set[tuple[Behaviour | None, Opened]]] = defaultdict(set)
        self._begin_stage()
        for run in (*self.runs, *self.controls):
            run.stage = self.stage
        self.pairs = self._count_pairs()

    @property
    def open(self) -> bool:
        """Whether further paths are needed and available."""
        return self.look < len(self.sampled.ends) and not all(run.settled for run in self.runs)

    @property
    def next_blocks(self) -> tuple[int, ...]:
        """Blocks of the next look, and the index of the screening."""
        return (*self.blocks, SCREENING)

    @property
    def blocks(self) -> range:
        """Blocks of the next look."""
        return range(self.sampled.ends[self.look - 1] if self.look else 0, self.sampled.ends[self.look])

    def halt(self, lacking: Collection[Pair], reason: str) -> None:
        """Take no further look at the given pairs of scheme and measure; `reason` goes into their rows."""
        for run in (*self.runs, *self.controls):
            if run.cell.pair in lacking:
                run.halted = reason
        self.pairs = self._count_pairs()

    def task(self) -> Task:
        """Return the task of the next look: the open cells, and the controls."""
        made = entries_of(run.cell for run in self._running())
        return Task(self.plan.spec, made, self.settings, screened=True, stage=self.stage, followed=self.plan.followed)

    def absorb(self, task: Task, evidence: Iterable[SchemeEvidence]) -> None:
        """Merge the evidence of one more block."""
        runs = {run.cell.pair: run for run in (*self.runs, *self.controls)}
        for entry, found in zip(task.entries, evidence, strict=True):
            self.behaviour[entry.scheme].add((found.behaviour, found.opened))
            for index, measure in enumerate(entry.measures):
                run = runs[entry.scheme, measure.name]
                run.evidence = _merge(run.evidence, found, index)

    def judgement(self) -> LookJudgement:
        """Return the judgement of the open cells at the end of a look."""
        known = {run.cell.pair: (self._settings_of(run), run.final_evidence) for run in (*self.runs, *self.controls)}
        return look_judgement(self.plan, [run.cell for run in self.runs if run.asking], known)

    def accept(self, judged: Iterable[CellResult], failed: Iterable[CellResult] = ()) -> None:
        """Take the results of the open cells, as judged at the end of a look, and go on to the next look.

        Parameters
        ----------
        judged : iterable of CellResult
        failed : iterable of CellResult
            Of cells whose judgement ended its process or took too long: no further look is taken at them.
        """
        runs, asked = {run.cell.pair: run for run in self.runs}, list[CellRun]()
        for ends, results in ((False, judged), (True, failed)):
            for result in results:
                run = runs[result.cell.pair]
                asked.append(run)
                run.result, run.exhausted = replace(result, cell=run.cell), run.exhausted or ends
        self.look += 1
        if self.stages:
            self._mark_for_next_stage([run for run in asked if not (run.pathless or run.exhausted)])
        self.pairs = self._count_pairs()

    def results(self, stopped: str) -> tuple[CellResult, ...]:
        """Return the current results of all cells; `stopped` says why further looks were not taken."""
        unsettled = self.open
        done = [
            _current_result(run, run.halted or (stopped if unsettled or run.result is None else ""))
            for run in self.runs
        ]
        return (*agreeing(self.plan.problem, done), *self.excluded)

    def _mark_for_next_stage(self, runs: Iterable[CellRun]) -> None:
        """Mark the runs that need the next stage, and begin it when all other runs are finished."""
        last = self.look == len(self.sampled.ends)
        for run in runs:
            assert run.result is not None
            found = run.result.findings
            asks = [_asks_for_finer(finding, self.stage, self.look, last=last) for finding in found]
            run.finer = any(asks)
            run.min_paths = max(run.min_paths, run.evidence.paths if any(map(_contradicts, found)) else 0)
            marked = (send(finding, Case(finer=ask)) for finding, ask in zip(found, asks, strict=True))
            run.result = replace(run.result, findings=tuple(marked))
        if any(run.finer for run in self.runs) and (last or not any(run.asking for run in self.runs)):
            self._begin_next_stage()

    def _begin_next_stage(self) -> None:
        """Begin the next stage with the runs that need it and their controls, discarding the paths sampled so far."""
        for run in self.runs:
            run.exhausted, run.finer = run.exhausted or not run.finer, False
        self._begin_stage()
        for run in self._running():
            run.evidence, run.stage = run.evidence.without_paths, self.stage
            run.min_paths = min(run.min_paths, self.sampled.paths)

    def _begin_stage(self) -> None:
        self.stage, self.look = self.stages.pop(0), 0
        self.sampled = self.settings.at(self.stage)

    def _settings_of(self, run: CellRun) -> Settings:
        return self.settings if _draws_none(run.cell.measure) else self.settings.at(run.stage)

    def _count_pairs(self) -> tuple[int, int]:
        schemes = {run.cell.scheme for run in self.runs}
        return len(schemes), len(schemes - {run.cell.scheme for run in self.runs if not run.settled})

    def _running(self) -> Iterator[CellRun]:
        # A settled cell keeps the evidence of its last look; a control continues for the cells it controls.
        controls = self._control_keys
        wanted = [run for run in self.runs if run.asking or run.cell.pair in controls]
        wanted += [run for run in self.controls if run.cell.pair in controls]
        yield from (run for run in wanted if not (run.halted or run.evidence.refused))

    @property
    def _control_keys(self) -> set[Pair]:
        """Keys of the controls of open cells."""
        # On levels finer than those of the settings, paths only guard one-step results, so controls are not sampled.
        asked = {run.cell.measure.name for run in self.runs if run.asking} if self.stage <= 0 else set()
        return {cell.pair for cell in self.plan.control_cells if cell.measure.name in asked}


def _asks_for_finer(finding: Finding, stage: int, look: int, *, last: bool) -> bool:
    """Return whether a finding needs finer levels.

    The levels of guards suffice if one step decides the finding or nothing is claimed. All levels and finer ones
    suffice unless paths contradict the one-step result, or paths alone cannot exclude a term of a lower order.
    """
    if _contradicts(finding):
        return last or look >= GUARD_LOOKS or finding.reason.has(Kind.FINER)
    if stage >= 0 and finding.reason.has(Kind.FINER) and not finding.settled:
        return last or look >= GUARD_LOOKS
    if finding.reason.has(Kind.GUARD) and not (finding.settled or last):
        return False
    return stage < 0 and _needs_all_levels(finding)


def _contradicts(finding: Finding) -> bool:
    """Return whether paths contradict one step, so that the number of paths that would decide is unknown."""
    return finding.reason.has(Kind.GUARD) and not (finding.settled or finding.reason.paths)


def _needs_all_levels(finding: Finding) -> bool:
    if finding.verdict is Verdict.VERIFIED:
        return not _shows_claim(finding)
    if finding.verdict is Verdict.REFUTED:
        return finding.tier == SAMPLED
    return finding.verdict is not Verdict.OUT_OF_SCOPE


def _shows_claim(finding: Finding) -> bool:
    """Return whether coarse levels suffice for a verified finding.

    They suffice along paths for a claim of exactness, and for one step unless the estimate is below a claimed order.
    """
    claim = finding.claim
    if finding.tier == SAMPLED:
        return claim is not None and isinstance(claim.value, Exact)
    return claim is None or not isinstance(claim.value, Order) or not finding.estimate < claim.value.floor


def _draws_none(measure: Measure) -> bool:
    return type(measure).observer is Measure.observer


def _merge(known: CellEvidence, found: SchemeEvidence, index: int) -> CellEvidence:
    try:
        return known.merge(found, index)
    except FAULTS as error:
        # Occurs only for evidence files that another program has written.
        return replace(known, error=f"the evidence of two blocks of paths cannot be combined: {one_line(error)}")


def _current_result(run: CellRun, stopped: str) -> CellResult:
    if run.result is None:
        return without_evidence(run.cell, Verdict.NOT_RUN, stopped)
    findings = (send(finding, Case(stopped=stopped)) for finding in run.result.findings)
    return replace(run.result, findings=tuple(findings)) if stopped else run.result
