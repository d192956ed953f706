"""The picture of the README, from the reference run: `python docs/picture.py` writes docs/_static/verdicts.svg."""

from pathlib import Path

import matplotlib as mpl
from matplotlib import pyplot as plt

from sdaeverify.report.folders import read_tables
from sdaeverify.report.paper.axes import label_steps
from sdaeverify.report.plots import Plots
from sdaeverify.report.verdict_row import VerdictRow

HERE = Path(__file__).parent
CELLS = (("milstein", "gbm", "strong", "x"), ("half-explicit-euler", "pendulum", "strong", "v"))
KEPT_AND_NOT = {"half-explicit-euler", "euler-maruyama"}


def draw() -> None:
    """Draw two cells with their claims, and how a constraint is kept and not kept."""
    mpl.rcParams |= {"svg.hashsalt": "sdaeverify", "svg.fonttype": "none"}
    tables = read_tables(HERE.parent / "reports" / "reference")
    verdicts = [VerdictRow.from_row(row) for row in tables.verdicts]
    drawn = [row for row in verdicts if row.scheme in KEPT_AND_NOT]
    figure, axes = plt.subplots(1, 3, figsize=(11, 3), layout="constrained")
    for cell, ax in zip(CELLS, axes, strict=False):
        row = next(row for row in verdicts if (row.scheme, row.problem, row.measure, row.quantity) == cell)
        Plots(verdicts, tables.levels).convergence(*cell, ax=ax)
        ax.set_title(f"{cell[0]} on {cell[1]}\n{row.claim}: {row.verdict}", fontsize=9)
    drift = Plots(drawn, tables.levels).drift("pendulum", "g", ax=axes[-1])
    drift.set_title("violation of the constraint\non pendulum", fontsize=9)
    label_steps(drift, [float(h) for line in drift.get_lines() for h in line.get_xdata()])
    for ax in axes:
        ax.legend(fontsize=7)
    figure.savefig(HERE / "_static" / "verdicts.svg", metadata={"Date": None})


if __name__ == "__main__":
    draw()
