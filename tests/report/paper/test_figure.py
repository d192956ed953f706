"""Figures for a paper: several schemes in one axes, slope triangles, files."""

import itertools

import numpy as np
import pytest

from report.rows import level, read, verdict
from sdaeverify import UsageError
from sdaeverify.report.paper.axes import COLUMN_WIDTH, label_decades, label_steps, mark_of
from sdaeverify.report.plots import Plots

matplotlib = pytest.importorskip("matplotlib", reason="needs the extra plot")
matplotlib.use("agg")
plt = pytest.importorskip("matplotlib.pyplot")
SIZES = [0.125, 0.0625, 0.03125, 0.015625]


@pytest.fixture
def plots():
    """Return the pictures of three schemes of orders 0.5 and 1."""
    orders = {"euler": 0.5, "milstein": 1.0, "heun[theta=0.5]": 1.0}
    rows = [verdict(scheme=name, claimed_order=str(order)) for name, order in orders.items()]
    levels = [
        level(scheme=name, h=str(h), estimate=str(h**order / (2 + place)), std_error=str(0.05 * h))
        for place, (name, order) in enumerate(orders.items())
        for h in SIZES
    ]
    yield Plots(read(*rows), levels)
    plt.close("all")


@pytest.fixture
def axes():
    """Return empty axes."""
    yield plt.subplots()[1]
    plt.close("all")


def test_no_two_of_seventy_lines_look_alike():
    """Marker and colour repeat together at the seventy-first line, not at the eleventh."""
    marks = [tuple(mark_of(number).values()) for number in range(71)]
    assert len({*marks[:70]}) == 70
    assert marks[70] == marks[0]


def test_schemes_stand_in_one_axes_with_their_orders(plots):
    """A curve with its interval for each, in the order that is asked for; the legend is beside the data."""
    ax = plots.convergence(schemes=["milstein", "eu*"], style="paper")
    (legend,) = ax.figure.legends
    assert [text.get_text() for text in legend.get_texts()] == ["milstein (0.39)", "euler (0.39)"]
    assert [len(container.get_children()) for container in ax.containers] == [4, 4]
    first = ax.containers[0][0].get_xydata()
    assert sorted(first[:, 0].tolist()) == sorted(SIZES)
    box = legend.get_window_extent()
    assert not box.overlaps(ax.get_window_extent())


def test_each_claimed_order_has_a_triangle_of_its_slope(plots):
    """Of two steps; it lies below all curves, and its hypotenuse has the slope."""
    ax = plots.convergence(schemes="*", style="paper")
    corners = [patch.get_xy()[:3] for patch in ax.patches]
    slopes = [np.log(high / low) / np.log(right / left) for (left, low), (right, _), (_, high) in corners]
    assert slopes == pytest.approx([1.0, 0.5])
    lowest = {h: h**1.0 / 4 for h in SIZES}
    assert all(y < min(lowest[x] for x in lowest if x <= right) * 1.01 or y < lowest[right]
               for (_, _), (right, _), (_, y) in corners)  # fmt: skip
    assert [text.get_text() for text in ax.texts] == ["1", "0.5"]


def test_a_figure_for_a_paper_has_the_width_of_a_column(plots):
    """Its texts have 7 and 8 points, and no title stands above it; a picture for the screen is as before."""
    ax = plots.convergence(style="paper", problem="gbm")
    assert ax.figure.get_figwidth() == pytest.approx(COLUMN_WIDTH)
    assert {label.get_fontsize() for label in ax.get_xticklabels()} == {7.0}
    assert ax.xaxis.label.get_fontsize() == 8.0
    assert ax.get_title() == ""
    assert len(ax.containers) == 3
    assert plots.convergence("euler").get_title() == "euler on gbm, strong x"


@pytest.mark.long
def test_files_of_a_figure(plots, tmp_path):
    """PDF embeds its fonts as TrueType, and the same figure gives the same bytes."""
    ax = plots.convergence(style="paper")
    files = [tmp_path / name for name in ("a.pdf", "b.pdf", "c.svg", "d.png")]
    plots.save(ax, *files)
    assert files[0].read_bytes() == files[1].read_bytes()
    assert b"/CIDFontType2" in files[0].read_bytes()
    assert all(file.stat().st_size for file in files)


@pytest.mark.long
def test_pgf_without_latex_is_told(plots, tmp_path, monkeypatch):
    """A suffix that is none, a folder that is not there and a missing LaTeX cost one line each."""
    ax = plots.convergence(style="paper")
    monkeypatch.setenv("PATH", "")
    with pytest.raises(UsageError, match=r"a\.pgf needs pdflatex"):
        plots.save(ax, tmp_path / "a.pgf")
    with pytest.raises(UsageError, match=r"save expects a file that ends in \.pdf, \.pgf"):
        plots.save(ax, tmp_path / "a.txt")
    with pytest.raises(UsageError, match="cannot write"):
        plots.save(ax, tmp_path / "missing" / "a.pdf")


@pytest.mark.parametrize(
    ("asked", "message"),
    [
        ({"style": "poster"}, "style expects 'screen' or 'paper', got 'poster'"),
        ({"schemes": ["euler", "nobody"]}, "the result has no scheme 'nobody'"),
        ({"schemes": "x*", "style": "paper"}, "the result has no scheme"),
    ],
)
def test_what_cannot_be_drawn_is_told(plots, asked, message):
    """A style or scheme that there is not is named."""
    with pytest.raises(UsageError, match=message):
        plots.convergence(**asked)


def overlaps(labels):
    """Return the pairs of neighbouring labels that overlap."""
    boxes = [label.get_window_extent() for label in labels if label.get_text()]
    return [pair for pair in itertools.pairwise(boxes) if pair[0].overlaps(pair[1])]


@pytest.mark.sweep
@pytest.mark.parametrize("sizes", [SIZES, [0.3 / 2**k for k in range(12)], [0.7, 0.35], [2.0**-k for k in range(20)]])
def test_ticks_of_step_sizes_do_not_collide(axes, sizes):
    """Powers of two are written as such; of many sizes some have no label."""
    axes.plot(sizes, sizes)
    axes.set(xscale="log", yscale="log")
    label_steps(axes, sizes)
    label_decades(axes)
    axes.figure.canvas.draw()
    assert not overlaps(axes.get_xticklabels())
    assert not overlaps(axes.get_yticklabels())
    assert 2 <= len(axes.get_xticks()) <= 8
    assert not axes.get_xticklabels(minor=True)


def test_the_matrix_has_labels_on_its_axes(plots):
    """Schemes and problems are named as what they are, and the measure stands above."""
    ax = plots.matrix("strong")
    assert (ax.get_xlabel(), ax.get_ylabel(), ax.get_title()) == ("problem", "scheme", "strong")
