"""Runs into one folder: rows of cells that a run is not about stay as they are."""

import csv
import json
from pathlib import Path

import pandas as pd
import pytest
from sdaeverify.report.earlier import read_runs, save_tables

from sdaeverify.report.files import csv_text
from sdaeverify.report.folders import SCHEMA

COLUMNS = ("scheme", "problem", "measure", "quantity", "run", "seed", "reason")
CODE = {"framework": "1", "schemes": {"a": "x", "b": "y", "=c": "z"}, "problems": {"p": "u", "q": "v"}}


def run(*cells, seed=1, **code):
    """Return what is told of a run on some cells."""
    kinds = zip(("schemes", "problems", "measures"), zip(*cells, strict=True), strict=True)
    selection = {kind: sorted({*labels}) for kind, labels in kinds}
    known = {kind: {x: d for x, d in CODE[kind].items() if x in selection[kind]} for kind in ("schemes", "problems")}
    return {
        "schema_version": SCHEMA,
        "seed": seed,
        "selection": selection,
        "code": {"framework": "1", **known, **code},
    }


def saved(folder, *cells, seed=1, reason="", further=(), **code):
    """Save a run on some cells, with a row for each."""
    rows = [(*cell, "x", 0, seed, reason) for cell in cells]
    verdicts = pd.DataFrame(rows, columns=COLUMNS).assign(**dict.fromkeys(further, 0.25))
    levels = verdicts.drop(columns="run").assign(h=0.1)
    tables = {"verdicts.csv": verdicts, "levels.csv": levels}
    tables |= {f"details/{name}.csv": levels[levels["measure"] == name] for name in levels["measure"].unique()}
    return save_tables(folder, tables, run(*cells, seed=seed, **code), set(cells))


def told(folder, name="verdicts.csv"):
    """Return the cells and seeds of a table, in its order."""
    with (folder / name).open(newline="") as file:
        return [(row["scheme"], row["problem"], row["measure"], int(row["seed"])) for row in csv.DictReader(file)]


A, B, C = ("a", "p", "m"), ("b", "p", "m"), ("a", "q", "m")


def test_rows_of_another_selection_stay(tmp_path):
    """Rows stay in all tables, and each names the run that it is of, which run.json tells of."""
    saved(tmp_path, A, seed=1)
    kept = saved(tmp_path, B, seed=2)
    saved(tmp_path, C, seed=3)

    for name in ("verdicts.csv", "levels.csv", "details/m.csv"):
        assert told(tmp_path, name) == [(*C, 3), (*B, 2), (*A, 1)]
    assert [one["seed"] for one in read_runs(tmp_path)] == [3, 2, 1]
    with (tmp_path / "verdicts.csv").open(newline="") as file:
        assert [int(row["seed"]) + int(row["run"]) for row in csv.DictReader(file)] == [3, 3, 3]
    assert (kept.verdicts, kept.changed) == (1, 0)


def test_rows_of_the_same_cells_are_replaced(tmp_path):
    """Of a cell that is run again there is one row, and nothing more is told of the earlier run."""
    saved(tmp_path, A, B, seed=1)
    saved(tmp_path, A, B, seed=2)

    assert told(tmp_path) == [(*A, 2), (*B, 2)]
    assert [one["seed"] for one in read_runs(tmp_path)] == [2]


def test_a_run_that_is_saved_again_and_again(tmp_path):
    """While a run is under way its tables are written many times, with the same earlier rows."""
    saved(tmp_path, A, seed=1, reason='a "reason", in two parts')
    for _ in range(3):
        saved(tmp_path, B, seed=2)

    assert told(tmp_path) == [(*B, 2), (*A, 1)]
    assert 'a ""reason"", in two parts' in (tmp_path / "verdicts.csv").read_text()


@pytest.mark.parametrize(
    "code",
    [{"framework": "2"}, {"schemes": {"a": "other"}}, {"problems": {"p": "other", "q": "v"}}],
    ids=["framework", "scheme", "problem"],
)
def test_rows_of_other_code_are_left_out(tmp_path, code):
    """What is told of a version of a scheme or problem that is no more is not kept, and counted."""
    saved(tmp_path, A, seed=1)

    kept = saved(tmp_path, C, seed=2, **code)

    assert (told(tmp_path), kept.changed) == ([(*C, 2)], 1)


