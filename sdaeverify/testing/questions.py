"""What a scheme or a problem is asked, every check with its subject, and the answers, as data or as tests.

`check_scheme` and `check_problem` are the kit as plain functions, `parametrize_with_checks` is the kit as parameters
of a test, one for each check. Failures that an author expects have a reason each.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ..contracts.labels import did_you_mean, matches, parse_label
from ..contracts.scheme import Scheme
from ..contracts.specs import ProblemSpec
from ..errors import FAULTS, UsageError, is_blank, one_line
from ..forms import Problem
from ..report.plain import visible
from .check import LEVEL, Check, CheckOutcome, CheckStatus, run_check
from .checks.declarations import check_usable
from .checks.problem_declarations import check_builds
from .checks.problem_declarations import check_usable as check_function
from .subjects import Problems, ProblemSubject, SchemeSubject, cells_of, load_plugins, problem_of, scheme_of
from .table import checks

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


# What a problem is asked even if it cannot be built.
FIRST = ("declaration", "builds", "docstring")
NEWER = "the check came with level {since} of the kit, and level {level} is asked for"


@dataclass(frozen=True)
class Question:
    """A check that is put to a subject.

    Attributes
    ----------
    check : Check
    label, kind : str
        Of the scheme or problem.
    problem : str
        Label of the problem on which a scheme is asked; empty if on none.
    subject : object
        What the check's function takes.
    skipped : str
        Why it is not asked; empty if it is.
    """

    check: Check
    label: str
    kind: str
    problem: str
    subject: Any
    skipped: str = ""

    def answer(self, expected: Expected) -> CheckOutcome:
        """Ask, and compare with the failures that are expected."""
        unasked = (CheckStatus.SKIPPED, self.skipped, 0.0)
        status, reason, seconds = unasked if self.skipped else run_check(self.check, self.subject)
        why = expected_reason(expected, self.check.name, self.problem)
        if why and status is CheckStatus.FAILED:
            status, reason = CheckStatus.XFAILED, f"{why}: {reason}"
        elif why and status is CheckStatus.PASSED:
            status, reason = CheckStatus.XPASSED, f"it passes, but was expected to fail: {why}"
        check = self.check
        return CheckOutcome(
            self.label, self.kind, check.name, check.category, check.since, self.problem, status, reason, seconds
        )


def scheme_questions(subject: SchemeSubject, problems: Problems | None, level: int | None) -> list[Question]:
    """Return everything that a scheme is asked.

    Parameters
    ----------
    subject : SchemeSubject
    problems : str or sequence, optional
        As `cells_of` takes them.
    level : int, optional
        Newest level of the kit whose checks are made; the newest there is if left out.
    """
    scheme = subject.scheme
    broken = check_usable(subject)
    cells = [] if broken else cells_of(scheme, problems, subject.registry)
    label = type(scheme).__name__ if broken else scheme.label
    found = []
    for check in checks("scheme"):
        skipped = _why_skipped(check, level)
        if check.category != "api" and broken:
            found.append(Question(check, label, "scheme", "", subject, f"it cannot be used: {broken}"))
        elif check.each_problem:
            found += [Question(check, label, "scheme", cell.label, cell, skipped) for cell in cells]
        else:
            found.append(Question(check, label, "scheme", "", subject, skipped))
    return found


def problem_questions(subject: ProblemSubject, level: int | None) -> list[Question]:
    """Return everything that a problem is asked; see `scheme_questions` for the parameters."""
    unusable = check_function(subject)
    broken = unusable or _unbuilt(subject)
    label = subject.spec.name if unusable else subject.spec.label
    found = []
    for check in checks("problem"):
        skipped = "" if check.name in FIRST else broken and f"it cannot be built: {broken}"
        found.append(Question(check, label, "problem", "", subject, skipped or _why_skipped(check, level)))
    return found


def _unbuilt(subject: ProblemSubject) -> str:
    try:
        with np.errstate(all="ignore"):
            return check_builds(subject)
    except FAULTS as error:
        return one_line(error)


def answers(questions: list[Question], expected: Expected | None) -> Iterator[CheckOutcome]:
    """Yield what becomes of each question.

    Raises
    ------
    UsageError
        If a failure is expected of a check that is not asked, or without a reason.
    """
    require_known(expected or {}, [(question.check.name, question.problem) for question in questions])
    for question in questions:
        yield question.answer(expected or {})


def _why_skipped(check: Check, level: int | None) -> str:
    asked_for = LEVEL if level is None else level
    if not (isinstance(asked_for, int) and not isinstance(asked_for, bool) and 1 <= asked_for <= LEVEL):
        raise UsageError(f"level must be a whole number from 1 to {LEVEL}, the newest of this kit, got {level!r}")
    return NEWER.format(since=check.since, level=asked_for) if check.since > asked_for else ""


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
    registry = load_plugins()
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
    registry = load_plugins()
    questions = problem_questions(ProblemSubject(problem_of(problem, registry), registry), level)
    return [outcome.row for outcome in answers(questions, expected_failures)]


if TYPE_CHECKING:
    import pytest

Subject = str | Scheme | ProblemSpec | Callable[..., Problem]


@dataclass(frozen=True)
class BoundCheck:
    """A check of a test's subject: calling it raises AssertionError with the reason, or skips the test."""

    question: Question

    def __call__(self, subject: object) -> None:  # noqa: ARG002 - a test reads better with its subject
        """Ask the question that this is bound to."""
        import pytest  # noqa: PLC0415 - the kit itself needs no pytest

        outcome = self.question.answer({})
        if outcome.status is CheckStatus.SKIPPED:
            pytest.skip(visible(outcome.reason))
        if outcome.status is CheckStatus.FAILED:
            where = f"{outcome.subject} on {outcome.problem}" if outcome.problem else outcome.subject
            raise AssertionError(visible(f"{where} fails {outcome.check}: {outcome.reason}"))

    def __repr__(self) -> str:
        return self.question.check.name


