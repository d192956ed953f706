"""The lock file of a policy: what is read from it, held against a gate, and written into it."""

from collections.abc import Sequence

from ..errors import UsageError
from ..registry.load import Registry
from ..registry.selection import select_measures, select_problems
from .lock import Claims, compared, found_claims, lock_text, read_lock
from .outcomes import Outcome, Status
from .plan import gated_schemes
from .policy import Policy


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


def locked_before(policy: Policy) -> dict[str, Claims]:
    """Return what the lock file locks before it is written, by tier; nothing where there is none.

    Raises
    ------
    UsageError
        If something else stands in its place, which must not be overwritten.
    """
    return read_lock(policy.lock_file) if policy.lock_file.exists() else {}


def demanded(locked: Claims, registry: Registry, policy: Policy, *, narrowed: bool) -> Claims:
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
    claims, before = found_claims(outcomes), locked_before(policy)
    write_text(lock_text({**before, tier: claims}), file)
    gone = compared(before.get(tier, {}), outcomes).violations
    locked = f"{len(claims)} claims of tier {tier} are locked in {file}"
    return [locked, *(f"unlocked: {line}" for line in gone)]
