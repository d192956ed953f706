"""Theorem 7 of Lindner et al. (2018): fourth moments of a fibre beside the bound (3.4)."""

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
    Probe,
    SchemeRun,
    TableEntry,
    Work,
)

from ._estimates import Mean, mean
from ._fibres import B, fibre_label

HORIZONS, PER_TIME = (1, 2, 4, 8), 128
PROBLEM = fibre_label(alpha=4.0, N=2, horizon=float(HORIZONS[-1]))


def _fourth(problem: Problem, t: float, parts: Parts) -> Array:
    """Return |(r, v)|^4, shape (P,)."""
    return ((parts["r"] ** 2).sum(axis=0) + (parts["v"] ** 2).sum(axis=0)) ** 2


def growth(problems: tuple[Problem, ...], schemes: tuple[object, ...]) -> dict[str, Array]:
    """Return the least C_T >= 1 of (3.2b) to a few per cent, and |(r_0, v_0)|^4.

    a is affine and B constant: |a(x, y)| <= |a(0)| + |L| |(x, y)|, and C_T the largest of |a(0)|, |L|, |B|_F and 1.
    """
    (problem,) = problems
    n, start = problem.dimension, problem.initial(1)
    zero = np.zeros((n, 1))
    still = problem.force(0.0, zero, zero)
    columns = [problem.force(0.0, x[:, None], y[:, None]) - still for x, y in np.eye(2 * n).reshape(2 * n, 2, n)]
    units = np.eye(problem.noise_dim)
    noise = [problem.diffused(0.0, zero, zero, unit[:, None]) for unit in units]
    sizes = (np.linalg.norm(still), np.linalg.norm(np.hstack(columns), 2), np.linalg.norm(np.hstack(noise)), 1.0)
    return {"C_T": np.array([max(map(float, sizes))]), "start": _fourth(problem, 0.0, {"r": start.r, "v": start.v})}


class FourthMoments(Experiment):
    """E sup |(r, v)|^4 up to several times, and log of the bound."""

    name = "lindner-2018-theorem-7"
    title = "fourth moments of a fibre in time, and the bound (3.4)"
    source = "Lindner et al. 2018, Theorem 7"
    paths = 200
    full_paths = 2000
    notes = (
        "The theorem bounds E sup |(r, v)|^4 by C (E |(r_0, v_0)|^4 + C_T^2 T^3) exp(C C_T^2 T^3) with a C that does "
        "not depend on T. The table has the log of the bound for C = 1: one C serves all T, also one far below 1.",
        "C_T is the growth constant of force and noise; the fibre's force is affine, its noise constant.",
    )

    def work(self, budget: Budget) -> Work:
        """Return one run with a supremum up to each time, and a probe of C_T."""
        notes = tuple(Note(f"T={T}", _fourth, range(1, PER_TIME * T + 1), "max") for T in HORIZONS)
        return {"run": SchemeRun(PROBLEM, B, PER_TIME * HORIZONS[-1], notes), "growth": Probe(growth, (PROBLEM,))}

    def exhibit(self, evidence: ExperimentEvidence) -> Exhibit:
        """Return the moments and the bound."""
        known = evidence.probe("growth")
        C_T, start = float(known["C_T"][0]), float(known["start"][0])
        found = [mean(np.maximum(start, evidence.values("run", f"T={T}")[-1])) for T in HORIZONS]
        bounds = [float(np.log(start + C_T**2 * T**3) + C_T**2 * T**3) for T in HORIZONS]
        entries = [TableEntry("C_T of the fibre, and |(r_0, v_0)|^4", {"of": "C_T"}, C_T),
                   TableEntry("C_T of the fibre, and |(r_0, v_0)|^4", {"of": "start"}, start)]  # fmt: skip
        for T, moment, bound in zip(HORIZONS, found, bounds, strict=True):
            entries += [
                moment.entry("E sup |(r, v)|^4 up to T", {"T": T}),
                TableEntry("log of the bound (3.4) with C = 1", {"T": T}, bound),
            ]
        return Exhibit(tuple(sorted(entries, key=lambda entry: entry.group)), (_panel(found, bounds),))


def _panel(found: list[Mean], bounds: list[float]) -> Panel:
    T = np.array(HORIZONS, dtype=float)
    values, errors = np.array([(each.value, each.std_error / each.value) for each in found]).T
    log = np.log(values)
    curves = (Curve("log E sup |(r, v)|^4", T, log, log - 2.0 * errors, log + 2.0 * errors),
              Curve("log of the bound, C = 1", T, np.array(bounds), kind="guide"))  # fmt: skip
    return Panel("fibre of 2 points, alpha = 4", "T", "log", curves, "x")


@hookimpl
def sdaeverify_experiments() -> list[Experiment]:
    """Register the moments."""
    return [FourthMoments()]
