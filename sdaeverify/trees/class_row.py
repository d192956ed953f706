"""The verdict on one claim about one class of equations."""

from dataclasses import dataclass
from enum import StrEnum
from math import nan

from ..contracts.scheme import Claim
from .conditions import Condition

ORDER_CONDITIONS, RANDOM_MEMBERS = "order conditions", "random members"


class ClassVerdict(StrEnum):
    """What order conditions say of a claim for a class of equations."""

    VERIFIED = "verified"
    REFUTED = "refuted"
    PREMISE = "premise fails"
    NOT_CLAIMED = "not claimed"
    ERROR = "error"
    NOT_APPLICABLE = "not applicable"


@dataclass(frozen=True)
class ClassRow:
    """What is found of one claim for one class.

    Attributes
    ----------
    scheme, kind, measure : str
        Label of the scheme, name of the class, ``strong``, ``weak`` or ``invariant``.
    motions : int
        Number of Brownian motions.
    verdict : ClassVerdict
    order : float
        That conditions give, as far as they were looked at; NaN where none were.
    claim : float
        The order claimed; NaN without a claim.
    held, of : int
        How many of the conditions of the claimed order, without a claim of all that are looked at, hold, of how many.
    first : Condition or None
        The first one that does not hold.
    premise : str
        The premises, or why one fails, or why nothing applies.
    promise : Claim or None
        What is claimed.
    conditions : str
        What the claim was put to: ``order conditions`` or ``random members``.
    mistake : str
        What a refuted scheme does instead, if it is a mistake that is known.
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
        """Why the verdict is what it is, in a sentence."""
        named = f"{self.mistake}; " if self.mistake else ""
        if self.verdict is ClassVerdict.REFUTED and self.first:
            found, wanted = self.first.texts
            return (
                f"{named}order {self.order:g}: the condition {self.first.name} fails, found {found}, wanted {wanted}"
            )
        if self.verdict is ClassVerdict.VERIFIED and self.conditions == ORDER_CONDITIONS:
            return f"{self.held} of {self.of} conditions hold for up to {self.motions} motions; {self.premise}"
        return f"{named}{self.premise}"

    @property
    def cells(self) -> dict[str, object]:
        """The row of a table."""
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
