"""What is locked, and what is held against it."""

import json
from dataclasses import replace

import numpy as np
import pytest

from facade import Key, Locked, Policy, compare, found_claims, lock_text, outcomes, read_lock, write_lock
from sdaeverify import Claim, UsageError
from sdaeverify.measuring import Verdict

from .conftest import SHARP, WEAKER, result

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


def test_dropped_claim():
    """A claim that is locked and not found is a violation that names it."""
    violations, _ = held(BOTH, FOUND[0])

    assert violations == ("no longer tested: plain on line, sharp y: order >= 0.5",)


def test_a_claim_that_is_tested_on_another_problem():
    """Tier smoke tests a claim on one problem: where that is another one now, the violation names it."""
    (key,) = found_claims(outcomes(FOUND[:1], Policy()))
    violations, _ = compare({key._replace(problem="curve"): Locked(order=1.0)}, outcomes(FOUND[:1], Policy()))

    assert violations == ("no longer tested: plain on curve, sharp x: order >= 1.0; tested on line now",)


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
        ("{", "is no lock file of version 2: .*; if it should be one, remove it and write a new one"),
        ("[" * 100_000, "is no lock file of version 2: .*; if it should be one, remove it and write a new one"),
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
