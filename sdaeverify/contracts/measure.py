"""The contract of a measure: its observations during a simulation, and the judgement of the evidence."""

from collections.abc import Container, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple, Protocol

import numpy as np

from ..arrays import Parts
from ..forms import Problem
from .claimed import IN_MEAN_SQUARE
from .finding import Finding, Judgement
from .scheme import Claim, Scheme
from .settings import Settings
from .tally import Tally

# Members of a measure that select questions, turn evidence into findings or word them. The evidence itself does not
# depend on them.
JUDGING = frozenset(
    {
        "refuses",
        "judge",
        "judge_member",
        "judge_step",
        "detail_columns",
        "level_columns",
        "value_of",
        "step_tolerance",
    }
)


class Snapshot(NamedTuple):
    """States of all levels and of the truth at the end of a coarsest step.

    Attributes
    ----------
    levels : sequence of mapping
        Named components of the scheme's state at each level, coarsest first.
    truth : mapping
        Named components of the truth; of the finest level if no measure of the scheme requests the truth.
    coarser_truth : mapping or None
        Named components of the truth at half its resolution, where the truth has a discretisation error.
    """

    levels: Sequence[Parts]
    truth: Parts
    coarser_truth: Parts | None


class Observer(Protocol):
    """Accumulates the observations of a measure for one scheme on one block of paths."""

    @property
    def wanted(self) -> Sequence[Container[int]]:
        """Steps of each level after which `after_step` is called."""

    def after_step(self, level: int, step: int, parts: Parts) -> None:
        """Record the named components after a wanted step.

        Parameters
        ----------
        level : int
            0 for the coarsest step size; each further level halves it.
        step : int
            Number of steps made so far, including this one.
        parts : mapping of str to ndarray, shape (k, P)
            The components of the new state.
        """

    def after_coarsest_step(self, snapshot: Snapshot) -> None:
        """Record the named components of all levels and of the truth."""

    def tally(self) -> Tally:
        """Return the accumulated evidence."""


@dataclass(frozen=True)
class Evidence:
    """Evidence from the measurement of one cell.

    Attributes
    ----------
    scheme : Scheme
    problem : Problem
        As registered, with its truths.
    view : Problem
        The problem in the form that the scheme solves; its traits decide which claims apply.
    settings : Settings
    tally : Tally
    health : Tally
        Sums ``failed``, ``lost``, ``truncated`` and ``steps`` of each level.
    level : float
        Significance level of one one-sided test, corrected for repeated looks and for the other tests.
    claims : tuple of Claim, optional
        Claims to judge; those of the scheme if omitted.
    probed : Tally, optional
        Part of `tally` that does not depend on the number of paths; all of it if omitted.
    sampled : Tally, optional
        Part of `tally` that comes from paths; all of it if omitted.
    """

    scheme: Scheme
    problem: Problem
    view: Problem
    settings: Settings
    tally: Tally
    health: Tally
    level: float = 0.005
    claims: tuple[Claim, ...] | None = None
    probed: Tally | None = None
    sampled: Tally | None = None

    @classmethod
    def of_one_step(cls, scheme: Scheme, view: Problem, tally: Tally | None = None) -> "Evidence":
        """Return evidence on a problem without truths, obtained without paths.

        Parameters
        ----------
        scheme : Scheme
        view : Problem
            In the scheme's form.
        tally : Tally, optional
            The evidence; empty if omitted.
        """
        return cls(scheme, view, view, Settings(), Tally() if tally is None else tally, Tally())

    @property
    def along_paths(self) -> Tally:
        """Evidence from paths; always the same tally object, so that its cached readings are shared."""
        return self.tally if self.sampled is None else self.sampled

    @property
    def without_paths(self) -> Tally:
        """Evidence that does not depend on the number of paths."""
        return self.tally if self.probed is None else self.probed

    @property
    def promises(self) -> tuple[Claim, ...]:
        """Claims to judge."""
        return self.scheme.promises if self.claims is None else self.claims

    @property
    def paths(self) -> int:
        """Number of paths, which every observer counts by groups under ``paths``; 0 if none was sampled."""
        return int(np.sum(self.tally.sums.get("paths", 0)))

    @property
    def step_sizes(self) -> list[float]:
        """Step size h of each level, coarsest first, in the problem's unit of time."""
        return [self.problem.horizon / n for n in self.settings.steps]


