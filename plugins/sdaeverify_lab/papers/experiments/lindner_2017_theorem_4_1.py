"""Theorem 4.1 of Lindner & Stroot (2017): sup norms on the grid, and in continuous time with interpolants."""

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
    SchemeRun,
    TableEntry,
    Work,
)

from ._estimates import mean, order, slope
from ._fibres import positions, velocities

PROBLEMS = {"B = Id": "pendulum[horizon=1.0]", "B = v": "pendulum-velocity-noise[horizon=1.0]"}
SCHEME, PARTS = "half-explicit-euler[truncation=none]", ("r", "v", "mu")
STEPS, REFERENCE = (16, 32, 64, 128, 256), 4096
WHERE = ("grid", "constant", "linear")
# Powers p of (E sup |error|^p)^{1/p} on the grid, in addition to p = 1.
POWERS = (2, 4, 8)
# Orders expected from theory, on the grid and in continuous time; r has finite variation.
EXPECTED = {"B = Id": 1.0, "B = v": 0.5}


def multipliers(problem: Problem, t: float, parts: Parts) -> Array:
    """Return mu, shape (m, P).

    Parameters
    ----------
    problem : Problem
    t : float
    parts : dict of str to ndarray
        Components of a state, including mu.
    """
    return parts["mu"]


class SupNorms(Experiment):
    """E sup |error| over the grid, and over all times with piecewise constant and linear interpolants."""

    name = "lindner-2017-theorem-4-1"
    title = "strong convergence in sup norms: on the grid and in continuous time"
    source = "Lindner & Stroot 2017, Theorem 4.1"
    paths = 100
    full_paths = 1000
    block = 100
    notes = (
        "Theorem 4.1 claims convergence without a rate. On the grid order 1 is expected where B does not depend on "
        "v, and 1/2 where it does; in continuous time v and mu cannot do better than (h log 1/h)^{1/2}, because a "
        "Brownian path is not resolved between grid points, and r of a piecewise constant interpolant not better "
        "than h.",
        "On the grid runs are compared with those of half the step size, in continuous time with 4096 steps. "
        "Expected of (h log 1/h)^{1/2}: its slope over these h.",
        "The theorem claims convergence for every p. A large p is carried by few paths: see their number.",
    )

    def work(self, budget: Budget) -> Work:
        """Return the runs, each recorded after every step."""
        return {
            (problem, steps): SchemeRun(label, SCHEME, steps, _notes(steps))
            for problem, label in PROBLEMS.items()
            for steps in (*STEPS, 2 * STEPS[-1], REFERENCE)
        }

    def exhibit(self, evidence: ExperimentEvidence) -> Exhibit:
        """Return orders and curves."""
        found = {problem: _errors(evidence, problem) for problem in PROBLEMS}
        entries = [
            _entry(problem, part, where, errors[part, where])
            for problem, errors in found.items()
            for part in PARTS
            for where in WHERE
        ]
        entries += [
            _power_entry(problem, part, p, errors[part, "grid"])
            for problem, errors in found.items()
            for part in PARTS
            for p in POWERS
        ]
        return Exhibit(tuple(entries), tuple(_panel(problem, errors) for problem, errors in found.items()))


def _notes(steps: int) -> tuple[Note, ...]:
    every = range(1, steps + 1)
    return (Note("r", positions, every), Note("v", velocities, every), Note("mu", multipliers, every))


def _path(evidence: ExperimentEvidence, problem: str, steps: int, part: str) -> Array:
    """Return a component at all times including the start, shape (steps + 1, k, P)."""
    made = evidence.values((problem, steps), part)
    start = evidence.problem(PROBLEMS[problem]).initial(1)._asdict()[part]
    return np.concatenate([np.broadcast_to(start, made[:1].shape), made])


def _errors(evidence: ExperimentEvidence, problem: str) -> dict[tuple[str, str], Array]:
    """Return sup |error| of each path by component and sense of the supremum, shape (L, P)."""
    found: dict[tuple[str, str], list[Array]] = {(part, where): [] for part in PARTS for where in WHERE}
    for part in PARTS:
        fine = _path(evidence, problem, REFERENCE, part)
        for steps in STEPS:
            coarse, finer = (_path(evidence, problem, each, part) for each in (steps, 2 * steps))
            found[part, "grid"].append(_sup(coarse - finer[::2]))
            for where, interpolant in _interpolants(coarse, REFERENCE // steps):
                found[part, where].append(_sup(interpolant - fine))
    return {key: np.array(values) for key, values in found.items()}


def _sup(x: Array) -> Array:
    """Return sup_t |x(t)| of each path, shape (times, k, P) -> (P,)."""
    sup: Array = np.sqrt((x * x).sum(axis=1)).max(axis=0)
    return sup


def _interpolants(x: Array, ratio: int) -> list[tuple[str, Array]]:
    steps = len(x) - 1
    constant = np.concatenate([np.repeat(x[:-1], ratio, axis=0), x[-1:]])
    part = np.tile(np.arange(ratio) / ratio, steps)[:, None, None]
    rise = np.concatenate([np.repeat(np.diff(x, axis=0), ratio, axis=0) * part, np.zeros_like(x[:1])])
    return [("constant", constant), ("linear", constant + rise)]


def _sizes() -> Array:
    return 1.0 / np.array(STEPS)


def _entry(problem: str, part: str, where: str, errors: Array) -> TableEntry:
    fitted, h = order(_sizes(), errors), _sizes()
    rough = where != "grid" and (part != "r" or where == "constant")
    brownian = slope(h, np.sqrt(h * np.log(1.0 / h)))
    expected = (min(1.0, EXPECTED[problem]) if part == "r" else brownian) if rough else EXPECTED[problem]
    return fitted.entry(
        f"order of E sup |error|, {problem}",
        {"of": part, "sup over": "grid" if where == "grid" else f"all t, {where}", "expected": f"{expected:.2f}"},
    )


def _power_entry(problem: str, part: str, p: int, errors: Array) -> TableEntry:
    fitted = order(_sizes(), errors**p)
    value, std_error = (float(each) / p for each in (fitted.value, fitted.std_error))
    group = f"order of (E sup |error|^p)^(1/p) on the grid, {problem}, expected {EXPECTED[problem]:g}"
    effective = float(min((errors**p).sum(axis=1) ** 2 / (errors ** (2 * p)).sum(axis=1)))
    return TableEntry(group, {"of": part, "p": p}, value, std_error, errors.shape[1], effective)


def _panel(problem: str, errors: dict[tuple[str, str], Array]) -> Panel:
    h, curves = _sizes(), []
    for part in PARTS:
        for where in ("grid", "linear"):
            name = f"{part}, {'grid' if where == 'grid' else 'all t'}"
            curves.append(mean(errors[part, where]).curve(name, h))
    top = curves[3].y[0]
    brownian = np.sqrt(h * np.log(1.0 / h))
    curves.append(Curve("(h log 1/h)^(1/2)", h, top * brownian / brownian[0], kind="guide"))
    curves.append(Curve("h", h, curves[2].y[0] * h / h[0], kind="guide"))
    return Panel(f"pendulum, {problem}, T = 1", "h", "E sup |error|, 90 %", tuple(curves), "xy")


@hookimpl
def sdaeverify_experiments() -> list[Experiment]:
    """Register the sup norms."""
    return [SupNorms()]
