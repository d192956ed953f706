"""The lock file: claims that a gate must find, so that no claim is dropped, weakened or unmeasured unnoticed.

::

    {"schema_version": 2, "tiers": {"ci": {"milstein": {"gbm": {"strong": {"x": {"order": 1.0}}}}}}}

Schemes, problems, measures and quantities are sorted, with one claim on each line.
"""

import json
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, Literal

import msgspec

from ..contracts.claimed import IN_MEAN_SQUARE, MARGIN, SENSES, Bound, Order, Word
from ..contracts.finding import Status
from ..contracts.scheme import Claim
from ..contracts.spelling import counted
from ..errors import UsageError
from ..registry.load import Registry
from ..registry.selection import select_measures, select_problems
from ..report.files import write_text
from ..report.folders import Key, key_in
from ..study import CellResult
from ..study.every_equation import is_premise_failing
from .expected import Text
from .gate_plan import gated_schemes
from .outcomes import Outcome
from .policy import Policy

SCHEMA = 2
WRITE = "if it should be one, remove it and write a new one with gate --write-lock"
Positive = Annotated[float, msgspec.Meta(gt=0.0)]


class Locked(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True, omit_defaults=True):
    """Locked form of a claim: an order with its margin, or words with their bound.

    Attributes
    ----------
    order : float or None
        Least order; None for a claim in words.
    margin : float
        Tolerance below the order.
    words : str
        Empty for an order.
    within : float or None
        Bound of the claimed quantity; None if the words have no bound.
    share : float
        Least fraction of the steps in which the bound holds.
    at : float or None
        Step size at which the bound holds; None for every step size.
    sense : str
        Sense of convergence; omitted from the file if it is mean square.

    Raises
    ------
    ValueError
        If there is neither an order nor words, or both, or if the sense is unknown.
    """

    order: Positive | None = None
    margin: Positive = MARGIN
    words: str = ""
    within: Positive | None = None
    share: Positive = 1.0
    at: Positive | None = None
    sense: str = IN_MEAN_SQUARE

    def __post_init__(self) -> None:
        if (self.order is None) is not bool(self.words):
            raise ValueError("a locked claim has either an order or words")
        if self.sense not in SENSES:
            raise ValueError(f"a locked claim holds {' or '.join(SENSES)}")

    @classmethod
    def of(cls, claim: Claim) -> "Locked":
        """Convert a claim to its locked form."""
        given: dict[str, Any] = {"sense": claim.sense}
        match claim.value:
            case Order(least, margin):
                given |= {"order": float(least), "margin": float(margin)}
            case Bound(words, most, share, at):
                step = None if at is None else float(at)
                given |= {"words": words, "within": float(most), "share": float(share), "at": step}
            case words:
                given["words"] = str(words)
        # msgspec omits defaults that are the same objects, which numbers and texts from a worker are not.
        defaults = dict(zip(cls.__struct_fields__, cls.__struct_defaults__, strict=True))
        return cls(**{name: value for name, value in given.items() if value != defaults[name]})

    def implies(self, other: "Locked") -> bool:
        """Return whether this claim is at least as strong as another."""
        if self.sense not in {IN_MEAN_SQUARE, other.sense}:
            return False
        if self.order is not None and other.order is not None:
            return self.order - self.margin >= other.order - other.margin
        if self.words == other.words and self.within is other.within is None:
            return True
        if self.words != other.words or self.at != other.at or self.within is None or other.within is None:
            return False
        return self.within <= other.within and self.share >= other.share

    def __str__(self) -> str:
        sense = "" if self.sense == IN_MEAN_SQUARE else f" {self.sense}"
        if self.order is not None:
            return f"order >= {self.order}{sense}" + (f", margin {self.margin}" if self.margin != MARGIN else "")
        value = Word(self.words) if self.within is None else Bound(self.words, self.within, self.share, self.at)
        return f"{value}{sense}"


class LockFile(msgspec.Struct, frozen=True):
    """Contents of a lock file: claims by tier, scheme, problem, measure and quantity."""

    schema_version: Literal[2]
    tiers: dict[Text, dict[str, dict[str, dict[str, dict[str, Locked]]]]]


