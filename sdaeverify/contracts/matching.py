"""Which scheme can be put to which problem, and in which view."""

from typing import NamedTuple

from ..forms import Problem
from ..forms.names import article
from .scheme import Scheme


class Match(NamedTuple):
    """A problem in the form a scheme solves, or the reason why there is none.

    Attributes
    ----------
    problem : Problem or None
    view : str
        Name of the view, empty for the problem itself.
    reason : str
        Empty if the two match.
    failed : bool
        Whether the reason is what the scheme raised.
    """

    problem: Problem | None
    view: str = ""
    reason: str = ""
    failed: bool = False


def match(scheme: Scheme, problem: Problem) -> Match:
    """Offer a problem to a scheme.

    Parameters
    ----------
    scheme : Scheme
    problem : Problem

    Returns
    -------
    Match
    """
    seen = scheme.view_of(problem)
    if seen is None:
        needed = " or ".join(article(form.__name__) for form in scheme.forms)
        return Match(None, reason=f"needs {needed}; this problem is {article(type(problem).__name__)}")
    # One Brownian motion has no areas with others.
    if missing := scheme.noise - seen.noise - ({"A"} if seen.noise_dim == 1 else set()):
        return Match(
            None, seen.seen_as, f"needs noise {', '.join(sorted(missing))}, which the problem does not declare"
        )
    if reason := scheme.refuses(seen):
        return Match(None, seen.seen_as, reason)
    return Match(seen, seen.seen_as)
