"""Matching of schemes and problems: whether a scheme applies to a problem, and in which view."""

from typing import Any, NamedTuple

from ..forms import Problem
from ..forms.names import article
from .scheme import Scheme
from .spelling import did_you_mean


class Match(NamedTuple):
    """A problem in a form that the scheme solves, or the reason why there is none.

    Attributes
    ----------
    problem : Problem or None
    view : str
        Name of the view, empty for the problem itself.
    reason : str
        Empty if scheme and problem match.
    failed : bool
        Whether the mismatch is a defect of the scheme rather than a difference of scope.
    """

    problem: Problem | None
    view: str = ""
    reason: str = ""
    failed: bool = False


def match(scheme: Scheme, problem: Problem) -> Match:
    """Match a problem to a scheme.

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
    if reason := _why_not_given(scheme, seen):
        return Match(None, seen.seen_as, reason, failed=True)
    # With one Brownian motion there are no mixed iterated integrals.
    if missing := scheme.noise - seen.noise - ({"A"} if seen.noise_dim == 1 else set()):
        return Match(
            None, seen.seen_as, f"needs noise {', '.join(sorted(missing))}, which the problem does not declare"
        )
    if reason := scheme.why_not(seen):
        return Match(None, seen.seen_as, reason)
    return Match(seen, seen.seen_as)


def _why_not_given(scheme: Scheme, seen: Any) -> str:
    """Return that `Scheme.gives` names a component that the problem lacks, or an empty string."""
    if not scheme.gives:
        return ""
    known = [*seen.parts(seen.initial(1))]
    unknown = [name for name in scheme.gives if name not in known]
    # A scheme for several forms may name components of another form only.
    if not unknown or (len(scheme.forms) > 1 and len(unknown) == len(scheme.gives)):
        return ""
    meant = did_you_mean(unknown[0], known)
    expected = f"components of {article(type(seen).__name__)}: {', '.join(known)}"
    return f"gives {', '.join(unknown)}, expected {expected}{meant}"
