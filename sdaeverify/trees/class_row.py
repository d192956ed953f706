"""The verdict on one claim about one class of equations."""

from dataclasses import dataclass
from enum import StrEnum
from math import nan

from ..contracts.scheme import Claim
from .conditions import Condition

ORDER_CONDITIONS, RANDOM_MEMBERS = "order conditions", "random members"


class ClassVerdict(StrEnum):
    """Verdict of order conditions on a claim for a class of equations."""

    VERIFIED = "verified"
    REFUTED = "refuted"
    PREMISE = "premise fails"
    NOT_CLAIMED = "not claimed"
    ERROR = "error"
    NOT_APPLICABLE = "not applicable"


@dataclass(frozen=True)
class ClassRow:
    """Result for one claim and one class.

    Attributes
    ----------
    scheme, kind, measure : str
        Label of the scheme, name of the class, ``strong``, ``weak`` or ``invariant``.
    motions : int
        Number of Brownian motions.
    verdict : ClassVerdict
    order : float
        Order from the examined conditions; NaN if there are none.
    claim : float
        Claimed order; NaN without a claim.
    held, of : int
        Number of conditions that hold, out of those of the claimed order, or of all examined ones without a claim.
    first : Condition or None
        First condition that does not hold.
    premise : str
        The premises, or why one fails, or why the class does not apply.
    promise : Claim or None
        The claim.
    conditions : str
        Kind of the test: ``order conditions`` or ``random members``.
    mistake : str
        Known mistake of a refuted scheme; empty if it is not recognised.
    """

    scheme: str
    kind: str
    motions: int
    measure: str
    verdict: ClassVerdict
    order: float = nan
    claim: float = nan
    held: int = 0
    of: int = 0
    first: Condition | None = None
    premise: str = ""
    promise: Claim | None = None
    conditions: str = ORDER_CONDITIONS
    mistake: str = ""

    @property
    def why(self) -> str:
        """Reason of the verdict in a sentence."""
        if self.verdict is ClassVerdict.REFUTED and self.first:
            found, wanted = self.first.texts
            named = f"{self.mistake}; " if self.mistake else ""
            return (
                f"{named}order {self.order:g}: the condition {self.first.name} fails, found {found}, wanted {wanted}"
            )
        if self.verdict is ClassVerdict.VERIFIED and self.conditions == ORDER_CONDITIONS:
            return f"{self.held} of {self.of} conditions hold for up to {self.motions} motions; {self.premise}"
        return self.premise

    @property
    def cells(self) -> dict[str, object]:
        """Cells of the table row by column."""
        found, wanted = self.first.texts if self.first else ("", "")
        return {
            "scheme": self.scheme,
            "class": self.kind,
            "motions": self.motions,
            "measure": self.measure,
            "order": self.order,
            "claim": self.claim,
            "verdict": self.verdict.value,
            "held": self.held,
            "of": self.of,
            "first": self.first.name if self.first else "",
            "found": found,
            "wanted": wanted,
            "premise": ", ".join(filter(None, (self.mistake, self.premise))),
        }
