"""What is found of a claim: an opinion, which is a verdict with its reason, and the rows of a cell."""

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
    """What can be said of a claim, or why nothing can."""

    VERIFIED = "verified"
    REFUTED = "refuted"
    INCONCLUSIVE = "inconclusive"
    DIVERGED = "diverged"
    ERROR = "error"
    NOT_RUN = "not_run"
    OUT_OF_SCOPE = "out_of_scope"
    NOT_APPLICABLE = "not_applicable"


class Status(StrEnum):
    """What a finding means to a gate, or the answer to a check to a test, where something is expected."""

    PASSED = "passed"
    FAILED = "failed"
    SKIPPED = "skipped"
    UNMEASURED = "unmeasured"
    UNDECIDED = "undecided"
    XFAILED = "xfailed"
    XPASSED = "xpassed"


# Nothing was measured of what was to be.
UNMEASURED = frozenset({Verdict.ERROR, Verdict.DIVERGED, Verdict.NOT_RUN})


class Kind(StrEnum):
    """What a reason says, where something is decided by it or somebody counts it."""

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
    """Why a verdict is what it is: a value of one or several parts, whose words are made where they are read.

    Attributes
    ----------
    text : str
        With places for the numbers, as `str.format` fills them; as it stands where there are no numbers.
    kind : str
        A `Kind`, or a word of a measure's own.
    numbers : mapping of str to object
    joint : str
        What stands between the part before and this one.
    rest : tuple of Reason
        Further parts, each of them without a rest.
    """

    text: str = ""
    kind: str = Kind.PLAIN
    numbers: Mapping[str, object] = field(default_factory=dict)
    joint: str = "; "
    rest: "tuple[Reason, ...]" = ()

    @classmethod
    def of(cls, *reasons: "Reason | str") -> "Reason":
        """Return several reasons as one; empty ones are left out."""
        return reduce(cls.then, reasons, cls())

    @property
    def parts(self) -> "tuple[Reason, ...]":
        """The parts, each by itself."""
        return (replace(self, rest=()), *self.rest) if self.rest else (self,)

    def then(self, other: "Reason | str", joint: str = "; ") -> "Reason":
        """Return this reason with another one behind it; an empty one adds nothing."""
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
        """Kinds of the parts that have one, each once."""
        return tuple(dict.fromkeys(str(part.kind) for part in self.parts if part.kind))

    @property
    def paths(self) -> float:
        """How many paths would decide, as far as the parts say; 0 if none does."""
        said = (part.numbers.get("paths", 0) for part in self.parts if part.kind == Kind.MORE_PATHS)
        return max(map(float, map(str, said)), default=0.0)

    def without(self, kind: str) -> "Reason":
        """Return the reason without the parts of a kind."""
        return Reason.of(*(part for part in self.parts if part.kind != kind))

    def has(self, kind: str) -> bool:
        """Tell whether a part is of a kind."""
        return any(part.kind == kind for part in self.parts)

    def includes(self, other: "Reason") -> bool:
        """Tell whether a reason of one part is a part of this one, however it is joined."""
        return any(replace(part, joint=other.joint) == other for part in self.parts)

    def before(self, kind: str) -> "Reason":
        """Return the parts before the first one of a kind; all of them if there is none."""
        first, *further = [*takewhile(lambda part: part.kind != kind, self.parts)] or [Reason()]
        return replace(first, rest=tuple(further))

    @property
    def sentence(self) -> str:
        """The words as a sentence: a capital where it begins with a word, and a full stop."""
        text = str(self)
        first = text.split(" ", 1)[0].rstrip(",:").replace("-", "")
        # A letter by itself is a component, but for the article.
        if first.isalpha() and first.islower() and (len(first) > 1 or first == "a"):
            text = text[0].upper() + text[1:]
        return text if not text or text.endswith((".", "?", "!")) else f"{text}."

    @property
    def standard_errors(self) -> float:
        """How many standard errors an effect is that is not told from noise, as far as the parts say; NaN if none."""
        said = (part.numbers["standard_errors"] for part in self.parts if "standard_errors" in part.numbers)
        return min(map(float, map(str, said)), default=nan)

    def __bool__(self) -> bool:
        return bool(self.text)

    def __str__(self) -> str:
        return self._words() + "".join(part.joint + part._words() for part in self.rest)

    def _words(self) -> str:
        return self.text.format(**self.numbers) if self.numbers else self.text


class Opinion(NamedTuple):
    """What is said of a claim.

    Attributes
    ----------
    verdict : Verdict
    reason : Reason
    tier : int
        Of the method: 0 contract, 1 local, 2 deterministic and global, 3 sampled.
    settled : bool
        Whether more paths could not change the verdict, or need not be asked for.
    p_verified, p_refuted : float
        p-values of the hypotheses that the claim fails and that it holds, which the two verdicts reject; NaN where
        no sampling error is involved. They enter the family-wise correction of a run.
    excluded : frozenset of Verdict
        What something that was seen stands against: no p-value makes up for that, nor any correction of one. An
        inconclusive opinion that excludes *verified* speaks against the claim; one that does not says nothing.
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
        """Whether what was seen stands against the claim, decided or not."""
        return self.verdict is Verdict.REFUTED or Verdict.VERIFIED in self.excluded

    @property
    def final(self) -> bool:
        """Whether neither verdict can be had: no other evidence decides then."""
        return self.excluded >= {Verdict.VERIFIED, Verdict.REFUTED}

    def plus(self, *remarks: Reason | str) -> "Opinion":
        """Return the opinion with remarks behind its reason; empty ones add nothing."""
        further = Reason.of(*remarks)
        return self._replace(reason=self.reason.then(further)) if further else self


# Tiers of methods: the contract of a step, one step, all steps at once, paths that are drawn; beside them, the order
# conditions of a class of equations, which override none.
CONTRACT, ONE_STEP, AT_ONCE, SAMPLED = 0, 1, 2, 3
CONDITIONS = -1


def tier_name(tier: int) -> str:
    """Return how a tier is written."""
    return "TA" if tier == CONDITIONS else f"T{tier}"


class Method(NamedTuple):
    """How a quantity was measured.

    Attributes
    ----------
    what : str
        What was looked at: ``local order``, ``paths``.
    tier : int or None
        Of it: 0 contract, 1 local, 2 deterministic and global, 3 sampled; None where nothing could be decided.
    guard : str
        What would have shown that the tier errs.
    reference : str
        What stands for the truth along paths.
    """

    what: str
    tier: int | None = None
    guard: str = ""
    reference: str = ""

    @property
    def guarded_by(self) -> str:
        """The guard with its reference; empty where there is none."""
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
        Order or residual, with its interval at the run's confidence.
    resolution : float
        Largest error of the limit that the evidence leaves possible, as part of the quantity's size: one that is
        larger would have shown. NaN where nothing is said of a limit, infinite where no error would have shown.
    order_resolution : float
        Largest share of the error at the finest step that a term of half an order less than the claimed one may have,
        where paths alone decide an order; NaN elsewhere, infinite where it is not known.
    value_of : str
        What the estimate is where it is neither an order nor what the measure's estimates are.
    method : Method or None
        None where nothing was measured.
    details : mapping of str to object
        Further columns.
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
        Index of the level of the run's paths; None for a step size of the measure's own.
    estimate, std_error : float
    details : mapping of str to object
        Further columns.
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
        Read once at most: nobody asks for those of a control, and a generator makes none then.
    """

    findings: tuple[Finding, ...]
    levels: Iterable[LevelFinding]
