"""Figure 5.1 of Lindner et al. (2018): the fibre for dt = ds -> 0, on one white noise in space and time."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from sdaeverify import Array, hookimpl
from sdaeverify_lab.papers import (
    Budget,
    Curve,
    Exhibit,
    Experiment,
    ExperimentEvidence,
    Panel,
    SchemeRun,
    SharedNoise,
    TableEntry,
    Work,
)
from sdaeverify_problems import Fibre, clamped_chain
from sdaeverify_problems.fibres._hanging_fibre import hanging_fibre

from ._estimates import mean, order
from ._fibres import FINAL, A, fibre_label

D, COARSEST = 2, 8
Z = {"r": ("r",), "(r, v)": ("r", "v")}
BETAS = ("0.1", "0.0001")
# Turbulence weak enough for the transverse motion of the fibre to follow the linear equation, and final time.
WEAK, TIME = "1e-06", "0.25"


class Cells(NamedTuple):
    """Numbers of cells 1/ds, doubling, the last one of the reference; and the final time."""

    numbers: tuple[int, ...]
    horizon: str

    def steps(self, cells: int) -> int:
        """Return the number of steps at which dt = ds."""
        return round(float(self.horizon) * cells)


SHORT, WHOLE = Cells((8, 16, 32, 64), "1.0"), Cells((8, 16, 32, 64, 128), "2.5")


@dataclass(frozen=True)
class CellSums:
    """Increments of the points of a coarse fibre from those of a fine one, for the same white noise.

    With the noise xi(I_i) of a cell of length ds, w_i = xi(I_i)/sqrt(ds): cells are joined, and divided by the coarse
    root. Point i has the cell (i ds, (i + 1) ds); the first cell belongs to the clamp.

    Attributes
    ----------
    coarse, fine : int
        Numbers of cells.
    """

    coarse: int
    fine: int

    def __call__(self, w: Array) -> Array:
        """Return the increments of the coarse fibre, shape (steps, (fine - 1) d, P) -> (steps, (coarse - 1) d, P)."""
        steps, _, paths = w.shape
        ratio = self.fine // self.coarse
        cells = w.reshape(steps, self.fine - 1, D, paths)[:, ratio - 1 :]
        joined = cells.reshape(steps, self.coarse - 1, ratio, D, paths).sum(axis=2)
        return joined.reshape(steps, -1, paths) / np.sqrt(ratio)


class SpaceTime(Experiment):
    """Errors of (A) with dt = ds against the finest grid, and the law of two fibres with a common fine noise."""

    name = "lindner-2018-figure-5-1"
    title = "refinement in space and time together, dt = ds -> 0, on shared white noise"
    source = "Lindner et al. 2018, Figure 5.1"
    paths = 20
    full_paths = 20
    block = 20
    notes = (
        "One white noise in space and time drives all grids: increments of neighbouring cells and steps are added, "
        "so that the coarse noise is that of the fine one to rounding (Chen's relation).",
        "Errors are taken on the coarse cells, over which the finest fibre is averaged. Orders are those of the "
        "distance of neighbouring grids, where no reference has an error of its own.",
        "In v no order shows at beta = 0.1: the drag forgets a velocity within Dr^2 = 1/100, and steps are longer, "
        "so that the kick of a step is damped by a factor of its length. The paper does not say of what its order "
        "1 is.",
        "Scheme: the standard deviation of (A) on the linear equation at these steps.",
    )

    def cells(self, budget: Budget) -> Cells:
        """Return the paper's time at full budget."""
        return WHOLE if budget is Budget.FULL else SHORT

    def work(self, budget: Budget) -> Work:
        """Return the runs by turbulence and number of cells, and two weakly driven ones."""
        at = self.cells(budget)
        runs: dict[object, SchemeRun] = {}
        for beta in BETAS:
            for cells in at.numbers:
                runs[beta, cells] = _run(beta, cells, at.numbers[-1], at.horizon, at.steps(cells))
        for cells in (10, 40):
            runs["law", cells] = _run(WEAK, cells, 40, TIME, 256)
        return runs

    def exhibit(self, evidence: ExperimentEvidence) -> Exhibit:
        """Return orders, errors, and variances of the tip next to the exact ones."""
        at = self.cells(evidence.budget)
        entries = [_order(evidence, at, beta, z) for beta in BETAS for z in Z]
        errors = [_error(evidence, at, beta, z, cells) for beta in BETAS for z in Z for cells in at.numbers[:-1]]
        laws = [_variance(evidence, cells, part) for cells in (10, 40) for part in "rv"]
        return Exhibit((*entries, *errors, *laws), (_panel(evidence, at), _law_panel(evidence)))


def _run(beta: str, cells: int, finest: int, horizon: str, steps: int) -> SchemeRun:
    return SchemeRun(
        fibre_label(alpha="0.4", beta=beta, N=cells - 1, horizon=horizon),
        A,
        steps,
        FINAL,
        noise=SharedNoise(f"white noise of {finest} cells, beta = {beta}", (finest - 1) * D),
        drive=CellSums(cells, finest),
    )


def on_cells(z: Array, cells: int) -> Array:
    """Return the means over coarse cells of a finer fibre's points, shape ((fine - 1) d, P) -> (cells - 1, d, P)."""
    points = z.reshape(-1, D, z.shape[1])
    ratio = (len(points) + 1) // cells
    return points[ratio - 1 :].reshape(cells - 1, ratio, D, -1).mean(axis=1)


