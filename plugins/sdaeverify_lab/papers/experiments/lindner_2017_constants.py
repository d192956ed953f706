"""The constants C_g, C_eta and C_kappa of Lindner & Stroot (2017), (2.7) and (3.11), over the problem family."""

from collections.abc import Iterator, Mapping
from typing import NamedTuple

import numpy as np

from sdaeverify import Array, Problem, Scheme, hookimpl
from sdaeverify_lab.papers import (
    Budget,
    Curve,
    Exhibit,
    Experiment,
    ExperimentEvidence,
    Panel,
    Printed,
    Probe,
    Range,
    TableEntry,
    Work,
)

# Size of the neighbourhoods of the shipped problems: unit circle and sphere, and a fibre in units of ds.
EPS = 0.01
MASSES = ((1.0, 1.0, 1.0), (1.0, 2.0, 4.0))
POINTS = (3, 7, 15)


class Case(NamedTuple):
    """A problem by its name in the table, with C_g on its neighbourhood, or |G| or |G^{-1}| of a straight fibre."""

    name: str
    label: str
    exact: float


def cases() -> Iterator[Case]:
    """Yield the problems with their closed forms."""
    yield Case("pendulum", "pendulum", (1.0 - EPS) ** -2)
    for mass in MASSES:
        bound = max((1.0 + EPS) ** 2 / min(mass), max(mass) / (1.0 - EPS) ** 2, 1.0)
        label = ",".join(f"m_{i}={m}" for i, m in enumerate(mass, 1))
        yield Case(f"sphere, M = diag{mass}", f"sphere-langevin[{label}]", bound)
    for N in POINTS:
        bound = (2.0 + 2.0 * np.cos(2.0 * np.pi / (2 * N + 1))) * (N + 1) ** 2
        yield Case(f"fibre at rest, N = {N}", f"fibre-clamped[N={N}]", bound)


def constants(problems: tuple[Problem, ...], schemes: tuple[Scheme, ...]) -> Mapping[str, Array]:
    """Return C_g as declared, and the largest of the five norms of (2.7) at points around the start.

    On circle and sphere the points are x = s r, with r over directions and |s - 1| <= eps; for a fibre only the
    start.
    """
    return {
        "declared": np.array([problem.constraint_bound for problem in problems]),
        "found": np.array([_largest(problem) for problem in problems]),
    }


def _points(problem: Problem) -> Array:
    n = problem.dimension
    if n > 3:
        return problem.initial(1).r
    rng = np.random.Generator(np.random.Philox(key=27))
    directions = np.concatenate([np.eye(n), rng.standard_normal((200, n))])
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    return np.concatenate([s * directions for s in (1.0 - EPS, 1.0, 1.0 + EPS)]).T


def _largest(problem: Problem) -> float:
    x = _points(problem)
    n, m = problem.dimension, problem.constraints
    largest = 0.0
    for p in range(x.shape[1]):
        at = x[:, p : p + 1]
        J = problem.dg(at)[:, :, 0]
        push = problem.inverse_mass(np.broadcast_to(J.T, (n, m)).copy())
        G = J @ push
        units = np.eye(n)
        D2 = np.array([[problem.d2g(at, a[:, None], b[:, None])[:, 0] for a in units] for b in units])
        sizes = (float(np.linalg.norm(each, 2)) for each in (push, G, np.linalg.inv(G)))
        largest = max(largest, *sizes, _second(D2))
    return largest


def _second(D2: Array) -> float:
    """Return a lower bound of sup |D^2 g(y, z)| over unit vectors: over the columns of each Hessian."""
    return float(max(np.linalg.norm(D2[:, :, k], 2) for k in range(D2.shape[2])))


class Constants(Experiment):
    """Constants of the theory, and their values in the paper."""

    name = "lindner-2017-constants"
    title = "C_g, C_eta and C_kappa of pendulum, spheres and fibres"
    source = "Lindner & Stroot 2017, (2.7), (3.11) and section 5.1"
    paths = 2
    notes = (
        "Norms are those of M^{-1} grad g, G, G^{-1} and D^2 g over the neighbourhood; g is quadratic, and D^3 g = "
        "0.",
        "C_g depends on eps, the masses and the scaling of g. On a fibre it is about 4/ds^2 and C_eta of size "
        "1e-8: the truncation of the theory cannot be used there.",
        "Printed: the end of the interval that section 5.1 quotes. It is reached at eps = 0.293, and C_g is "
        "unbounded.",
    )

    def work(self, budget: Budget) -> Work:
        """Return one probe of all problems."""
        return {"constants": Probe(constants, tuple(case.label for case in cases()))}

    def exhibit(self, evidence: ExperimentEvidence) -> Exhibit:
        """Return the constants next to their closed forms, and C_g against eps."""
        found = evidence.probe("constants")
        entries = [
            entry
            for row, case in enumerate(cases())
            for entry in _entries(case, float(found["declared"][row]), float(found["found"][row]))
        ]
        entries += [_quoted_entry(name, *ends) for name, ends in QUOTED.items()]
        return Exhibit(tuple(entries), (_panel(),))


def _entries(case: Case, declared: float, found: float) -> list[TableEntry]:
    name, straight = case.name, case.name.startswith("fibre")
    what = "|G| of the straight fibre, at most C_g" if straight else "largest norm of (2.7) around it"
    return [
        TableEntry(name, {"of": what}, found, exact=case.exact, exact_source="closed form"),
        TableEntry(name, {"of": "C_g as the problem declares it"}, declared),
        TableEntry(name, {"of": "C_eta = 1/(4 C_g^3)"}, 0.25 * declared**-3),
        TableEntry(name, {"of": "C_kappa = 1/(8 C_g^4)"}, 0.125 * declared**-4),
    ]


# Ends of the intervals in section 5.1 for eps from 0 to 1: printed end, and right one as eps tends to 1.
QUOTED = {
    "C_g": ("2", np.inf),
    "C_eta": ("0.03125", 0.0),
    "C_kappa": ("0.0078125", 0.0),
}


def _quoted_entry(name: str, printed: str, right: float) -> TableEntry:
    at_half = {"C_g": 4.0, "C_eta": 0.25 / 64.0, "C_kappa": 0.125 / 256.0}[name]
    return TableEntry(
        "pendulum at eps = 1/2, beside the end of the interval that section 5.1 quotes for all eps",
        {"of": name, "eps -> 1": right},
        at_half,
        exact=at_half,
        exact_source="C_g = 1/(1 - eps)^2",
        printed=Printed(printed),
    )


def _panel() -> Panel:
    eps = np.linspace(0.0, 0.9, 181)
    C_g = (1.0 - eps) ** -2
    curves = (
        Curve("C_g = 1/(1 - eps)^2", eps, C_g, kind="line"),
        Curve("C_eta = 1/(4 C_g^3)", eps, 0.25 * C_g**-3, kind="line"),
        Curve("C_kappa = 1/(8 C_g^4)", eps, 0.125 * C_g**-4, kind="line"),
    )
    quoted = Range(0.0, 1.0 - 0.5**0.5, "C_g in (1, 2), as quoted for all eps")
    return Panel("the pendulum's constants", "eps of the neighbourhood", "constant", curves, "y", (quoted,))


@hookimpl
def sdaeverify_experiments() -> list[Experiment]:
    """Register the constants."""
    return [Constants()]
