"""Table 1 of Laurent (2022): the mean trace of matrices near the orthogonal group."""

from collections.abc import Iterator, Sequence

import numpy as np

from sdaeverify import hookimpl
from sdaeverify_lab.papers import Curve, Experiment, ExperimentEvidence, MeanLine, MeanTable, Panel, Printed, Row

PATHS = 10**6
# With the noise (2.3) of the paper.
UNIFORM, EULER = "uniformly-accurate[xi=three-point]", "constrained-euler[xi=three-point]"
# By m: J(m) of the reference, UA with h = 2^-9, then J_UA and J_EC with h = 2^-7.
TABLE = {
    2: ("2.00934", "2.00619", "1.99165"),
    3: ("3.01458", "3.00821", "2.97460"),
    4: ("4.02050", "4.00972", "3.94846"),
    5: ("5.02669", "5.00842", "4.91298"),
}
NOTES = (
    "The printed references J(m) have the error of their step size: the exact values are those of the invariant law.",
    "The printed reference, h = 2^-9, is within its sampling error of what the scheme gives at 2^-10, and the "
    "printed UA mean, h = 2^-7, near what it gives at 2^-8: errors half as large as at the steps that are named. For "
    "m >= 4 it is off from that, too, by far more than sampling. Printed means of EC are too low by 4e-4, 1e-3 and "
    "3e-3 for m = 3, 4, 5. Noise of three points gives the same, the direction of the new point higher ones; an "
    "iteration that ends early gives lower ones, at no tolerance those of all m.",
    "The time of the drift is 1/100, so that at T = 1 the law is invariant to all digits.",
)


def rows(m: int) -> Iterator[Row]:
    """Yield the rows of O(m)."""
    problem = f"orthogonal-group[eps=0.005,m={m},stiffness=100,horizon=1]"
    reference, uniform, euler = (Printed(digits, PATHS) for digits in TABLE[m])
    for scheme, k, printed in (
        (UNIFORM, 7, uniform),
        (UNIFORM, 8, None),
        (UNIFORM, 9, reference),
        (UNIFORM, 10, None),
        (EULER, 7, euler),
    ):
        yield Row(problem=problem, scheme=scheme, steps=2**k, observable="tr x", printed=printed, costly=k > 8)


class Traces(MeanTable):
    """The table, with a bar for each m."""

    def panels(self, found: Sequence[MeanLine], evidence: ExperimentEvidence) -> tuple[Panel, ...]:
        """Return the errors of the computed and of the printed means."""
        return (_panel(found, "errors of the means"),)


def _panel(found: Sequence[MeanLine], title: str) -> Panel:
    groups: dict[tuple[str, int], list[MeanLine]] = {}
    for line in found:
        groups.setdefault((line.row.scheme, line.row.steps), []).append(line)
    curves = []
    for hue, ((scheme, steps), lines) in enumerate(groups.items()):
        m, k = np.array(list(TABLE), dtype=float)[: len(lines)], steps.bit_length() - 1
        error = np.array([line.sample.value - line.exact for line in lines])
        bar = 2.0 * np.array([line.sample.std_error for line in lines])
        name = f"{'UA' if scheme == UNIFORM else 'EC'}, h = 2^-{k}"
        curves.append(Curve(name, m + 0.08 * hue, error, error - bar, error + bar, "marks", hue))
        if lines[0].row.printed:
            printed = np.array([line.row.printed.value - line.exact for line in lines if line.row.printed])
            curves.append(Curve(f"{name}, printed", m + 0.08 * hue, printed, kind="printed", hue=hue))
    return Panel(title, "m", "J - exact J, 2 standard errors", tuple(curves))


@hookimpl
def sdaeverify_experiments() -> list[Experiment]:
    """Register the table."""
    return [
        Traces(
            name="laurent-2022-table-1",
            title="E tr x near O(m), m = 2..5, eps = 0.005: uniformly accurate and constrained Euler at T = 1",
            source="Laurent 2022, Table 1",
            rows=tuple(row for m in TABLE for row in rows(m)),
            equilibrium=True,
            notes=NOTES,
        )
    ]
