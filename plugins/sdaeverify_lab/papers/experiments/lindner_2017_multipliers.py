"""Estimate (3.17) of Lindner & Stroot (2017): decrease of kappa and of the remainders of lambda with h."""

from collections.abc import Mapping

import numpy as np

from sdaeverify import Array, HolonomicState, Increment, Problem, Scheme, hookimpl
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

SIZES = 2.0 ** -np.arange(4, 12)
THETA, OMEGA = 0.7, 1.1
# By name: claimed order, and order for zero tangential force.
ORDERS = {"kappa": (2.0, 2.0), "lambda^re": (2.0, 3.0), "Lambda^re w": (1.0, 1.0)}
W = np.array([0.6, -0.8])


def remainders(problems: tuple[Problem, ...], schemes: tuple[Scheme, ...]) -> Mapping[str, Array]:
    """Return kappa, lambda^re and Lambda^re w of a step for each h and fixed w, and their closed forms.

    lambda = -G^{-1} {Dg [a h + B w] + D^2 g(v, v) h} + lambda^re + Lambda^re w.
    """
    return {
        f"{name} {kind}": np.array([_remainders(problem, schemes[0])[kind][name] for problem in problems])
        for kind in ("here", "exact")
        for name in ORDERS
    }


def _remainders(problem: Problem, scheme: Scheme) -> dict[str, dict[str, Array]]:
    r = np.array([[np.sin(THETA)], [-np.cos(THETA)]])
    along = np.array([[np.cos(THETA)], [np.sin(THETA)]])
    state = HolonomicState(r, OMEGA * along, np.zeros((1, 1)))
    a = problem.force(0.0, state.r, state.v)
    found: dict[str, list[float]] = {name: [] for name in ORDERS}
    for h in SIZES:
        still, moved = (
            scheme.step(problem, state, 0.0, h, Increment(w[:, None], None)).outputs for w in (0.0 * W, W)
        )
        # On the circle G = 1, Dg = -r^T and D^2 g(v, v) = -|v|^2.
        leading = (r * a).sum() * h + OMEGA**2 * h
        found["kappa"].append(still["kappa"][0, 0])
        found["lambda^re"].append(still["lambda"][0, 0] - leading)
        found["Lambda^re w"].append(moved["lambda"][0, 0] - still["lambda"][0, 0] - W @ r[:, 0])
    tangential, tan = float((along * a).sum()), np.tan(np.arcsin(OMEGA * SIZES))
    exact = {
        "kappa": 1.0 - np.sqrt(1.0 - (OMEGA * SIZES) ** 2),
        "lambda^re": OMEGA * (tan - OMEGA * SIZES) + tangential * SIZES * tan,
        "Lambda^re w": tan * float(W @ along[:, 0]),
    }
    return {"here": {name: np.array(values) for name, values in found.items()}, "exact": exact}


PROBLEMS = {"c_g = 1": "pendulum[c_g=1]", "c_g = 0": "pendulum[c_g=0]"}


class Multipliers(Experiment):
    """Exponents of the estimate, from single steps."""

    name = "lindner-2017-estimate-3-17"
    title = "exponents of kappa and of the remainders of lambda"
    source = "Lindner & Stroot 2017, (3.17)"
    paths = 2
    notes = (
        "w is the same at every h. Estimate (3.17) bounds the three by h^2, h^2 and h; without tangential force "
        "lambda^re is of size h^3 on the circle.",
    )

    def work(self, budget: Budget) -> Work:
        """Return one probe."""
        scheme = "half-explicit-euler[truncation=none]"
        return {"steps": Probe(remainders, tuple(PROBLEMS.values()), (scheme,))}

    def exhibit(self, evidence: ExperimentEvidence) -> Exhibit:
        """Return the exponents next to those of the closed forms."""
        found = evidence.probe("steps")
        entries = [_entry(found, name, row) for row in range(len(PROBLEMS)) for name in ORDERS]
        off = max(float(np.abs(found[f"{name} here"] - found[f"{name} exact"]).max()) for name in ORDERS)
        remark = f"The largest difference from the closed forms on the circle is {off:.1e}."
        return Exhibit(tuple(entries), tuple(_panel(found, row) for row in range(len(PROBLEMS))), (remark,))


def _entry(found: Mapping[str, Array], name: str, row: int) -> TableEntry:
    here, exact = (np.abs(found[f"{name} {kind}"][row]) for kind in ("here", "exact"))
    return TableEntry(
        f"exponent of h, slope over h = 2^-4 to 2^-11, {list(PROBLEMS)[row]}",
        {"of": name, "claimed": f"{ORDERS[name][0]:g}", "expected here": f"{ORDERS[name][row]:g}"},
        slope(SIZES, here),
        exact=slope(SIZES, exact),
        exact_source="closed form on the circle, the same fit",
    )


def _panel(found: Mapping[str, Array], row: int) -> Panel:
    curves = []
    for hue, name in enumerate(ORDERS):
        here = np.abs(found[f"{name} here"][row])
        curves.append(Curve(f"|{name}|", SIZES, here, hue=hue))
        p = ORDERS[name][row]
        curves.append(Curve(f"h^{p:g}", SIZES, here[0] * (SIZES / SIZES[0]) ** p, kind="guide", hue=hue))
    return Panel(f"one step of the pendulum, {list(PROBLEMS)[row]}", "h", "size", tuple(curves), "xy")


@hookimpl
def sdaeverify_experiments() -> list[Experiment]:
    """Register the exponents."""
    return [Multipliers()]
