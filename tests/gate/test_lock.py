"""What is locked, and what is held against it."""

import json
import pickle
from dataclasses import replace

import numpy as np
import pytest

from facade import (
    CONDITIONS,
    Key,
    Locked,
    Policy,
    compare,
    found_claims,
    lock_text,
    locked_tiers,
    outcomes,
    read_lock,
    restrict,
    undecided_claims,
    write_lock,
)
from sdaeverify import Claim, UsageError
from sdaeverify.measuring import Verdict

from .conftest import SHARP, WEAKER, registered, result

X, Y = Key("plain", "line", "sharp", "x"), Key("plain", "line", "sharp", "y")
UNBIASED = Claim(measure="sharp", value="unbiased", bound=0.01, source="made up")
FOUND = (result(Verdict.VERIFIED), result(Verdict.INCONCLUSIVE, quantity="y", claim=WEAKER))

BOTH = {X: Locked(order=1.0), Y: Locked(order=0.5)}


def lock_of(claim):
    return json.dumps({"schema_version": 2, "tiers": {"ci": {"plain": {"line": {"sharp": {"x": claim}}}}}})


def held(locked, *results):
    return compare(locked, outcomes(results, Policy()))


def test_what_is_locked():
    """Every claim that was put to the test is locked, verified or not, with a margin that is not the default."""
    wide = Claim(measure="sharp", value=1.0, margin=0.4, source="made up")

    assert found_claims(outcomes(FOUND, Policy())) == BOTH
    assert Locked.of(wide) == Locked(order=1.0, margin=0.4)
    assert Locked.of(replace(wide, value="round-off")) == Locked(words="round-off")


def test_claims_from_workers_are_written_as_claims_from_here():
    """Values that are defaults are left out, though a claim from another process has copies of them."""
    sent = pickle.loads(pickle.dumps(SHARP))

    assert lock_text({"ci": {X: Locked.of(sent)}}) == lock_text({"ci": {X: Locked(order=1.0)}})


def test_dropped_claim():
    """A claim that is locked and not found is a violation that names it."""
    violations, _ = held(BOTH, FOUND[0])

    assert violations == ("no longer tested: plain on line, sharp y: order >= 0.5",)


def test_a_claim_that_is_tested_on_another_problem():
    """Tier smoke tests a claim on one problem: where that is another one now, the violation names it."""
    (key,) = found_claims(outcomes(FOUND[:1], Policy()))
    violations, _ = compare({key._replace(problem="curve"): Locked(order=1.0)}, outcomes(FOUND[:1], Policy()))

    assert violations == ("no longer tested: plain on curve, sharp x: order >= 1.0; tested on line now",)


def test_undecided_claim_of_a_class():
    """A claim about a class whose premise fails is tested like one that is inconclusive: a note, and no violation."""
    undecided_row = result(Verdict.INCONCLUSIVE, quantity="order conditions", tier=CONDITIONS)
    key = X._replace(quantity="order conditions")

    undecided = undecided_claims([undecided_row])
    gated = outcomes([undecided_row], Policy())

    assert (gated, undecided) == ([], {key: Locked(order=1.0)})
    why = "a premise of the order conditions fails"
    assert compare({key: Locked(order=1.0)}, gated, undecided) == ((), (f"not decided: {key}: order >= 1.0: {why}",))
    assert compare({key: Locked(order=1.5)}, gated, undecided)[0] == (
        f"claim weakened: {key}: was order >= 1.5, is order >= 1.0",
    )
    assert compare({}, gated, undecided) == ((), ())
    assert undecided_claims([undecided_row, *FOUND]) == undecided


@pytest.mark.parametrize(
    ("claim", "locked", "weaker"),
    [
        (SHARP, Locked(order=1.0), False),
        (SHARP, Locked(order=0.5), False),
        (SHARP, Locked(order=1.5), True),
        (SHARP, Locked(order=1.0, margin=0.1), True),
        (SHARP, Locked(order=1.1, margin=0.3), False),
        (SHARP, Locked(words="round-off"), True),
        (UNBIASED, Locked(words="unbiased", within=0.01), False),
        (UNBIASED, Locked(words="unbiased", within=0.02), False),
        (UNBIASED, Locked(words="unbiased", within=0.005), True),
        (UNBIASED, Locked(words="exact", within=0.02), True),
        (UNBIASED, Locked(order=1.0), True),
    ],
)
def test_changed_claim(claim, locked, weaker):
    """What has become weaker, or says another thing, is a violation; what says more is a note."""
    violations, notes = held({X: locked}, result(Verdict.VERIFIED, claim=claim))

    assert bool(violations) is weaker
    assert bool(notes) is (not weaker and locked != Locked.of(claim))


def test_new_claims():
    """What is not locked is a note."""
    _, (note,) = held({}, *FOUND)

    assert note == "not in the lock file: plain on line, sharp x and 1 more; --write-lock adds what is new"


@pytest.mark.parametrize("verdict", [Verdict.ERROR, Verdict.REFUTED])
def test_cell_without_quantities(verdict):
    """A cell that could not be measured, or breaks the contract, fails by itself and is not missed as well."""
    assert held(BOTH, result(verdict, quantity=""))[0] == ()


def test_a_quantity_that_could_not_be_measured_is_not_missed_as_well():
    """It has an outcome of its own, without the claim, and other claims of the cell are missed."""
    violations, _ = held(BOTH, result(Verdict.ERROR, quantity="x"))

    assert violations == ("no longer tested: plain on line, sharp y: order >= 0.5",)


