"""Claims as tests: each claimed cell is a test, and all cells of a problem run together at the first request.

Noise and reference are thus simulated once per problem. The error level is shared among all tests of the session,
whether they are selected or not, so that the outcome of a cell depends neither on the selection nor on the worker
that runs it. The lock file is only compared by ``sdaeverify gate``.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, ClassVar

from msgspec import structs

from ..contracts.finding import Status
from ..contracts.measure import Measure
from ..contracts.scheme import Scheme
from ..contracts.settings import Settings, whole
from ..contracts.specs import ProblemSpec
from ..errors import UsageError
from ..forms import Problem
from ..gate.expected import FailingClaim, read_expected, require_matches
from ..gate.gate_plan import gate_plan
from ..gate.outcomes import ORDER, Outcome, is_red, outcomes
from ..gate.policy import Policy
from ..gate.words import command_of, message
from ..registry.load import Registry, load_registry
from ..report.folders import key_in
from ..report.plain import visible
from ..report.tables.command import examination_command
from ..study import Cell, CellResult, Plan, Study
from ..study.class_tests import class_cells, results_of_class
from ..study.examination import Work, begin_all
from .subjects import load_plugins

if TYPE_CHECKING:
    import pytest

Expected = FailingClaim | Mapping[str, Any]

# Assumed number of tests of a cell: its findings times the one-sided tests of each.
TESTS_OF_A_CELL = 10


class ClaimError(AssertionError):
    """A claim does not hold, could not be measured, or holds although it was expected to fail."""


@dataclass
class ClaimRun:
    """The claimed cells of a policy; each problem is run once, when one of its cells is requested.

    Attributes
    ----------
    plan : Plan
    policy : Policy
    registry : Registry
    """

    plan: Plan
    policy: Policy
    registry: Registry
    _known: dict[str, list[CellResult]] = field(default_factory=dict)

    @property
    def settings(self) -> Settings:
        """Settings of the tier, with the error level shared among all possible tests."""
        settings = self.policy.settings
        return replace(settings, tests_reserved=max(settings.tests_reserved, TESTS_OF_A_CELL * len(self.plan.cells)))

    @property
    def cells(self) -> list[Cell]:
        """Claimed cells, followed by those about classes of equations."""
        return [
            *self.plan.cells,
            *(class_cells(self.plan.cells, self.settings.seed) if self.policy.asks_classes else ()),
        ]

    def outcomes(self, cell: Cell) -> list[Outcome]:
        """Return the outcomes of a cell, worst first."""
        results = self._results(cell) if cell.class_name is None else results_of_class(cell, self.settings.seed)
        return sorted(outcomes(results, self.policy), key=lambda outcome: ORDER.index(outcome.status))

    def _results(self, cell: Cell) -> list[CellResult]:
        label = cell.spec.label
        if label not in self._known:
            (made,) = (problem for problem in self.plan.problems if problem.spec.label == label)
            # Not the results of the study, which are corrected for a whole run; these hold for each cell separately.
            events = Study(Plan((made,)), self.settings).run()
            self._known[label] = [result for event in events for result in event.results]
        return [result for result in self._known[label] if result.cell == cell]

    def words(self, outcome: Outcome) -> str:
        """Return an outcome in words, with the command that reproduces it if its names are registered."""
        cell = outcome.cell
        named = self.registry.names(cell.scheme) and (cell.class_name is not None or self.registry.names(cell.spec))
        command = command_of(outcome, self.settings) if named else ""
        return message(outcome, self.settings, command)


@dataclass(frozen=True)
class ClaimCheck:
    """Check of one claimed cell, as a parameter of a test."""

    sdaeverify_part: ClassVar[str] = "claims"

    run: ClaimRun
    cell: Cell

    def __call__(self, subject: object) -> None:  # noqa: ARG002 - a test reads better with its subject
        """Raise the error of the cell; return if all its claims are verified.

        Raises
        ------
        ClaimError
            If a claim is refuted, could not be measured, is undecided and the policy fails undecided claims, or is
            verified although it was expected to fail.
        pytest.skip.Exception, pytest.xfail.Exception
            If a claim is undecided, or fails as expected.
        """
        __tracebackhide__ = True
        found = self.run.outcomes(self.cell)
        if red := [outcome for outcome in found if is_red(outcome, self.run.policy)]:
            raise ClaimError("\n".join(map(self.run.words, red)))
        _skip_or_xfail(found)

    def __repr__(self) -> str:
        return visible(f"{self.cell.measure.name} on {self.cell.spec.label}")


@dataclass(frozen=True)
class ExaminationCheck:
    """An examination, as a parameter of a test.

    Attributes
    ----------
    work : Work
    policy : Policy
        With what is expected to fail.
    """

    sdaeverify_part: ClassVar[str] = "examinations"

    work: Work
    policy: Policy

    def __call__(self, subject: object) -> None:  # noqa: ARG002 - a test reads better with its subject
        """Make the examination and raise an exception with its outcome; return if all claims are verified.

        Raises
        ------
        ClaimError
            If one is refuted, could not be measured, or is verified although it was expected to fail.
        pytest.skip.Exception, pytest.xfail.Exception
            If one is undecided, or fails as expected.
        """
        __tracebackhide__ = True
        for _ in self.work.run():
            pass
        found = sorted(outcomes(self.work.results, self.policy), key=lambda each: ORDER.index(each.status))
        if red := [outcome for outcome in found if is_red(outcome, self.policy)]:
            raise ClaimError("\n".join(map(self._words, red)))
        _skip_or_xfail(found)

    def __repr__(self) -> str:
        return "examination"

    def _words(self, outcome: Outcome) -> str:
        return message(outcome, self.policy.settings, examination_command(outcome.key[:3], self.work.command))


def claim_run(registry: Registry, policy: Policy) -> ClaimRun:
    """Plan the claimed cells of a policy.

    Raises
    ------
    UsageError
        If a name is unknown or a pattern matches nothing.
    """
    return ClaimRun(gate_plan(registry, policy), policy, registry)


def parametrize_with_claims(
    schemes: Sequence[str | Scheme],
    *,
    problems: Sequence[str | ProblemSpec | Callable[..., Problem]] = (),
    measures: Sequence[str | Measure] = (),
    tier: str = "ci",
    seed: int | None = None,
    expected_failures: Iterable[Expected] | None = None,
) -> "pytest.MarkDecorator":
    """Return a decorator for a test function of ``subject`` and ``check`` that makes a test of each claimed cell.

    Claims of orders are also tested by order conditions of classes of equations and by random members of forms.

    ::

        @parametrize_with_claims([MyScheme()], problems=["gbm"])
        def test_claims(subject, check):
            check(subject)

    Parameters
    ----------
    schemes : sequence of Scheme or str
        Schemes, and patterns of registered schemes.
    problems : sequence of str, ProblemSpec or callable, optional
        Patterns, specifications and problem functions; by default those that the tier covers.
    measures : sequence of str or Measure, optional
        Patterns and measures; by default those with a claim.
    tier : str, optional
        Budget: ``ci``, ``smoke`` (each claim on one problem alone) or ``nightly``.
    seed : int, optional
        Seed of all noise.
    expected_failures : sequence of mapping, optional
        Mappings with a ``reason``, and globs ``scheme``, ``problem``, ``measure`` and ``quantity`` if they do not
        apply to all. A matching finding is an expected failure of its test; if it is verified nevertheless, the test
        fails, unless ``strict`` is False.

    Returns
    -------
    pytest.MarkDecorator

    Raises
    ------
    UsageError
        If a name is unknown, there is no claim, the seed is not an integer, or an expected failure is malformed or
        matches no cell.
    """
    import pytest  # noqa: PLC0415 - the kit itself needs no pytest

    if not schemes:
        raise UsageError("schemes is empty; name the schemes whose claims are to be tested")
    expected = read_expected(expected_failures, FailingClaim)
    policy = Policy(
        schemes=_sequence(schemes), problems=_sequence(problems), measures=_sequence(measures), tier=tier,
        seed=Settings().seed if seed is None else whole("seed", seed), expected_failures=expected,
    )  # fmt: skip
    run = claim_run(load_plugins(), policy)
    _require_cells(run.cells, expected)
    return pytest.mark.parametrize(("subject", "check"), [_parameters(run, cell) for cell in run.cells])


def parametrize_with_examinations(
    tables: Mapping[str, Mapping[str, Any]],
    *,
    tier: str = "ci",
    seed: int | None = None,
    expected_failures: Iterable[Expected] | None = None,
) -> "pytest.MarkDecorator":
    """Return a decorator of a test function of ``subject`` and ``check`` that makes a test of each examination.

    ::

        @parametrize_with_examinations({"adaptive": {"solvers": ["my-heun"]}})
        def test_solvers(subject, check):
            check(subject)

    Parameters
    ----------
    tables : mapping of str to mapping
        By name of the examination, its table as in ``[tool.sdaeverify.examinations]`` of a policy.
    tier, seed, expected_failures : optional
        As of `parametrize_with_claims`.

    Returns
    -------
    pytest.MarkDecorator

    Raises
    ------
    UsageError
        If no examination is named, a name is unknown, or its table in the policy has an unknown key.
    """
    import pytest  # noqa: PLC0415 - the kit itself needs no pytest

    if not tables:
        raise UsageError("tables is empty; name the examinations that are to be made")
    policy = Policy(
        tier=tier,
        seed=Settings().seed if seed is None else whole("seed", seed),
        expected_failures=read_expected(expected_failures, FailingClaim),
        examinations={name: dict(table) for name, table in tables.items()},
    )
    # Examinations belong to plugins that only some commands load, as the gate does.
    works = begin_all(load_registry(lab=True), policy.examinations, policy.settings)
    cases = [
        pytest.param(name, ExaminationCheck(work, policy), id=visible(name))
        for name, work in zip(tables, works, strict=True)
    ]
    return pytest.mark.parametrize(("subject", "check"), cases)


def describe_undecided(found: Sequence[Outcome]) -> str:
    """Return the undecided claims of a cell with their reasons, in one line."""
    open_ones = [outcome for outcome in found if outcome.status is Status.UNDECIDED]
    return "; ".join(
        f"undecided: {visible(str(each.key))}: {visible(str(each.finding.reason))}" for each in open_ones
    )


def _skip_or_xfail(found: Sequence[Outcome]) -> None:
    import pytest  # noqa: PLC0415

    if not found:
        raise pytest.skip.Exception("none of its claims applies to these problems", _use_item_location=True)
    if found[0].status is Status.UNDECIDED:
        raise pytest.skip.Exception(describe_undecided(found), _use_item_location=True)
    if found[0].status is Status.XFAILED:
        raise pytest.xfail.Exception(visible("; ".join(dict.fromkeys(o.expected for o in found if o.expected))))


def _parameters(run: ClaimRun, cell: Cell) -> Any:
    import pytest  # noqa: PLC0415

    name = f"{cell.spec.label}-{cell.scheme.label}-{cell.measure.name}"
    return pytest.param(cell.scheme, ClaimCheck(run, cell), id=visible(name), marks=())


def _sequence(given: Any) -> tuple[Any, ...]:
    return (given,) if isinstance(given, str) or not isinstance(given, Iterable) else tuple(given)


def _require_cells(claimed: Sequence[Cell], expected: Iterable[FailingClaim]) -> None:
    if not claimed:
        raise UsageError("the schemes have no claims about the measures on the problems")
    cells = [key_in(cell, "")._asdict() for cell in claimed]
    require_matches((structs.replace(one, quantity="*") for one in expected), cells, "claimed cell")
