"""Pages of the programs about the verifier: the self-test, the calibration, a comparison, a history."""

from pathlib import Path
from shutil import copytree

import pytest

from browser import browser, needs_chromium
from report.rows import level, tables, verdict, weak
from sdaeverify.cli.commands.history import history_series, history_tables
from sdaeverify.report.html import TablePage, verifier, write_tables

REPORTS = Path(__file__).resolve().parents[2] / "reports"


@pytest.fixture
def runs():
    """Return two runs: a verdict, an order and a constant have changed, those of another quantity have not."""
    still = verdict(quantity="y", local_order="", path_order="1.0", path_low="0.9", path_high="1.1")
    before = tables([verdict(), still], [level(), level(quantity="y")], folder=Path("old"))
    changed = verdict(verdict="refuted", path_order="0.2", path_low="0.15", path_high="0.25")
    after = tables(
        [changed, {**still, "path_order": "1.05"}],
        [level(estimate="0.02"), level(quantity="y", estimate="0.0105")],
        folder=Path("new"),
    )
    return [before, after]


CELL = ("some-euler", "gbm", "strong", "x")


def test_what_changed_between_runs_is_told(runs):
    """Counts of each run, verdicts that changed, and orders and constants apart that chance does not explain."""
    told, changed, orders, constants = history_tables(runs)
    assert [row[0] for row in told.rows] == ["old", "new"]
    assert changed.rows == [("old", "new", *CELL, "verified", "refuted")]
    assert orders.rows == [("old", "new", *CELL, 0.392, 0.2, 0.2 / 0.392)]
    (row,) = constants.rows
    assert row[:6] == ("old", "new", *CELL)
    assert row[6:] == pytest.approx((0.01 / 0.125**0.5, 0.02 / 0.125**0.5, 2.0))


def test_errors_that_double_leave_the_order(runs):
    """Where errors grow by a factor at every step size, the constant makes a step and the order does not."""
    before, _ = runs
    after = tables(before.verdicts, [{**row, "estimate": "0.02"} for row in before.levels], folder=Path("new"))
    _, _, orders, constants = history_tables([before, after])
    assert orders.rows == []
    assert {row[5] for row in constants.rows} == {"x", "y"}


def test_what_is_not_sampled_makes_a_step_where_it_changes(runs):
    """An order of one step has no standard error: it has made a step where it changed by more than a hundredth."""
    rows = [[weak(local_order=text)] for text in ("1.0", "1.005", "2.0")]
    found = [tables(each, folder=Path(str(place))) for place, each in enumerate(rows)]
    _, _, orders, _ = history_tables(found)
    assert [row[:2] for row in orders.rows] == [("1", "2")]


def test_constants_at_other_step_sizes_are_not_compared(runs):
    """Errors at two finest step sizes tell nothing of each other."""
    before, _ = runs
    after = tables(before.verdicts, [{**row, "estimate": "0.9", "h": "0.25"} for row in before.levels])
    assert history_tables([before, after])[-1].rows == []


def test_a_run_beside_itself_shows_nothing(runs):
    """The same numbers make no step."""
    _, changed, orders, constants = history_tables([runs[0], runs[0]])
    assert (changed.rows, orders.rows, constants.rows) == ([], [], [])
    assert "None." in changed.text


def test_the_history_of_folders_is_a_page(call):
    """The command writes it and says what is on it; one folder is no history."""
    folder = str(REPORTS / "reference")
    outcome = call("history", folder, folder, "--out", "page/history.html")
    assert outcome.code == 0
    assert "2 runs, 0 verdicts changed, 0 orders and 0 error constants made a step" in outcome.out
    assert max(map(len, outcome.out.splitlines())) <= 80
    assert Path("page/history.html").is_file()
    assert call("history", folder).err == "sdaeverify: error: history needs two runs or more\n"


def test_a_changed_verdict_is_told_in_the_terminal(call):
    """Which quantity of which scheme, and what it was in which run."""
    strong = ("-s", "euler-maruyama", "-p", "gbm", "-m", "strong", "--paths", "256")
    assert call("matrix", *strong, "--out", "old").code == 0
    copytree("old", "new")
    table = Path("new/verdicts.csv")
    table.write_text(table.read_text(encoding="utf-8").replace(",verified,", ",refuted,", 1), encoding="utf-8")
    words = " ".join(call("history", "old", "new").out.split())
    assert "euler-maruyama on gbm, strong x: verified in old, refuted in new" in words


def test_reports_beside_a_run_are_on_its_page():
    """The committed calibration is found, a self-test that was not run is not."""
    found = verifier(REPORTS)
    assert {*found} == {"calibration"}
    assert {"study", "case", "rate", "ci_low", "ci_high"} <= {*found["calibration"][0]}
    assert verifier(Path("nowhere")) == {}


def test_the_pictures_have_the_numbers_of_the_tables(runs):
    """Counts of each verdict run by run; orders and constants of every quantity, marked where a step led to them."""
    drawn = history_series(runs)
    about = {"cell": "some-euler on gbm", "measure": "strong, p"}
    assert drawn["counts"] == {"refuted": [0, 1], "verified": [2, 1]}
    assert drawn["orders"] == [
        {**about, "quantity": "x", "values": [0.392, 0.2], "steps": [0, 1]},
        {**about, "quantity": "y", "values": [1, 1.05], "steps": [0, 0]},
    ]
    assert [one["values"] for one in drawn["constants"]] == [
        [pytest.approx(e / 0.125**0.5, rel=1e-5) for e in errors] for errors in ((0.01, 0.02), (0.01, 0.0105))
    ]
    assert [one["steps"] for one in drawn["constants"]] == [[0, 1], [0, 0]]


@needs_chromium
def test_a_history_is_drawn(runs, tmp_path):
    """A mark for each count, order and constant, a hollow one where a step is significant; p and q apart."""
    q = [weak(local_order=text) for text in ("1.0", "2.0")]
    both = [run._replace(verdicts=[*run.verdicts, row]) for run, row in zip(runs, q, strict=True)]
    write_tables(tmp_path / "p.html", "some steps", history_tables(both), history=history_series(both))
    with browser() as page:
        page.look()
        page.open(tmp_path / "p.html")
        titles = page.run("[...document.querySelectorAll('main h2, main h3')].map(h => h.innerText)")
        assert titles == ["Verdicts", "Orders", "strong, p", "weak, q", "Error constants", "strong, p"]
        marks = page.run("[...document.querySelectorAll('main svg circle')].map(c => [+c.dataset.h, +c.dataset.e])")
        assert {(1, 0.392), (2, 0.2), (1, 1), (2, 1.05), (1, 2)} <= {*map(tuple, marks)}
        assert page.run("document.querySelectorAll('main circle.hollow').length") == 3
        assert "1 of 2 made a significant step" in page.run("document.querySelector('main').innerText")
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
