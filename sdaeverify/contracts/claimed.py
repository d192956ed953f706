"""Values of claims: a minimum order, exactness, a bound, or a word defined by a measure.

Code dispatches on the type of the value; its text is for readers only.
"""

from dataclasses import dataclass
from math import inf

from ..errors import SchemeError

# Texts by which users claim exactness, a bias below a bound, and an error below a bound at one step size.
ROUND_OFF, UNBIASED, ERROR = "round-off", "unbiased", "error"
# Suffix of a quantity that is its error at one step size.
AT_H = "@h="
# Orders in h are multiples of 1/2, so a margin of 1/2 would accept the next order below the claimed one.
MARGIN, HALF = 0.2, 0.5
# The sense in which an order holds. An order in mean square needs moments of the scheme that stay bounded as h falls;
# an order in probability, that is along almost every path, needs local conditions only (Gyongy 1998).
IN_MEAN_SQUARE, IN_PROBABILITY = "in mean square", "in probability"
SENSES = (IN_MEAN_SQUARE, IN_PROBABILITY)


@dataclass(frozen=True)
class Order:
    """A minimum order of convergence.

    Attributes
    ----------
    least : float
        The claimed order.
    margin : float
        Amount by which an order measured along paths may fall short of `least`: part of the claim, less than 1/2.
    """

    least: float
    margin: float = MARGIN

    def __post_init__(self) -> None:
        if not 0 < self.margin < self.least < inf:
            given = f"value {self.least!r} with margin {self.margin!r}"
            raise SchemeError(
                f"a claimed order must be finite and larger than its margin, which is positive; got {given}"
            )
        if self.margin >= HALF:
            raise SchemeError(
                f"a margin must be less than 1/2, or the next lower order would be accepted; got {self.margin!r}"
            )

    @property
    def floor(self) -> float:
        """Smallest accepted order, ``least - margin``; the claim holds for orders at or above it."""
        return self.least - self.margin

    @property
    def bar(self) -> str:
        """Text of the claim with the margin of orders along paths, for use in a reason."""
        return f"claim {float(self.least)}, margin {self.margin:.3g}"

    def __str__(self) -> str:
        return f"order >= {float(self.least)}"


def bar(claimed: float, accepted: float) -> str:
    """Return the text of a claimed order with the tolerance that applies to orders found without sampling.

    Parameters
    ----------
    claimed, accepted : float
        The claimed order, and the smallest order that is accepted.
    """
    return f"claim {float(claimed)}, one-step tolerance {claimed - accepted:.3g}"


@dataclass(frozen=True)
class Exact:
    """Claim that the error does not exceed rounding."""

    def __str__(self) -> str:
        return ROUND_OFF


@dataclass(frozen=True)
class Bound:
    """Claim that a quantity does not exceed a bound at any step size, or at one of them.

    Attributes
    ----------
    text : str
        Name of the bounded quantity: ``unbiased`` for a bias, ``error`` for an error at a step size, or a word
        defined by a measure, such as ``iterations``.
    most : float
        The largest absolute value, in the unit of the quantity.
    share : float
        Minimum fraction of the steps in which the bound holds.
    at : float or None
        Step size at which an error is bounded, in the problem's unit of time; None for every step size.
    """

    text: str
    most: float
    share: float = 1.0
    at: float | None = None

    def __post_init__(self) -> None:
        if (self.at is None) is (self.text == ERROR) or not 0 < (1 if self.at is None else self.at) < inf:
            text = "a bound on an error needs the one positive step size at which it holds, other bounds take none"
            raise SchemeError(f"{text}; got {self.text!r} at {self.at!r}")
        if not (0 < self.most < inf and 0 < self.share <= 1):
            given = f"{self.text!r}, {self.most!r} in a share {self.share!r} of the steps"
            raise SchemeError(f"a bound is positive and finite, its share positive and at most 1; got {given}")

    @property
    def suffix(self) -> str:
        """Suffix of the name of the bounded quantity: ``@h=0.125``, or empty for a bound at all step sizes."""
        return "" if self.at is None else f"{AT_H}{self.at:g}"

    def __str__(self) -> str:
        most = str(float(self.most)).removesuffix(".0")
        if self.at is not None:
            return f"error at most {most} at h = {self.at:g}"
        words = f"{UNBIASED} within {most}" if self.text == UNBIASED else f"at most {most} {self.text}"
        return words if self.share == 1 else f"{words} in {100 * self.share:g} per cent of the steps"


@dataclass(frozen=True)
class Word:
    """Claim expressed by a word that a measure defines.

    Attributes
    ----------
    text : str
    """

    text: str

    def __post_init__(self) -> None:
        if not self.text:
            raise SchemeError("a claim's value must be an order or words such as round-off, got an empty text")
        if self.text == UNBIASED:
            raise SchemeError("a claim of `unbiased` needs a bound")

    def __str__(self) -> str:
        return self.text


Value = Order | Exact | Bound | Word


def as_value(
    given: float | str | Value,
    margin: float | None,
    bound: float | None,
    share: float | None,
    at: float | None = None,
) -> Value:
    """Convert the value of a claim to a record.

    Parameters
    ----------
    given : float or str or record
        An order, a text, or a record.
    margin : float or None
        Margin of an order; None means `MARGIN`.
    bound : float or None
        Bound on the quantity that the text names.
    share : float or None
        Minimum fraction of the steps in which the bound holds; None means all steps.
    at : float or None
        Step size at which the bound holds; None means every step size.

    Raises
    ------
    SchemeError
        If `margin`, `bound` or `share` does not apply to the kind of value given.
    """
    _require_bound(bound, share, at)
    if isinstance(given, str):
        if bound is not None:
            return Bound(given, bound, 1.0 if share is None else share, at)
        if given.strip().replace(".", "", 1).isdecimal():
            raise SchemeError(f"a claimed order is a number, not a text; got {given!r}")
        return Exact() if given == ROUND_OFF else Word(given)
    if bound is not None:
        raise SchemeError(f"a bound belongs to a claim in words; got {given!r}, {bound!r}")
    if not isinstance(given, Order | Exact | Bound | Word):
        return Order(given, MARGIN if margin is None else margin)
    if margin is not None:
        raise SchemeError(f"a margin belongs to an order given as a number; got {given!r}, {margin!r}")
    return given


def _require_bound(bound: float | None, share: float | None, at: float | None) -> None:
    if share is not None and bound is None:
        raise SchemeError(f"a share is the part of the steps in which a bound holds; got {share!r} without bound")
    if at is not None and bound is None:
        raise SchemeError(f"at is the step size at which a bound holds; got at = {at!r} without a bound")