Claims = dict[Key, Locked]


def found_claims(outcomes: Iterable[Outcome]) -> Claims:
    """Return the tested claims, keyed by scheme, problem, measure and quantity."""
    pairs = ((outcome.key, outcome.finding.claim) for outcome in outcomes)
    return {key: Locked.of(claim) for key, claim in pairs if claim is not None and key.quantity}


def undecided_claims(results: Iterable[CellResult]) -> Claims:
    """Return the claims about classes of equations that order conditions do not decide, because a premise fails."""
    pairs = ((key_in(each.cell, one.quantity), one) for each in results for one in each.findings)
    return {key: Locked.of(one.claim) for key, one in pairs if one.claim is not None and is_premise_failing(one)}


def compare(
    locked: Claims, outcomes: Iterable[Outcome], undecided: Claims | None = None
) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Compare the locked claims with those found.

    A cell without any measured quantity is no violation, because its own outcome reports it. Neither is a claim
    about a class that is not decided: like any other inconclusive claim, it is tested.

    Parameters
    ----------
    locked : dict of Key to Locked
    outcomes : iterable of Outcome
    undecided : dict of Key to Locked, optional
        Claims without an outcome, as returned by `undecided_claims`.

    Returns
    -------
    violations : tuple of str
        A line for each claim that is gone, weaker or no longer measured.
    notes : tuple of str
        Lines about undecided, stronger and new claims.
    """
    known = list(outcomes)
    found = {**(undecided or {}), **(gated := found_claims(known))}
    whole = _whole(known)
    without = {outcome.key for outcome in known if outcome.finding.claim is None}
    missing = [key for key in locked if key not in found and key[:3] not in whole and key not in without]
    changed = [key for key in locked if key in found and found[key] != locked[key]]
    weaker = [key for key in changed if not found[key].implies(locked[key])]
    violations = [f"no longer tested: {key}: {locked[key]}{_elsewhere(key, locked[key], found)}" for key in missing]
    violations += [f"claim weakened: {key}: was {locked[key]}, is {found[key]}" for key in weaker]
    notes = [f"claim strengthened: {k}: was {locked[k]}, is {found[k]}" for k in changed if k not in weaker]
    undecided_keys = [key for key in locked if key in found and key not in gated]
    notes += [f"not decided: {key}: {locked[key]}: a premise of the order conditions fails" for key in undecided_keys]
    if new := [key for key in gated if key not in locked]:
        more = f" and {len(new) - 1} more" if len(new) > 1 else ""
        notes.append(f"not in the lock file: {new[0]}{more}; --write-lock adds what is new")
    return tuple(sorted(violations)), tuple(notes)


def _whole(outcomes: Iterable[Outcome]) -> set[tuple[str, ...]]:
    """Return scheme, problem and measure of each outcome that is not about a single quantity."""
    return {outcome.key[:3] for outcome in outcomes if not outcome.finding.quantity}


def _elsewhere(key: Key, claim: Locked, found: Claims) -> str:
    """Return the other problem on which a claim is now tested: tier smoke selects one for each claim."""
    same = (other for other in found if other._replace(problem=key.problem) == key and found[other].implies(claim))
    other = next(same, None)
    return "" if other is None else f"; tested on {other.problem} now"


def read_lock(file: Path) -> dict[str, Claims] | None:
    """Return the locked claims of each tier, or None if there is no such file.

    Raises
    ------
    UsageError
        If the file cannot be read or is not a lock file.
    """
    try:
        known = msgspec.json.decode(file.read_bytes(), type=LockFile)
    except FileNotFoundError:
        return None
    except OSError as error:
        raise UsageError(f"cannot read the lock file {file}: {error.strerror or error}") from error
    # The JSON decoder raises RecursionError, not ValueError, for nesting that is too deep.
    except (ValueError, RecursionError) as error:
        raise UsageError(f"{file} is not a lock file of version {SCHEMA}: {error}; {WRITE}") from error
    return {tier: dict(_flat(nested)) for tier, nested in known.tiers.items()}


def lock_text(tiers: Mapping[str, Claims]) -> str:
    """Return the text of a lock file; tiers without claims are omitted."""
    nested = {tier: _nest_claims(claims) for tier, claims in tiers.items() if claims}
    return claims_on_lines(msgspec.to_builtins({"schema_version": SCHEMA, "tiers": nested}))


def claims_on_lines(contents: Mapping[str, Any]) -> str:
    """Return the text of a lock file: names sorted, one claim on each line."""
    text = json.dumps(contents, indent=1, sort_keys=True, ensure_ascii=False)
    return re.sub(r"\{\n[^{}]*\}", _on_one_line, text) + "\n"


def _on_one_line(claim: re.Match[str]) -> str:
    _, *lines, _ = claim[0].split("\n")
    return f"{{{' '.join(map(str.strip, lines))}}}"


def _nest_claims(claims: Claims) -> dict[str, Any]:
    nested: dict[str, Any] = {}
    for key, claim in claims.items():
        nested.setdefault(key.scheme, {}).setdefault(key.problem, {}).setdefault(key.measure, {})[key.quantity] = (
            claim
        )
    return nested


def _flat(nested: Any, names: tuple[str, ...] = ()) -> Iterator[tuple[Key, Locked]]:
    if isinstance(nested, Locked):
        yield Key(*names), nested
        return
    for name, below in nested.items():
        yield from _flat(below, (*names, name))


def locked_tiers(policy: Policy) -> dict[str, Claims] | None:
    """Return the locked claims by tier, or None if there is no lock file and the policy names none.

    Raises
    ------
    UsageError
        If the policy names a file that does not exist, or the file is not a lock file.
    """
    found = read_lock(policy.lock_file)
    if found is None and policy.lock:
        file = policy.lock_file
        raise UsageError(f"there is no lock file {file}, though the policy names it; write it with gate --write-lock")
    return found


def restrict(locked: Claims, registry: Registry, policy: Policy, *, narrowed: bool) -> Claims:
    """Return the locked claims that a gate must find: all of them, or those in a narrowed selection.

    Parameters
    ----------
    locked : dict of Key to Locked
    registry : Registry
    policy : Policy
    narrowed : bool
        Whether the command line selects schemes, problems or measures.
    """
    if not narrowed:
        return locked
    schemes = {scheme.label for scheme in gated_schemes(registry, policy)}
    problems = {spec.label for spec in select_problems(registry, policy.problems)}
    measures = {measure.name for measure in select_measures(registry, policy.measures)}
    return {
        key: claim
        for key, claim in locked.items()
        if key.scheme in schemes and key.problem in problems and key.measure in measures
    }


def write_lock(policy: Policy, outcomes: Sequence[Outcome]) -> list[str]:
    """Write the claims found by a gate into the section of its tier, and keep all other sections.

    Locked claims of a scheme on a problem that breaks a contract are kept as well, because no single claim is found
    there.

    Parameters
    ----------
    policy : Policy
    outcomes : sequence of Outcome

    Returns
    -------
    list of str
        Number of locked claims, and each claim that was locked before and is gone or weaker. If a cell could not be
        measured, the file is not written, because its claims would be lost, and the line says why.

    Raises
    ------
    UsageError
        If the file cannot be read or written, or was not written by this program. It is not changed then.
    """
    file, tier = policy.lock_file, policy.tier
    unmeasured = [outcome for outcome in outcomes if outcome.status is Status.UNMEASURED]
    if unmeasured or not outcomes:
        why = f"not measured: {len(unmeasured)}" if unmeasured else "no claim was tested"
        return [f"the lock file {file} is not written: {why}"]
    before, whole = read_lock(file) or {}, _whole(outcomes)
    kept = {key: claim for key, claim in before.get(tier, {}).items() if key[:3] in whole}
    claims = {**kept, **found_claims(outcomes)}
    write_text(lock_text({**before, tier: claims}), file)
    gone, _ = compare(before.get(tier, {}), outcomes)
    locked = f"{file} locks {counted(len(claims), 'claim')} of tier {tier}"
    return [locked, *(f"unlocked: {line}" for line in gone)]
