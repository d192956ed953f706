"""Pages of a run with too many quantities for one: an overview, and a page for each problem."""

import pytest

from browser import browser, needs_chromium
from report.rows import level, tables, verdict
from sdaeverify.report.html import PAGE, large, page_text, payload, remove_page, write_page

ODD = "ou[name=a/b c,x=1]"


def run(folder):
    """Return tables of two schemes on two problems, one of which has a name with characters of an address."""
    rows = [
        verdict(problem=problem, scheme=scheme, verdict=outcome, reason=f"because of {problem}")
        for problem in ("gbm", ODD)
        for scheme, outcome in (("some-euler", "verified"), ("other-scheme", "inconclusive"))
    ]
    levels = [
        level(
            problem=row["problem"],
            scheme=row["scheme"],
            h=str(h),
            estimate=str(h),
            std_error="1e-4",
            steps=str(int(1 / h)),
        )
        for row in rows
        for h in (0.25, 0.125, 0.0625)
    ]
    absent = [verdict(problem=ODD, scheme="third", reason="needs constraints")]
    return tables(rows, levels, folder=folder, absent=absent)


@pytest.fixture
def pages(tmp_path, monkeypatch):
    """Return the folder of a run whose pages were written with a bound below its number of quantities."""
    monkeypatch.setattr(large, "MOST", 3)
    monkeypatch.setattr("sdaeverify.report.html.read_tables", run)
    write_page(tmp_path)
    return tmp_path


def test_the_page_of_a_problem_has_all_that_the_whole_page_says_of_it(tmp_path):
    """Findings, levels and cells that do not apply are those of the payload of the run, problem by problem."""
    saved = run(tmp_path)
    whole = payload(saved)
    parts = [payload(part.tables) for part in large.problem_pages(saved, {})]
    for name in ("scheme", "problem", "verdict", "reason", "reproduce"):
        found = [part["findings"][name]["words"][place] for part in parts for place in part["findings"][name]["at"]]
        assert found == [whole["findings"][name]["words"][place] for place in whole["findings"][name]["at"]]
    assert [each for part in parts for each in part["levels"]] == whole["levels"]
    assert [part["absent"]["scheme"]["words"] for part in parts] == [[], ["third"]]


def test_an_overview_has_verdicts_without_details(tmp_path):
    """Levels and commands are left out, and reasons except where attention is needed."""
    saved = run(tmp_path)
    data = large.overview(payload(saved._replace(levels=(), details=())))
    reasons = data["findings"]["reason"]
    assert [reasons["words"][place] for place in reasons["at"]] == ["", "because of gbm", "", f"because of {ODD}"]
    assert data["levels"] == []
    assert "reproduce" not in data["findings"]
    assert data["parts"] == {problem: large.file_of(problem) for problem in ("gbm", ODD)}


def test_names_of_files_are_distinct_and_plain():
    """Two labels that differ in a sign have two files, and no label leaves the folder of the pages."""
    names = {large.file_of(name) for name in ("a+b", "a-b", "../../a", "a" * 500, "", "ä")}
    assert len(names) == 6
    assert all(name.startswith(f"{large.FOLDER}/") and name.count("/") == 1 and len(name) < 100 for name in names)


def test_pages_of_problems_do_not_outlive_their_run(pages, monkeypatch):
    """A run of fewer problems, a small run, and a run without a page leave no page of a problem behind."""
    stale = pages / large.FOLDER / "stale.html"
    stale.touch()
    write_page(pages)
    assert len([*stale.parent.iterdir()]) == 2
    monkeypatch.setattr(large, "MOST", 100)
    write_page(pages)
    assert not [*stale.parent.iterdir()]
    stale.touch()
    remove_page(pages)
    assert not stale.exists()


@needs_chromium
def test_the_overview_leads_to_the_page_of_a_problem_and_back(pages):
    """Cells of the matrix open the page of their problem, whose schemes lead back; nothing is requested."""
    with browser() as page:
        page.open(pages / PAGE, "#/matrix")
        cell = page.run(f"document.querySelector('a.cell[href*=\"{large.file_of(ODD)}\"]').href")
        page.visit(cell)
        assert page.run("document.querySelector('h1').textContent") == f"other-scheme on {ODD}"
        assert page.run("document.querySelectorAll('circle.dot').length") == 3
        page.visit(page.run("document.querySelector('h1 a').href"))
        assert page.run("location.pathname").endswith(f"/{PAGE}")
        assert page.run("document.querySelector('h1').textContent") == "other-scheme"
        assert page.complaints == []
        assert page.requests == []


def test_a_page_of_a_small_run_stands_alone(tmp_path):
    """Below the bound nothing changes: one file with all details."""
    assert "parts" not in payload(run(tmp_path))
    assert '"parts":' not in page_text(payload(run(tmp_path)))
