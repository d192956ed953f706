"""Failures that an author expects, each with a reason."""

from collections.abc import Iterable, Mapping

from ..contracts.labels import did_you_mean, matches
from ..errors import UsageError, is_blank

Expected = Mapping[str, str]


def expected_reason(expected: Expected, check: str, problem: str = "") -> str:
    """Return the reason why a check is expected to fail, or an empty string.

    Parameters
    ----------
    expected : mapping of str to str
        Reasons by the name of a check, or by ``check on problem``; ``*`` and ``?`` are wildcards.
    check : str
    problem : str
        Label of the problem a scheme is asked on; empty if there is none.
    """
    names = _names(check, problem)
    return next((reason for pattern, reason in expected.items() if _means(pattern, names)), "")


def require_known(expected: Expected, asked: Iterable[tuple[str, str]]) -> None:
    """Check that each pattern of an expected failure names a check that is asked, and has a reason.

    Parameters
    ----------
    expected : mapping of str to str
    asked : iterable of (str, str)
        Names of checks and labels of their problems.

    Raises
    ------
    UsageError
        If one does not: a failure that is expected of nothing hides a misspelt name.
    """
    if not (isinstance(expected, Mapping) and all(isinstance(pattern, str) for pattern in expected)):
        raise UsageError(f"expected_failures expects a mapping of names of checks to reasons, got {expected!r}")
    names = [_names(check, problem) for check, problem in asked]
    known = sorted({check for check, *_ in names})
    for pattern, reason in expected.items():
        if not any(_means(pattern, each) for each in names):
            hint = did_you_mean(pattern, known)
            raise UsageError(f"expected failure {pattern!r} matches no check{hint} (known: {', '.join(known)})")
        if not (isinstance(reason, str) and not is_blank(reason)):
            raise UsageError(f"expected failure {pattern!r} has no reason; say in words why the check fails")


def _names(check: str, problem: str) -> tuple[str, ...]:
    return (check, f"{check} on {problem}") if problem else (check,)


def _means(pattern: str, names: Iterable[str]) -> bool:
    return any(matches(pattern, name) for name in names)
