"""Theorem 2.3 of Laurent (2022): the dynamics (1.3) and (1.4) tend to the constrained ones like eps^(1/2)."""

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

# Penalties g zeta/eps of (1.3) and g G^{-1} zeta/eps of (1.4).
FORMS = ("(1.3)", "(1.4)")
EPS = 2.0 ** -np.arange(3, 9)
RADIUS, SIGMA, HORIZON, PATHS = 2.0, 1.0, 1.0, 500
# Euler's step: a 64th of the fastest time eps/G, G = 4, of the stiffest member, where it takes 1 % of the variance.
STEPS = 2**16
GRAM = RADIUS**2


def distances(problems: tuple[Problem, ...], schemes: tuple[Scheme, ...]) -> Mapping[str, Array]:
    """Return sup over t of E |X^eps - X^0|^2 and E zeta(X^eps(T))^2 by form and eps, on one Brownian motion.

    zeta = (|x|^2 - R^2)/2, R = 2, so that G = |x|^2 = 4 on the circle, f = 0. X^0 is Brownian motion on the circle:
    an Euler step is brought back to it. All have the same steps and increments.
    """
    rng = np.random.Generator(np.random.Philox(key=23))
    h = HORIZON / STEPS
    x = np.zeros((2, len(FORMS), len(EPS), PATHS))
    x[0] = RADIUS
    limit, worst = x[:, 0, 0].copy(), np.zeros(x.shape[1:3])
    for n in range(STEPS):
        w = SIGMA * np.sqrt(h) * rng.standard_normal((2, PATHS))
        x = _penalised(x, w, h)
        limit = _constrained(limit, w)
        if n % 256 == 255:
            apart = ((x - limit[:, None, None]) ** 2).sum(axis=0).mean(axis=-1)
            worst = np.maximum(worst, apart)
    zeta = 0.5 * ((x * x).sum(axis=0) - RADIUS**2)
    return {"apart": worst, "zeta": (zeta**2).mean(axis=-1), "error": (zeta**2).std(axis=-1) / np.sqrt(PATHS)}


def _penalised(x: Array, w: Array, h: float) -> Array:
    # Fixman's term (sigma^2/4) grad ln det G is sigma^2 x/(2 |x|^2).
    G = (x * x).sum(axis=0)
    zeta = 0.5 * (G - RADIUS**2)
    penalty = np.stack([zeta[0], zeta[1] / G[1]]) / EPS[:, None]
    moved: Array = x * (1.0 + h * (0.5 * SIGMA**2 / G - penalty)) + w[:, None, None]
    return moved


def _constrained(x: Array, w: Array) -> Array:
    moved = x + w
    on: Array = RADIUS * moved / np.sqrt((moved * moved).sum(axis=0))
    return on


def stationary(form: str) -> Array:
    """Return the leading term of E zeta^2 as eps tends to 0.

    d zeta = -lambda zeta dt + sigma G^{1/2} dB near the circle, with lambda = G/eps of (1.3) and 1/eps of (1.4):
    E zeta^2 = sigma^2 G/(2 lambda).
    """
    term: Array = 0.5 * SIGMA**2 * EPS * (1.0 if form == FORMS[0] else GRAM)
    return term


class Penalised(Experiment):
    """Distance of the exact solutions from the constrained one, and from the manifold, by eps."""

    name = "laurent-2022-theorem-2-3"
    title = "strong distance of the penalised dynamics (1.3) and (1.4) from the constrained dynamics"
    source = "Laurent 2022, (1.3), (1.4) and Theorem 2.3"
    paths = 2
    notes = (
        "Brownian motion on a circle of radius 2, sigma = 1, T = 1, 500 paths; Euler steps of 2^-16 on one Brownian "
        "motion stand for the exact solutions. Theorem 2.3 bounds both means by C eps: exponent 1 of eps.",
        "Exact: the leading term sigma^2 G eps/2 of (1.4), G = 4, and sigma^2 eps/2 of (1.3), whose penalty is G "
        "times as strong.",
    )

    def work(self, budget: Budget) -> Work:
        """Return one probe."""
        return {"distances": Probe(distances)}

    def exhibit(self, evidence: ExperimentEvidence) -> Exhibit:
        """Return exponents of eps and the means of zeta^2 beside their leading terms."""
        found = evidence.probe("distances")
        exponents = [
            TableEntry(
                "exponent of eps, slope over eps = 2^-3 to 2^-8",
                {"of": of, "dynamics": form},
                slope(EPS, y),
                exact=1.0,
            )
            for of, key in (("sup_t E |X^eps - X^0|^2", "apart"), ("E zeta(X^eps(T))^2", "zeta"))
            for form, y in zip(FORMS, found[key], strict=True)
        ]
        means = [
            TableEntry(
                "E zeta^2 at the smallest eps, 2^-8",
                {"of": "E zeta(X^eps(T))^2", "dynamics": form},
                float(found["zeta"][row, -1]),
                float(found["error"][row, -1]),
                PATHS,
                exact=float(stationary(form)[-1]),
                exact_source="leading term",
            )
            for row, form in enumerate(FORMS)
        ]
        return Exhibit((*exponents, *means), (_panel(found),))


def _panel(found: Mapping[str, Array]) -> Panel:
    curves = []
    for hue, form in enumerate(FORMS):
        curves.append(Curve(f"sup E |X^eps - X^0|^2, {form}", EPS, found["apart"][hue], hue=hue))
        curves.append(Curve(f"E zeta^2, {form}", EPS, found["zeta"][hue], kind="marks", hue=hue + len(FORMS)))
        curves.append(Curve("", EPS, stationary(form), kind="guide", hue=hue + len(FORMS)))
    return Panel("circle of radius 2, T = 1", "eps", "mean square", tuple(curves), "xy")


@hookimpl
def sdaeverify_experiments() -> list[Experiment]:
    """Register the distances."""
    return [Penalised()]
