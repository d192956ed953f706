"""Axes of figures: size, style, distinguishable markers, and tick labels that do not overlap."""

import shutil
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from math import ceil, inf, isfinite, log2, log10
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ...errors import UsageError

if TYPE_CHECKING:
    from matplotlib.axes import Axes
else:
    Axes = Any

MISSING = "result.plot needs matplotlib: pip install 'sdaeverify[plot]'"
# Seven markers and ten colours have no common factor: the pairs repeat after 70 lines.
MARKERS = "osD^v<>"
# M. A. Petroff, Accessible color sequences for data visualization, arXiv:2107.02270, table 1, ten colours.
COLOURS = (
    "#3f90da", "#ffa90e", "#bd1f01", "#94a4a2", "#832db6", "#a96b59", "#e76300", "#b9ac70", "#717581", "#92dadd",
)  # fmt: skip
SCREEN, PAPER = "screen", "paper"
# Column width of a two-column journal, 86 mm, and height of the axes of a figure, in inches.
COLUMN_WIDTH, PAPER_HEIGHT = 3.386, 2.3
# Sizes in points. The fonts come with matplotlib; journals require fonts of type 42.
PAPER_STYLE: dict[str, Any] = {
    "font.size": 8, "axes.labelsize": 8, "axes.titlesize": 8, "xtick.labelsize": 7, "ytick.labelsize": 7,
    "legend.fontsize": 7, "font.family": "STIXGeneral", "mathtext.fontset": "stix", "axes.linewidth": 0.5,
    "lines.linewidth": 0.8, "lines.markersize": 3.5, "lines.markeredgewidth": 0.7, "errorbar.capsize": 1.5,
    "xtick.major.width": 0.5, "ytick.major.width": 0.5, "xtick.major.size": 2.5, "ytick.major.size": 2.5,
    "ytick.minor.width": 0.4, "ytick.minor.size": 1.5, "pdf.fonttype": 42, "ps.fonttype": 42,
    "pgf.rcfonts": False, "pgf.texsystem": "pdflatex",
}  # fmt: skip
STYLES: dict[str, dict[str, Any]] = {SCREEN: {}, PAPER: PAPER_STYLE}
# Largest number of tick labels of step sizes that do not overlap, by style.
MOST_TICKS = {SCREEN: 8, PAPER: 6}
# Length in decades of a logarithmic axis up to which 2 and 5 times each power of 10 are labelled as well.
MOST_DECADES = 2.0
KINDS = (".pdf", ".pgf", ".svg", ".png")


def axes_of(ax: Axes | None, size: tuple[float, float] | None = None) -> Axes:
    """Return the given axes, or those of a new figure.

    Parameters
    ----------
    ax : Axes or None
    size : tuple of float, optional
        Width and height of a new figure in inches; matplotlib's default if left out.

    Raises
    ------
    UsageError
        If matplotlib is not installed, or `ax` is not an `Axes`.
    """
    if ax is not None:
        if not hasattr(ax, "errorbar"):
            raise UsageError(f"ax expects the axes of a matplotlib figure, got {ax!r:.200}")
        return ax
    new: Axes = _pyplot().subplots(layout="constrained", figsize=size)[1]
    return new


@contextmanager
def in_style(style: str) -> Iterator[None]:
    """Set the style of figures: ``screen``, matplotlib's settings, or ``paper``.

    Raises
    ------
    UsageError
        If the style is unknown, or matplotlib is not installed.
    """
    if style not in STYLES:
        raise UsageError(f"style expects {' or '.join(map(repr, STYLES))}, got {style!r:.200}")
    with _pyplot().rc_context(STYLES[style]):
        yield


def mark_of(number: int) -> dict[str, Any]:
    """Return marker and colour of a line; the combinations of 70 consecutive lines differ."""
    return {"marker": MARKERS[number % len(MARKERS)], "color": COLOURS[number % len(COLOURS)]}


def label_steps(ax: Axes, sizes: Sequence[float], style: str = SCREEN) -> None:
    """Set the ticks of a logarithmic axis to step sizes, as powers of two where exact, without overlaps.

    Parameters
    ----------
    ax : Axes
        Axes whose x axis is labelled.
    sizes : sequence of float
        Step sizes of all curves; zeros and values that are not finite are left out.
    style : str
        ``screen`` or ``paper``, which determines the number of labels.
    """
    every = sorted({size for size in sizes if size > 0.0 and isfinite(size)})
    # Starting from the coarsest; neighbouring ticks differ by a factor of two or more unless problems are mixed.
    shown = every[:: -max(1, ceil(len(every) / MOST_TICKS[style]))]
    ax.set_xticks(shown, [_size_in_words(size) for size in shown])
    ax.set_xticks([], minor=True)


def label_decades(ax: Axes, which: str = "y") -> None:
    """Label the decades of a logarithmic axis, and 2 and 5 times each if it has fewer than two decades.

    Parameters
    ----------
    ax : Axes
    which : str, optional
        ``x`` or ``y``.
    """
    from matplotlib.ticker import LogFormatterSciNotation, LogLocator, NullFormatter  # noqa: PLC0415 - optional

    axis, (low, high) = (ax.xaxis, ax.get_xlim()) if which == "x" else (ax.yaxis, ax.get_ylim())
    if axis.get_scale() != "log" or low <= 0.0:
        return
    if log10(high / low) < MOST_DECADES:
        axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
        # Infinite thresholds, so that each of these ticks is labelled.
        axis.set_major_formatter(LogFormatterSciNotation(minor_thresholds=(inf, inf)))
    axis.set_minor_formatter(NullFormatter())


def save_figure(ax: Axes, files: Sequence[str | Path]) -> None:
    """Write the figure of some axes to files; the suffix determines the format.

    Parameters
    ----------
    ax : Axes
    files : sequence of str or Path
        Files in PDF, PGF, SVG or PNG. The same figure gives the same bytes, because no date is written.

    Raises
    ------
    UsageError
        If the suffix is unknown, the file cannot be written, or PGF is requested without LaTeX.
    """
    for file in map(Path, files):
        kind = file.suffix.lower()
        if kind not in KINDS:
            raise UsageError(f"save expects a file that ends in {', '.join(KINDS)}, got {str(file)!r:.200}")
        if kind == ".pgf" and shutil.which(PAPER_STYLE["pgf.texsystem"]) is None:
            raise UsageError(f"{file} needs pdflatex, which measures the texts of a PGF file; PDF needs none")
        metadata = {".pdf": {"CreationDate": None}, ".svg": {"Date": None}}.get(kind)
        try:
            with in_style(PAPER):
                _figure_of(ax).savefig(file, dpi=300, metadata=metadata)
        except OSError as error:
            raise UsageError(f"cannot write {file}: {error.strerror or error}") from error


def as_label(text: str) -> str:
    r"""Escape a text for matplotlib, which would interpret text between two $ as a formula."""
    return text.replace("$", r"\$")


def _figure_of(ax: Axes) -> Any:
    return axes_of(ax).get_figure(root=True)


def _size_in_words(size: float) -> str:
    power = log2(size)
    return f"$2^{{{round(power)}}}$" if abs(power - round(power)) < 1e-9 else f"{size:.2g}"


def _pyplot() -> Any:
    try:
        from matplotlib import pyplot as plt  # noqa: PLC0415 - only pictures need it
    except ImportError as error:
        raise UsageError(MISSING) from error
    return plt
