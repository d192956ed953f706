"""Table 1 of Qu, Huang & Liu (2010): mean square errors of backward Euler on a delay equation."""

from collections.abc import Iterator, Sequence

import numpy as np

from sdaeverify import hookimpl
from sdaeverify_lab.papers import (
    Curve,
    Experiment,
    ExperimentEvidence,
    FineRun,
    MeanLine,
    MeanTable,
    Panel,
    Printed,
    Row,
)

# 20 blocks of 100.
PATHS = 2000
PROBLEM, HORIZON = "delay-test[set=IV]", 4
SCHEME = "stochastic-theta[theta=1.0]"
# Printed numbers by 1/h. The first entry is printed as "2.9806-04".
TABLE = {8: "2.9806e-04", 16: "1.5971e-04", 32: "7.2109e-05", 64: "4.045e-05", 128: "2.3559e-05"}
# Explicit: a step costs a quarter, and the mean square error equals that of backward Euler to first order in h.
EXPLICIT = "stochastic-theta[theta=0.0]"
FINE = 8192
REFERENCE = FineRun(EXPLICIT, HORIZON * FINE)
NOTES = (
    "The paper's reference has steps of 1/1024. Halving h must halve a mean square; those printed at 1/64 and 1/128 "
    "are higher than that, as if a floor were added.",
    "Of the first entry the paper prints 2.9806-04, without the e.",
    "The reference's own error is taken from every mean square, a part of h_ref/h of it, 1/64 at h = 1/128; the last "
    "two rows, steps twice as long as those of the reference, show how large it is.",
)


def rows() -> Iterator[Row]:
    """Yield x and y by step size, then the rows for the reference's error."""
    for observable in ("x", "y"):
        for finer, digits in TABLE.items():
            printed = Printed(digits, PATHS) if observable == "x" else None
            yield row(SCHEME, finer, observable, printed)
    for observable in ("x", "y"):
        yield row(EXPLICIT, FINE // 2, observable)


def row(scheme: str, finer: int, observable: str, printed: Printed | None = None) -> Row:
    """Return the row for steps of size 1/finer.

    Parameters
    ----------
    scheme : str
        Label of the scheme.
    finer : int
        Number of steps per unit of time.
    observable : str
        Observable whose error is tabulated.
    printed : Printed, optional
        Number printed in the paper.
    """
    return Row(
        problem=PROBLEM,
        scheme=scheme,
        steps=HORIZON * finer,
        observable=observable,
        printed=printed,
        reference=REFERENCE,
    )


class MeanSquareErrors(MeanTable):
    """The table, with a plot of printed and computed numbers against h."""

    def panels(self, found: Sequence[MeanLine], evidence: ExperimentEvidence) -> tuple[Panel, ...]:
        """Return one panel."""
        curves = []
        for hue, observable in enumerate("xy"):
            lines = [line for line in found if line.row.observable == observable and line.row.scheme == SCHEME]
            h, means = np.array([line.h for line in lines]), np.array([line.sample.value for line in lines])
            bar = 2.0 * np.array([line.sample.std_error for line in lines])
            curves.append(Curve(f"{observable}, here", h, means, means - bar, means + bar, hue=hue))
            curves.append(Curve("h" if hue else "", h, means[0] * h / h[0], kind="guide"))
        printed = np.array([float(digits) for digits in TABLE.values()])
        curves.append(Curve("x, printed", 1.0 / np.array(list(TABLE), dtype=float), printed, kind="printed", hue=0))
        return (Panel("set IV, backward Euler, T = 4", "h", "mean square error", tuple(curves), "xy"),)


@hookimpl
def sdaeverify_experiments() -> list[Experiment]:
    """Register the table."""
    return [
        MeanSquareErrors(
            name="qu-2010-table-1",
            title="E |x(T) - x_N|^2, and of y, set IV, backward Euler at T = 4",
            source="Qu, Huang & Liu 2010, Table 1",
            rows=tuple(rows()),
            paths=PATHS,
            block=1000,
            notes=NOTES,
        )
    ]
