"""The lock file: the claims a gate must find, so that nothing is dropped, weakened or left unmeasured unnoticed.

::

    {"schema_version": 1, "tiers": {"ci": {"milstein": {"gbm": {"strong": {"x": "order >= 1.0"}}}}}}

Schemes, problems, measures and quantities are sorted, each claim on a line of its own.
"""

import json
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from math import inf
from pathlib import Path
from typing import Any, NamedTuple

from ..contracts.claimed import MARGIN, Order
from ..contracts.scheme import Claim
from ..errors import UsageError
from ..registry.load import Registry
from ..registry.selection import select_measures, select_problems
from .gate_plan import gated_schemes
from .outcomes import Outcome, Status
from .policy import Policy

SCHEMA = 1
WRITE = "if it is meant to be one, remove it and write it anew with gate --write-lock"
ORDER = "order >="
_NUMBER = r"[0-9]+(?:\.[0-9]+)?(?:e[+-]?[0-9]{1,3})?"
_ORDER = re.compile(rf"{ORDER} ({_NUMBER})(?:, margin ({_NUMBER}))?")
_WITHIN = re.compile(rf"(.+) within ({_NUMBER})")


class Key(NamedTuple):
    """What a claim is about: label of the scheme, label of the problem, measure, quantity."""

    scheme: str
    problem: str
    measure: str
    quantity: str

    def __str__(self) -> str:
        return f"{self.scheme} on {self.problem}, {self.measure} {self.quantity}".strip()


Claims = dict[Key, str]


@dataclass(frozen=True)
class Lock:
    """What a lock file demands of a tier, compared with what was found.

    Attributes
    ----------
    violations : tuple of str
        A line for each claim that is gone, weaker or no longer measured.
    notes : tuple of str
        What is new.
    """

    violations: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()


def claim_words(claim: Claim) -> str:
    """Return a claim as it is locked: with its margin, unless that is the default."""
    value = claim.value
    if not isinstance(value, Order) or value.margin == MARGIN:
        return str(claim)
    return f"{claim}, margin {value.margin}"


def found_claims(outcomes: Iterable[Outcome]) -> Claims:
    """Return the claims that were put to the test, by what they are about."""
    pairs = ((_key(outcome), outcome.finding.claim) for outcome in outcomes)
    return {key: claim_words(claim) for key, claim in pairs if claim is not None and key.quantity}


def compare(locked: Claims, outcomes: Iterable[Outcome]) -> Lock:
    """Compare what is locked with what was found.

    A cell in which nothing could be measured at all is no violation: its own outcome says so.

    Parameters
    ----------
    locked : dict of Key to str
    outcomes : iterable of Outcome

    Returns
    -------
    Lock
    """
    known = list(outcomes)
    found = found_claims(known)
    whole = {_key(outcome)[:3] for outcome in known if not outcome.finding.quantity}
    without = {_key(outcome) for outcome in known if outcome.finding.claim is None}
    missing = [key for key in locked if key not in found and key[:3] not in whole and key not in without]
    changed = [key for key in locked if key in found and found[key] != locked[key]]
    weaker = [key for key in changed if not _implies(found[key], locked[key])]
    violations = [f"no longer tested: {key}: {locked[key]}" for key in missing]
    violations += [f"claim weakened: {key}: was {locked[key]}, is {found[key]}" for key in weaker]
    notes = [f"claim strengthened: {k}: was {locked[k]}, is {found[k]}" for k in changed if k not in weaker]
    if new := [key for key in found if key not in locked]:
        more = f" and {len(new) - 1} more" if len(new) > 1 else ""
        notes.append(f"not in the lock file: {new[0]}{more}; --write-lock adds what is new")
    return Lock(tuple(sorted(violations)), tuple(notes))


def read_lock(file: Path) -> dict[str, Claims]:
    """Return the locked claims of each tier.

    Raises
    ------
    UsageError
        If it cannot be read, or is no lock file.
    """
    try:
        data = json.loads(file.read_text(encoding="utf-8"))
    except OSError as error:
        raise UsageError(f"cannot read the lock file {file}: {error.strerror or error}") from error
    # What is nested too deeply for the reader is no ValueError to it.
    except (ValueError, RecursionError) as error:
        raise UsageError(f"{file} is no lock file: {error}; {WRITE}") from error
    version = data.get("schema_version") if isinstance(data, dict) else None
    if version != SCHEMA or isinstance(version, bool):
        raise UsageError(f"{file} is no lock file of version {SCHEMA}; {WRITE}")
    try:
        return {tier: _flat(nested) for tier, nested in data["tiers"].items()}
    except (KeyError, AttributeError, TypeError) as error:
        raise UsageError(f"{file} is damaged; {WRITE}") from error


