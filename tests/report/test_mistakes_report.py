"""The kept report on one-line mistakes: each is still one, and no sentence about any is wrong."""

import csv
import importlib.util
from pathlib import Path

import pytest

FOLDER = Path(__file__).parents[2] / "reports" / "mistakes"


def program():
    """Return the program of the report."""
    spec = importlib.util.spec_from_file_location("mistakes_report", FOLDER / "run.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


PROGRAM = program()
PLANTED = {(each.scheme, each.mistake): each for each in PROGRAM.planted()}


@pytest.fixture(scope="module")
def rows():
    """Return the rows of the kept table."""
    with (FOLDER / "sentences.csv").open(newline="") as table:
        return list(csv.DictReader(table))


def test_no_sentence_is_wrong(rows):
    """Each sentence is right by the label of its mistake, and at least thirty mistakes are named."""
    told = [row for row in rows if row["sentence"]]
    outcomes = {PLANTED[row["scheme"], row["mistake"]].outcome(row["sentence"]) for row in told}

    assert outcomes == {row["outcome"] for row in told} == {"right"}
    assert {(row["scheme"], row["mistake"]) for row in rows} == {*PLANTED}
    assert len({(row["scheme"], row["mistake"]) for row in told}) >= 30


@pytest.mark.parametrize("key", PLANTED, ids=" ".join)
def test_each_mistake_is_in_the_file_of_its_scheme(key):
    """The text that it replaces is still there, and the wrong scheme has the parameters of the right one."""
    assert type(PLANTED[key].build()).__name__ == key[0]


@pytest.mark.long
@pytest.mark.parametrize(
    "key", [("BAOAB", "half the friction"), ("EulerMaruyama", "a further drift x")], ids=" ".join
)
def test_the_program_says_the_same_again(rows, key):
    """What is said of two of the mistakes is what the table has."""
    kept = {row["sentence"]: row["where"] for row in rows if (row["scheme"], row["mistake"]) == key}
    found = PROGRAM.sentences(PLANTED[key].build())

    assert (found or {"": []}) == {text: where.split(", ") if where else [] for text, where in kept.items()}
