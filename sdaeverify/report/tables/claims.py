"""Findings on each claim of a run: on problems, for classes of equations, and by hunts."""

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import pandas as pd

from ...contracts.spelling import counted
from ...study.every_equation import RANDOM_MEMBERS
from ..cells import grouped
from ..folders import class_in
from ..saved import SavedAttack, SavedClaim, claims_of
from ..verdict_row import VerdictRow

PROBLEMS, CLASSES, MEMBERS = "problems", "classes", "members"
VERIFIED, REFUTED, UNDECIDED, UNMEASURED = OUTCOMES = ("verified", "refuted", "undecided", "not measured")
UNTESTED = "tested nowhere"
WORST_FIRST = (REFUTED, UNMEASURED, UNDECIDED, VERIFIED)
# Outcome of a claim for each verdict on a claim; other verdicts have no outcome.
OUTCOME_OF = {
    "verified": VERIFIED,
    "refuted": REFUTED,
    "inconclusive": UNDECIDED,
    "diverged": UNMEASURED,
    "error": UNMEASURED,
    "not_run": UNMEASURED,
}
WHERE = {PROBLEMS: "on problems", CLASSES: "for classes of equations", MEMBERS: "on random members of forms"}
# Largest number of problems and classes that are named in the line of a refuted claim.
MOST_NAMED = 3


class ClaimHunt(NamedTuple):
    """Result of a hunt for a claim.

    Attributes
    ----------
    form : str
        Form of the examples.
    examples : int
        Number of examples to which the claim applies.
    refuted : bool
        Whether an example and a run on it refute the claim.
    """

    form: str
    examples: int
    refuted: bool

    @property
    def sentence(self) -> str:
        """The result in words."""
        found = "refuted" if self.refuted else "not refuted"
        return f"{found} by a hunt, {counted(self.examples, 'example')} of {self.form}"


@dataclass(frozen=True)
class KnownClaim:
    """A claim with its findings.

    Attributes
    ----------
    scheme, measure, claim : str
        Label of the scheme, name of the measure, and claim in words.
    when : tuple of str
        Traits that a problem must have, joined by *and*; alternatives, if the claim is made several times.
    sources : tuple of str
        Sources of the claim.
    counts : mapping of str to Counter
        Number of findings by outcome, for each kind of object: ``problems``, ``classes``, ``members``.
    refuted_on : tuple of str
        Problems and classes on which the claim is refuted.
    hunts : tuple of ClaimHunt
    """

    scheme: str
    measure: str
    claim: str
    when: tuple[str, ...] = ()
    sources: tuple[str, ...] = ()
    counts: Mapping[str, Counter[str]] = field(default_factory=dict)
    refuted_on: tuple[str, ...] = ()
    hunts: tuple[ClaimHunt, ...] = ()

    @property
    def worst(self) -> str:
        """Worst outcome on any object; a claim with no findings but hunts that refute nothing is undecided."""
        hunted = {REFUTED if hunt.refuted else UNDECIDED for hunt in self.hunts}
        found = {outcome for counts in self.counts.values() for outcome in counts} or hunted
        return next((each for each in WORST_FIRST if each in found | (hunted & {REFUTED})), UNTESTED)

    @property
    def sentence(self) -> str:
        """Claim and findings in one line."""
        where = f" where the problem has {', or '.join(self.when)}" if self.when else ""
        parts = [_counts_in_words(WHERE[kind], found) for kind, found in self.counts.items() if found]
        if self.refuted_on:
            more = len(self.refuted_on) - MOST_NAMED
            names = ", ".join(self.refuted_on[:MOST_NAMED])
            parts.append(f"refuted on {names}{f' and {more} more' if more > 0 else ''}")
        parts += [hunt.sentence for hunt in self.hunts]
        return f"{self.scheme}, {self.measure} {self.claim}{where}: {'; '.join(parts) or UNTESTED}"

    @property
    def record(self) -> dict[str, Any]:
        """Claim and findings for JSON."""
        named = {name: getattr(self, name) for name in ("scheme", "measure", "claim")}
        lists = {name: [*getattr(self, name)] for name in ("when", "sources", "refuted_on")}
        counts = {kind: {each: found[each] for each in OUTCOMES} for kind, found in self.counts.items()}
        return {**named, **lists, **counts, "hunts": [each._asdict() for each in self.hunts], "worst": self.worst}