def lock_text(tiers: Mapping[str, Claims]) -> str:
    """Return the text of a lock file."""
    nested = {tier: _nest_claims(claims) for tier, claims in tiers.items() if claims}
    return json.dumps({"schema_version": SCHEMA, "tiers": nested}, indent=1, sort_keys=True) + "\n"


def _key(outcome: Outcome) -> Key:
    cell = outcome.cell
    return Key(cell.scheme.label, cell.spec.label, cell.measure.name, outcome.finding.quantity)


def _nest_claims(claims: Claims) -> dict[str, Any]:
    nested: dict[str, Any] = {}
    for key, text in claims.items():
        nested.setdefault(key.scheme, {}).setdefault(key.problem, {}).setdefault(key.measure, {})[key.quantity] = text
    return nested


def _flat(nested: Mapping[str, Any]) -> Claims:
    return {
        Key(scheme, problem, measure, quantity): _read_claim(text)
        for scheme, problems in nested.items()
        for problem, measures in problems.items()
        for measure, quantities in measures.items()
        for quantity, text in quantities.items()
    }


def _read_claim(text: object) -> str:
    """Return the words of a claim, which may be any, unless they look like an order and are none."""
    if not isinstance(text, str) or (text.startswith(ORDER) and not _ORDER.fullmatch(text)):
        raise TypeError(f"{text!r} is no claim")
    return text


def _implies(found: str, locked: str) -> bool:
    words, more = _WITHIN.fullmatch(found), _WITHIN.fullmatch(locked)
    if words and more:
        return words[1] == more[1] and float(words[2]) <= float(more[2])
    return _least_order(found) >= _least_order(locked) > -inf


def _least_order(text: str) -> float:
    match = _ORDER.fullmatch(text)
    return float(match[1]) - float(match[2] or MARGIN) if match else -inf


def locked_tiers(policy: Policy) -> dict[str, Claims] | None:
    """Return the locked claims by tier, or None where there is no lock file and none is asked for.

    Raises
    ------
    UsageError
        If the policy names a file that is not there, or it is no lock file.
    """
    file = policy.lock_file
    try:
        is_there = file.exists()
    except (OSError, ValueError) as error:
        raise UsageError(f"cannot read the lock file {file}: {getattr(error, 'strerror', None) or error}") from error
    if is_there:
        return read_lock(file)
    if policy.lock_named:
        raise UsageError(f"there is no lock file {file}, though the policy names it; write it with gate --write-lock")
    return None


def read_previous_lock(policy: Policy) -> dict[str, Claims]:
    """Return what the lock file locks before it is written, by tier; nothing where there is none.

    Raises
    ------
    UsageError
        If something else stands in its place, which must not be overwritten.
    """
    return read_lock(policy.lock_file) if policy.lock_file.exists() else {}


def restrict(locked: Claims, registry: Registry, policy: Policy, *, narrowed: bool) -> Claims:
    """Return the locked claims that a gate must find: all, or those that a narrowed selection reaches.

    Parameters
    ----------
    locked : dict of Key to str
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
    """Write the claims that a gate has found into the section of its tier; other sections stay.

    Parameters
    ----------
    policy : Policy
    outcomes : sequence of Outcome

    Returns
    -------
    list of str
        What was done, with each claim that was locked before and is gone or weaker; or why nothing was: a cell that
        could not be measured would be forgotten.

    Raises
    ------
    UsageError
        If the file cannot be read or written, or is none that was written by this program: it stays as it is.
    """
    # Files of a run need pandas, which a run of tests should not have to load to read what is locked.
    from ..report.files import write_text  # noqa: PLC0415

    file, tier = policy.lock_file, policy.tier
    unmeasured = [outcome for outcome in outcomes if outcome.status is Status.UNMEASURED]
    if unmeasured or not outcomes:
        why = f"not measured: {len(unmeasured)}" if unmeasured else "no claim was tested"
        return [f"the lock file {file} is not written: {why}"]
    claims, before = found_claims(outcomes), read_previous_lock(policy)
    write_text(lock_text({**before, tier: claims}), file)
    gone = compare(before.get(tier, {}), outcomes).violations
    locked = f"{len(claims)} claims of tier {tier} are locked in {file}"
    return [locked, *(f"unlocked: {line}" for line in gone)]
