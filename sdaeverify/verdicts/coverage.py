"""What covers a quantity: the strongest claim of a scheme about it on a problem."""

from collections.abc import Iterable
from math import inf
from typing import NamedTuple

from ..contracts.claimed import IN_MEAN_SQUARE, Bound, Exact, Order
from ..contracts.finding import Kind, Reason
from ..contracts.measure import Evidence
from ..contracts.scheme import Claim, Scheme
from ..forms import Problem


class Coverage(NamedTuple):
    """A quantity with the strongest claim that covers it.

    Attributes
    ----------
    quantity : str
    claim : Claim or None
    gap : Reason
        Why there is none; empty if there is one.
    """

    quantity: str
    claim: Claim | None
    gap: Reason = Reason()


def coverage(evidence: Evidence, measure: str, quantity: str) -> Coverage:
    """Return a quantity of a measure with the strongest claim that covers it on the problem of a cell.

    Parameters
    ----------
    evidence : Evidence
        Of one cell.
    measure : str
        Name of the measure.
    quantity : str
        What it measures: a component, an observable, a constraint.
    """
    return _strongest(evidence.promises, evidence.view.traits, measure, quantity)


def claim_for(scheme: Scheme, traits: Iterable[str], measure: str, quantity: str) -> Coverage:
    """Return a quantity with the strongest claim of a scheme that covers it on a problem with these traits.

    Parameters
    ----------
    scheme : Scheme
    traits : iterable of str
        Of the problem as the scheme sees it.
    measure, quantity : str

    Returns
    -------
    Coverage
    """
    return _strongest(scheme.promises, traits, measure, quantity)


def why_not_claimed(scheme: Scheme, problem: Problem, measure: str, what: str = "") -> str:
    """Return that a scheme claims nothing about a measure on a problem, or `what` it measures; empty if it does.

    Parameters
    ----------
    scheme : Scheme
    problem : Problem
    measure : str
        A claim about it counts where its traits are among those of the problem as the scheme sees it.
    what : str
        What the reason names in place of the measure.
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
    gap = f"no claim about {quantity} here: the claims of the scheme need the {asked}, which this problem lacks"
    return Coverage(quantity, None, Reason(gap, Kind.NO_CLAIM))


def _strength(claim: Claim) -> tuple[float, bool]:
    """Return what claims are compared by: the value first, then the sense, as mean square implies probability."""
    value = 0.0
    match claim.value:
        case Exact():
            value = inf
        case Order(least):
            value = least
        case Bound(most=most):
            value = -most
    return value, claim.sense == IN_MEAN_SQUARE
