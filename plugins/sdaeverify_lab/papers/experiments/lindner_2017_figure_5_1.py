"""Figure 5.1 of Lindner & Stroot (2017): a step of the pendulum that has two roots, one, or none."""

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

# omega h of the three steps; h = 1.
TURNS = (0.7, 1.0, 1.3)
WORDS = ("two roots", "one root", "no root")
SCHEMES = {"without truncation": "half-explicit-euler[truncation=none]", "truncated": "half-explicit-euler"}


def steps(problems: tuple[Problem, ...], schemes: tuple[Scheme, ...]) -> Mapping[str, Array]:
    """Return kappa, failures, and eta by its formula for a step without noise from the lowest point.

    Each is an array of shape (schemes, turns); r+ has the shape (schemes, 2, turns).
    """
    (problem,) = problems
    omega = np.array(TURNS)
    state = HolonomicState(
        np.array([0.0 * omega, 0.0 * omega - 1.0]), np.array([omega, 0.0 * omega]), np.zeros((1, len(omega)))
    )
    noise = Increment(np.zeros((2, len(omega))), None)
    made = [scheme.step(problem, state, 0.0, 1.0, noise) for scheme in schemes]
    C_eta = 1.0 / (4.0 * problem.constraint_bound**3)
    force = np.linalg.norm(problem.force(0.0, state.r, state.v), axis=0)
    eta = np.minimum(1.0, C_eta / np.maximum(np.maximum(omega, omega**2), force))
    return {
        "kappa": np.array([step.outputs["kappa"][0] for step in made]),
        "failed": np.array([step.failed for step in made]),
        "eta": np.array([np.ones_like(eta), eta]),
        "r": np.array([step.state.r for step in made]),
        "bound": np.array([1.0 / (8.0 * problem.constraint_bound**4)]),
    }


class Roots(Experiment):
    """Geometry of kappa, compared with the scheme."""

    name = "lindner-2017-figure-5-1"
    title = "the equation for kappa on the pendulum: two roots, one, none, and with truncation"
    source = "Lindner & Stroot 2017, Figure 5.1"
    paths = 2
    notes = (
        "From the lowest point, with h = 1 and without noise; eta_k takes the motion to at most C_eta, so that "
        "there are two roots, and one of them below C_kappa.",
        "At omega h = 1 the two roots are one, with a Jacobian of 0, which Newton's method reaches linearly.",
    )

    def work(self, budget: Budget) -> Work:
        """Return one probe of single steps."""
        return {"steps": Probe(steps, ("pendulum[c_g=0]",), tuple(SCHEMES.values()))}

    def exhibit(self, evidence: ExperimentEvidence) -> Exhibit:
        """Return kappa next to its closed form, and the pictures."""
        found = evidence.probe("steps")
        entries = [_entry(found, which, turn) for which in range(2) for turn in range(len(TURNS))]
        bound = float(found["bound"][0])
        remark = f"C_kappa = {bound:.6f}: with truncation every kappa is below it, and the other root far above."
        return Exhibit(tuple(entries), tuple(_panel(found, turn) for turn in range(len(TURNS))), (remark,))


def _entry(found: Mapping[str, Array], which: int, turn: int) -> TableEntry:
    reach = TURNS[turn] * found["eta"][which, turn]
    failed = bool(found["failed"][which, turn])
    return TableEntry(
        f"kappa of a step, {list(SCHEMES)[which]}",
        {"omega h": TURNS[turn], "eta": float(found["eta"][which, turn]), "root": "no" if failed else "yes"},
        np.nan if failed else float(found["kappa"][which, turn]),
        exact=1.0 - np.sqrt(1.0 - reach**2) if reach <= 1.0 else np.nan,
        exact_source="1 - sqrt(1 - (eta omega h)^2); the other root is 1 + sqrt(...), and there is none above 1",
    )


def _panel(found: Mapping[str, Array], turn: int) -> Panel:
    angle = np.linspace(0.0, 2.0 * np.pi, 361)
    x, reach = TURNS[turn], TURNS[turn] * found["eta"][1, turn]
    roots = np.sqrt(1.0 - x * x) * np.array([-1.0, 1.0]) if x <= 1.0 else np.zeros(0)
    curves = [
        Curve("", np.cos(angle), np.sin(angle), kind="line", hue=6),
        Curve("r_k", np.array([0.0]), np.array([-1.0]), kind="marks", hue=6),
        Curve("r_k + h v_k", np.array([0.0, x]), np.array([-1.0, -1.0]), hue=0),
        Curve("along grad g(r_k)", np.full(2, x), np.array([-1.2, 1.2]), kind="guide", hue=0),
    ]
    if len(roots):
        curves.append(Curve("roots", np.full(len(roots), x), roots, kind="marks", hue=1))
    curves += [
        Curve("with eta_k", np.full(2, reach), np.array([-1.2, 1.2]), kind="guide", hue=2),
        Curve("r_{k+1} of the scheme", found["r"][1][:1, turn], found["r"][1][1:, turn], kind="marks", hue=2),
    ]
    return Panel(f"{WORDS[turn]}: omega h = {x:g}", "x_1", "x_2", tuple(curves), equal=True)


@hookimpl
def sdaeverify_experiments() -> list[Experiment]:
    """Register the figure."""
    return [Roots()]
