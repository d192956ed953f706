"""`check_scheme` and `check_problem`: the kit as plain functions, whose answers are data."""

from collections.abc import Callable, Mapping

from ..contracts.scheme import Scheme
from ..contracts.specs import ProblemSpec
from ..forms import Problem
from .problem_subject import ProblemSubject
from .questions import answers, problem_questions, scheme_questions
from .subjects import Problems, SchemeSubject, installed, problem_of, scheme_of


def check_scheme(
    scheme: str | Scheme,
    problems: Problems | None = None,
    *,
    level: int | None = None,
    expected_failures: Mapping[str, str] | None = None,
) -> list[dict[str, object]]:
    """Put a scheme to every check of the kit.

    Parameters
    ----------
    scheme : Scheme or str
        A scheme, registered or not, or the label of a registered one.
    problems : str or sequence of str, ProblemSpec or callable, optional
        Labels of registered problems and problem functions, mixed. Where left out, the registered problems that the
        scheme does not refuse, but for those on request: of its own form rather than in a view, and of these the
        three whose states have the fewest components.
    level : int, optional
        Checks that came with a later level of the kit are skipped; by default none is.
    expected_failures : mapping of str to str, optional
        Reasons by the name of a check, or by ``check on problem``; ``*`` and ``?`` are wildcards.

    Returns
    -------
    list of dict
        For each check, on each problem: subject, kind, check, category, level, problem, status (``passed``,
        ``failed``, ``skipped``, ``xfailed``, ``xpassed``), reason and seconds, as JSON can hold them. Nothing is
        raised for a check that fails.

    Raises
    ------
    UsageError
        If it is no scheme, a problem is unknown or refused, or an expected failure names no check.
    """
    registry = installed()
    questions = scheme_questions(SchemeSubject(scheme_of(scheme, registry), registry), problems, level)
    return [outcome.row for outcome in answers(questions, expected_failures)]


def check_problem(
    problem: str | ProblemSpec | Callable[..., Problem],
    *,
    level: int | None = None,
    expected_failures: Mapping[str, str] | None = None,
) -> list[dict[str, object]]:
    """Put a problem to every check of the kit.

    Parameters
    ----------
    problem : callable, ProblemSpec or str
        A problem function, uncalled, or the label of a registered one.
    level : int, optional
        Checks that came with a later level of the kit are skipped; by default none is.
    expected_failures : mapping of str to str, optional
        Reasons by the name of a check; ``*`` and ``?`` are wildcards.

    Returns
    -------
    list of dict
        As of `check_scheme`, ``problem`` being empty.

    Raises
    ------
    UsageError
        If it is no problem function, or an expected failure names no check.
    """
    registry = installed()
    questions = problem_questions(ProblemSubject(problem_of(problem, registry), registry), level)
    return [outcome.row for outcome in answers(questions, expected_failures)]
