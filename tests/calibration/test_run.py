"""A calibration from its jobs to its tables."""

from concurrent.futures import ThreadPoolExecutor

import pytest

from facade import (
    Calibration,
    ExpectedRate,
    Rate,
    calibration_plan,
    load_registry,
    markdown,
    rate_table,
    sections,
    summary,
)

pytestmark = pytest.mark.long

MAKING = {"stream_fingerprint": "abc", "versions": {"numpy": "2.0"}}


@pytest.fixture(scope="module")
def plan():
    """Return the smallest plan with paths, chains and families."""
    return calibration_plan(load_registry(lab=True), 1, 40, ["slope milstein on gbm", "chains*on ou", "families"])


@pytest.fixture(scope="module")
def rates(plan):
    """Return its rates."""
    calibration = Calibration(plan)
    events = list(calibration.run())
    assert [event.done for event in events] == list(range(1, len(calibration.jobs) + 1))
    return calibration.rates


def test_rates_do_not_depend_on_the_executor(plan, rates):
    """The same seed gives the same rates, in the same order, whoever does the jobs."""
    calibration = Calibration(plan)
    with ThreadPoolExecutor(2) as executor:
        list(calibration.run(executor))

    assert calibration.rates == rates


def test_studies_follow_each_other(rates):
    """All rates of a study stand together."""
    assert list(dict.fromkeys(rate.study for rate in rates)) == ["slope", "chains", "families"]


def test_table_has_a_row_a_rate(plan, rates):
    """The table for programs has every rate with its interval, its promise and the seed."""
    table = rate_table(rates, plan)

    assert len(table) == len(rates)
    assert ((table.ci_low <= table.rate) & (table.rate <= table.ci_high)).all()
    assert (table.hits / table.trials == table.rate).all()
    assert set(table.seed) == {1}
    assert table.agrees.all()


def test_sections_are_by_sample_size(rates):
    """A study of a few sample sizes has a column for each, one without paths has one for the rate."""
    slope, _, families = sections(rates)

    assert slope.headings == ["case", "statistic", "100 paths", "400 paths", "1600 paths", "promised"]
    assert families.headings == ["case", "statistic", "rate", "promised"]
    assert all(len(row) == len(section.headings) for section in (slope, families) for row in section.rows)


def test_a_rate_that_disagrees_is_named(plan, rates):
    """What disagrees has a star in the table and a line in the summary; the others have not."""
    wrong = Rate("slope", "a|b", "L1 interval", 100.0, 670, 1000, ExpectedRate(0.93, 0.97, "0.95 within 0.02"))

    text = markdown([*rates, wrong], plan, "the command", MAKING)
    table = rate_table([*rates, wrong], plan)

    assert [line for line in text.splitlines() if " *" in line and line.startswith("|")] == [
        line for line in text.splitlines() if "a\\|b" in line and line.startswith("|")
    ]
    assert list(table.agrees) == [True] * len(rates) + [False]
    assert summary([*rates, wrong])[1].startswith(
        "disagrees: slope, a|b, L1 interval, 100 paths: 0.67 (0.6399, 0.6991)"
    )
    assert len(summary(rates)) == 1


def test_report_says_how_it_was_made(plan, rates):
    """The report for readers gives command, seed, repetitions and versions."""
    head = markdown(rates, plan, "python -m sdaeverify calibrate", MAKING).split("##")[0]

    for words in ("`python -m sdaeverify calibrate`", "seed 1", "about 40 trials", "numpy 2", "none of"):
        assert words in head
