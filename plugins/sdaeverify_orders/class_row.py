"""The verdict on one claim about one class of equations."""

from dataclasses import dataclass
from math import nan

from sdaeverify import Claim
from sdaeverify.measuring import Verdict
from sdaeverify.studying import ClassTests

from .trees.conditions import Condition

ORDER_CONDITIONS, RANDOM_MEMBERS = ClassTests.order_conditions, ClassTests.random_members


@dataclass(frozen=True)
class ClassRow:
    """Result for one claim and one class.

    Attributes
    ----------
    scheme, kind, measure : str
        Label of the scheme, name of the class, ``strong``, ``weak`` or ``invariant``.
    motions : int
        Number of Brownian motions.
    verdict : Verdict
        Inconclusive if a premise of the conditions fails, out of scope if the scheme claims no order for the class.
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
        Claim that was examined; None without a claim.
    conditions : str
        Kind of the test: ``order conditions`` or ``random members``.
    mistake : str
        Known mistake of a refuted scheme; empty if it is not recognised.
    modified, modified_terms : str
        Modified equation as lines, and its terms with their trees; empty unless it was computed.
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
    modified: str = ""
    modified_terms: str = ""

    @property
    def why(self) -> str:
        """Reason of the verdict in a sentence."""
        named = f"{self.mistake}; " if self.mistake else ""
        if self.verdict is Verdict.REFUTED and self.first:
            found, wanted = self.first.texts
            return (
                f"{named}order {self.order:g}: the condition {self.first.name} fails, found {found}, wanted {wanted}"
            )
        if self.verdict is Verdict.VERIFIED and self.conditions == ORDER_CONDITIONS:
            motions = f"{self.motions} Brownian motion{'s' * (self.motions != 1)}"
            noise = f" for up to {motions}" if self.motions else ""
            return f"order conditions hold, {self.held} of {self.of}{noise}"
        if self.verdict is Verdict.VERIFIED:
            return f"holds on {self.held} of {self.of} random members"
        if self.verdict is Verdict.OUT_OF_SCOPE:
            return f"no claim about the class {self.kind}"
        undecided = self.verdict is Verdict.INCONCLUSIVE and self.conditions == ORDER_CONDITIONS
        return f"{named}{'order conditions decide nothing here: ' if undecided else ''}{self.premise}"

    @property
    def cells(self) -> dict[str, object]:
        """Cells of the table row by column."""
        named = {"scheme": self.scheme, "class": self.kind, "measure": self.measure}
        return {**named, "claim": self.claim, "verdict": self.verdict.value, **self.details}

    @property
    def details(self) -> dict[str, object]:
        """Further columns from conditions or members."""
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
            "modified": self.modified,
            "modified_terms": self.modified_terms,
        }
