"""Progress: the line of a finished cell."""

from types import SimpleNamespace

from sdaeverify.contracts.finding import Verdict
from sdaeverify.report.progress import line


def test_a_line_counts_verdicts_in_the_words_of_the_summary():
    """A quantity without a claim, or in error, is called so as at the end of the run."""
    cell = SimpleNamespace(
        scheme=SimpleNamespace(label="some-euler"),
        spec=SimpleNamespace(label="gbm"),
        measure=SimpleNamespace(name="weak"),
    )
    verdicts = (Verdict.VERIFIED, Verdict.VERIFIED, Verdict.OUT_OF_SCOPE, Verdict.ERROR)
    findings = [SimpleNamespace(verdict=verdict) for verdict in verdicts]
    told = line(SimpleNamespace(cell=cell, findings=findings, seconds=1.5))
    assert told == "some-euler  gbm  weak  2 verified, 1 without a claim, 1 in error  1.50 s"
