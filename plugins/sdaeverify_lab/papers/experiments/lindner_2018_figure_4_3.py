"""Figure 4.3 of Lindner et al. (2018): effect of skipped projections on constraints and cost."""

from dataclasses import dataclass

import numpy as np

from sdaeverify import Array, Parts, Problem, hookimpl
from sdaeverify_lab.papers import (
    Budget,
    Curve,
    Exhibit,
    Experiment,
    ExperimentEvidence,
    Note,
    Panel,
    Printed,
    SchemeRun,
    TableEntry,
    Work,
)

from ._estimates import Mean, mean, mean_count, slope, stack
from ._fibres import FINAL, B, differences, edges, fibre_label, norm, spacing

N, ALPHA, BETA = 7, "0.4", "0.1"
# The paper's curve has no numbers; these are from an independent program at T = 1.
COUNTED = {10: "1.00", 100: "1.47", 300: "1.92"}
# Tolerances of Newton's iteration: rounding, and typical values.
TOLERANCES = ("0.0", "1e-11", "1e-10", "1e-08")
# Bound on the defect before an update, in the norm of the figure.
BEFORE = 1e-5


def length_defect(problem: Problem, t: float, parts: Parts) -> Array:
    """Return sum_i ds (|d_s r|^2 - 1)^2 on the edges, shape (P,).

    Parameters
    ----------
    problem : Problem
    t : float
    parts : dict of str to ndarray
        Components of a state; r of shape (2 N, P) is used.
    """
    ds = spacing(len(parts["r"]) // 2)
    e = edges(parts["r"]) / ds
    return ds * (((e * e).sum(axis=1) - 1.0) ** 2).sum(axis=0)


def velocity_defect(problem: Problem, t: float, parts: Parts) -> Array:
    """Return sum_i ds <d_s r, d_s v>^2 on the edges, shape (P,).

    Parameters
    ----------
    problem : Problem
    t : float
    parts : dict of str to ndarray
        Components of a state; r and v of shape (2 N, P) are used.
    """
    ds = spacing(len(parts["r"]) // 2)
    e, y = edges(parts["r"]) / ds, differences(parts["v"]) / ds
    return ds * ((e * y).sum(axis=1) ** 2).sum(axis=0)


@dataclass(frozen=True)
class AboveBefore:
    """Whether the position after another step of size h, before projection, has a defect above BEFORE."""

    h: float

    def __call__(self, problem: Problem, t: float, parts: Parts) -> Array:
        """Return 1 or 0, shape (P,)."""
        free = {"r": parts["r"] + self.h * parts["v"]}
        return np.where(np.sqrt(length_defect(problem, t, free)) > BEFORE, 1.0, 0.0)


DEFECTS = {"| |d_s r|^2 - 1 |": "length", "| <d_s r, d_s v> |": "velocity"}


@dataclass(frozen=True)
class Setting:
    """Final time, number of steps, and numbers of skipped projections."""

    horizon: str
    steps: int
    skips: tuple[int, ...]

    @property
    def problem(self) -> str:
        """Label of the fibre."""
        return fibre_label(alpha=ALPHA, beta=BETA, N=N, horizon=self.horizon)

    @property
    def h(self) -> float:
        """Step size."""
        return float(self.horizon) / self.steps

    def before(self, skip: int) -> tuple[Note, ...]:
        """Return the note on the steps before those that project, for the comparison of iterations."""
        at = range(skip, self.steps, skip + 1)
        return (Note("before", AboveBefore(self.h), at, "mean"),) if skip in COUNTED else ()

    def scheme(self, skip: int, tolerance: str) -> str:
        """Return the label of (B_n)."""
        return f"{B}[skip={skip},solver=newton,tolerance={tolerance}]"


SHORT = Setting("0.03125", 2**12, (0, 10, 30, 100, 300))
WHOLE = Setting("1.0", 2**17, (0, 3, 10, 30, 100, 300))


class Skipping(Experiment):
    """Defects of (B_n) in space and time, its error at T, and the iterations of its projections."""

    name = "lindner-2018-figure-4-3"
    title = "projections skipped for n steps: defects of the constraints, error at T, Newton iterations"
    source = "Lindner et al. 2018, Figure 4.3"
    paths = 4
    full_paths = 10
    block = 10
    notes = (
        "Norms: (dt ds sum over steps and edges of squares)^{1/2}: an edge counts ds, so that a fibre of length 1 "
        "whose defect is 1 everywhere has the norm T^{1/2}. Without the factor ds numbers are sqrt(8) as large.",
        "Iterations are counted in the steps that project; in all steps they are fewer by the factor n + 1.",
        "One update of Newton's method leaves about the square of a defect of size 1e-6 to 1e-4, so that a second "
        "one is the last: the mean count is 1 and the share of projections that make a second one. With a "
        "tolerance on what an update leaves that is a tolerance on squares, whose share rises more slowly with n "
        "than the independent program's counts, 1.00, 1.47, 1.92 at T = 1, at every tolerance.",
        f"These are met where the defect is tested before an update, by {BEFORE:g} in the norm above: then it is the "
        "share of projections that start above it. The paper prints no tolerance, and that counts stay below 2.",
    )

    def setting(self, budget: Budget) -> Setting:
        """Return the paper's time at full budget, otherwise 1/32 of it."""
        return WHOLE if budget is Budget.FULL else SHORT

    def work(self, budget: Budget) -> Work:
        """Return a run for each number of skipped steps, and for further tolerances where needed."""
        at = self.setting(budget)
        every = range(1, at.steps + 1)
        notes = (Note("length", length_defect, every, "mean"), Note("velocity", velocity_defect, every, "mean"))
        return {
            (skip, tolerance): SchemeRun(
                at.problem,
                at.scheme(skip, tolerance),
                at.steps,
                (*FINAL, *notes, *at.before(skip)) if tolerance == TOLERANCES[0] else (),
            )
            for skip in at.skips
            for tolerance in TOLERANCES
            if tolerance == TOLERANCES[0] or skip in COUNTED
        }

    def exhibit(self, evidence: ExperimentEvidence) -> Exhibit:
        """Return defects, errors and iterations by the number of skipped steps."""
        at = self.setting(evidence.budget)
        defects = [_defect(evidence, at, title, skip) for title in DEFECTS for skip in at.skips]
        away = [_error(evidence, at, skip) for skip in at.skips[1:]]
        counts = [
            _count(evidence, at, skip, tolerance)
            for tolerance in TOLERANCES
            for skip in at.skips
            if tolerance == TOLERANCES[0] or skip in COUNTED
        ]
        tested = [_entry_of_early_test(evidence, at, skip) for skip in COUNTED]
        return Exhibit((*defects, *away, *counts, *tested), _panels(evidence, at), tuple(_growths(evidence, at)))


def defect(evidence: ExperimentEvidence, at: Setting, note: str, skip: int) -> Mean:
    """Return the mean over paths of the defect's norm in L2(space x time).

    Parameters
    ----------
    evidence : ExperimentEvidence
    at : Setting
        Setting whose horizon is the length of the time integral.
    note : str
        Name of the note, with time averages of the squared defect.
    skip : int
        Number of steps without projection between two with one.
    """
    squares = evidence.values((skip, TOLERANCES[0]), note)[-1] * float(at.horizon)
    return mean(np.sqrt(squares))


def error(evidence: ExperimentEvidence, skip: int) -> Mean:
    """Return the relative difference of (r, v) at T from the run with all projections, on the same paths."""
    z, z_0 = (
        np.concatenate([evidence.values((each, TOLERANCES[0]), name)[-1] for name in "rv"]) for each in (skip, 0)
    )
    return mean(norm(z - z_0, N) / norm(z_0, N))


def _defect(evidence: ExperimentEvidence, at: Setting, title: str, skip: int) -> TableEntry:
    found = defect(evidence, at, DEFECTS[title], skip)
    return found.entry(
        f"{title} in L2(space x time), T = {at.horizon}, dt = {float(at.horizon) / at.steps:.4g}", {"n": skip}
    )


def _error(evidence: ExperimentEvidence, at: Setting, skip: int) -> TableEntry:
    found = error(evidence, skip)
    return found.entry("relative difference of (r, v) at T from that with every projection", {"n": skip})


def _count(evidence: ExperimentEvidence, at: Setting, skip: int, tolerance: str) -> TableEntry:
    found = mean_count(evidence, (skip, tolerance))
    return found.entry(
        "Newton iterations of a projected step, by the tolerance of Newton's iteration (0: rounding)",
        {"tolerance": tolerance, "n": skip, "a step": f"{found.value / (skip + 1):.4f}"},
    )


def count_if_early(evidence: ExperimentEvidence, skip: int) -> Mean:
    """Return the iterations of a projected step if the defect is tested before the last update.

    There is one iteration, and a second one if the first starts above BEFORE, because an update leaves about the
    square.
    """
    return mean(1.0 + evidence.values((skip, TOLERANCES[0]), "before")[-1])


def _entry_of_early_test(evidence: ExperimentEvidence, at: Setting, skip: int) -> TableEntry:
    found = count_if_early(evidence, skip)
    return found.entry(
        f"the same where the defect is tested before an update, by {BEFORE:g}",
        {"n": skip},
        printed=Printed(COUNTED[skip]) if at is WHOLE else None,
    )


def _growths(evidence: ExperimentEvidence, at: Setting) -> list[str]:
    n = np.array(at.skips[1:], dtype=float)
    return [
        f"{title} grows as n^{slope(n, np.array([defect(evidence, at, note, int(k)).value for k in n])):.2f}"
        for title, note in DEFECTS.items()
    ]


def _panels(evidence: ExperimentEvidence, at: Setting) -> tuple[Panel, ...]:
    n = np.array(at.skips[1:], dtype=float)
    panels = [
        _curve(
            n, [defect(evidence, at, note, int(k)) for k in n], f"{title} in L2(space x time)", "constraint defect"
        )
        for title, note in DEFECTS.items()
    ]
    away = _curve(
        n, [error(evidence, int(k)) for k in n], "(r, v) at T against all projections", "relative difference"
    )
    counts = []
    for tolerance in TOLERANCES:
        skips = [k for k in at.skips if tolerance == TOLERANCES[0] or k in COUNTED]
        found = [mean_count(evidence, (k, tolerance)).value for k in skips]
        name = "to rounding" if tolerance == TOLERANCES[0] else f"tolerance {tolerance}"
        counts.append(Curve(name, np.array(skips, float), np.array(found)))
    early = stack([count_if_early(evidence, skip) for skip in COUNTED])
    counts.append(early.curve("tested before updates", np.array(list(COUNTED), float)))
    if at is WHOLE:
        values = np.array([float(text) for text in COUNTED.values()])
        counts.append(Curve("another program", np.array(list(COUNTED), float), values, kind="printed"))
    return (
        *panels,
        away,
        Panel("iterations of a projected step", "skipped steps n", "Newton iterations", tuple(counts)),
    )


def _curve(n: Array, found: list[Mean], title: str, y: str) -> Panel:
    curve = stack(found).curve("mean, 90 %", n)
    guide = Curve("slope 1", n, curve.y[0] * n / n[0], kind="guide")
    return Panel(title, "skipped steps n", y, (curve, guide), "xy")


@hookimpl
def sdaeverify_experiments() -> list[Experiment]:
    """Register the figure."""
    return [Skipping()]
