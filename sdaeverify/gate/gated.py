"""The result of a completed gate, from which all its reports are made."""

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

from ..contracts.finding import Status
from ..contracts.settings import Settings
from ..report.folders import Key
from ..report.plain import visible
from ..report.saved import SavedAttack
from .outcomes import ORDER, Outcome, is_red
from .policy import Policy

WORDS = {
    Status.PASSED: "verified",
    Status.FAILED: "refuted",
    Status.UNMEASURED: "not measured",
    Status.UNDECIDED: "undecided",
    Status.XFAILED: "failing as expected",
    Status.XPASSED: "unexpectedly verified",
}


# Status of a claim that is missing from one of two compared gates.
ABSENT = "not gated"


class StatusChange(NamedTuple):
    """A claim whose status differs from that of an earlier gate.

    Attributes
    ----------
    key : Key
        Scheme, problem, measure and quantity.
    before, now : str
        Status in words; `ABSENT` if the claim was or is not gated.
    """

    key: Key
    before: str
    now: str

    def __str__(self) -> str:
        return visible(f"{self.key}: {self.before} before, {self.now} now")


@dataclass(frozen=True)
class Gated:
    """Result of a gate.

    Attributes
    ----------
    outcomes : tuple of Outcome
    policy : Policy
    settings : Settings
    violations : tuple of str
        A line for each locked claim that is gone, weaker or no longer measured.
    hunted : tuple of str
        A line for each claim that a hunt refuted.
    attacks : tuple of SavedAttack
        Results of the hunt for each scheme, measure and form.
    code : int
        Exit code.
    words : str
        Meaning of the exit code.
    plugins : tuple of str
        Plugins that were named: paths of files, and texts of sources.
    unnamed : frozenset of str
        Labels of schemes and problems that no command can name.
    examined : mapping of str to list of str
        Words of the commands that reproduce results of examinations, by the name of the measure.
    warnings, notes : tuple of str
        Further lines for the report.
    changes : tuple of StatusChange or None
        Claims whose status changed since an earlier gate; None without an earlier gate.
    """

    outcomes: tuple[Outcome, ...]
    policy: Policy
    settings: Settings
    violations: tuple[str, ...] = ()
    hunted: tuple[str, ...] = ()
    attacks: tuple[SavedAttack, ...] = ()
    code: int = 0
    words: str = ""
    plugins: tuple[str, ...] = ()
    unnamed: frozenset[str] = frozenset()
    examined: Mapping[str, list[str]] = field(default_factory=dict)
    warnings: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()
    changes: tuple[StatusChange, ...] | None = None

    @property
    def counts(self) -> Counter[Status]:
        """Number of outcomes of each status."""
        return Counter(outcome.status for outcome in self.outcomes)

    @property
    def summary(self) -> str:
        """The counts in words, passed claims first."""
        counts = self.counts
        told = (Status.PASSED, *(status for status in ORDER if counts[status] and status is not Status.PASSED))
        parts = ", ".join(f"{counts[status] or 'none'} {WORDS[status]}" for status in told)
        return f"{len(self.outcomes)} claimed {'quantity' if len(self.outcomes) == 1 else 'quantities'}: {parts}"

    @property
    def not_passed(self) -> list[Outcome]:
        """Outcomes with another status than passed, worst first."""
        return [o for status in ORDER if status is not Status.PASSED for o in self.outcomes if o.status is status]

    @property
    def budget(self) -> str:
        """The tier with its sample size, step sizes, seed and level, in words."""
        s = self.settings
        steps = f"{s.steps[0]}..{s.steps[-1]} steps"
        return f"tier {self.policy.tier}: up to {s.paths} paths, {steps}, seed {s.seed}, alpha {self.policy.alpha:g}"

    def is_red(self, outcome: Outcome) -> bool:
        """Return whether an outcome fails the gate."""
        return is_red(outcome, self.policy)
