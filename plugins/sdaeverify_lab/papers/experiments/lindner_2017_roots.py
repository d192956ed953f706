"""Frequency of steps without root for the pendulum, by h and omega_0: section 5.1 of Lindner & Stroot."""

from functools import cache

import numpy as np

from sdaeverify import hookimpl
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

from ._fibres import positions

HORIZON, STEPS, OMEGAS = 1.0, (2, 4, 8, 16, 32), ("0.0", "1.0", "2.0", "4.0")
SCHEMES = {"none": "half-explicit-euler[truncation=none]", "theory": "half-explicit-euler"}
# Gauss-Legendre nodes of the operator, on an interval of length 2/h for a kernel of width h^(1/2).
FEWEST, PER_H = 300, 38.0


@cache
def exact_share(omega: float, h: float, steps: int) -> float:
    """Return P(some |omega_k| h >= 1, k < steps) of the chain without truncation.

    omega+ is normal with mean omega/cos(phi) and deviation sqrt(h)/cos(phi), sin(phi) = omega h. The survival
    probability is propagated on Gauss-Legendre nodes in phi.

    Parameters
    ----------
    omega : float
        Angular velocity at time 0, in 1/time.
    h : float
        Step size.
    steps : int
        Number of steps of the chain.
    """
    x, w = np.polynomial.legendre.leggauss(max(FEWEST, round(PER_H / h)))
    phi = 0.5 * np.pi * x
    at, cosine = np.sin(phi) / h, np.cos(phi)
    weights = 0.5 * np.pi * w * cosine / h

    def density(start: np.ndarray, cos: np.ndarray) -> np.ndarray:
        z = (at[:, None] * cos - start) / np.sqrt(h)
        return np.exp(-0.5 * z * z) * cos / np.sqrt(2.0 * np.pi * h)

    if abs(omega) * h >= 1.0:
        return 1.0
    if steps == 1:
        return 0.0
    p = density(np.array([omega]), np.sqrt(1.0 - np.array([omega * h]) ** 2))[:, 0]
    kernel = density(at, cosine) * weights
    for _ in range(steps - 2):
        p = kernel @ p
    # Clipped, because the sum is rounded.
    return float(np.clip(1.0 - weights @ p, 0.0, 1.0))


class WithoutRoot(Experiment):
    """Fraction of paths without root, with and without truncation."""

    name = "lindner-2017-section-5-1-roots"
    title = "share of pendulum paths that meet a step without root, with and without truncation"
    source = "Lindner & Stroot 2017, section 5.1"
    paths = 2000
    full_paths = 100000
    block = 5000
    notes = (
        "On the free pendulum omega is a Markov chain, whose first exit from |omega| h < 1 needs no sampling: the "
        "column scheme. With truncation there is a root at every h, Theorem 3.4.",
        "At h = 1/2 and omega_0 = 2, and wherever omega_0 h >= 1, the first step has none; at omega_0 h = 1 it has "
        "one, with a Jacobian of 0.",
    )

    def work(self, budget: Budget) -> Work:
        """Return the runs."""
        return {
            (truncation, omega, steps): SchemeRun(
                f"pendulum[c_g=0,omega_0={omega},horizon={HORIZON}]", scheme, steps, (Note("r", positions),)
            )
            for truncation, scheme in SCHEMES.items()
            for omega in OMEGAS
            for steps in STEPS
        }

    def exhibit(self, evidence: ExperimentEvidence) -> Exhibit:
        """Return the fractions next to the exact ones."""
        entries = [
            _entry(evidence, truncation, omega, steps)
            for truncation in SCHEMES
            for omega in OMEGAS
            for steps in STEPS
        ]
        return Exhibit(tuple(entries), (_panel(evidence),))


def share(evidence: ExperimentEvidence, truncation: str, omega: str, steps: int) -> tuple[float, float]:
    """Return the fraction of paths without root and its standard error.

    Parameters
    ----------
    evidence : ExperimentEvidence
    truncation, omega : str
        Truncation and initial angular velocity as in the plan.
    steps : int
        Number of steps from 0 to T.
    """
    evidence.values((truncation, omega, steps), "r")
    lost = evidence.run((truncation, omega, steps)).noted["r"].without_root[-1]
    p = float(lost.mean())
    return p, float(np.sqrt(p * (1.0 - p) / len(lost)))


def _entry(evidence: ExperimentEvidence, truncation: str, omega: str, steps: int) -> TableEntry:
    p, std_error = share(evidence, truncation, omega, steps)
    h = HORIZON / steps
    exact = exact_share(float(omega), h, steps) if truncation == "none" else 0.0
    if truncation == "none":
        # If no path or every path is lost, use the error of the exact fraction, at least a quarter of a path.
        std_error = max(std_error, float(np.sqrt(exact * (1.0 - exact) / evidence.paths)), 0.25 / evidence.paths)
    return TableEntry(
        f"share of paths that meet a step without root up to T = 1, truncation = {truncation}",
        {"omega_0": float(omega), "h": h},
        p,
        std_error,
        evidence.paths,
        expected=exact,
        more={"expected_source": "transfer operator of omega" if truncation == "none" else "Theorem 3.4"},
    )


def _panel(evidence: ExperimentEvidence) -> Panel:
    h = HORIZON / np.array(STEPS)
    curves = []
    for hue, omega in enumerate(OMEGAS):
        found = np.array([share(evidence, "none", omega, steps) for steps in STEPS])
        low, high = found[:, 0] - 2.0 * found[:, 1], found[:, 0] + 2.0 * found[:, 1]
        curves.append(Curve(f"omega_0 = {omega}", h, found[:, 0], low, high, "marks", hue))
        exact = np.array([exact_share(float(omega), HORIZON / steps, steps) for steps in STEPS])
        curves.append(Curve("", h, exact, kind="guide", hue=hue))
    truncated = np.array([[share(evidence, "theory", omega, steps)[0] for steps in STEPS] for omega in OMEGAS])
    curves.append(Curve("truncated, all omega_0", h, truncated.max(axis=0), kind="line", hue=6))
    title = "paths that meet a step without root; dashed: exact"
    return Panel(title, "h", "share up to T = 1", tuple(curves), "x")


@hookimpl
def sdaeverify_experiments() -> list[Experiment]:
    """Register the experiment."""
    return [WithoutRoot()]
