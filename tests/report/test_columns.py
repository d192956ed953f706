"""The dictionary of columns: each column of the committed tables is in it, with one meaning."""

import csv
from collections import Counter
from pathlib import Path

import pandas as pd
import pytest

from facade import MEAN, VERDICTS, dictionary, load_registry, names, select_measures

REFERENCE = Path(__file__).resolve().parents[2] / "reports" / "reference"
FILES = [file.relative_to(REFERENCE).as_posix() for file in REFERENCE.rglob("*.csv") if file.name != "columns.csv"]


@pytest.fixture(scope="module")
def known():
    """Return the dictionary of everything that is shipped."""
    return list(dictionary(select_measures(load_registry(environ={}), ())))


@pytest.mark.parametrize("file", FILES)
def test_each_column_of_the_committed_tables_is_told(known, file):
    """By its name, or as the mean of a cost that schemes report."""
    told = {row["column"] for row in known if row["file"] == file}
    with (REFERENCE / file).open(newline="") as table:
        columns = next(csv.reader(table))
    left = {name for name in columns if name not in told}
    assert {name for name in left if not (f"{MEAN}*" in told and name.startswith(MEAN))} == set()


def test_a_column_has_one_meaning(known):
    """No file has a column twice, each is explained, and what two measures tell of levels is the same thing."""
    assert max(Counter((row["file"], row["column"]) for row in known).values()) == 1
    assert all(row["meaning"] for row in known)
    meanings = {}
    for measure in select_measures(load_registry(environ={}), ()):
        for name, meaning in measure.level_columns.items():
            meanings.setdefault(name, set()).add(meaning)
    assert {name: told for name, told in meanings.items() if len(told) > 1} == {}


def test_the_verdicts_are_one_small_table():
    """At most 26 columns and 1.5 MB, no more and no fewer than the dictionary has; read without a warning."""
    file = REFERENCE / "verdicts.csv"
    table = pd.read_csv(file)
    assert tuple(table.columns) == names(VERDICTS)
    assert len(names(VERDICTS)) <= 26
    assert file.stat().st_size <= 1_500_000
