"""The picture of the README, from the reference run: `python docs/picture.py` writes docs/_static/verdicts.svg."""

from pathlib import Path

import matplotlib as mpl
from matplotlib import pyplot as plt
from matplotlib.ticker import NullFormatter

from sdaeverify.report.folders import key_of, read_tables
from sdaeverify.report.plots import Plots

HERE = Path(__file__).parent
CELLS = (("milstein", "gbm", "strong", "x"), ("half-explicit-euler", "pendulum", "strong", "v"))
KEPT_AND_NOT = {"half-explicit-euler", "euler-maruyama"}


def draw() -> None:
    """Draw two cells with their claims, and how a constraint is kept and not kept."""
    mpl.rcParams |= {"svg.hashsalt": "sdaeverify", "svg.fonttype": "none"}
    tables = read_tables(HERE.parent / "reports" / "reference")
    two = [[row for row in rows if row["scheme"] in KEPT_AND_NOT] for rows in (tables.verdicts, tables.levels)]
    figure, axes = plt.subplots(1, 3, figsize=(11, 3), layout="constrained")
    for cell, ax in zip(CELLS, axes, strict=False):
        row = next(row for row in tables.verdicts if key_of(row) == cell)
        Plots(tables.verdicts, tables.levels).convergence(*cell, ax=ax)
        ax.set_title(f"{cell[0]} on {cell[1]}\n{row['claim']}: {row['verdict']}", fontsize=9)
    Plots(*two).drift("pendulum", "g", ax=axes[-1]).set_title("violation of the constraint\non pendulum", fontsize=9)
    for ax in axes:
        ax.xaxis.set_minor_formatter(NullFormatter())
        ax.legend(fontsize=7)
    figure.savefig(HERE / "_static" / "verdicts.svg", metadata={"Date": None})


if __name__ == "__main__":
    draw()
