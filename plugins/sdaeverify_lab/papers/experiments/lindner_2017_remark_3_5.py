"""Remark 3.5 of Lindner & Stroot (2017): what a weaker truncation leaves of the estimates (3.17)."""

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

from ._estimates import slope

SIZES, SPEEDS = 2.0 ** -np.arange(4, 12), 10.0 ** np.arange(0.0, 5.0)
THETA, LARGE = 0.7, 0.5
W = np.array([0.6, -0.8])
# What the truncation bounds, times h: |v| alone, and the maximum of (3.14).
TRUNCATIONS = {"weak, |v|": False, "full, (3.14)": True}


def remainders(problems: tuple[Problem, ...], schemes: tuple[Scheme, ...]) -> Mapping[str, Array]:
    """Return |lambda^re| and |Lambda^re w| of a truncated step of the pendulum, by truncation, speed and h.

    sin phi = eta |v| h is the angle of a step on the circle. Solving (3.13) there, with a_t the tangential force,

        lambda^re = |v| (tan phi - sin phi) + eta h a_t tan phi,    Lambda^re w = w_t tan phi.

    The remainders are taken from a solution of (3.13b) as a linear equation, not from this form.
    """
    (problem,) = problems
    found = {
        (name, part): np.array([[_remainder(problem, speed, h, full=full)[part] for h in (*SIZES, LARGE)]
                                for speed in SPEEDS])
        for name, full in TRUNCATIONS.items() for part in (0, 1)
    }  # fmt: skip
    return {f"{name}: {PARTS[part]}": values for (name, part), values in found.items()}


PARTS = ("lambda^re", "Lambda^re w")


def _remainder(problem: Problem, speed: float, h: float, *, full: bool) -> tuple[float, float]:
    r, along = np.array([np.sin(THETA), -np.cos(THETA)]), np.array([np.cos(THETA), np.sin(THETA)])
    v = speed * along
    a = problem.force(0.0, r[:, None], v[:, None])[:, 0]
    C_eta = 0.25 * problem.constraint_bound**-3
    bounded = max(speed, speed**2, float(np.linalg.norm(a))) if full else speed
    eta = min(1.0, C_eta / (bounded * h))
    # kappa of (3.13a) is the root of |r + eta v h - r kappa| = 1 near 0; Dg = -r^T, grad g = -r.
    kappa = 1.0 - np.sqrt(1.0 - (eta * speed * h) ** 2)
    new = r * (1.0 - kappa) + eta * h * v
    lam, lam_w = ((new @ (v * (part == 0) + push)) / (new @ r) for part, push in enumerate((eta * h * a, W)))
    # The leading terms of (3.16): D^2 g(v, v) = -|v|^2 and G = 1.
    return abs(float(lam - (r @ a * eta * h + eta * h * speed**2))), abs(float(lam_w - r @ W))


class WeakTruncation(Experiment):
    """Exponents of h at a fixed state, and of |v| at a fixed h, under both truncations."""

    name = "lindner-2017-remark-3-5"
    title = "remainders of lambda under the weaker truncation of Remark 3.5"
    source = "Lindner & Stroot 2017, (3.14), (3.17) and Remark 3.5"
    paths = 2
    notes = (
        "Estimate (3.17) has two bounds: by h^2 and h at a fixed state, and by constants, whatever h and |v|. Remark "
        "3.5: if |v| h alone is truncated, the first are left. The second are lost: lambda^re grows like |v|.",
        "Lambda^re w is bounded under both, as B = Id does not grow.",
    )

    def work(self, budget: Budget) -> Work:
        """Return one probe."""
        return {"remainders": Probe(remainders, ("pendulum",))}

    def exhibit(self, evidence: ExperimentEvidence) -> Exhibit:
        """Return the exponents."""
        found = evidence.probe("remainders")
        in_h, in_v = "exponent of h at |v| = 1, h = 2^-4 to 2^-11", f"exponent of |v| = 1e2 to 1e4 at h = {LARGE}"
        entries = []
        for name, full in TRUNCATIONS.items():
            for part, power in zip(PARTS, (2.0, 1.0), strict=True):
                values = found[f"{name}: {part}"]
                at = {"truncation": name, "of": part}
                entries.append(TableEntry(in_h, {**at, "bound": f"{power:g}"}, slope(SIZES, values[0, :-1])))
                bound = "none" if part == PARTS[0] and not full else "0"
                entries.append(
                    TableEntry(in_v, {**at, "bound": bound}, round(slope(SPEEDS[2:], values[2:, -1]), 12) + 0.0)
                )
        return Exhibit(tuple(sorted(entries, key=lambda entry: entry.group)), (_panel(found),))


def _panel(found: Mapping[str, Array]) -> Panel:
    curves = [
        Curve(f"|{part}|, {name}", SPEEDS, found[f"{name}: {part}"][:, -1]) for name in TRUNCATIONS for part in PARTS
    ]
    return Panel(f"a step of the pendulum, h = {LARGE}", "|v|", "remainder", tuple(curves), "xy")


@hookimpl
def sdaeverify_experiments() -> list[Experiment]:
    """Register the remainders."""
    return [WeakTruncation()]
