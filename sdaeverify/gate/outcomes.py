"""Outcomes of a gate: whether each gated finding passed, and if not, whether its failure was expected."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass

from ..contracts.claimed import Order
from ..contracts.finding import UNMEASURED, Finding, Status, Verdict
from ..contracts.labels import matches, parse_label
from ..contracts.scheme import Claim
from ..contracts.spelling import did_you_mean
from ..errors import UsageError
from ..registry.contributions import Registered
from ..registry.load import Registry
from ..report.folders import Key, key_in
from ..study import Cell, CellResult
from ..study.every_equation import EVERY_EQUATION, is_premise_failing
from ..study.plan import claims_of, promises_of
from ..verdicts.rules import Case, send
from .expected import FailingClaim
from .policy import Policy

# Order in which outcomes are reported, worst first.
ORDER = (
    Status.FAILED,
    Status.UNMEASURED,
    Status.XPASSED,
    Status.UNDECIDED,
    Status.XFAILED,
    Status.PASSED,
)


GLOBS = ("*", "?")


@dataclass(frozen=True)
class Outcome:
    """A gated finding with its status.

    Attributes
    ----------
    result : CellResult
        Result of the cell of the finding.
    finding : Finding
    status : Status
    expected : str
        Reason of the matching expected failure; empty if none matches.
    """

    result: CellResult
    finding: Finding
    status: Status
    expected: str = ""

    @property
    def cell(self) -> Cell:
        """Cell of the finding."""
        return self.result.cell

    @property
    def key(self) -> Key:
        """Scheme, problem, measure and quantity of the finding."""
        return key_in(self.cell, self.finding.quantity)

    @property
    def claim(self) -> str:
        """The claim in words with its margin, or all claims of the cell if no quantity was measured."""
        claim = self.finding.claim if self.finding.quantity else None
        claims = claims_of(self.cell) or promises_of(self.cell) if claim is None else (claim,)
        return " and ".join(dict.fromkeys(map(_words, claims)))


def _words(claim: Claim) -> str:
    return f"{claim} up to a margin of {claim.value.margin:g}" if isinstance(claim.value, Order) else str(claim)


def outcomes(results: Iterable[CellResult], policy: Policy) -> list[Outcome]:
    """Return an outcome for each finding covered by a claim and for each cell that could not be measured.

    Parameters
    ----------
    results : iterable of CellResult
        Results corrected for all tests of the run, as returned by `Study.results`.
    policy : Policy

    Returns
    -------
    list of Outcome
        In the order of the results.
    """
    return [outcome for result in results for outcome in _outcomes(result, policy)]


def is_red(outcome: Outcome, policy: Policy) -> bool:
    """Return whether an outcome fails the gate."""
    if outcome.status is Status.UNDECIDED:
        return policy.fails_undecided
    return outcome.status in {Status.FAILED, Status.UNMEASURED, Status.XPASSED}


def idle(found: Iterable[Outcome], policy: Policy) -> list[FailingClaim]:
    """Return the expected failures that match no finding."""
    known = list(found)
    return [one for one in policy.expected_failures if not any(one.matches(**o.key._asdict()) for o in known)]


def require_named(registry: Registry, policy: Policy, cells: Iterable[Cell]) -> None:
    """Check that expected failures of a policy name existing schemes, problems and measures.

    A policy with examinations is not checked here, because the solvers of examinations are known only at their end.

    Parameters
    ----------
    registry : Registry
    policy : Policy
    cells : iterable of Cell
        Cells of the plan, whose schemes and problems need not be registered.

    Raises
    ------
    UsageError
        If an expected failure can never match a finding.
    """
    if policy.examinations:
        return
    planned = list(cells)
    for one in policy.expected_failures:
        if why := why_never(one, registry, planned):
            raise UsageError(f"the expected failure {one} ({one.reason}) can never match: {why}")


def why_never(one: FailingClaim, registry: Registry, cells: Iterable[Cell]) -> str:
    """Return why an expected failure can never match a finding, or an empty string.

    Parameters
    ----------
    one : FailingClaim
    registry : Registry
    cells : iterable of Cell
        Cells of the plan, whose schemes and problems need not be registered.
    """
    planned = list(cells)
    kinds = {
        "scheme": (registry.schemes, {cell.scheme.label for cell in planned}),
        "problem": (registry.problems, {cell.spec.label for cell in planned} | {EVERY_EQUATION}),
        "measure": (registry.measures, {cell.measure.name for cell in planned}),
    }
    reasons = (why for kind, known in kinds.items() for why in _objections(kind, getattr(one, kind), *known))
    return next(reasons, "")


def _objections(kind: str, pattern: str, registered: Mapping[str, Registered], labels: set[str]) -> Iterator[str]:
    """Yield why a pattern matches neither a given label nor a label of a registered entry."""
    if any(matches(pattern, label) for label in labels):
        return
    name = pattern.partition("[")[0]
    names = {*registered, *(label.partition("[")[0] for label in labels)}
    if not any(matches(name, each) for each in names):
        yield f"no {kind} is named {name}{did_you_mean(name, names)}"
    elif name in registered and not any(glob in pattern for glob in GLOBS):
        yield from _objections_to_label(pattern, registered[name])


def _objections_to_label(pattern: str, entry: Registered) -> Iterator[str]:
    """Yield why a pattern without wildcards is not the label of a registered entry."""
    try:
        made = entry.make(parse_label(pattern).parameters)
    except UsageError as error:
        yield str(error)
        return
    if (label := str(getattr(made, "label", entry.name))) != pattern:
        yield f"the label of {pattern} is written {label}"


def _outcomes(result: CellResult, policy: Policy) -> Iterator[Outcome]:
    for finding in (send(found, Case(resolution=policy.resolution)) for found in result.findings):
        if is_gated(finding):
            names = key_in(result.cell, finding.quantity)._asdict()
            one = next((one for one in policy.expected_failures if one.matches(**names)), None)
            yield Outcome(result, finding, _status(finding, one), one.reason if one else "")


def is_gated(finding: Finding) -> bool:
    """Return whether a gate counts a finding: a finding on a claim, or one that could not be measured."""
    return finding.verdict in UNMEASURED or (finding.claim is not None and not is_premise_failing(finding))


def _status(finding: Finding, expected: FailingClaim | None) -> Status:
    if finding.verdict is Verdict.VERIFIED:
        return Status.XPASSED if expected is not None and expected.strict else Status.PASSED
    # An expected failure does not cover a step that raises, hangs, dies or breaks its contract.
    if finding.verdict in UNMEASURED - {Verdict.DIVERGED}:
        return Status.UNMEASURED
    if expected is not None and not (finding.verdict is Verdict.REFUTED and not finding.quantity):
        return Status.XFAILED
    if finding.verdict in UNMEASURED:
        return Status.UNMEASURED
    return Status.FAILED if finding.verdict is Verdict.REFUTED else Status.UNDECIDED
