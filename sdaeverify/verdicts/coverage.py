"""The strongest claim of a scheme about a quantity of a problem."""

from collections.abc import Iterable
from math import inf
from typing import NamedTuple

from ..contracts.claimed import IN_MEAN_SQUARE, Bound, Exact, Order
from ..contracts.finding import Kind, Reason
from ..contracts.measure import Evidence
from ..contracts.scheme import Claim, Scheme
from ..forms import Problem


class Coverage(NamedTuple):
    """Pair a quantity with the strongest claim that covers it.

    Attributes
    ----------
    quantity : str
    claim : Claim or None
    gap : Reason
        Why no claim covers the quantity; empty if `claim` is given.
    """

    quantity: str
    claim: Claim | None
    gap: Reason = Reason()


def coverage(evidence: Evidence, measure: str, quantity: str) -> Coverage:
    """Return a quantity of a measure with the strongest claim that covers it in a cell.

    Parameters
    ----------
    evidence : Evidence
        Evidence of the cell; it holds the claims of the scheme and the traits of the problem.
    measure : str
        Name of the measure.
    quantity : str
        Component, observable or constraint that is measured.
    """
    return _strongest(evidence.promises, evidence.view.traits, measure, quantity)


def claim_for(scheme: Scheme, traits: Iterable[str], measure: str, quantity: str) -> Coverage:
    """Return a quantity with the strongest claim of a scheme that covers it on a problem with given traits.

    Parameters
    ----------
    scheme : Scheme
    traits : iterable of str
        Traits of the scheme's view of the problem.
    measure, quantity : str

    Returns
    -------
    Coverage
    """
    return _strongest(scheme.promises, traits, measure, quantity)


def why_not_claimed(scheme: Scheme, problem: Problem, measure: str, what: str = "") -> str:
    """Return the reason that a scheme has no claim about a measure on a problem, or an empty string if it has one.

    Parameters
    ----------
    scheme : Scheme
    problem : Problem
    measure : str
        Only claims whose required traits all belong to the scheme's view of the problem count.
    what : str
        Name of the measured quantity, used in the reason instead of `measure`.
    """
    view = scheme.view_of(problem)
    traits = frozenset() if view is None else view.traits
    claimed = any(claim.measure == measure and claim.when <= traits for claim in scheme.promises)
    return "" if claimed else f"no claim about {what or measure} here"


def _strongest(claims: Iterable[Claim], traits: Iterable[str], measure: str, quantity: str) -> Coverage:
    covering, known = [claim for claim in claims if claim.covers(measure, quantity)], frozenset(traits)
    in_scope = [claim for claim in covering if claim.when <= known]
    if in_scope:
        return Coverage(quantity, max(in_scope, key=_strength))
    if not covering:
        return Coverage(quantity, None, Reason(f"no claim about {quantity}", Kind.NO_CLAIM))
    missing = sorted(set().union(*(claim.when for claim in covering)) - known)
    asked = f"trait{'s' * (len(missing) > 1)} {' and '.join(missing)}"
    gap = f"no claim about {quantity} here: claims of the scheme need the {asked}, which this problem lacks"
    return Coverage(quantity, None, Reason(gap, Kind.NO_CLAIM))


def _strength(claim: Claim) -> tuple[float, bool]:
    """Return the sort key of a claim: its value, then its sense, because mean square implies probability."""
    value = 0.0
    match claim.value:
        case Exact():
            value = inf
        case Order(least):
            value = least
        case Bound(most=most):
            value = -most
    return value, claim.sense == IN_MEAN_SQUARE
