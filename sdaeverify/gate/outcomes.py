"""What a maintainer needs to know of each gated finding: whether it passed, and if not, whether that was expected."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from enum import StrEnum

from ..contracts.claimed import Order
from ..contracts.finding import UNMEASURED, Finding, Verdict
from ..contracts.scheme import Claim
from ..report.folders import Key, key_in
from ..study import Cell, CellResult
from ..study.plan import claims_of, promises_of
from ..verdicts.rules import Case, send
from .expected import FailingClaim
from .policy import Policy


class Status(StrEnum):
    """What a finding means for the gate."""

    PASSED = "passed"
    FAILED = "failed"
    UNMEASURED = "unmeasured"
    UNDECIDED = "undecided"
    XFAILED = "xfailed"
    XPASSED = "xpassed"


# Worst first: the order in which outcomes are told.
ORDER = (
    Status.FAILED,
    Status.UNMEASURED,
    Status.XPASSED,
    Status.UNDECIDED,
    Status.XFAILED,
    Status.PASSED,
)


@dataclass(frozen=True)
class Outcome:
    """A gated finding.

    Attributes
    ----------
    result : CellResult
        Of its cell.
    finding : Finding
    status : Status
    expected : str
        Reason of the expected failure it matches; empty if none does.
    """

    result: CellResult
    finding: Finding
    status: Status
    expected: str = ""

    @property
    def cell(self) -> Cell:
        """The cell that the finding is of."""
        return self.result.cell

    @property
    def key(self) -> Key:
        """What it is about."""
        return key_in(self.cell, self.finding.quantity)

    @property
    def claim(self) -> str:
        """The claim in words, with its margin; where nothing was measured, all that the cell was to test."""
        claim = self.finding.claim if self.finding.quantity else None
        claims = claims_of(self.cell) or promises_of(self.cell) if claim is None else (claim,)
        return " and ".join(dict.fromkeys(map(_words, claims)))


def _words(claim: Claim) -> str:
    return f"{claim} up to a margin of {claim.value.margin:g}" if isinstance(claim.value, Order) else str(claim)


def outcomes(results: Iterable[CellResult], policy: Policy) -> list[Outcome]:
    """Return an outcome for each finding that a claim covers, and for each cell that could not be measured.

    Parameters
    ----------
    results : iterable of CellResult
        Family-wise, as `Study.results` gives them.
    policy : Policy

    Returns
    -------
    list of Outcome
        In the order of the results.
    """
    return [outcome for result in results for outcome in _outcomes(result, policy)]


def is_red(outcome: Outcome, policy: Policy) -> bool:
    """Tell whether an outcome fails the gate."""
    if outcome.status is Status.UNDECIDED:
        return policy.fails_undecided
    return outcome.status in {Status.FAILED, Status.UNMEASURED, Status.XPASSED}


def idle(found: Iterable[Outcome], policy: Policy) -> list[FailingClaim]:
    """Return the expected failures that no finding matches."""
    known = list(found)
    return [one for one in policy.expected_failures if not any(one.matches(**o.key._asdict()) for o in known)]


def _outcomes(result: CellResult, policy: Policy) -> Iterator[Outcome]:
    for finding in (send(found, Case(resolution=policy.resolution)) for found in result.findings):
        if finding.claim is not None or finding.verdict in UNMEASURED:
            names = key_in(result.cell, finding.quantity)._asdict()
            one = next((one for one in policy.expected_failures if one.matches(**names)), None)
            yield Outcome(result, finding, _status(finding, one), one.reason if one else "")


def _status(finding: Finding, expected: FailingClaim | None) -> Status:
    if finding.verdict is Verdict.VERIFIED:
        return Status.XPASSED if expected is not None and expected.strict else Status.PASSED
    # A step that raises, hangs, dies or breaks its contract is no way to fail that anybody expects.
    if finding.verdict in UNMEASURED - {Verdict.DIVERGED}:
        return Status.UNMEASURED
    if expected is not None and not (finding.verdict is Verdict.REFUTED and not finding.quantity):
        return Status.XFAILED
    if finding.verdict in UNMEASURED:
        return Status.UNMEASURED
    return Status.FAILED if finding.verdict is Verdict.REFUTED else Status.UNDECIDED
