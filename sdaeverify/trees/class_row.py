"""The verdict on one claim about one class of equations."""

from dataclasses import dataclass
from math import nan

from ..contracts.finding import Verdict
from ..contracts.scheme import Claim
from ..contracts.spelling import counted
from .conditions import Condition

ORDER_CONDITIONS, RANDOM_MEMBERS = "order conditions", "random members"
# Stands for the equations of a class where a row names a problem.
EVERY_EQUATION = "every-equation"


@dataclass(frozen=True)
class ClassRow:
    """What is found of one claim for one class.

    Attributes
    ----------
    scheme, kind, measure : str
        Label of the scheme, name of the class, ``strong``, ``weak`` or ``invariant``.
    motions : int
        Number of Brownian motions.
    verdict : Verdict
        Inconclusive where a premise of the conditions fails, out of scope where nothing is claimed for the class.
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
    verdict: Verdict
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
        if self.verdict is Verdict.REFUTED and self.first:
            found, wanted = self.first.texts
            named = f"{self.mistake}; " if self.mistake else ""
            return (
                f"{named}order {self.order:g}: the condition {self.first.name} fails, found {found}, wanted {wanted}"
            )
        if self.verdict is Verdict.VERIFIED and self.conditions == ORDER_CONDITIONS:
            noise = f" for up to {counted(self.motions, 'Brownian motion')}" if self.motions else ""
            return f"order conditions hold, {self.held} of {self.of}{noise}"
        if self.verdict is Verdict.VERIFIED:
            return f"holds on {self.held} of {self.of} random members"
        return f"no claim about the class {self.kind}" if self.verdict is Verdict.OUT_OF_SCOPE else self.premise

    @property
    def cells(self) -> dict[str, object]:
        """The row of a table."""
        named = {"scheme": self.scheme, "class": self.kind, "measure": self.measure}
        return {**named, "claim": self.claim, "verdict": self.verdict.value, **self.details}

    @property
    def details(self) -> dict[str, object]:
        """What else conditions or members tell."""
        found, wanted = self.first.texts if self.first else ("", "")
        return {
            "motions": self.motions,
            "order": self.order,
            "held": self.held,
            "of": self.of,
            "first": self.first.name if self.first else "",
            "found": found,
            "wanted": wanted,
            "premise": ", ".join(filter(None, (self.mistake, self.premise))),
        }
