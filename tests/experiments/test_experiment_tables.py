"""The table of an experiment: print, mean and exact value, and where they disagree."""

from math import isnan, nan

import pytest

from experiments.running import lines_of
from facade import FineRun, MeanLine, MeanSample, Printed, Row, SchemeMean
from sdaeverify import InvariantMean

# 400 paths of standard deviation 2: standard error 0.1, and 0.02 for a print from 10000 paths.
SAMPLE = MeanSample(400, 1.0, 4.0 * 399)


def line(digits="1.0", exact=1.0, paths=10**4, sample=SAMPLE):
    printed = Printed(digits, paths) if digits else None
    row = Row(problem="p", scheme="s", steps=4, observable="x", printed=printed)
    return MeanLine(row, 0.25, 1.0, sample, exact)


def entry(*arguments, **options):
    return line(*arguments, **options).entry


@pytest.mark.parametrize(
    ("digits", "ours", "exact"),
    [
        ("1.084", "agrees", "disagrees"),  # beyond 0.08 + 0.0005
        ("1.080", "agrees", "agrees"),
        ("1.08", "agrees", "agrees"),
        ("1.41", "agrees", "disagrees"),  # both errors: 4 sqrt(0.1^2 + 0.02^2) = 0.408, and 0.005
        ("1.42", "disagrees", "disagrees"),
        ("0.58", "disagrees", "disagrees"),
    ],
)
def test_agreement(digits, ours, exact):
    """Print and mean may differ by half a unit and four of their standard errors, print and exact value by less."""
    assert (entry(digits).print_and_value, entry(digits).print_and_exact) == (ours, exact)


def test_digits_matter():
    """A number printed with fewer digits says less: it agrees with all that is rounded to it."""
    assert entry("1.1", paths=10**12).print_and_exact == "disagrees"
    assert entry("1.1", exact=1.14, paths=10**12).print_and_exact == "agrees"
    assert entry("1.10", exact=1.14, paths=10**12).print_and_exact == "disagrees"


def test_nothing_to_compare():
    """Without print, exact value or mean there is no verdict."""
    assert entry("").print_and_value == entry("").print_and_exact == ""
    assert entry(exact=nan).print_and_exact == ""
    assert entry(sample=MeanSample(3, nan, nan, lost=3)).print_and_value == ""


def test_exact_values(planned, registry):
    """The exact value is the moment at the final time; the invariant mean counts in equilibrium only."""
    rows = [Row(problem=name, scheme="milstein", steps=2, observable="x^2") for name in ("gbm[b=0]", "double-well")]

    known = [found.exact for found in lines_of(planned(*rows))]
    invariant = lines_of(planned(*rows, equilibrium=True))

    assert known[0] == pytest.approx(2.718281828459045, rel=1e-14)
    assert isnan(known[1])
    assert invariant[0].exact == known[0]
    truths = registry.problems["double-well"].make().build().truths
    assert invariant[1].exact in [truth.value for truth in truths if isinstance(truth, InvariantMean)]
    assert invariant[1].exact_source


def test_exact_value_on_the_way(planned):
    """The exact value is the moment at the time at which the mean is taken; an error has none."""
    rows = [
        Row(problem="gbm[b=0]", scheme="milstein", steps=4, observable="x", at=1),
        Row(problem="gbm[b=0]", scheme="milstein", steps=4, observable="x", reference=FineRun("milstein", 8)),
    ]
    mean, error = lines_of(planned(*rows))

    assert (mean.time, error.time) == (0.25, 1.0)
    assert mean.exact == pytest.approx(1.1331484530668263, rel=1e-14)
    assert isnan(error.exact)


@pytest.mark.parametrize(("scheme_mean", "word"), [(1.39, "agrees"), (1.41, "disagrees"), (nan, "")])
def test_mean_of_the_scheme(scheme_mean, word):
    """Our mean is compared with the scheme's to four standard errors, where that is known."""
    assert line()._replace(scheme_mean=SchemeMean(scheme_mean)).entry.value_and_expected == word


def test_table(planned):
    """Every row of the table has all that is known, with all digits."""
    row = Row(problem="gbm[b=0]", scheme="euler-maruyama", steps=2, observable="x", printed=Printed("1.5624", 9))
    run = planned(row)
    list(run.run())

    found = run.plan.experiment.exhibit(run.evidence).entries[0].record()

    assert found["value"] == pytest.approx(1.5625, rel=1e-15)
    assert found["exact"] == pytest.approx(1.6487212707001282, rel=1e-15)
    assert found["value_minus_exact"] == found["value"] - found["exact"]
    assert (found["printed"], found["printed_and_value"], found["printed_and_exact"]) == (
        "1.5624", "disagrees", "disagrees",
    )  # fmt: skip
    assert (found["steps"], found["h"], found["time"], found["paths"]) == (2, 0.5, 1.0, 10)
    # Without noise all paths are equal.
    assert found["effective_paths"] == pytest.approx(10.0, rel=1e-12)
    assert found["reference_scheme"] == found["reference_steps"] == found["value_and_expected"] == ""


def test_few_effective_paths():
    """Fewer than 30 effective paths make a comparison void, whether the numbers differ or not."""
    heavy = MeanSample(1000, 1.0, 1000.0 * 50.0)
    light = MeanSample(1000, 1.0, 1000.0 * 30.0)

    assert heavy.effective < 30.0 < light.effective
    assert (entry(sample=heavy).print_and_value, entry(sample=light).print_and_value) == ("void", "agrees")
    assert entry("900", sample=heavy).print_and_value == "void"
    assert entry("900", sample=light).print_and_value == "disagrees"


def test_words():
    """What is missing is said in one line each, and nothing else is."""
    telling = [
        line(),
        line(sample=MeanSample()),
        line(sample=MeanSample(9, nan, nan, lost=2)),
        line(sample=MeanSample(9, 1.0, 1.0, without_root=1)),
        line(sample=MeanSample(error="no view")),
    ]

    assert [word for each in telling for word in each.in_words] == [
        "s on p, h = 0.25: not reached",
        "s on p, h = 0.25: 2 of 9 paths are lost",
        "s on p, h = 0.25: on 1 of 9 paths a step found no root",
        "s on p, h = 0.25: no view",
    ]
