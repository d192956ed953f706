"""A result comes back from its folder and out of a pickle, is short at a prompt, and goes into other libraries."""

import json
import logging
import pickle
import sys

import numpy as np
import pandas as pd
import pytest

from sdaeverify import SDE, Claim, Scheme, Step, UsageError, load, sample, verify
from sdaeverify.numerics import apply
from sdaeverify.report.tables.datasets import dataset_of_levels
from sdaeverify.report.tables.rows import table_of

SMALL = {"paths": 200, "levels": 3}


class Counting(Scheme):
    """Euler-Maruyama that counts under a name which is no identifier."""

    name = "counting"
    form = SDE
    claims = (Claim(measure="strong", value=0.5, source="test"),)

    def step(self, problem, state, t, h, noise):
        new = state + h * problem.drift(t, state) + apply(problem.diffusion(t, state), noise.dW)
        return Step(new, costs={"2 calls/step": 1.0 + 0.0 * new[0]})


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """Return a small result, and the folder that it is saved in."""
    folder = tmp_path_factory.mktemp("run")
    result = verify(["milstein", Counting()], ["gbm", "circle"], ["strong", "drift"], **SMALL)
    result.save(folder)
    return result, folder


def bare(table):
    """Return a table in which nothing stands for what is empty: a file does not tell no text from an empty one."""
    known = table.astype(object)
    return known.where(table.notna() & (known != ""), None)


def assert_same(result, other):
    """Check that two results have the same tables, rows and settings."""
    assert other.settings == result.settings
    assert json.dumps(other.run) == json.dumps(result.run)
    assert {*result.tables} == {*other.tables} - {"details/classes.csv"}
    assert [str(row) for row in other.rows.verdicts] == [str(row) for row in result.rows.verdicts]
    kept = other.tables["verdicts.csv"]
    of_problems = kept[~kept["problem"].str.startswith("every-equation")]
    pd.testing.assert_frame_equal(bare(of_problems), bare(result.tables["verdicts.csv"]))
    for name, table in result.tables.items():
        if name == "verdicts.csv":
            continue
        pd.testing.assert_frame_equal(bare(other.tables[name]), bare(table), obj=name)


def test_a_result_comes_back_from_its_folder(made):
    """What is loaded has the tables that were saved, value by value, and can be asked all that does not run again."""
    result, folder = made
    loaded = load(folder)

    assert_same(result, loaded)
    pd.testing.assert_frame_equal(loaded.classes, result.classes, check_dtype=False)
    assert loaded.command("milstein", "gbm", "strong") == result.command("milstein", "gbm", "strong")
    assert repr(loaded.cell("milstein", "gbm")) == repr(result.cell("milstein", "gbm"))


def test_a_loaded_result_is_saved_as_it_was(made, tmp_path):
    """To load and to save again changes no byte of a table."""
    _, folder = made
    load(folder).save(tmp_path)

    for file in folder.rglob("*.csv"):
        assert (tmp_path / file.relative_to(folder)).read_bytes() == file.read_bytes()


def test_a_result_pickles(made):
    """Tables go through a pickle, even of schemes that no other process could import."""
    result, _ = made
    assert_same(result, pickle.loads(pickle.dumps(result)))


@pytest.mark.parametrize(
    ("odd", "message"),
    [
        (3, "load expects a folder, got 3"),
        ("", "load expects a folder, got ''"),
        ("nowhere", "nowhere holds no run: cannot read verdicts.csv"),
    ],
)
def test_no_folder_of_a_run(odd, message):
    """One line says what was expected."""
    with pytest.raises(UsageError, match=message):
        load(odd)


def test_a_verdict_that_is_none(made, tmp_path):
    """A table that somebody has changed is not read as if nothing were the matter."""
    _, folder = made
    load(folder).save(tmp_path)
    file = tmp_path / "verdicts.csv"
    file.write_text(file.read_text().replace(",verified,", ",true,").replace(",inconclusive,", ",true,"))

    with pytest.raises(UsageError, match="has a verdict that is none: 'true'"):
        load(tmp_path)


