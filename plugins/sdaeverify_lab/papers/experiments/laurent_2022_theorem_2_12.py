"""Theorem 2.12 of Laurent (2022): the implicit step (2.4) is a contraction with a factor C h^(1/2), for all eps."""

from collections.abc import Mapping
from itertools import product

import numpy as np

from sdaeverify import Array, Increment, Problem, Scheme, hookimpl
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

SIZES = 2.0 ** -np.arange(4, 17, 2)
STIFFNESS = 10.0 ** np.arange(-8.0, 3.0, 2.0)
# The three-point noise (2.3) has so many values in the plane: the largest factor over all of them is exact.
XI = np.array([*product((-(3.0**0.5), 0.0, 3.0**0.5), repeat=2)]).T
SCHEME = "uniformly-accurate[xi=three-point]"


def factors(problems: tuple[Problem, ...], schemes: tuple[Scheme, ...]) -> Mapping[str, Array]:
    """Return the largest |DF| at the root by h and eps, and how far the scheme's step is from a fixed point of F.

    F(y) = x + Y + x phi(y), phi = (level - (x + y).Y/2)/((x + y).x/2) for x on the circle: the mean of g^T from x to
    y is (x + y)^T/2. DF = x grad phi^T has the norm |grad phi|.
    """
    (scheme,) = schemes
    largest, off = np.zeros((2, len(SIZES), len(STIFFNESS)))
    for row, h in enumerate(SIZES):
        for column, eps in enumerate(STIFFNESS):
            x = problems[column].initial(XI.shape[1])
            Y, level = _expansion(problems[column], x, h, eps)
            y = scheme.step(problems[column], x, 0.0, h, Increment(np.sqrt(h) * XI, None)).state
            below, above = 0.5 * ((x + y) * x).sum(axis=0), level - 0.5 * ((x + y) * Y).sum(axis=0)
            gradient = -0.5 * (Y * below + x * above) / below**2
            largest[row, column] = np.sqrt((gradient**2).sum(axis=0)).max()
            off[row, column] = np.abs(x + Y + x * above / below - y).max()
    return {"factor": largest, "off": off}


def _expansion(problem: Problem, x: Array, h: float, eps: float) -> tuple[Array, Array]:
    """Return Y and the level of (2.4) at points of the unit circle, one for every xi: G = 1, g'(g) = x, div g = 2."""
    sigma, f, half = problem.strength, problem.drift(x), -0.5 * eps * np.expm1(-2.0 * h / eps)
    Y = np.sqrt(h) * sigma * XI + h * f + 0.5 * sigma**2 * half * x
    normal = (x * f).sum(axis=0) + 0.5 * sigma**2 + sigma**2
    level = sigma * np.sqrt(half) * (x * XI).sum(axis=0) - eps * np.expm1(-h / eps) * normal
    return Y, level


class Contraction(Experiment):
    """The factor of the fixed point iteration of a step, by step size and stiffness."""

    name = "laurent-2022-theorem-2-12"
    title = "contraction factor of the implicit step of the uniformly accurate integrator"
    source = "Laurent 2022, Theorem 2.12 and its proof"
    paths = 2
    notes = (
        "Largest norm of DF at the root over all values of the three-point noise, unit circle, a constant force. The "
        "theorem asks for a factor L < 1 for all h <= h_0, uniformly in eps; its proof gives C h^(1/2).",
        "Y and the level are written from (2.4) here. The step of the shipped scheme is a fixed point of F.",
    )

    def work(self, budget: Budget) -> Work:
        """Return one probe."""
        return {"factors": Probe(factors, tuple(f"penalised-sphere[eps={eps}]" for eps in STIFFNESS), (SCHEME,))}

    def exhibit(self, evidence: ExperimentEvidence) -> Exhibit:
        """Return the factor over all eps by h, its exponent, and its spread over eps."""
        found = evidence.probe("factors")
        factor = found["factor"]
        worst = factor.max(axis=1)
        entries = [
            TableEntry("largest contraction factor over eps = 1e-8 to 1e2", {"h": float(h)}, float(value))
            for h, value in zip(SIZES, worst, strict=True)
        ]
        spread = float((worst / factor.min(axis=1)).max())
        whole = "exponent of h of the largest factor, and its spread over eps"
        entries += [
            TableEntry(whole, {"of": "slope over h = 2^-6 to 2^-16"}, slope(SIZES[1:], worst[1:]), exact=0.5),
            TableEntry(whole, {"of": "largest over smallest eps, at any h"}, spread),
        ]
        remark = f"The scheme's step is a fixed point of F up to {found['off'].max():.1e}."
        return Exhibit(tuple(entries), (_panel(factor),), (remark,))


def _panel(factor: Array) -> Panel:
    curves = [Curve(f"eps = {eps:.0e}", SIZES, factor[:, column]) for column, eps in enumerate(STIFFNESS)]
    guide = factor[-1].max() * np.sqrt(SIZES / SIZES[-1])
    return Panel("unit circle", "h", "largest |DF|", (*curves, Curve("h^(1/2)", SIZES, guide, kind="guide")), "xy")


@hookimpl
def sdaeverify_experiments() -> list[Experiment]:
    """Register the factors."""
    return [Contraction()]