@pytest.mark.parametrize(("found", "why"), [((), "no claim was tested"), ((Verdict.ERROR,), "not measured: 1")])
def test_a_lock_file_is_not_written_without_what_it_locks(tmp_path, found, why):
    """Claims that were locked before would be lost."""
    policy = Policy(file=tmp_path / "pyproject.toml", lock="my.lock", tier="ci")

    told = write_lock(policy, tuple(outcomes(map(result, found), policy)))

    assert told == [f"the lock file {tmp_path / 'my.lock'} is not written: {why}"]
    assert not (tmp_path / "my.lock").exists()


def test_a_lock_file_that_a_policy_names_has_to_exist(tmp_path):
    """The default file need not; a folder in its place is told in the words of the system."""
    default, named = (Policy(file=tmp_path / "pyproject.toml", lock=lock) for lock in ("", "my.lock"))

    assert locked_tiers(default) is None
    with pytest.raises(UsageError, match=r"there is no lock file .*, though the policy names it"):
        locked_tiers(named)
    for policy in (default, named):
        policy.lock_file.write_text(lock_text({"ci": BOTH}))
        assert locked_tiers(policy) == {"ci": BOTH}
    named.lock_file.unlink()
    named.lock_file.mkdir()
    with pytest.raises(UsageError, match=r"cannot read the lock file .*: Is a directory"):
        locked_tiers(named)


def test_a_narrowed_gate_has_to_find_the_claims_of_its_selection():
    """Scheme, problem and measure are selected; a gate that is not narrowed has to find all claims."""
    policy = Policy(schemes=("plain",), problems=("line",), measures=("sharp",))
    others = [X._replace(**{kind: name}) for kind, name in (("scheme", "fussy"), ("problem", "added"))]
    locked = dict.fromkeys([X, Y, *others, X._replace(measure="blunt")], Locked(order=1.0))

    assert restrict(locked, registered(), policy, narrowed=False) == locked
    assert [*restrict(locked, registered(), policy, narrowed=True)] == [X, Y]


def test_what_breaks_a_contract_stays_locked(tmp_path):
    """The claims of a cell that is refuted as a whole are not unlocked; those of others are what is found."""
    policy = Policy(file=tmp_path / "pyproject.toml", lock="my.lock", tier="ci")
    write_lock(policy, tuple(outcomes(FOUND, policy)))

    told = write_lock(policy, tuple(outcomes([result(Verdict.REFUTED, quantity="")], policy)))

    assert told == [f"{tmp_path / 'my.lock'} locks 2 claims of tier ci"]
    assert read_lock(policy.lock_file) == {"ci": BOTH}
    assert "unlocked: no longer tested" in write_lock(policy, tuple(outcomes(FOUND[:1], policy)))[1]


def test_file(tmp_path):
    """What is written can be read; the order of the claims does not matter and each has a line of its own."""
    file = tmp_path / "my.lock"
    locked = BOTH
    file.write_text(lock_text({"ci": locked, "smoke": {}}))

    assert read_lock(file) == {"ci": locked}
    assert lock_text({"ci": dict(reversed(locked.items()))}) == file.read_text()
    assert '"x": {"order": 1.0},\n' in file.read_text()


@pytest.mark.parametrize(
    "claim",
    [
        *(Claim(measure="sharp", value=value, source="made up") for value in ("A-stable", "round-off", "orderly")),
        *(Claim(measure="sharp", value=value, margin=1e-9, source="made up") for value in (1e-6, 2, 3.5e17)),
        Claim(measure="sharp", value=np.float64(1.0), margin=np.float64(0.3), source="made up"),
        Claim(measure="sharp", value=2, margin=0.25, source="made up"),
        *(Claim(measure="sharp", value="unbiased", bound=b, source="made up") for b in (1e-7, 2, np.float64(0.1))),
    ],
    ids=lambda claim: str(Locked.of(claim)),
)
def test_every_claim_can_be_read_again(tmp_path, claim):
    """Whatever words or numbers a claim has, what is written of it is no damage, and nothing has become weaker."""
    file = tmp_path / "my.lock"
    file.write_text(lock_text({"ci": {X: Locked.of(claim)}}))

    assert held(read_lock(file)["ci"], result(Verdict.VERIFIED, claim=claim)) == held({})


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("{", "is not a lock file of version 2: .*; if it should be one, remove it and write a new one"),
        ("[" * 100_000, "is not a lock file of version 2: .*; if it should be one, remove it and write a new one"),
        (json.dumps({"schema_version": 1, "tiers": {}}), "Invalid enum value 1 - at `$.schema_version`"),
        *((lock_of(claim), "Expected `object`, got") for claim in (5, None, True, "order >= 1.0", [1.0])),
        *((lock_of(claim), "has either an order or words") for claim in ({}, {"order": 1.0, "words": "round-off"})),
        (lock_of({"order": 1.0, "margin": -1.0}), "Expected `float` > 0.0"),
        (lock_of({"ordre": 1.0}), "unknown field `ordre`"),
    ],
)
def test_damaged_file(tmp_path, text, message):
    """A file that is no lock file is an error in one line."""
    file = tmp_path / "my.lock"
    file.write_text(text)

    with pytest.raises(UsageError, match=message.replace("$", r"\$").replace("|", r"\|")):
        read_lock(file)