def test_verdicts_are_ordered(made):
    """The worst comes first, so that a comparison selects what needs attention."""
    verdicts = made[0].verdicts.verdict

    assert list(verdicts.cat.categories[:3]) == ["refuted", "diverged", "error"]
    assert (verdicts >= "verified").sum() == verdicts.isin(["verified", "out_of_scope"]).sum() > 0


def test_columns_are_identifiers(made):
    """Each column of each table is an attribute, those included that plugins name."""
    tables = made[0].tables

    assert [name for table in tables.values() for name in table.columns if not name.isidentifier()] == []
    assert "mean_2_calls_step" in tables["levels.csv"]


def test_representations_are_short(made):
    """A result, its pictures and paths are a few lines at a prompt."""
    paths = sample("milstein", "gbm", steps=8, paths=3)
    told = [repr(made[0]), repr(made[0].plot), repr(paths)]

    assert all(2 <= len(text.splitlines()) <= 6 for text in told)
    assert all(len(line) <= 120 for text in told for line in text.splitlines())
    assert "3 paths of milstein on gbm" in told[2]
    assert "8 steps to t = 1" in told[2]


@pytest.mark.long
def test_results_and_paths_as_datasets(made):
    """Each level is selected by the names of its quantity and its step size; a component has time, index and path."""
    pytest.importorskip("xarray", reason="needs the extra xarray")
    result, paths = made[0], sample("milstein", "gbm", steps=8, paths=3)
    found, own = result.to_xarray(), paths.to_xarray()

    names = ["scheme", "problem", "measure", "quantity"]
    assert found.sizes["row"] == len(result.verdicts)
    for level in result.levels.to_dict("records"):
        told = found.estimate.sel({**{name: level[name] for name in names}, "h": level["h"]})
        assert level["estimate"] in np.atleast_1d(told.to_numpy())
    assert int((~np.isnan(found.estimate)).sum()) == result.levels.estimate.notna().sum()
    of_one = found.sel(scheme="milstein", problem="gbm")
    assert (
        0 < of_one.verdict.size == (result.verdicts[["scheme", "problem"]] == ["milstein", "gbm"]).all(axis=1).sum()
    )
    assert own.x.dims == ("time", "x_index", "path")
    assert (own.x.to_numpy() == paths["x"]).all()


def test_densities_have_a_dimension_of_their_own():
    """Several rows of one quantity at one step size are points: none of them is lost."""
    pytest.importorskip("xarray", reason="needs the extra xarray")
    names = {"scheme": "a", "problem": "b", "measure": "invariant", "quantity": "density"}
    levels = pd.DataFrame([{**names, "h": 0.5, "estimate": each} for each in (1.0, 2.0, 3.0)])
    found = dataset_of_levels(pd.DataFrame([{**names, "verdict": "verified"}]), levels)

    assert found.estimate.sel(scheme="a", h=0.5).to_numpy().ravel().tolist() == [1.0, 2.0, 3.0]


def test_no_column_is_an_object_because_a_row_is_empty(made):
    """Whole numbers and truth values are of a nullable type."""
    table = table_of([{"seen": True, "count": 1}, {"seen": None, "count": None}])

    assert [str(kind) for kind in table.dtypes] == ["boolean", "Int64"]
    assert "boolean" in map(str, made[0].levels.dtypes)
    assert "object" not in map(str, made[0].levels.dtypes)


def test_without_xarray(made, monkeypatch):
    """Who lacks it is told what to install, in one line."""
    monkeypatch.setitem(sys.modules, "xarray", None)

    for thing in (made[0], sample("milstein", "gbm", steps=8, paths=3)):
        with pytest.raises(UsageError, match=r"to_xarray needs xarray: pip install 'sdaeverify\[xarray\]'"):
            thing.to_xarray()


def test_a_run_logs(caplog):
    """Whoever sets a level of the logger hears of each problem; else nothing is said."""
    with caplog.at_level(logging.INFO, logger="sdaeverify"):
        verify("milstein", "gbm", "strong", **SMALL)

    assert [each.getMessage() for each in caplog.records][-1] == "gbm is finished: 1 cells"
    assert any(isinstance(handler, logging.NullHandler) for handler in logging.getLogger("sdaeverify").handlers)
