"""Figure 4.1 of Lindner et al. (2018): the fibre and its velocity, for two stiffnesses and two turbulences."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from sdaeverify import Array, hookimpl
from sdaeverify_lab.papers import (
    Budget,
    Curve,
    Exhibit,
    Experiment,
    ExperimentEvidence,
    Note,
    Panel,
    SchemeRun,
    TableEntry,
    Work,
)

from ._estimates import mean
from ._fibres import A, differences, edges, fibre_label, positions, spacing, velocities

ALPHAS, BETAS = ("0.4", "4.0"), ("0.0001", "0.1")


class Resolution(NamedTuple):
    """Number of points, final time and number of steps."""

    N: int
    horizon: str
    steps: int


SMALL, LARGE = Resolution(39, "1.0", 128), Resolution(199, "1.0", 2048)


class Shape(NamedTuple):
    """A fibre at one time, on its edges.

    Attributes
    ----------
    s : ndarray, shape (N,)
    tangential, normal : ndarray, shape (N, P)
        v_t = <v, d_s r> and v_n = <v, n>.
    bends : ndarray, shape (N - 1, P)
        Angles between neighbouring edges.
    """

    s: Array
    tangential: Array
    normal: Array
    bends: Array


def shape(r: Array, v: Array) -> Shape:
    """Return the drawn quantities of positions and velocities, shape (n, P)."""
    N = len(r) // 2
    tau = edges(r) / spacing(N)
    y = differences(v)
    # Mean velocity of the two ends of an edge, which are cumulative sums of the differences.
    mid = np.cumsum(y, axis=0) - 0.5 * y
    angle = np.unwrap(np.arctan2(tau[:, 1], tau[:, 0]), axis=0)
    turned = np.stack([-tau[:, 1], tau[:, 0]], axis=1)
    s = (np.arange(N) + 1.0) * spacing(N)
    return Shape(s, (mid * tau).sum(axis=1), (mid * turned).sum(axis=1), np.diff(angle, axis=0))


class Fibres(Experiment):
    """One path of each fibre, drawn; mean crimp and fluctuations."""

    name = "lindner-2018-figure-4-1"
    title = "the fibre in the rotating flow and its velocity: two stiffnesses, two turbulences"
    source = "Lindner et al. 2018, Figure 4.1"
    paths = 4
    full_paths = 4
    block = 4
    notes = (
        "The first path of each fibre is drawn, on the same Brownian motion; means are over all paths.",
        "The paper draws ds = 5e-3 and dt = 2.5e-7 and does not print the time; it scales velocities at beta = 1e-4.",
        "Expected: a larger beta crimps the fibre and lets velocities fluctuate; a smaller alpha, a stiffer fibre, "
        "less.",
    )

    def resolution(self, budget: Budget) -> Resolution:
        """Return the paper's resolution at full budget."""
        return LARGE if budget is Budget.FULL else SMALL

    def work(self, budget: Budget) -> Work:
        """Return a run for each fibre."""
        N, horizon, steps = self.resolution(budget)
        at = (steps // 4, steps // 2, steps)
        notes = (Note("r", positions, at), Note("v", velocities, at))
        return {
            (alpha, beta): SchemeRun(fibre_label(alpha=alpha, beta=beta, N=N, horizon=horizon), A, steps, notes)
            for alpha in ALPHAS
            for beta in BETAS
        }

    def exhibit(self, evidence: ExperimentEvidence) -> Exhibit:
        """Return crimp and fluctuations, the curves, and the velocities along them."""
        entries = [entry for alpha in ALPHAS for beta in BETAS for entry in _entries(evidence, alpha, beta)]
        horizon = float(self.resolution(evidence.budget).horizon)
        panels = [_curves(evidence, alpha, horizon) for alpha in ALPHAS]
        velocity = [_velocities(evidence, alpha, horizon) for alpha in ALPHAS]
        return Exhibit(tuple(entries), (*panels, *velocity))


def _shape(evidence: ExperimentEvidence, alpha: str, beta: str) -> Shape:
    return shape(evidence.values((alpha, beta), "r")[-1], evidence.values((alpha, beta), "v")[-1])


def _entries(evidence: ExperimentEvidence, alpha: str, beta: str) -> Iterator[TableEntry]:
    found = _shape(evidence, alpha, beta)
    rough = np.diff(found.normal, axis=0)
    for group, values in (
        ("crimp: root mean square angle between neighbouring edges", found.bends),
        ("fluctuation: root mean square difference of v_n between neighbouring edges", rough),
    ):
        each = mean(np.sqrt((values**2).mean(axis=0)))
        yield each.entry(group, {"alpha": float(alpha), "beta": float(beta)})


def _curves(evidence: ExperimentEvidence, alpha: str, horizon: float) -> Panel:
    curves = []
    for hue, beta in enumerate(BETAS):
        for index, part in enumerate((0.25, 0.5, 1.0)):
            e = edges(evidence.values((alpha, beta), "r")[index])[:, :, 0]
            line = np.cumsum(np.concatenate([[[0.0, -0.5 * spacing(len(e))]], e]), axis=0)
            name = f"beta = {beta}, t = {horizon * part:g}" if part == 1.0 else ""
            kind = "line" if part == 1.0 else "guide"
            curves.append(Curve(name, line[:, 0], line[:, 1], kind=kind, hue=hue))
    return Panel(
        f"a path, alpha = {alpha}; dashed: t = {horizon / 4:g}, {horizon / 2:g}",
        "x_1",
        "x_2",
        tuple(curves),
        equal=True,
    )


def _velocities(evidence: ExperimentEvidence, alpha: str, horizon: float) -> Panel:
    curves = []
    for beta in BETAS:
        found = _shape(evidence, alpha, beta)
        for name, values in (("v_t", found.tangential), ("v_n", found.normal)):
            curves.append(Curve(f"{name}, beta = {beta}", found.s, values[:, 0], kind="line"))
    return Panel(
        f"velocity along the fibre, t = {horizon:g}, alpha = {alpha}", "arc length s", "velocity", tuple(curves)
    )


@hookimpl
def sdaeverify_experiments() -> list[Experiment]:
    """Register the figure."""
    return [Fibres()]
