"""Checks applied to subjects, and their results as data or as tests.

`check_scheme` and `check_problem` run the kit as plain functions; `parametrize_with_checks` turns each check into a
test. Every expected failure of an author has a reason.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from ..contracts.finding import Status
from ..contracts.labels import parse_label
from ..contracts.scheme import Scheme
from ..contracts.specs import ProblemSpec
from ..errors import FAULTS, UsageError, one_line
from ..forms import Problem
from ..gate.expected import FailingCheck, read_expected, require_matches
from ..report.plain import visible
from .check import LEVEL, Check, run_check
from .checks.declarations import check_usable
from .checks.problem_declarations import check_builds
from .checks.problem_declarations import check_usable as check_function
from .subjects import Problems, ProblemSubject, SchemeSubject, cells_of, load_plugins, problem_of, scheme_of
from .table import checks

Expected = FailingCheck | Mapping[str, Any]
Row = dict[str, object]

# Checks of a problem that are made even if it cannot be built.
FIRST = ("declaration", "builds", "docstring")
NEWER = "the check belongs to level {since} of the kit, and level {level} is requested"


@dataclass(frozen=True)
class Question:
    """A check with its subject; as a parameter of a test, it is called with that subject.

    Attributes
    ----------
    check : Check
    label, kind : str
        Label and kind of the subject, a scheme or a problem.
    problem : str
        Label of the problem on which a scheme is checked; empty if there is none.
    subject : object
        Argument of the check's function.
    skipped : str
        Why the check is skipped; empty if it is not.
    """

    sdaeverify_part: ClassVar[str] = "checks"

    check: Check
    label: str
    kind: str
    problem: str
    subject: Any
    skipped: str = ""

    @property
    def names(self) -> dict[str, str]:
        """Names that the globs of an expected failure are matched with."""
        scheme, problem = (self.label, self.problem) if self.kind == "scheme" else ("", self.label)
        return {"check": self.check.name, "scheme": scheme, "problem": problem}

    def expectation(self, expected: Iterable[FailingCheck]) -> FailingCheck | None:
        """Return the first matching expected failure, or None."""
        return next((one for one in expected if one.matches(**self.names)), None)

    def answer(self, expected: Iterable[FailingCheck] = ()) -> Row:
        """Run the check, compare with expected failures, and return a row of `check_scheme`."""
        unasked = (Status.SKIPPED, self.skipped, 0.0)
        status, reason, seconds = unasked if self.skipped else run_check(self.check, self.subject)
        one = self.expectation(expected)
        if one and status is Status.FAILED:
            status, reason = Status.XFAILED, f"{one.reason}: {reason}"
        elif one and one.strict and status is Status.PASSED:
            status, reason = Status.XPASSED, f"it passes, but was expected to fail: {one.reason}"
        return {
            "subject": self.label,
            "kind": self.kind,
            "check": self.check.name,
            "category": self.check.category,
            "level": self.check.since,
            "problem": self.problem,
            "status": status.value,
            "reason": reason,
            "seconds": seconds,
        }

    def __call__(self, subject: object) -> None:  # noqa: ARG002 - a test reads better with its subject
        """Raise AssertionError with the reason if the check fails, or skip the test."""
        import pytest  # noqa: PLC0415 - the kit itself needs no pytest

        row = self.answer()
        if row["status"] == Status.SKIPPED:
            pytest.skip(visible(str(row["reason"])))
        if row["status"] == Status.FAILED:
            where = f"{self.label} on {self.problem}" if self.problem else self.label
            raise AssertionError(visible(f"{where} fails {self.check.name}: {row['reason']}"))

    def __repr__(self) -> str:
        return self.check.name


def scheme_questions(subject: SchemeSubject, problems: Problems | None, level: int | None) -> list[Question]:
    """Return all checks of a scheme with their subjects.

    Parameters
    ----------
    subject : SchemeSubject
    problems : str or sequence, optional
        As in `cells_of`.
    level : int, optional
        Newest level of the kit whose checks are made; by default the newest level.
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
    """Return all checks of a problem with their subjects; see `scheme_questions` for the parameters."""
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


def _answers(questions: list[Question], given: Iterable[Expected] | None) -> list[Row]:
    expected = _read(given, questions)
    return [question.answer(expected) for question in questions]


