"""Controls: schemes of known order that show whether a problem can distinguish orders."""

from collections.abc import Iterable
from dataclasses import dataclass

from ..errors import ProblemError


@dataclass(frozen=True, kw_only=True)
class Control:
    """Two schemes whose verdicts on a claim are known in advance.

    A claim of this order is verified on a problem only if the positive control is verified and the negative one is
    refuted; otherwise the problem does not discriminate. A claim of an order between two declared orders uses the
    controls of both. Paths do not refute a claim in a quantity in which they also refute the positive control, if
    that is another scheme: the truth of the problem is then likely to be wrong. For a claim that only the tests of a
    whole run together may refute, a p-value of the control up to the run's level is sufficient for this.

    Attributes
    ----------
    measure : str
    order : float
        The order that may be gated on the problem.
    positive, negative : str
        Labels of registered schemes: one of at least this order on the problem, and one of a lower order.
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
    """Return the declared orders whose controls decide a claim of an order.

    The positive control of the smallest declared order that is not below the claim has the claimed order. The
    negative control of that order shows that a scheme of lower order is refuted. If the claim lies between two
    declared orders, the positive control of the lower one also shows whether the problem distinguishes that order
    from the claim.

    Parameters
    ----------
    declared : iterable of float
        Orders of one measure.
    order : float
        The claimed order.

    Returns
    -------
    tuple of float
        The smallest declared order that is not below the claim and, if it is above the claim, the largest one below
        the claim if there is one; empty if all are below the claim.
    """
    known = set(declared)
    above = min((each for each in known if each >= order), default=None)
    if above is None:
        return ()
    below = [] if above == order else [each for each in known if each < order]
    return (above, max(below)) if below else (above,)