def distance(evidence: ExperimentEvidence, beta: str, z: str, cells: int, finer: int) -> Array:
    """Return |z - z_finer|/|z_finer| at T of each path, on the cells of the coarse grid, shape (P,).

    Parameters
    ----------
    evidence : ExperimentEvidence
    beta : str
        Factor of the noise (turbulence).
    z : str
        Compared components, a key of `Z`.
    cells, finer : int
        Numbers of cells of the two grids.
    """
    squares = np.zeros(2)[:, None]
    for name in Z[z]:
        fine = on_cells(evidence.values((beta, finer), name)[-1], cells)
        own = on_cells(evidence.values((beta, cells), name)[-1], cells)
        squares = squares + np.array([((own - fine) ** 2).sum(axis=(0, 1)), (fine**2).sum(axis=(0, 1))])
    return np.sqrt(squares[0] / squares[1])


def relative_error(evidence: ExperimentEvidence, at: Cells, beta: str, z: str, cells: int) -> Array:
    """Return the distance from the finest grid, shape (P,).

    Parameters
    ----------
    evidence : ExperimentEvidence
    at : Cells
        Grids, the last of which is the finest.
    beta : str
        Factor of the noise (turbulence).
    z : str
        Compared components, a key of `Z`.
    cells : int
        Number of cells of the grid.
    """
    return distance(evidence, beta, z, cells, at.numbers[-1])


def _errors(evidence: ExperimentEvidence, at: Cells, beta: str, z: str) -> Array:
    return np.array([relative_error(evidence, at, beta, z, cells) for cells in at.numbers[:-1]])


def _order(evidence: ExperimentEvidence, at: Cells, beta: str, z: str) -> TableEntry:
    ds = 1.0 / np.array(at.numbers[:-1])
    pairs = zip(at.numbers[:-1], at.numbers[1:], strict=True)
    fitted = order(ds, np.array([distance(evidence, beta, z, *pair) for pair in pairs]))
    return fitted.entry(
        f"order in ds = dt of the distance of neighbouring grids, T = {at.horizon}, alpha = 0.4",
        {"beta": float(beta), "z": z, "grids": len(ds)},
    )


def _error(evidence: ExperimentEvidence, at: Cells, beta: str, z: str, cells: int) -> TableEntry:
    found = mean(relative_error(evidence, at, beta, z, cells))
    return found.entry("relative error", {"beta": float(beta), "z": z, "1/ds": cells})


def _scale(cells: int, part: str) -> tuple[float, float]:
    """Return the exact standard deviation of the transverse motion of the tip, and that of (A), from its matrices."""
    N = cells - 1
    fibre = Fibre(chain=clamped_chain(N, D), alpha=0.4, beta=float(WEAK))
    straight = hanging_fibre(fibre, 1.0)
    tip, t, steps = (N - 1 if part == "r" else 2 * N - 1), float(TIME), 256
    h = t / steps
    step = np.linalg.inv(np.eye(2 * N) - h * straight.generator)
    covariance = np.zeros((2 * N, 2 * N))
    for _ in range(steps):
        covariance = step @ (covariance + h * straight.noise @ straight.noise.T) @ step.T
    exact = straight.covariance(t)[tip, tip]
    return float(np.sqrt(exact)), float(np.sqrt(covariance[tip, tip]))


def _tip_positions(evidence: ExperimentEvidence, cells: int, part: str) -> Array:
    return evidence.values(("law", cells), part)[-1][-D]


def _variance(evidence: ExperimentEvidence, cells: int, part: str) -> TableEntry:
    x = _tip_positions(evidence, cells, part)
    exact, scheme = _scale(cells, part)
    # The relative error of the standard deviation of a normal sample is 1/sqrt(2 (P - 1)).
    return TableEntry(
        f"standard deviation of the tip across the fibre, beta = {WEAK}, t = {TIME}, one noise of 40 cells",
        {"N + 1": cells, "of": f"{part}_1"},
        float(x.std(ddof=1)),
        float(x.std(ddof=1) / np.sqrt(2.0 * (len(x) - 1))),
        len(x),
        exact=exact,
        exact_source="linearised fibre, Lyapunov equation; the flow makes it relative 1.5 percent wrong",
        expected=scheme,
    )


def _panel(evidence: ExperimentEvidence, at: Cells) -> Panel:
    ds = 1.0 / np.array(at.numbers[:-1])
    curves = [mean(_errors(evidence, at, beta, z)).curve(f"{z}, beta = {beta}", ds) for beta in BETAS for z in Z]
    curves.append(Curve("order 1", ds, curves[0].y[0] * ds / ds[0], kind="guide"))
    return Panel(f"(A), dt = ds, T = {at.horizon}", "dt = ds", "relative error at T, 90 %", tuple(curves), "xy")


def _law_panel(evidence: ExperimentEvidence) -> Panel:
    coarse, fine = (_tip_positions(evidence, cells, "r") for cells in (10, 40))
    centre, scale = fine.mean(), fine.std(ddof=1)
    ends = np.array([-2.5, 2.5])
    curves = (
        Curve("a path", (fine - centre) / scale, (coarse - coarse.mean()) / scale, kind="marks"),
        Curve("equal", ends, ends, kind="guide"),
    )
    return Panel(
        "the tip on one noise", "N = 39, in standard deviations", "N = 9, in the same unit", curves, equal=True
    )


@hookimpl
def sdaeverify_experiments() -> list[Experiment]:
    """Register the figure."""
    return [SpaceTime()]
