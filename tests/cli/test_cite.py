"""``cite`` tells how a run is cited."""

import pytest

from sdaeverify import verify


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """Return the folder of a small run."""
    folder = tmp_path_factory.mktemp("run")
    verify("milstein", "gbm", "strong", paths=64, levels=3).save(folder)
    return folder


def test_a_run_is_cited(call, run):
    """A sentence with the version, an entry for BibTeX, and the source of each claim."""
    told = call("cite", str(run)).out
    assert told.startswith("Verdicts of sdaeverify 0.")
    assert "@software{sdaeverify," in told
    assert "milstein: " in told.partition("Sources of the claims:")[2]


def test_the_table_of_a_run(call, run):
    """As LaTeX or Markdown, lines unbroken and indentation kept."""
    latex, markdown = (call("cite", str(run), "--table", kind).out for kind in ("latex", "markdown"))
    assert "\\begin{tabular}" in latex
    assert " & strong x & order $\\geq$ 1.0 & " in latex
    assert " | strong x | order ≥ 1.0 | " in markdown
    assert "Scheme: milstein. Problem: gbm." in latex


def test_a_folder_without_a_run_is_told(call):
    """One line and the code of wrong usage."""
    outcome = call("cite", "nowhere")
    assert outcome.code == 2
    assert "nowhere holds no run" in outcome.err
