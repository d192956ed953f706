"""The sense of a claim in a lock file: left out where it is in mean square, and part of what is compared."""

from facade import Key, Locked, lock_text, read_lock
from sdaeverify import Claim

MEAN_SQUARE = Claim(measure="strong", value=1.0, source="test")
IN_PROBABILITY = Claim(measure="strong", value=1.0, source="test", sense="in probability")
KEY = Key("milstein", "gbm", "strong", "x")


def test_a_lock_file_of_claims_in_mean_square_does_not_name_the_sense(tmp_path):
    """It reads as it did before claims had one."""
    text = lock_text({"ci": {KEY: Locked.of(MEAN_SQUARE)}})
    (tmp_path / "lock").write_text(text)

    assert '{"order": 1.0}' in text
    assert read_lock(tmp_path / "lock") == {"ci": {KEY: Locked.of(MEAN_SQUARE)}}


def test_a_claim_in_probability_is_locked_as_such(tmp_path):
    """It is read again, and shown with its sense."""
    locked = Locked.of(IN_PROBABILITY)
    (tmp_path / "lock").write_text(lock_text({"ci": {KEY: locked}}))

    assert read_lock(tmp_path / "lock") == {"ci": {KEY: locked}}
    assert str(locked) == str(IN_PROBABILITY) == "order >= 1.0 in probability"


def test_a_claim_in_mean_square_implies_one_in_probability_and_not_the_other_way_round():
    """So a sense that is weakened is a violation of the lock, and one that is strengthened a note."""
    strong, weak = Locked.of(MEAN_SQUARE), Locked.of(IN_PROBABILITY)

    assert strong.implies(weak)
    assert not weak.implies(strong)
    assert weak.implies(weak)
