"""The contract of a measure: what it notes while a scheme runs, and how it judges what was noted."""

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

# What of a measure decides what is asked, makes findings of evidence, or words them: evidence does not depend on it.
JUDGING = frozenset({"refuses", "judge", "judge_member", "detail_columns", "level_columns", "value_of"})


class Snapshot(NamedTuple):
    """What is known at the end of a coarsest step.

    Attributes
    ----------
    levels : sequence of mapping
        Named components of the scheme's state at each level, coarsest first.
    truth : mapping
        The same of the truth; of the finest level where no measure of the scheme asks for the truth.
    coarser_truth : mapping or None
        The same of the truth at half its resolution, where it has an error of its own.
    """

    levels: Sequence[Parts]
    truth: Parts
    coarser_truth: Parts | None


class Observer(Protocol):
    """A measure's notebook for one scheme on one block of paths."""

    @property
    def wanted(self) -> Sequence[Container[int]]:
        """Steps of each level after which `after_step` is called."""

    def after_step(self, level: int, step: int, parts: Parts) -> None:
        """Note the named components after a wanted step.

        Parameters
        ----------
        level : int
            0 for the coarsest step size; each further one halves it.
        step : int
            How many steps were made, this one included.
        parts : mapping of str to ndarray, shape (k, P)
            The components of the new state.
        """

    def after_coarsest_step(self, snapshot: Snapshot) -> None:
        """Note the named components of all levels and of the truth."""

    def tally(self) -> Tally:
        """Return what was noted."""


@dataclass(frozen=True)
class Evidence:
    """What a measurement of one cell produced.

    Attributes
    ----------
    scheme : Scheme
    problem : Problem
        As registered, with its truths.
    view : Problem
        As the scheme saw it; its traits decide which claims apply.
    settings : Settings
    tally : Tally
    health : Tally
        Sums ``failed``, ``lost``, ``truncated`` and ``steps`` of each level.
    level : float
        Significance level of one one-sided test, all corrections for looks and for further tests made.
    claims : tuple of Claim, optional
        That are judged; those of the scheme if left out.
    probed : Tally, optional
        The part of `tally` that further paths leave as it is; all of it if left out.
    sampled : Tally, optional
        The part of `tally` that is of paths; all of it if left out.
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
        """Return evidence on a problem without truths, found without paths.

        Parameters
        ----------
        scheme : Scheme
        view : Problem
            In the scheme's form.
        tally : Tally, optional
            What was found; nothing if left out.
        """
        return cls(scheme, view, view, Settings(), Tally() if tally is None else tally, Tally())

    @property
    def along_paths(self) -> Tally:
        """What paths tell: judged alone, or beside what is found without them, it is read once."""
        return self.tally if self.sampled is None else self.sampled

    @property
    def without_paths(self) -> Tally:
        """What further paths leave as it is."""
        return self.tally if self.probed is None else self.probed

    @property
    def promises(self) -> tuple[Claim, ...]:
        """The claims that are judged."""
        return self.scheme.promises if self.claims is None else self.claims

    @property
    def paths(self) -> int:
        """Number of paths, which every observer notes by groups under ``paths``; 0 if none was sampled."""
        return int(np.sum(self.tally.sums.get("paths", 0)))

    @property
    def step_sizes(self) -> list[float]:
        """Step size h of each level, coarsest first, in the problem's unit of time."""
        return [self.problem.horizon / n for n in self.settings.steps]


class Measure:
    """Base of all measures: a subclass sets `name` and overrides what it needs; it must be picklable.

    A measure that samples returns an observer; one that evaluates the one-step map overrides `probe`; one may do
    both. Evidence is a `Tally`, so that blocks, machines and runs can be merged before they are judged.
    """

    name: ClassVar[str]
    # Whether `probe` looks at the budget: the number of paths, looks, confidence, family. Paths that are added later
    # leave the evidence of a measure that does not as it is.
    budgeted: ClassVar[bool] = False
    # Whether a cell takes seconds even where hardly any paths are wanted: the gate's smallest tier leaves it out.
    lengthy: ClassVar[bool] = False
    # What a claim about it says that short steps follow: the ``paths`` of the equation, their ``law``, or, in a long
    # run, the ``stationary law``; empty for nothing.
    follows: ClassVar[str] = ""
    # Whether its quantities are of a whole run: then single steps, compared with the equation along one, tell how
    # small an error would have shown; that is part of its evidence.
    resolved_by_steps: ClassVar[bool] = False
    # Whose solution its observer looks at as the truth: that of the ``problem``, and where it has none that of the
    # ``scheme`` with shorter steps, which costs four times the rest; neither is computed where nobody looks at it.
    truths: ClassVar[frozenset[str]] = frozenset({"problem", "scheme"})
    # What the estimate of a finding is, where it is no order.
    value_of: ClassVar[str] = ""
    # What the details of findings and of levels mean, by name.
    detail_columns: ClassVar[Mapping[str, str]] = {}
    level_columns: ClassVar[Mapping[str, str]] = {}

    def refuses(self, scheme: Scheme, problem: Problem) -> str:  # noqa: ARG002 - most measures refuse nothing
        """Return why the question makes no sense for this pair, or an empty string."""
        return ""

    def observer(self, problem: Problem, parts: Parts, settings: Settings) -> Observer | None:  # noqa: ARG002
        """Return the notebook for one block, given the initial components; None to sample nothing.

        Parameters
        ----------
        problem : Problem
        parts : mapping of str to ndarray, shape (k, P)
            The components of the initial state.
        settings : Settings
        """
        return None

    def probe(self, scheme: Scheme, view: Any, settings: Settings) -> Tally:  # noqa: ARG002
        """Evaluate the one-step map and return evidence without sampling error; run once a cell.

        Parameters
        ----------
        scheme : Scheme
        view : Problem
            In the form that the scheme solves.
        settings : Settings
            Of the whole run; those of the paths that are observed and judged may be its `guards`.
        """
        return Tally()

    def judge(self, evidence: Evidence) -> Judgement:
        """Turn evidence into rows; a pure function."""
        raise NotImplementedError

    def judge_member(self, scheme: Scheme, view: Any) -> Iterable[Finding]:  # noqa: ARG002
        """Return the findings of one step on a random member of a form; nothing is sampled.

        The coefficients of a member are smooth and of size 1, and nothing is known of its solution. A measure that
        has no answer without sampling returns nothing.

        Parameters
        ----------
        scheme : Scheme
        view : Problem
            The member, in the form that the scheme solves.
        """
        return ()


class Followed(NamedTuple):
    """Names of the measures whose claims say that short steps follow an equation.

    Attributes
    ----------
    paths, law : frozenset of str
        Those about its ``paths``, and those about their ``law``.
    """

    paths: frozenset[str] = frozenset()
    law: frozenset[str] = frozenset()

    @classmethod
    def by(cls, measures: Iterable[Measure]) -> "Followed":
        """Return the names that are among those of some measures."""
        known = {measure.name: measure.follows for measure in measures}
        return cls(*(frozenset(name for name in known if known[name] == what) for what in cls._fields))


NONE_FOLLOW = Followed()
# What a claim about an invariant law says that a long run follows.
STATIONARY = "stationary law"


def rests_on_moments(claim: Claim, measure: Measure) -> bool:
    """Return whether a claim cannot hold where moments of a run tend to infinity, or rare paths of it do.

    Parameters
    ----------
    claim : Claim
    measure : Measure
        That the claim is about.
    """
    return bool(measure.follows) and (claim.sense == IN_MEAN_SQUARE or measure.follows == STATIONARY)
