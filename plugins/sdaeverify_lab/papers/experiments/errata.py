"""Errors in print of the four papers, each with a number from the printed formula and from the right one."""

from collections.abc import Mapping

import numpy as np

from sdaeverify import Array, InvariantMean, Problem, Scheme, hookimpl
from sdaeverify_lab.papers import (
    Budget,
    Curve,
    Exhibit,
    Experiment,
    ExperimentEvidence,
    Panel,
    Printed,
    Probe,
    TableEntry,
    Work,
)

from ._estimates import slope
from ._slips import READ, SLIPS, slip_entries

SIZES = 2.0 ** -np.arange(6, 13)
# Probabilities of the drawn quantiles.
SHARES = np.linspace(0.0, 1.0, 201)[1:]


def curvature_sign(problems: tuple[Problem, ...], schemes: tuple[Scheme, ...]) -> Mapping[str, Array]:
    """Return the defects of an Euler step of the inherent SDE without noise for either sign of D^2 g(v, v).

    unprojected: order of Dg(r+) v+; projected: order of the difference of the two signs after v+ = Q(r+) v^; work:
    <v, grad g G^{-1} D^2 g(v, v)>, which affects energies.
    """
    (problem,) = problems
    r, v = np.array([[np.sin(0.7)], [-np.cos(0.7)]]), 1.1 * np.array([[np.cos(0.7)], [np.sin(0.7)]])
    J = problem.linearised(r)
    push = problem.push(J, J.gram(J).solve(problem.d2g(r, v, v)))
    pull, _ = problem.tangent(J, problem.force(0.0, r, v))
    defects: dict[float, list[float]] = {-1.0: [], 1.0: []}
    apart = []
    for h in SIZES:
        new = problem.linearised(r + h * v)
        moved = {sign: v + h * (pull + sign * push) for sign in defects}
        for sign, found in defects.items():
            found.append(float(np.abs(new.times(moved[sign])[0, 0])))
        apart.append(
            float(np.linalg.norm(problem.tangent(new, moved[1.0])[0] - problem.tangent(new, moved[-1.0])[0]))
        )
    right, printed = (np.array(defects[sign]) for sign in (-1.0, 1.0))
    return {
        "defects": np.array([right, printed]),
        "right": np.array([slope(SIZES, right)]),
        "printed": np.array([slope(SIZES, printed)]),
        "projected": np.array([slope(SIZES, np.array(apart))]),
        "work": np.array([float((v * push).sum())]),
    }


def gravity(problems: tuple[Problem, ...], schemes: tuple[Scheme, ...]) -> Mapping[str, Array]:
    """Return the tangential acceleration over -sin(theta) with c_g = 2, as registered and as printed."""
    (problem,) = problems
    r, along = np.array([[np.sin(0.7)], [-np.cos(0.7)]]), np.array([[np.cos(0.7)], [np.sin(0.7)]])
    force = problem.force(0.0, r, 0.0 * r)
    return {"right": -(along * force).sum(axis=0) / np.sin(0.7), "printed": np.array([1.0])}


def last_line(problems: tuple[Problem, ...], schemes: tuple[Scheme, ...]) -> Mapping[str, Array]:
    """Return the largest of the two sums in the last line of (2.2) and of their difference, for random quadratics."""
    rng = np.random.Generator(np.random.Philox(key=22))
    sums, off = [], []
    for d, q in ((3, 1), (4, 2), (6, 3), (9, 6)) * 25:
        H = rng.standard_normal((q, d, d))
        H = H + np.swapaxes(H, 1, 2)
        g = rng.standard_normal((d, q))
        P = g @ np.linalg.solve(g.T @ g, g.T)
        first = sum(np.array([P[:, i] @ (H[k] @ P[:, i]) for k in range(q)]) for i in range(d))
        second = sum(np.array([P[:, i] @ H[k][:, i] for k in range(q)]) for i in range(d))
        sums.append(np.abs(first).max())
        off.append(np.abs(first - second).max())
    return {"sums": np.array([max(sums)]), "difference": np.array([max(off)])}


def second_branch(problems: tuple[Problem, ...], schemes: tuple[Scheme, ...]) -> Mapping[str, Array]:
    """Return quantiles up to the maximum of B^2/(4 A) over random coefficients admitted by (4.1), with B <= 0.

    The first two lines of (4.1) imply abar <= al0; the second branch of h_0 requires B^2 >= 4 A.
    """
    rng = np.random.Generator(np.random.Philox(key=42))
    al0, al1, al2, be0, be2, L1, L2, L3 = 10.0 ** rng.uniform(-3.0, 2.0, (8, 10**6))
    theta, abar = rng.uniform(0.0, 1.0, 10**6), al0 * rng.uniform(0.0, 1.0, 10**6)
    K1 = al0 + al2 * L1 * L2
    A = 2.0 * (1.0 - theta) ** 2 * K1**2
    drift = al1 + al2 * L1 * L3 + 2.0 * al2 * L1 * L2 - 2.0 * abar
    B = be0 + 2.0 * be2 * L1**2 * L2**2 + (1.0 - theta) * drift
    ratio = (B**2 / (4.0 * A))[B <= 0.0]
    return {"ratio": np.quantile(ratio, SHARES), "cases": np.array([float(ratio.size)])}


