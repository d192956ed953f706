"""Pictures of a result are drawn from the numbers of its tables."""

import math

import numpy as np
import pytest

from report.rows import level, read, verdict, weak
from sdaeverify import UsageError
from sdaeverify.report.plots import Plots

matplotlib = pytest.importorskip("matplotlib", reason="needs the extra plot")
matplotlib.use("agg")
SIZES, ERRORS = [0.125, 0.0625, 0.03125], [0.04, 0.02, 0.01]


@pytest.fixture
def plots():
    """Return the pictures of two schemes: errors, drift, stability and a stationary mean."""
    rows = [verdict(), weak(), verdict(scheme="other", verdict="inconclusive", problem="ou")]
    rows += [verdict(measure=name, quantity="g", local_order="") for name in ("drift", "invariant", "stability")]
    levels = [
        level(measure=row["measure"], scheme=row["scheme"], problem=row["problem"], quantity=row["quantity"],
              h=str(h), estimate=str(e), fitted=str(h < 0.1))
        for row in rows for h, e in zip(SIZES, ERRORS, strict=True)
    ]  # fmt: skip
    yield Plots(read(*rows), levels)
    matplotlib.pyplot.close("all")


def points(ax, label):
    """Return the points of a line with a label."""
    (line,) = [line for line in ax.get_lines() if line.get_label() == label]
    return [tuple(map(float, xy)) for xy in zip(*line.get_data(), strict=True)], line


def test_errors_are_those_of_the_table_and_slopes_those_of_the_row(plots):
    """Fitted levels are filled, the others hollow; lines have the slope, the claim and the claim less its margin."""
    ax = plots.convergence("some-euler", "gbm")
    fitted, line = points(ax, "fitted")
    assert fitted == list(zip(SIZES[1:], ERRORS[1:], strict=True))
    assert line.get_markerfacecolor() != "none"
    left, hollow = points(ax, "not fitted")
    assert left == [(SIZES[0], ERRORS[0])]
    assert hollow.get_markerfacecolor() == "none"
    for label, slope in (("slope 0.39", 0.392), ("claim 0.50", 0.5), ("claim - margin 0.30", 0.3)):
        (first, *_, last), _ = points(ax, label)
        assert np.log(last[1] / first[1]) / np.log(last[0] / first[0]) == pytest.approx(slope)


def test_ticks_of_orders_are_explained_once(plots):
    """However many rows there are, a claim and the least order that is accepted stand in the legend once."""
    told = [text.get_text() for text in plots.orders("strong").get_legend().get_texts()]
    assert told == ["claim", "claim - margin"]


def test_orders_are_told_with_their_intervals_and_no_noise(plots):
    """A row for each order: along paths with its interval, of one step where the paths tell none."""
    ax = plots.orders("weak")
    values = [float(line.get_xdata()[0]) for line in ax.get_lines() if line.get_marker() == "o"]
    assert values == [0.9988]
    ax = plots.orders("strong", "some-euler")
    assert [[float(x) for x in line.get_xdata()] for line in ax.get_lines()] == [
        [0.357, 0.428],
        [0.392],
        [0.5],
        [0.3],
    ]


def test_the_matrix_has_a_field_for_each_cell(plots):
    """With the symbol of its worst verdict and their number; what is undecided is hatched."""
    ax = plots.matrix("strong")
    assert [one.get_text() for one in ax.texts] == ["·", "?1", "✓1", "·"]
    assert [patch.get_hatch() for patch in ax.patches] == ["", "///", "", ""]


@pytest.mark.parametrize("kind", ["drift", "invariant", "stability"])
def test_schemes_are_compared_by_the_numbers_of_the_levels(plots, kind):
    """A line for each scheme on the first problem there is."""
    ax = getattr(plots, kind)()
    found, _ = points(ax, "some-euler")
    assert found == sorted(zip(SIZES, ERRORS, strict=True))


def test_work_is_the_measured_time_of_the_steps(plots):
    """Errors stand against steps times the time of one, beside the claim; without a time there is nothing to draw."""
    levels = [{**row, "steps": str(round(1.0 / float(row["h"])))} for row in plots.levels]
    details = [{**row.cells, "step_seconds": "0.002"} for row in plots.rows]
    ax = Plots(plots.rows, levels, details).work("gbm")
    found, _ = points(ax, "some-euler: order >= 0.5 ✓")
    assert found == [(0.002 * round(1 / h), e) for h, e in zip(SIZES, ERRORS, strict=True)]
    with pytest.raises(UsageError, match="nothing to draw: strong x on gbm has no measured times"):
        Plots(plots.rows, levels).work("gbm")


def test_densities_are_those_of_the_levels(plots):
    """The scheme's is solid, the equation's dashed; a coordinate without one is told."""
    at, own, exact = [-1.0, 0.0, 1.0], [0.1, 0.6, 0.2], [0.2, 0.5, 0.2]
    rows = [
        level(measure="invariant", quantity="density of coordinate 1", at=str(x), estimate=str(a), exact=str(b))
        for x, a, b in zip(at, own, exact, strict=True)
    ]
    ax = Plots(plots.rows, [*plots.levels, *rows]).density("some-euler", "gbm")
    (_, own_line), (found, line) = (points(ax, one.get_label()) for one in ax.get_lines())
    assert own_line.get_ydata().tolist() == own
    assert found == list(zip(at, exact, strict=True))
    assert line.get_linestyle() == "--"
    with pytest.raises(UsageError, match="no density of coordinate 2 is known"):
        Plots(plots.rows, [*plots.levels, *rows]).density(coordinate=2)


def test_a_picture_goes_onto_given_axes(plots):
    """Where axes are given nothing else is opened."""
    _, ax = matplotlib.pyplot.subplots()
    assert plots.convergence(ax=ax) is ax


def test_what_is_not_there_is_an_error_of_the_user(plots):
    """A name that is not in the result is one line."""
    with pytest.raises(UsageError, match=r"nothing to draw: the result has no scheme 'nobody'"):
        plots.convergence("nobody")
    assert math.isfinite(len(plots.rows))
