"""Every reason of the reference run and of the field is a sentence in the words of the field, with its number."""

import csv
import re
from collections.abc import Sequence
from pathlib import Path

import pytest

REPORTS = Path(__file__).resolve().parents[2] / "reports"
REFERENCE = REPORTS / "reference"
FIELD = sorted(file.parent for file in (REPORTS / "field").glob("*/verdicts.csv"))
LONGEST = 160
# Words of the engine's own, which nobody else knows.
OWN = re.compile(
    r"\b(p1|p2|q1|q2|rho|guard\w*|tells?|told|seen|so many|lanes?|clouds?|tall(y|ies)|opinions?|functionals?|nodes"
    r"|atoms|defects?|void|suspect|unlike|undecided|uninformative|half of it|notebook|stop(ped)? early|per cent"
    r"|a SDE|a IndexOneSDAE|an [b-df-hj-np-tv-z][a-z]+)\b"
)
# A reason of these kinds has no number: nothing is claimed, or nothing was measured.
WITHOUT_NUMBER = re.compile(
    r"^(No claim about|The scheme has a claim about|The step cannot be probed|Steps of a run differ"
    r"|Steps depend on memory)"
)


def reasons(table: str, folders: Sequence[Path] = (REFERENCE, *FIELD)) -> list[dict[str, str]]:
    """Return the rows of a table of some runs, each reason once."""
    found = dict[str, dict[str, str]]()
    for folder in folders:
        with (folder / f"{table}.csv").open(newline="", encoding="utf-8") as file:
            found.update((row["reason"], row) for row in csv.DictReader(file))
    return list(found.values())


def test_the_field_has_runs() -> None:
    """Solvers of other libraries have folders of their own."""
    assert len(FIELD) >= 5


@pytest.mark.parametrize("table", ["verdicts", "not_applicable"])
def test_a_reason_is_short_and_in_the_words_of_the_field(table: str) -> None:
    """None is longer than a line of a letter, none has a word of the engine's own, none is empty."""
    rows = reasons(table)

    assert len(rows) > 50
    assert {row["reason"] for row in rows if not 0 < len(row["reason"]) <= LONGEST} == set()
    assert {row["reason"] for row in rows if OWN.search(row["reason"])} == set()


def test_a_reason_of_a_verdict_is_a_sentence() -> None:
    """It begins with a capital, ends with a full stop, and has the number that decided, if something was measured."""
    found = {row["reason"] for row in reasons("verdicts")}

    assert {text for text in found if not re.match(r"[A-Z].*[.?]$", text)} == set()
    assert {text for text in found if not (re.search(r"\d", text) or WITHOUT_NUMBER.match(text))} == set()


def test_what_is_verified_says_from_where_on() -> None:
    """An order that is verified stands beside the least one that is accepted."""
    verified = (row for row in reasons("verdicts") if row["verdict"] == "verified" and row["claimed_order"])
    # Order conditions hold or do not: they have no tolerance.
    rows = [row for row in verified if row["decided_by"] != "TA"]
    exact = re.compile("round-off|no bias beyond|order .* holds", re.IGNORECASE)

    assert len(rows) > 300
    asked = {row["reason"] for row in rows if "error ~ h^" not in row["reason"].lower()}
    told = re.compile("accepted from|one-step tolerance|margin")
    assert {text for text in asked if not (told.search(text) or exact.search(text))} == set()


def test_nothing_is_verified_whose_paths_lie_below_what_is_accepted() -> None:
    """Where the interval along paths lies wholly below the claim less its margin, a verdict is left open."""
    with (REFERENCE / "verdicts.csv").open(newline="", encoding="utf-8") as file:
        rows = [row for row in csv.DictReader(file) if row["path_high"] and row["claimed_order"]]
    verified = [row for row in rows if row["verdict"] == "verified"]

    assert len(verified) > 500
    below = [r for r in verified if float(r["path_high"]) < float(r["claimed_order"]) - float(r["margin"])]
    assert below == []