def averages(problems: tuple[Problem, ...], schemes: tuple[Scheme, ...]) -> Mapping[str, Array]:
    """Return 1000-path averages of x^2 at T = 10 for set I, drawn exactly, and effective numbers of paths."""
    rng = np.random.Generator(np.random.Philox(key=10))
    t, a, c = 10.0, -1.0, 1.0
    x2 = np.exp(2.0 * ((a - 0.5 * c * c) * t + c * np.sqrt(t) * rng.standard_normal((400, 1000))))
    mean = x2.mean(axis=1)
    return {"mean": mean, "effective": x2.sum(axis=1) ** 2 / (x2**2).sum(axis=1), "exact": np.array([np.exp(-10.0)])}


PROBES = {
    "sign": Probe(curvature_sign, ("pendulum[c_g=1]",)),
    "gravity": Probe(gravity, ("pendulum[c_g=2.0]",)),
    "last line": Probe(last_line),
    "branch": Probe(second_branch),
    "averages": Probe(averages),
}
# Printed trace by m, with the standard deviation of tr x measured by laurent-2022-table-1.
TRACES = {2: ("2.00934", 0.10), 3: ("3.01458", 0.13), 4: ("4.02050", 0.15), 5: ("5.02669", 0.17)}
MEAN_SQUARES = (4.045e-05, 2.3559e-05)


class Errata(Experiment):
    """Printed and right formulas, with the evidence."""

    name = "errata"
    title = "errors in print: what is printed, what is right, how one knows"
    source = "Lindner & Stroot 2017, Lindner et al. 2018, Laurent 2022, Qu et al. 2010"
    paths = 2
    notes = (
        "The sign of D^2 g: estimates of energy and schemes that project in each step do not see it. What sees it: "
        "an unprojected step, mu, and a value computed before; the planted bugs of `selftest` hold it.",
        "Laurent Table 1 and Qu Table 1 are run by laurent-2022-table-1 and qu-2010-table-1.",
        "Unexplained: Laurent Table 1, column UA. Printed errors at h = 2^-7 are about half of the scheme's, and "
        "near those of h = 2^-8. Neither the noise of three points, nor the direction of the new point, nor an "
        "iteration that ends early gives them for all m.",
        "Smaller ones, without a number: LF (3.3), (3.6): coefficients at the integration variable; LF Lemma 9: "
        "entries of G~ in the recursion; LS (3.12): d nu in the first line; LS (2.7): M^{-1} grad g maps R^m to "
        "R^n.",
        *READ,
    )

    def work(self, budget: Budget) -> Work:
        """Return the probes."""
        return {**PROBES, **SLIPS}

    def exhibit(self, evidence: ExperimentEvidence) -> Exhibit:
        """Return the numbers, a group for each error."""
        slips = slip_entries({name: evidence.probe(name) for name in SLIPS})
        return Exhibit((*_lindner(evidence), *_laurent(evidence), *_qu(evidence), *slips), _panels(evidence))


def _number(group: str, of: str, value: float, exact: float = np.nan) -> TableEntry:
    return TableEntry(group, {"of": of}, value, exact=exact)


def _lindner(evidence: ExperimentEvidence) -> list[TableEntry]:
    sign, pull = evidence.probe("sign"), evidence.probe("gravity")
    curvature = "LF (3.5), (3.15), LS Remark 3.3: printed + grad g G^{-1} D^2 g(v, v); right: - as in LS (2.9)"
    return [
        _number(curvature, "order of Dg(r+) v+ of an unprojected step, minus", sign["right"][0], 2.0),
        _number(curvature, "the same with the printed plus", sign["printed"][0], 1.0),
        _number(curvature, "order of what the sign changes after projection", sign["projected"][0], 2.0),
        _number(curvature, "its work <v, .>, all that energies see", sign["work"][0], 0.0),
        _number(
            "LS (5.77b): printed gravity (0, -1); right (0, -c_g)", "c_g in the step, c_g = 2", pull["right"][0], 2.0
        ),
        _number("LS (5.77b): printed gravity (0, -1); right (0, -c_g)", "as printed", pull["printed"][0], 2.0),
        TableEntry(
            "LS section 5.1: printed C_eta in (1/32, 1/4) for all eps in (0, 1); right (0, 1/4)",
            {"of": "C_eta at eps = 1/2"},
            0.25 * 4.0**-3,
            exact=0.25 * (1.0 - 0.5) ** 6,
            printed=Printed("0.03125"),
        ),
    ]


