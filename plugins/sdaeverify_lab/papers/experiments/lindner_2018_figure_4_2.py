"""Figure 4.2 of Lindner et al. (2018): strong convergence of the fibre for dt -> 0."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from sdaeverify import Array, hookimpl
from sdaeverify_lab.papers import (
    Budget,
    Curve,
    Exhibit,
    Experiment,
    ExperimentEvidence,
    Panel,
    Range,
    SchemeRun,
    TableEntry,
    Work,
)
from sdaeverify_problems import Fibre, clamped_chain
from sdaeverify_problems.fibres._hanging_fibre import hanging_fibre

from ._estimates import mean, order
from ._fibres import B_SEMI, FINAL, NAMES, A, B, fibre_label, norm

N, BETAS = 7, ("0.1", "0.0001")
Z = {"r": ("r",), "(r, v)": ("r", "v")}


@dataclass(frozen=True)
class Case:
    """A stiffness with the numbers of steps of each scheme, the last of which is its reference."""

    alpha: str
    horizon: str
    steps: Mapping[str, tuple[int, ...]]

    def problem(self, beta: str) -> str:
        """Return the label of the problem."""
        return fibre_label(alpha=self.alpha, beta=beta, N=N, horizon=self.horizon)

    def h(self, steps: int) -> float:
        """Return the step size."""
        return float(self.horizon) / steps

    @property
    def limit(self) -> float:
        """Half the longest stable explicit step; longer steps do not resolve the fastest mode."""
        fibre = Fibre(chain=clamped_chain(N, 2), alpha=float(self.alpha))
        return 0.5 * hanging_fibre(fibre, 1.0).explicit_limit()


SOFT = Case("4.0", "0.03125", {
    A: (8, 16, 32, 64, 128, 256, 512, 2048), B: (32, 64, 128, 256, 512, 2048),
    B_SEMI: (32, 64, 128, 256, 512, 2048),
})  # fmt: skip
STIFF = Case("0.4", "0.25", {
    A: (256, 512, 1024, 2048, 8192), B: (2**15, 2**16, 2**17), B_SEMI: (2**12, 2**13, 2**14, 2**16),
})  # fmt: skip


class Convergence(Experiment):
    """Mean relative errors at T with intervals of 90 percent, and the distance of the references."""

    name = "lindner-2018-figure-4-2"
    title = "strong convergence of the fibre for dt -> 0: (A), (B) and (B'), two turbulences"
    source = "Lindner et al. 2018, Figure 4.2"
    paths = 20
    full_paths = 100
    block = 100
    notes = (
        "Norms are (sum_i |z_i|^2 ds)^{1/2} over the fibre, relative to the reference; means over the paths.",
        "A scheme's reference is its own run with the most steps, and its error is taken out of the fit where h is "
        "resolved.",
        "h resolved: up to half the longest stable explicit step, which resolves the fastest modes; on longer ones "
        "(A) is stable and not yet in its asymptotic range.",
        "The paper's range of dt is not printed; its fibre, alpha = 0.4 and T = 0.25, is run at full budget.",
    )

    def cases(self, budget: Budget) -> tuple[Case, ...]:
        """Return the soft fibre, and at full budget that of the paper."""
        return (SOFT, STIFF) if budget is Budget.FULL else (SOFT,)

    def work(self, budget: Budget) -> Work:
        """Return the runs."""
        return {
            (case.alpha, beta, scheme, steps): SchemeRun(case.problem(beta), scheme, steps, FINAL)
            for case in self.cases(budget)
            for beta in BETAS
            for scheme, all_steps in case.steps.items()
            for steps in all_steps
        }

    def exhibit(self, evidence: ExperimentEvidence) -> Exhibit:
        """Return orders and distances, and a panel for each stiffness and norm."""
        cases = self.cases(evidence.budget)
        fits = [
            fit for case in cases for z in Z for beta in BETAS for scheme in NAMES
            for fit in _entries(evidence, case, z, beta, scheme)
        ]  # fmt: skip
        distances = [_distance(evidence, case, z, beta) for case in cases for z in Z for beta in BETAS]
        panels = tuple(_panel(evidence, case, z) for case in cases for z in Z)
        return Exhibit((*fits, *distances), panels)


def errors(evidence: ExperimentEvidence, case: Case, beta: str, scheme: str, z: str) -> Array:
    """Return the relative error of each path at each step size, shape (L, P).

    Parameters
    ----------
    evidence : ExperimentEvidence
    case : Case
        Fibre with its numbers of steps, the last of which is the reference.
    beta : str
        Factor of the noise (turbulence).
    scheme : str
        Label of the scheme.
    z : str
        Compared components: "r" or "(r, v)".
    """
    *steps, reference = case.steps[scheme]
    last = _final(evidence, (case.alpha, beta, scheme, reference), z)
    found = [_final(evidence, (case.alpha, beta, scheme, each), z) - last for each in steps]
    return np.array([norm(each, N) for each in found]) / norm(last, N)


def _final(evidence: ExperimentEvidence, key: tuple[object, ...], z: str) -> Array:
    return np.concatenate([evidence.values(key, name)[-1] for name in Z[z]])


def _entries(evidence: ExperimentEvidence, case: Case, z: str, beta: str, scheme: str) -> Iterator[TableEntry]:
    found, (*steps, reference) = errors(evidence, case, beta, scheme, z), case.steps[scheme]
    h = np.array([case.h(each) for each in steps])
    group = f"order in {z} of the relative error at T = {case.horizon}, alpha = {case.alpha}, N = {N}"
    resolved = h <= case.limit
    parts = (
        {"all h": np.ones(len(h), dtype=bool)} if resolved.all() else {"h resolved": resolved, "h longer": ~resolved}
    )
    for name, part in parts.items():
        if part.sum() >= 2:
            # Unresolved step sizes have no expansion, so the error of the reference cannot be removed.
            fitted = order(h[part], found[part], case.h(reference) if name == "h resolved" else 0.0)
            yield fitted.entry(
                group,
                {"scheme": NAMES[scheme], "beta": float(beta), "step sizes": name, "number": int(part.sum())},
                exact=1.0 if name != "h longer" else np.nan,
                exact_source="noise that does not depend on v: the Milstein term vanishes",
            )


def _references(evidence: ExperimentEvidence, case: Case, z: str, beta: str) -> Array:
    first, second = (_final(evidence, (case.alpha, beta, scheme, case.steps[scheme][-1]), z) for scheme in (A, B))
    return norm(first - second, N) / norm(second, N)


def _distance(evidence: ExperimentEvidence, case: Case, z: str, beta: str) -> TableEntry:
    away = mean(_references(evidence, case, z, beta))
    return away.entry(
        "relative distance of the references of (A) and (B)", {"z": z, "alpha": case.alpha, "beta": float(beta)}
    )


def _panel(evidence: ExperimentEvidence, case: Case, z: str) -> Panel:
    curves = []
    for i, (beta, scheme) in enumerate((beta, scheme) for beta in BETAS for scheme in NAMES):
        h = np.array([case.h(each) for each in case.steps[scheme][:-1]])
        curves.append(mean(errors(evidence, case, beta, scheme, z)).curve(f"{NAMES[scheme]}, beta = {beta}", h, i))
    ends = np.array([min(curve.x[-1] for curve in curves), max(curve.x[0] for curve in curves)])
    for beta in BETAS:
        away = float(_references(evidence, case, z, beta).mean())
        curves.append(Curve(f"ref. of (A) - ref. of (B), beta = {beta}", ends, np.full(2, away), kind="guide"))
    curves.append(Curve("order 1", ends, curves[0].y[0] / curves[0].x[0] * ends, kind="guide"))
    wide = (Range(case.limit, 1.1 * ends[1], "fastest modes not resolved"),) if ends[1] > case.limit else ()
    title = f"{z}: alpha = {case.alpha}, ds = 1/8, T = {case.horizon}"
    return Panel(title, "dt", "mean relative error at T, 90 %", tuple(curves), "xy", wide)


@hookimpl
def sdaeverify_experiments() -> list[Experiment]:
    """Register the figure."""
    return [Convergence()]
