"""Pages of the programs about the verifier: the self-test, the calibration, a comparison, a history."""

from pathlib import Path

import pytest

from browser import browser, needs_chromium
from report.rows import level, tables, verdict
from sdaeverify.cli.commands.history import history_series, history_tables
from sdaeverify.report.html import TablePage, verifier, write_tables

REPORTS = Path(__file__).resolve().parents[2] / "reports"


@pytest.fixture
def runs():
    """Return two runs: a verdict has changed, one error has made a step and another one has not."""
    before = tables([verdict()], [level(), level(quantity="y")], folder=Path("old"))
    after = tables(
        [verdict(verdict="refuted")],
        [level(estimate="0.02"), level(quantity="y", estimate="0.0105")],
        folder=Path("new"),
    )
    return [before, after]


def test_what_changed_between_runs_is_told(runs):
    """Counts of each run, the verdicts that changed, and the errors that differ by more than chance explains."""
    told, changed, steps = history_tables(runs)
    assert [row[0] for row in told.rows] == ["old", "new"]
    assert changed.rows == [("old", "new", "some-euler", "gbm", "strong", "x", "verified", "refuted")]
    assert steps.rows == [("old", "new", "some-euler", "gbm", "strong", "x", 0.01, 0.02, 2.0)]


def test_a_run_beside_itself_shows_nothing(runs):
    """The same numbers make no step."""
    _, changed, steps = history_tables([runs[0], runs[0]])
    assert (changed.rows, steps.rows) == ([], [])
    assert "None." in changed.text


def test_the_history_of_folders_is_a_page(call):
    """The command writes it and says what is on it; one folder is no history."""
    folder = str(REPORTS / "reference")
    outcome = call("history", folder, folder, "--out", "page/history.html")
    assert outcome.code == 0
    assert "2 runs, 0 verdicts changed, 0 errors made a step" in outcome.out
    assert Path("page/history.html").is_file()
    assert call("history", folder).err == "sdaeverify: error: history needs two runs or more\n"


def test_reports_beside_a_run_are_on_its_page():
    """The committed calibration is found, a self-test that was not run is not."""
    found = verifier(REPORTS)
    assert {*found} == {"calibration"}
    assert {"study", "case", "rate", "ci_low", "ci_high"} <= {*found["calibration"][0]}
    assert verifier(Path("nowhere")) == {}


def test_the_pictures_have_the_numbers_of_the_tables(runs):
    """Counts of each verdict run by run; the errors that made a step, marked where the step led to."""
    drawn = history_series(runs)
    assert drawn["counts"] == {"refuted": [0, 1], "verified": [1, 0]}
    assert drawn["errors"] == [{"name": "some-euler on gbm, strong x", "values": [0.01, 0.02], "steps": [0, 1]}]


@needs_chromium
def test_a_history_is_drawn(runs, tmp_path):
    """A mark for each count and each error, a hollow one where a step is significant."""
    write_tables(tmp_path / "p.html", "one step", history_tables(runs), history=history_series(runs))
    with browser() as page:
        page.look()
        page.open(tmp_path / "p.html")
        marks = "[...document.querySelectorAll('main svg circle')].map(c => [+c.dataset.h, +c.dataset.e])"
        assert sorted(page.run(marks)) == [[1, 0], [1, 1], [1, 1], [2, 0], [2, 1], [2, 2]]
        assert page.run("document.querySelectorAll('main circle.hollow').length") == 1
        page.photograph(tmp_path / "history.png")
        assert not page.complaints


@needs_chromium
def test_tables_and_rates_are_shown_without_complaint(tmp_path):
    """A page of tables alone, with the rates of a calibration and a kill matrix; hostile cells are texts."""
    kills = {"head": ["bug", "strong T1"], "rows": [["<img src=x>", "1"]]}
    pages = [TablePage("Comparison", ("scheme", "factor"), [("<script>alert(1)</script>", 1.5)])]
    write_tables(tmp_path / "p.html", "one change", pages, verifier={**verifier(REPORTS), "kills": kills})
    with browser() as page:
        page.look()
        page.open(tmp_path / "p.html")
        assert "planted bugs" in page.run("document.querySelector('main').innerText").lower()
        assert page.run("document.querySelectorAll('main circle').length") > 100
        page.go("#/table/0")
        assert "<script>alert(1)</script>" in page.run("document.querySelector('main').innerText")
        assert page.run("document.querySelectorAll('main script, main img').length") == 0
        assert not page.complaints
        page.photograph(tmp_path / "verifier.png")