def exact_trace(evidence: ExperimentEvidence, m: int) -> float:
    """Return J(m), the mean of tr x under the invariant law."""
    problem = evidence.problem(f"orthogonal-group[eps=0.005,m={m},stiffness=100,horizon=1]")
    return next(
        each.value for each in problem.truths if isinstance(each, InvariantMean) and each.observable == "tr x"
    )


def _laurent(evidence: ExperimentEvidence) -> list[TableEntry]:
    line = evidence.probe("last line")
    vanishing = (
        "Laurent (2.2), last line: vanishes for q = 1, as printed, and for every q: both sums are (tr H_k P)_k"
    )
    entries = [
        _number(vanishing, "largest sum, q = 1, 2, 3, 6", line["sums"][0]),
        _number(vanishing, "largest difference of the sums", line["difference"][0], 0.0),
    ]
    for m, (digits, deviation) in TRACES.items():
        entries.append(
            TableEntry(
                "Laurent Table 1: printed J(m) are means of the scheme with h = 2^-9, of 10^6 paths",
                {"of": f"J({m})"},
                exact=exact_trace(evidence, m),
                printed=Printed(digits, 10**6),
                printed_std_error=deviation * 1e-3,
            )
        )
    return entries


def _qu(evidence: ExperimentEvidence) -> list[TableEntry]:
    branch, drawn = evidence.probe("branch"), evidence.probe("averages")
    second = "Qu Theorem 4.2: the second branch of h_0 asks for B^2 >= 4 A and B <= 0, which (4.1) rules out"
    table = "Qu Table 1: mean squares at h = 1/64 and 1/128; the first entry is 2.9806e-04, printed without the e"
    means = "Qu Figures 1 to 3: averages of x^2 over 1000 paths for set I at T = 10 lie, drawn 400 times"
    return [
        _number(second, f"largest B^2/(4 A), {branch['cases'][0]:.0f} cases", branch["ratio"][-1]),
        TableEntry(table, {"of": "ratio of the two, order 1/2"}, MEAN_SQUARES[0] / MEAN_SQUARES[1], exact=2.0),
        _number(means, "median of the averages", float(np.median(drawn["mean"])), drawn["exact"][0]),
        _number(means, "median of the effective paths", float(np.median(drawn["effective"]))),
    ]


def _panels(evidence: ExperimentEvidence) -> tuple[Panel, ...]:
    return (_sign(evidence), _traces(evidence), _branch(evidence), _averages(evidence))


def _sign(evidence: ExperimentEvidence) -> Panel:
    right, printed = evidence.probe("sign")["defects"]
    curves = (Curve("minus, as in LS (2.9)", SIZES, right), Curve("plus, as printed in LF (3.5)", SIZES, printed))
    title = "Dg(r+) v+ of an unprojected step, pendulum"
    return Panel(title, "h", "|Dg(r+) v+|", curves, "xy")


def _traces(evidence: ExperimentEvidence) -> Panel:
    m = np.array(list(TRACES), dtype=float)
    off = np.array([float(digits) - exact_trace(evidence, k) for k, (digits, _) in TRACES.items()])
    bar = 2e-3 * np.array([deviation for _, deviation in TRACES.values()])
    curves = (
        Curve("printed, 2 standard errors of 10^6 paths", m, off, off - bar, off + bar, "marks"),
        Curve("exact", m, 0.0 * m, kind="guide"),
    )
    return Panel("Laurent, Table 1: references J(m)", "m", "printed J(m) - exact J(m)", curves)


def _branch(evidence: ExperimentEvidence) -> Panel:
    asked, ends = np.array([1.0, 1.0]), np.array([0.0, 1.0])
    curves = (
        Curve("coefficients with (4.1) and B <= 0", evidence.probe("branch")["ratio"], SHARES, kind="line"),
        Curve("from here on the second branch is asked for", asked, ends, kind="guide"),
    )
    return Panel("Qu, Theorem 4.2: second branch of h_0", "B^2/(4 A)", "share below", curves)


def _averages(evidence: ExperimentEvidence) -> Panel:
    drawn = evidence.probe("averages")
    averages, ends = np.sort(drawn["mean"]), np.array([0.0, 1.0])
    curves = (
        Curve("400 averages of 1000 paths", averages, (np.arange(400) + 1) / 400.0, kind="line"),
        Curve("E x^2", np.repeat(drawn["exact"], 2), ends, kind="guide"),
    )
    return Panel("Qu, Figure 1: averages of x^2, set I, T = 10", "average", "share below", curves, "x")


@hookimpl
def sdaeverify_experiments() -> list[Experiment]:
    """Register the list of errata."""
    return [Errata()]