def _read(given: Iterable[Expected] | None, questions: Iterable[Question]) -> tuple[FailingCheck, ...]:
    expected = read_expected(given, FailingCheck)
    require_matches(expected, (question.names for question in questions), "check")
    return expected


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
    expected_failures: Iterable[Expected] | None = None,
) -> list[Row]:
    """Run every check of the kit on a scheme.

    Parameters
    ----------
    scheme : Scheme or str
        A scheme, registered or not, or the label of a registered one.
    problems : str or sequence of str, ProblemSpec or callable, optional
        Labels of registered problems, and problem functions. By default the three registered problems with the fewest
        components that the scheme accepts, excluding those on request and preferring the scheme's own form.
    level : int, optional
        Checks introduced by a later level of the kit are skipped; by default none.
    expected_failures : sequence of mapping, optional
        Mappings with a ``reason``, and globs ``check``, ``scheme`` and ``problem`` if they do not apply to all.

    Returns
    -------
    list of dict
        For each check, on each problem: subject, kind, check, category, level, problem, status (``passed``,
        ``failed``, ``skipped``, ``xfailed``, ``xpassed``), reason and seconds, in types that JSON can represent. A
        failed check does not raise.

    Raises
    ------
    UsageError
        If `scheme` is not a scheme, a problem is unknown or refused, or an expected failure matches no check.
    """
    registry = load_plugins()
    questions = scheme_questions(SchemeSubject(scheme_of(scheme, registry), registry), problems, level)
    return _answers(questions, expected_failures)


def check_problem(
    problem: str | ProblemSpec | Callable[..., Problem],
    *,
    level: int | None = None,
    expected_failures: Iterable[Expected] | None = None,
) -> list[Row]:
    """Run every check of the kit on a problem.

    Parameters
    ----------
    problem : callable, ProblemSpec or str
        Problem function (not called), or the label of a registered problem.
    level : int, optional
        Checks introduced by a later level of the kit are skipped; by default none.
    expected_failures : sequence of mapping, optional
        As in `check_scheme`.

    Returns
    -------
    list of dict
        As in `check_scheme`, with ``problem`` empty.

    Raises
    ------
    UsageError
        If `problem` is not a problem function, or an expected failure matches no check.
    """
    registry = load_plugins()
    questions = problem_questions(ProblemSubject(problem_of(problem, registry), registry), level)
    return _answers(questions, expected_failures)


if TYPE_CHECKING:
    import pytest

Subject = str | Scheme | ProblemSpec | Callable[..., Problem]


def parametrize_with_checks(
    subjects: Sequence[Subject],
    *,
    problems: Problems | None = None,
    level: int | None = None,
    expected_failures: Iterable[Expected] | None = None,
) -> "pytest.MarkDecorator":
    """Return a decorator for a test function of ``subject`` and ``check`` that makes a test of each check.

    ::

        @parametrize_with_checks([MyScheme(), my_problem])
        def test_conformance(subject, check):
            check(subject)

    Parameters
    ----------
    subjects : sequence of Scheme, callable, ProblemSpec or str
        Schemes and problem functions, and labels of registered ones.
    problems, level, expected_failures
        As in `check_scheme`. Expected failures become xfail marks: a check that passes nevertheless fails the test,
        unless ``strict`` is False.

    Returns
    -------
    pytest.MarkDecorator

    Raises
    ------
    UsageError
        As in `check_scheme`, or if there is no subject.
    """
    if isinstance(subjects, str | bytes) or not isinstance(subjects, Iterable):
        raise UsageError(f"subjects expects a list of schemes and problems, got {subjects!r:.200}")
    if not subjects:
        raise UsageError("subjects is empty; name the schemes and problems that are to be checked")
    import pytest  # noqa: PLC0415 - the kit itself needs no pytest

    asked = [(subject, question) for subject in subjects for question in _questions(subject, problems, level)]
    expected = _read(expected_failures, (question for _, question in asked))
    return pytest.mark.parametrize(("subject", "check"), [_parameters(*pair, expected) for pair in asked])


def _questions(subject: Any, problems: Problems | None, level: int | None) -> Iterator[Question]:
    registry = load_plugins()
    name = parse_label(subject).name if isinstance(subject, str) else ""
    if isinstance(subject, Scheme) or (name and name not in registry.problems):
        yield from scheme_questions(SchemeSubject(scheme_of(subject, registry), registry), problems, level)
    else:
        yield from problem_questions(ProblemSubject(problem_of(subject, registry), registry), level)


def _parameters(subject: Any, question: Question, expected: Iterable[FailingCheck]) -> Any:
    import pytest  # noqa: PLC0415

    one = question.expectation(expected)
    strict = bool(one and one.strict)
    marks = [pytest.mark.xfail(reason=visible(one.reason), raises=AssertionError, strict=strict)] if one else []
    where = f"{question.label}-{question.check.name}"
    name = f"{where}-on-{question.problem}" if question.problem else where
    return pytest.param(subject, question, id=visible(name), marks=marks)
