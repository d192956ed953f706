"""Moments of the uniformly accurate integrator of Laurent (2022), which his proofs bound for all eps at once."""

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
    Work,
)

from ._estimates import Mean, mean

STIFFNESSES = ("1e-08", "1e-06", "0.0001", "0.01", "0.1", "1.0", "100.0")
UNIFORM, EXPLICIT = "uniformly-accurate[xi=three-point]", "penalised-euler[xi=three-point]"
NAMES = {UNIFORM: "uniformly accurate (2.2)", EXPLICIT: "Euler (1.5)"}
HORIZON, STEPS = 8, (64, 256)


def _eighth(problem: Problem, t: float, parts: Parts) -> Array:
    """Return |x|^8, shape (P,)."""
    return (parts["x"] ** 2).sum(axis=0) ** 4


class UniformMoments(Experiment):
    """sup over n of E |X_n|^8 by eps and h."""

    name = "laurent-2022-moments"
    title = "eighth moments of the integrators for eps from 1e-8 to 100"
    source = "Laurent 2022, Assumption 2.1 and section 3"
    paths = 500
    full_paths = 4000
    notes = (
        "Near the unit circle with a constant force, up to T = 8. The integrator's moments are bounded for all eps "
        "at once, by those of a large eps, where the force alone moves x. Explicit Euler's grow, or its paths are "
        "lost, where h is larger than eps.",
        "The supremum over n is of means at every time unit.",
    )

    def work(self, budget: Budget) -> Work:
        """Return a run for each scheme, eps and number of steps."""
        return {(scheme, eps, steps): _run(scheme, eps, steps)
                for scheme in NAMES for eps in STIFFNESSES for steps in STEPS}  # fmt: skip

    def exhibit(self, evidence: ExperimentEvidence) -> Exhibit:
        """Return the moments."""
        entries = [
            _largest(evidence, scheme, eps, steps).entry(
                f"sup_n E |X_n|^8, {NAMES[scheme]}", {"eps": float(eps), "h": HORIZON / steps}
            )
            for scheme in NAMES
            for steps in STEPS
            for eps in STIFFNESSES
        ]
        return Exhibit(tuple(entries), tuple(_panel(evidence, steps) for steps in STEPS))


def _run(scheme: str, eps: str, steps: int) -> SchemeRun:
    every = range(steps // HORIZON, steps + 1, steps // HORIZON)
    return SchemeRun(f"penalised-sphere[eps={eps},horizon={HORIZON}.0]", scheme, steps, (Note("x", _eighth, every),))


def _largest(evidence: ExperimentEvidence, scheme: str, eps: str, steps: int) -> Mean:
    """Return the largest mean over the times; NaN where paths are lost."""
    found = mean(evidence.values((scheme, eps, steps), "x"))
    if not np.isfinite(found.value).all():
        return Mean(np.nan, np.nan, 0)
    worst = int(found.value.argmax())
    return Mean(found.value[worst], found.std_error[worst], found.paths)


def _panel(evidence: ExperimentEvidence, steps: int) -> Panel:
    x = np.array([float(eps) for eps in STIFFNESSES])
    curves = []
    for scheme, name in NAMES.items():
        values, errors, _ = np.array([_largest(evidence, scheme, eps, steps) for eps in STIFFNESSES]).T
        curves.append(Curve(name, x, values, values - 2.0 * errors, values + 2.0 * errors))
    return Panel(f"h = {HORIZON / steps:g}", "eps", "sup_n E |X_n|^8", tuple(curves), "xy")


@hookimpl
def sdaeverify_experiments() -> list[Experiment]:
    """Register the moments."""
    return [UniformMoments()]