def test_columns_of_either_run(tmp_path):
    """Rows lie below the columns they have; those of one run alone are empty in the other's rows."""
    saved(tmp_path, A, further=("old",))
    saved(tmp_path, B, further=("new",))

    with (tmp_path / "verdicts.csv").open(newline="") as file:
        rows = [(row["scheme"], row["old"], row["new"]) for row in csv.DictReader(file)]
    assert rows == [("b", "", "0.25"), ("a", "0.25", "")]


def test_labels_that_a_spreadsheet_would_evaluate(tmp_path):
    """A label that is written with an apostrophe is the same label."""
    saved(tmp_path, ("=c", "p", "m"), seed=1)
    saved(tmp_path, ("=c", "p", "m"), seed=2)
    saved(tmp_path, A, seed=3)

    assert told(tmp_path) == [(*A, 3), ("'=c", "p", "m", 2)]


def test_details_of_a_measure_that_is_gone(tmp_path):
    """Where no row of a measure is left, its file is gone, too; that of another measure stays with its rows."""
    saved(tmp_path, A, ("a", "p", "n"))
    saved(tmp_path, A, framework="2")

    assert [file.name for file in (tmp_path / "details").iterdir()] == ["m.csv"]


def test_rows_in_another_format(tmp_path):
    """What another version of the program has left is moved aside as it is: its columns mean something else."""
    saved(tmp_path, A)
    for name in ("report.html", "columns.csv", "levels.parquet", "gate.json"):
        (tmp_path / name).write_text(name)
    run_file = tmp_path / "run.json"
    run_file.write_text(json.dumps({**json.loads(run_file.read_text()), "schema_version": 1}))

    before = {file.relative_to(tmp_path): file.read_bytes() for file in tmp_path.rglob("*") if file.is_file()}
    gate = before.pop(Path("gate.json"))

    kept = saved(tmp_path, B)

    aside = tmp_path / "other-version-1"
    assert kept.aside == aside
    assert {file.relative_to(aside): file.read_bytes() for file in aside.rglob("*") if file.is_file()} == before
    assert told(tmp_path) == [(*B, 1)]
    assert (tmp_path / "gate.json").read_bytes() == gate
    assert saved(tmp_path, A).aside is None
    assert told(tmp_path) == [(*A, 1), (*B, 1)]


def test_formats_of_several_versions(tmp_path):
    """Each is moved into a folder of its own; what was moved before stays."""
    for version in (1, 99):
        saved(tmp_path, A, seed=version)
        run_file = tmp_path / "run.json"
        run_file.write_text(json.dumps({**json.loads(run_file.read_text()), "schema_version": version}))

    saved(tmp_path, B)

    assert [told(tmp_path / f"other-version-{n}") for n in (1, 2)] == [[(*A, 1)], [(*A, 99)]]


@pytest.mark.parametrize("damage", ["", "{", "[]", '{"selection": 3}', '{"selection": {}}', "[" * 100_000])
def test_a_folder_that_does_not_tell_of_a_run(tmp_path, damage):
    """Rows that no run tells of are nobody's: the tables are those of the run, to the byte."""
    saved(tmp_path, A)
    (tmp_path / "run.json").write_text(damage)

    saved(tmp_path, B)

    assert told(tmp_path) == [(*B, 1)]
    assert (tmp_path / "verdicts.csv").read_text() == csv_text(pd.DataFrame([(*B, "x", 0, 1, "")], columns=COLUMNS))
    assert "earlier" not in json.loads((tmp_path / "run.json").read_text())


@pytest.mark.parametrize(
    "damage", [b"", b"scheme,problem\n1,2\n", b'scheme,problem,measure\n"a', b"\xff\xfe", b"a" * 999]
)
def test_tables_that_are_damaged(tmp_path, damage):
    """What is no table has no rows, and is replaced."""
    saved(tmp_path, A)
    (tmp_path / "verdicts.csv").write_bytes(damage)

    saved(tmp_path, B)

    assert told(tmp_path) == [(*B, 1)]