def parametrize_with_checks(
    subjects: Sequence[Subject],
    *,
    problems: Problems | None = None,
    level: int | None = None,
    expected_failures: Mapping[str, str] | None = None,
) -> "pytest.MarkDecorator":
    """Return a decorator of a test function of ``subject`` and ``check`` that makes a test of each check.

    ::

        @parametrize_with_checks([MyScheme(), my_problem])
        def test_conformance(subject, check):
            check(subject)

    Parameters
    ----------
    subjects : sequence of Scheme, callable, ProblemSpec or str
        Schemes and problem functions, mixed, and labels of registered ones.
    problems, level, expected_failures
        As for `check_scheme`. Expected failures become strict xfail marks: a check that passes all the same fails the
        test.

    Returns
    -------
    pytest.MarkDecorator

    Raises
    ------
    UsageError
        As for `check_scheme`, or if there is no subject.
    """
    if isinstance(subjects, str | bytes) or not isinstance(subjects, Iterable):
        raise UsageError(f"subjects expects a list of schemes and problems, got {subjects!r:.200}")
    if not subjects:
        raise UsageError("subjects is empty; name the schemes and problems that are to be checked")
    import pytest  # noqa: PLC0415 - the kit itself needs no pytest

    expected = expected_failures or {}
    asked = [(subject, question) for subject in subjects for question in _questions(subject, problems, level)]
    require_known(expected, [(question.check.name, question.problem) for _, question in asked])
    return pytest.mark.parametrize(("subject", "check"), [_parameters(*pair, expected) for pair in asked])


def _questions(subject: Any, problems: Problems | None, level: int | None) -> Iterator[Question]:
    registry = load_plugins()
    name = parse_label(subject).name if isinstance(subject, str) else ""
    if isinstance(subject, Scheme) or (name and name not in registry.problems):
        yield from scheme_questions(SchemeSubject(scheme_of(subject, registry), registry), problems, level)
    else:
        yield from problem_questions(ProblemSubject(problem_of(subject, registry), registry), level)


def _parameters(subject: Any, question: Question, expected: Expected) -> Any:
    import pytest  # noqa: PLC0415

    why = expected_reason(expected, question.check.name, question.problem)
    marks = [pytest.mark.xfail(reason=visible(why), raises=AssertionError, strict=True)] if why else []
    where = f"{question.label}-{question.check.name}"
    name = f"{where}-on-{question.problem}" if question.problem else where
    return pytest.param(subject, BoundCheck(question), id=visible(name), marks=marks)
