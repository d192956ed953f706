"""`parametrize_with_checks`: the kit as parameters of a test, one for each check."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from ..contracts.labels import parse_label
from ..contracts.scheme import Scheme
from ..contracts.specs import ProblemSpec
from ..errors import UsageError
from ..forms import Problem
from ..report.plain import visible
from .check import CheckStatus
from .expected import Expected, expected_reason, require_known
from .problem_subject import ProblemSubject
from .questions import Question, problem_questions, scheme_questions
from .subjects import Problems, SchemeSubject, installed, problem_of, scheme_of

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
    registry = installed()
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
