"""Controls: schemes that show whether a problem can tell one order from another."""

from dataclasses import dataclass

from .errors import ProblemError


@dataclass(frozen=True, kw_only=True)
class Control:
    """Two schemes whose verdicts on a claim are known before they are measured.

    Nobody's claim of this order is verified on a problem where the positive control is not verified, too, or where
    the negative one is not refuted: such a problem does not discriminate. Nor do paths refute anybody's claim where
    they refute the positive control in the same quantity, too: the truth of the problem is the suspect then.

    Attributes
    ----------
    measure : str
    order : float
        The order that may be gated on the problem.
    positive, negative : str
        Labels of registered schemes: one of at least this order there, and one of a lower order.
    """

    measure: str
    order: float
    positive: str
    negative: str

    def __post_init__(self) -> None:
        if not self.order > 0.0:
            raise ProblemError(f"a control is for a positive order, got {self.order!r}")
        if self.positive == self.negative:
            raise ProblemError(f"positive and negative control are the same scheme, {self.positive}")
