"""Figure 2.1 of Lindner et al. (2018): the spatial grid of the clamped fibre, with its ghost points."""

from collections.abc import Mapping

import numpy as np

from sdaeverify import Array, Problem, Scheme, hookimpl
from sdaeverify_lab.papers import (
    Budget,
    Curve,
    Exhibit,
    Experiment,
    ExperimentEvidence,
    Panel,
    Probe,
    TableEntry,
    Work,
)

from ._fibres import fibre_label, spacing

N = 7


def arc_lengths(problems: tuple[Problem, ...], schemes: tuple[Scheme, ...]) -> Mapping[str, Array]:
    """Return the arc length of each point of the fibre at rest, hanging from the origin, shape (N,)."""
    (problem,) = problems
    return {"s": -problem.initial(1).r[1::2, 0]}


class Grid(Experiment):
    """Points and edges along the fibre."""

    name = "lindner-2018-figure-2-1"
    title = "the spatial grid of the clamped fibre and its ghost points"
    source = "Lindner et al. 2018, Figure 2.1"
    paths = 2
    notes = (
        "Points are means over cells of length ds; the first cell belongs to the clamp, so that ds = 1/(N + 1). "
        "Beyond the stress-free end r_{N+1} = 2 r_N - r_{N-1} and r_{N+2} = 3 r_N - 2 r_{N-1}.",
    )

    def work(self, budget: Budget) -> Work:
        """Return one probe."""
        return {"grid": Probe(arc_lengths, (fibre_label(N=N),))}

    def exhibit(self, evidence: ExperimentEvidence) -> Exhibit:
        """Return the arc lengths next to (i + 1/2) ds, and the drawing."""
        s, ds = evidence.probe("grid")["s"], spacing(N)
        entries = [
            TableEntry(f"arc length s_i, N = {N}, ds = 1/{N + 1}", {"i": i}, float(s[i - 1]), exact=(i + 0.5) * ds)
            for i in range(1, N + 1)
        ]
        ghosts, beyond = np.array([-0.5, 0.5]) * ds, np.array([N + 1.5, N + 2.5]) * ds
        edges = np.arange(1, N + 1) * ds
        curves = (
            Curve("fibre", np.array([0.0, 1.0]), np.zeros(2), kind="line", hue=6),
            Curve("points r_i", s, np.zeros(N), kind="marks", hue=0),
            Curve("clamped ghosts r_{-1}, r_0", ghosts, np.zeros(2), kind="marks", hue=1),
            Curve("ghosts beyond the free end", beyond, np.zeros(2), kind="marks", hue=2),
            Curve("edges, with constraint and traction", edges, np.zeros(N), kind="printed", hue=6),
        )
        panel = Panel("grid of the clamped fibre", "arc length s", "", curves)
        return Exhibit(tuple(entries), (panel,))


@hookimpl
def sdaeverify_experiments() -> list[Experiment]:
    """Register the drawing."""
    return [Grid()]