class Measure:
    """Base of all measures: a subclass sets `name` and overrides methods as needed; it must be picklable.

    A measure that samples returns an observer; a measure that evaluates the one-step map overrides `probe`; a measure
    may do both. Evidence is a `Tally`, so that blocks, machines and runs can be merged before they are judged.
    """

    name: ClassVar[str]
    # Whether `probe` depends on the budget (number of paths, looks, confidence, family). If it does not, its evidence
    # stays valid when paths are added later.
    budgeted: ClassVar[bool] = False
    # Whether a cell takes seconds even with few paths: the smallest tier of the gate omits it.
    lengthy: ClassVar[bool] = False
    # What a claim about this measure implies that short steps follow: the ``paths`` of the equation, their ``law``,
    # or, in a long run, the ``stationary law``; empty if the claim implies neither.
    follows: ClassVar[str] = ""
    # Whether its quantities belong to a whole run. Single steps along the run are then compared with the equation to
    # determine the smallest error that would have been detected; this is part of the evidence.
    resolved_by_steps: ClassVar[bool] = False
    # Solutions that its observer uses as the truth: that of the ``problem`` and, if the problem has none, that of the
    # ``scheme`` with shorter steps, which costs four times the rest. Neither is computed if no observer uses it.
    truths: ClassVar[frozenset[str]] = frozenset({"problem", "scheme"})
    # Meaning of the estimate of a finding, where it is not an order.
    value_of: ClassVar[str] = ""
    # Smallest defect of an order below its claim that `judge_step` detects.
    step_tolerance: ClassVar[float] = float("nan")
    # Meaning of the details of findings and of levels, by name.
    detail_columns: ClassVar[Mapping[str, str]] = {}
    level_columns: ClassVar[Mapping[str, str]] = {}

    def refuses(self, scheme: Scheme, problem: Problem) -> str:  # noqa: ARG002 - most measures refuse nothing
        """Return why the measure does not apply to this pair, or an empty string."""
        return ""

    def observer(self, problem: Problem, parts: Parts, settings: Settings) -> Observer | None:  # noqa: ARG002
        """Return the observer of one block, given the initial components; None to sample no paths.

        Parameters
        ----------
        problem : Problem
        parts : mapping of str to ndarray, shape (k, P)
            The components of the initial state.
        settings : Settings
        """
        return None

    def probe(self, scheme: Scheme, view: Any, settings: Settings) -> Tally:  # noqa: ARG002
        """Evaluate the one-step map and return evidence without sampling error; called once per cell.

        Parameters
        ----------
        scheme : Scheme
        view : Problem
            In the form that the scheme solves.
        settings : Settings
            Of the whole run; the paths that are observed and judged may use its `guards`.
        """
        return Tally()

    def judge(self, evidence: Evidence) -> Judgement:
        """Turn evidence into rows; a pure function."""
        raise NotImplementedError

    def judge_member(self, scheme: Scheme, view: Any) -> Iterable[Finding]:  # noqa: ARG002
        """Return the findings of one step on a random member of a form, without sampling.

        The coefficients of a member are smooth and of size 1; its solution is unknown. A measure that
        needs sampling returns an empty iterable.

        Parameters
        ----------
        scheme : Scheme
        view : Problem
            The member, in the form that the scheme solves.
        """
        return ()

    def judge_step(self, scheme: Scheme, problem: Any, view: Any) -> Iterable[Finding]:  # noqa: ARG002
        """Return the findings of one step on the claims about a problem, without sampling; none if paths are needed.

        Parameters
        ----------
        scheme : Scheme
        problem : Problem
            As registered or drawn.
        view : Problem
            In the form that the scheme solves.
        """
        return ()


def followed_by(measures: Iterable[Measure]) -> dict[str, str]:
    """Return `Measure.follows` of each measure whose claims imply that steps follow an equation, by name."""
    return {measure.name: measure.follows for measure in measures if measure.follows}


# Values of `Measure.follows` for claims about paths, and about their law.
ALONG_PATHS, IN_LAW = "paths", "law"
# The same for claims about an invariant law.
STATIONARY = "stationary law"


def rests_on_moments(claim: Claim, measure: Measure) -> bool:
    """Return whether a claim fails if moments of a run, or of its rare paths, tend to infinity.

    Parameters
    ----------
    claim : Claim
    measure : Measure
        The measure that the claim is about.
    """
    return bool(measure.follows) and (claim.sense == IN_MEAN_SQUARE or measure.follows == STATIONARY)
