"""Controls: schemes that show whether a problem can tell one order from another."""

from collections.abc import Iterable
from dataclasses import dataclass

from ..errors import ProblemError


@dataclass(frozen=True, kw_only=True)
class Control:
    """Two schemes whose verdicts on a claim are known before they are measured.

    Nobody's claim of this order is verified on a problem where the positive control is not verified, too, or where
    the negative one is not refuted: such a problem does not discriminate. A claim of an order between two declared
    ones is put to the controls on both sides. Nor do paths refute a scheme's claim where they refute another scheme,
    the positive control, in the same quantity, too: the truth of the problem is the suspect then. Where all tests of
    a run together may refute, a p-value of the control up to the run's level is enough for that.

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


def deciding(declared: Iterable[float], order: float) -> tuple[float, ...]:
    """Return the declared orders whose controls decide on a claim of an order.

    The positive control of the least order that is no lower has the claimed order. Which scheme misses it is known of
    the negative control there; and where the claim lies between two declared orders, the positive control of the
    highest lower one shows as well that the problem tells that order from the claimed one.

    Parameters
    ----------
    declared : iterable of float
        Orders of one measure.
    order : float
        The claimed one.

    Returns
    -------
    tuple of float
        The least one that is no lower and, where that is higher, the highest lower one if there is any; empty where
        all are lower.
    """
    known = set(declared)
    above = min((each for each in known if each >= order), default=None)
    if above is None:
        return ()
    below = [] if above == order else [each for each in known if each < order]
    return (above, max(below)) if below else (above,)