class Claimed(NamedTuple):
    """Claim that a finding is about; `words` is empty if the finding is about all claims of a measure."""

    scheme: str
    measure: str
    words: str


# A finding as kind of object, name of the object, and outcome.
Told = tuple[str, str, str]


def known_claims(
    rows: Iterable[VerdictRow],
    claims: Iterable[SavedClaim],
    attacks: Iterable[SavedAttack] = (),
) -> list[KnownClaim]:
    """Return all claims of a run with their findings; claims of a scheme with the same words are merged.

    A row that has no claim and could not be measured counts for each claim about its measure.

    Parameters
    ----------
    rows : iterable of VerdictRow
        Verdicts on problems and on classes.
    claims : iterable of SavedClaim
        Claims of the schemes of the run.
    attacks : iterable of SavedAttack
        Results of the hunt of the run.
    """
    made = grouped(claims, lambda each: Claimed(each.scheme, each.measure, each.claim))
    found = grouped(_told(rows), lambda told: told[0])
    hunted = [*attacks]
    known, schemes = [], [*dict.fromkeys(key.scheme for key in (*made, *found))]
    keys = dict.fromkeys((*made, *(key for key in found if key.words)))
    for key in sorted(keys, key=lambda each: schemes.index(each.scheme)):
        told = [each for _, each in (*found.get(key, ()), *found.get(key._replace(words=""), ()))]
        hunts = tuple(_hunts(key, hunted))
        known.append(_known(key, made.get(key, ()), told, hunts))
    return known


def claims_table(rows: Iterable[VerdictRow], run: Mapping[str, Any]) -> pd.DataFrame:
    """Return the claims with their findings as a table; counts have columns such as ``problems.verified``.

    Parameters
    ----------
    rows : iterable of VerdictRow
        Verdicts on problems and on classes.
    run : mapping
        Contents of ``run.json``.
    """
    known = known_claims(rows, claims_of(run))
    return pd.json_normalize([each.record for each in known]).drop(columns="hunts", errors="ignore")


def _known(
    key: Claimed, made: Sequence[SavedClaim], told: Sequence[Told], hunts: tuple[ClaimHunt, ...]
) -> KnownClaim:
    when = tuple(dict.fromkeys(" and ".join(each.when) for each in made))
    return KnownClaim(
        *key,
        when=() if "" in when else when,
        sources=tuple(dict.fromkeys(each.source for each in made)),
        counts={kind: Counter(outcome for own, _, outcome in told if own == kind) for kind in WHERE},
        refuted_on=tuple(dict.fromkeys(name for _, name, outcome in told if outcome == REFUTED)),
        hunts=hunts,
    )


def _told(rows: Iterable[VerdictRow]) -> Iterator[tuple[Claimed, Told]]:
    for row in rows:
        outcome, kind = OUTCOME_OF.get(row.verdict, ""), class_in(row.problem)
        if outcome and (row.claim or outcome == UNMEASURED):
            place = PROBLEMS if kind is None else MEMBERS if row.quantity == RANDOM_MEMBERS else CLASSES
            name = row.problem if kind is None else f"the class {kind}"
            yield Claimed(row.scheme, row.measure, row.claim), (place, name, outcome)


def _hunts(key: Claimed, attacks: Iterable[SavedAttack]) -> Iterator[ClaimHunt]:
    for each in attacks:
        if (each.scheme, each.measure) == key[:2] and key.words in each.claims:
            yield ClaimHunt(each.form, each.claims[key.words], each.refuted == key.words)


def _counts_in_words(where: str, found: Counter[str]) -> str:
    return f"{where} {', '.join(f'{found[each]} {each}' for each in OUTCOMES if found[each])}"
