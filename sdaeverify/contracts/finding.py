"""Results of judging a claim: opinions (a verdict with its reason), and the rows of a cell."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from enum import StrEnum
from functools import reduce
from itertools import takewhile
from math import nan
from typing import NamedTuple

from ..errors import UsageError
from .scheme import Claim


class Verdict(StrEnum):
    """Verdict on a claim, or the reason why there is none."""

    VERIFIED = "verified"
    REFUTED = "refuted"
    INCONCLUSIVE = "inconclusive"
    DIVERGED = "diverged"
    ERROR = "error"
    NOT_RUN = "not_run"
    OUT_OF_SCOPE = "out_of_scope"
    NOT_APPLICABLE = "not_applicable"

    @property
    def unmeasured(self) -> bool:
        """Whether it means that the quantity was not measured."""
        return self in UNMEASURED


class Status(StrEnum):
    """Status of a finding in a gate, or of a check in a test, given the expected failures."""

    PASSED = "passed"
    FAILED = "failed"
    SKIPPED = "skipped"
    UNMEASURED = "unmeasured"
    UNDECIDED = "undecided"
    XFAILED = "xfailed"
    XPASSED = "xpassed"


# Verdicts that mean the quantity was not measured.
UNMEASURED = frozenset({Verdict.ERROR, Verdict.DIVERGED, Verdict.NOT_RUN})


class Kind(StrEnum):
    """Kind of a reason, for reasons that a rule depends on or that are counted."""

    PLAIN = ""
    NO_CLAIM = "no claim"
    UNKNOWN_VALUE = "unknown value of a claim"
    ORDER = "order"
    WRONG_LIMIT = "wrong limit"
    LIMIT = "limit not confirmed"
    INCONSISTENT = "one step does not follow the equation"
    LOST_INDEX = "the problem loses its root"
    MORE_PATHS = "paths that would decide"
    TRUTH = "a truth that would decide"
    LOWER_ORDER = "a lower order is not excluded"
    GUARD = "paths do not guard what one step says"
    FINER = "finer levels would tell"
    NOT_SMOOTH = "the observable is not smooth"


@dataclass(frozen=True)
class Reason:
    """Reason for a verdict, made of one or several parts; the text is formatted when it is read.

    Attributes
    ----------
    text : str
        Format string for `str.format` if there are numbers, the literal text otherwise.
    kind : str
        A `Kind`, or a word defined by a measure.
    numbers : mapping of str to object
        Arguments of the format string.
    joint : str
        Separator between the preceding part and this one.
    rest : tuple of Reason
        Further parts, each with an empty `rest`.
    """

    text: str = ""
    kind: str = Kind.PLAIN
    numbers: Mapping[str, object] = field(default_factory=dict)
    joint: str = "; "
    rest: "tuple[Reason, ...]" = ()

    @classmethod
    def of(cls, *reasons: "Reason | str") -> "Reason":
        """Join several reasons into one; empty reasons are skipped."""
        return reduce(cls.then, reasons, cls())

    @property
    def parts(self) -> "tuple[Reason, ...]":
        """The parts as separate reasons with an empty `rest`."""
        return (replace(self, rest=()), *self.rest) if self.rest else (self,)

    def then(self, other: "Reason | str", joint: str = "; ") -> "Reason":
        """Return this reason followed by another one; an empty one leaves it unchanged."""
        if not other:
            return self
        added = Reason(other) if isinstance(other, str) else other
        if not self:
            return added
        first, *further = added.parts
        joined = first if first.joint == joint else replace(first, joint=joint)
        return Reason(self.text, self.kind, self.numbers, self.joint, (*self.rest, joined, *further))

    @property
    def kinds(self) -> tuple[str, ...]:
        """Distinct kinds of the parts, in order; parts without a kind are skipped."""
        return tuple(dict.fromkeys(str(part.kind) for part in self.parts if part.kind))

    @property
    def paths(self) -> float:
        """Number of paths that would decide, the largest over the parts; 0 if no part states one."""
        said = (part.numbers.get("paths", 0) for part in self.parts if part.kind == Kind.MORE_PATHS)
        return max(map(float, map(str, said)), default=0.0)

    def without(self, kind: str) -> "Reason":
        """Return the reason without the parts of the given kind."""
        return Reason.of(*(part for part in self.parts if part.kind != kind))

    def has(self, kind: str) -> bool:
        """Return whether any part has the given kind."""
        return any(part.kind == kind for part in self.parts)

    def includes(self, other: "Reason") -> bool:
        """Return whether a single-part reason is among the parts, ignoring separators."""
        return any(replace(part, joint=other.joint) == other for part in self.parts)

    def before(self, kind: str) -> "Reason":
        """Return the parts that precede the first one of the given kind; all parts if there is none."""
        first, *further = [*takewhile(lambda part: part.kind != kind, self.parts)] or [Reason()]
        return replace(first, rest=tuple(further))

    @property
    def sentence(self) -> str:
        """The text as a sentence, with a capital letter (if the first word is not a symbol) and a full stop."""
        text = str(self)
        first = text.split(" ", 1)[0].rstrip(",:").replace("-", "")
        # A single letter is the name of a component, except for the article.
        if first.isalpha() and first.islower() and (len(first) > 1 or first == "a"):
            text = text[0].upper() + text[1:]
        return text if not text or text.endswith((".", "?", "!")) else f"{text}."

    @property
    def standard_errors(self) -> float:
        """Smallest size over the parts of an insignificant effect in standard errors; NaN if no part states one."""
        said = (part.numbers["standard_errors"] for part in self.parts if "standard_errors" in part.numbers)
        return min(map(float, map(str, said)), default=nan)

    def __bool__(self) -> bool:
        return bool(self.text)

    def __str__(self) -> str:
        return self._words() + "".join(part.joint + part._words() for part in self.rest)

    def _words(self) -> str:
        return self.text.format(**self.numbers) if self.numbers else self.text


class Opinion(NamedTuple):
    """Verdict on a claim with its reason and statistics.

    Attributes
    ----------
    verdict : Verdict
    reason : Reason
    tier : int
        Tier of the method: 0 contract, 1 local, 2 deterministic and global, 3 sampled.
    settled : bool
        Whether sampling may stop: more paths could not change the verdict, or are not needed.
    p_verified, p_refuted : float
        p-values of the hypotheses that the claim fails and that it holds, which the two verdicts reject; NaN where
        no sampling error is involved. They enter the family-wise correction of a run.
    excluded : frozenset of Verdict
        Verdicts that the observations rule out. No p-value and no correction of one overrides this. An inconclusive
        opinion that excludes *verified* is evidence against the claim; any other inconclusive opinion is neutral.
    """

    verdict: Verdict
    reason: Reason = Reason()
    tier: int = 3
    settled: bool = True
    p_verified: float = nan
    p_refuted: float = nan
    excluded: frozenset[Verdict] = frozenset()

    @property
    def speaks_against(self) -> bool:
        """Whether the observations are evidence against the claim, decided or not."""
        return self.verdict is Verdict.REFUTED or Verdict.VERIFIED in self.excluded

    @property
    def final(self) -> bool:
        """Whether both *verified* and *refuted* are excluded, so that no other evidence can decide."""
        return self.excluded >= {Verdict.VERIFIED, Verdict.REFUTED}

    def plus(self, *remarks: Reason | str) -> "Opinion":
        """Return the opinion with remarks appended to its reason; empty remarks are skipped."""
        further = Reason.of(*remarks)
        return self._replace(reason=self.reason.then(further)) if further else self


# Tiers of methods: the contract of a step, one step, all steps at once, sampled paths. The order conditions of a
# class of equations have a tier outside this ranking because they override none of the others.
CONTRACT, ONE_STEP, AT_ONCE, SAMPLED = 0, 1, 2, 3
CONDITIONS = -1


def tier_name(tier: int) -> str:
    """Return the display name of a tier, such as ``T1``; ``TA`` for order conditions."""
    return "TA" if tier == CONDITIONS else f"T{tier}"


class Method(NamedTuple):
    """Method by which a quantity was measured.

    Attributes
    ----------
    what : str
        Subject of the measurement: ``local order``, ``paths``.
    tier : int or None
        Tier of the method: 0 contract, 1 local, 2 deterministic and global, 3 sampled; None if undecided.
    guard : str
        Observation that would have shown an error of the tier.
    reference : str
        Solution used as the truth along paths.
    """

    what: str
    tier: int | None = None
    guard: str = ""
    reference: str = ""

    @property
    def guarded_by(self) -> str:
        """The guard with its reference; empty if there is no guard."""
        return _joined(self.guard, self.reference) if self.guard else ""

    def __str__(self) -> str:
        tier = "" if self.tier is None else f" ({tier_name(self.tier)})"
        if self.guard:
            return f"{self.what}{tier}, guarded by {self.guarded_by}"
        return f"{_joined(self.what, self.reference)}{tier}"


def _joined(*words: str) -> str:
    return ", ".join(filter(None, words))


@dataclass(frozen=True, kw_only=True)
class Finding:
    """One quantity of a cell: a row of the verdicts.

    Attributes
    ----------
    quantity : str
    verdict, reason, tier, settled, p_verified, p_refuted, excluded
        See `Opinion`.
    claim : Claim or None
        None if no claim covers the quantity here.
    estimate, low, high : float
        Order or residual, with its confidence interval at the confidence level of the run.
    resolution : float
        Largest error of the limit that the evidence leaves possible, relative to the size of the quantity; a larger
        one would have been detected. NaN if the evidence does not concern a limit, infinite if no error would have
        been detected.
    order_resolution : float
        Largest share of the error at the finest step that may belong to a term of half an order less than the claimed
        order. Set where paths alone decide an order; NaN elsewhere, infinite where it is unknown.
    value_of : str
        Meaning of the estimate where it is neither an order nor the usual estimate of the measure.
    method : Method or None
        None if the quantity was not measured.
    details : mapping of str to object
        Additional columns.
    """

    quantity: str
    verdict: Verdict
    reason: Reason = Reason()
    claim: Claim | None = None
    estimate: float = nan
    low: float = nan
    high: float = nan
    resolution: float = nan
    order_resolution: float = nan
    value_of: str = ""
    method: Method | None = None
    p_verified: float = nan
    p_refuted: float = nan
    tier: int = 3
    settled: bool = True
    details: Mapping[str, object] = field(default_factory=dict)
    excluded: frozenset[Verdict] = frozenset()

    def __post_init__(self) -> None:
        if not isinstance(self.method, Method | None):
            raise UsageError(
                f"method of a finding expects a Method, such as Method('paths', 3), got {self.method!r:.200}"
            )


class LevelFinding(NamedTuple):
    """One quantity at one step size: a row of the levels.

    Attributes
    ----------
    quantity : str
    level : int or None
        Index of the level of the run's paths; None for a step size chosen by the measure.
    estimate, std_error : float
    details : mapping of str to object
        Additional columns.
    h : float
        Step size where `level` is None.
    """

    quantity: str
    level: int | None
    estimate: float
    std_error: float = 0.0
    details: Mapping[str, object] = {}
    h: float = nan


class Judgement(NamedTuple):
    """All rows of a cell.

    Attributes
    ----------
    findings : tuple of Finding
    levels : iterable of LevelFinding
        Iterated at most once. The levels of controls are never read, so a generator does not compute them.
    """

    findings: tuple[Finding, ...]
    levels: Iterable[LevelFinding]
