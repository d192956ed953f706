"""Figure 1 of Laurent (2022): errors of E |x|^2 on the torus against the stiffness parameter, by time averages."""

from collections.abc import Iterator

import numpy as np

from sdaeverify import InvariantMean, hookimpl
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

from ._estimates import Mean, mean

# Values of eps with known invariant mean: the limit, then from stiff to weak penalties.
STIFFNESSES = ("0", "1e-06", "0.0001", "0.001", "0.01", "0.1", "1.0", "10.0")
# With the noise (2.3) of the paper.
UNIFORM, CONSTRAINED, EXPLICIT = (
    f"{name}[xi=three-point]" for name in ("uniformly-accurate", "constrained-euler", "penalised-euler")
)
NAMES = {UNIFORM: "uniformly accurate (2.2)", CONSTRAINED: "constrained Euler (1.6)", EXPLICIT: "Euler (1.5)"}
# h = T/2^9 and shorter: with T = 10 the steps T/2^8 and longer often have no root. Averages begin at BURN.
PAPERS_TIME, HORIZON, BURN, FIRST = 10.0, 20, 2.0, 9
OBSERVABLE = "|x|^2"


class StationaryErrors(Experiment):
    """Time averages of |x|^2 minus the invariant mean."""

    name = "laurent-2022-figure-1"
    title = "errors of E |x|^2 on the torus for eps from 0 to 10 and h = T/2^9, T/2^10, ..., T = 10"
    source = "Laurent 2022, Figure 1"
    paths = 100
    full_paths = 1000
    block = 500
    notes = (
        "The figure is a plot without numbers, of 10^7 end values at T = 10. Averages over the times from 2 to 20 "
        "of each path resolve the errors with few paths.",
        "Explicit Euler is stable for h (1/eps + 25) < 2 only, so that its paths are lost for small eps.",
        "Where steps have no root, paths keep their state; for eps of order 1 the process comes near the torus' "
        "axis.",
    )

    def levels(self, budget: Budget) -> range:
        """Return the exponents k of h = T/2^k."""
        return range(FIRST, 13 if budget is Budget.FULL else 11)

    def work(self, budget: Budget) -> Work:
        """Return the schemes of the left half at the longest step, and shorter steps for the right half."""
        return {
            (scheme, eps, k): _run(scheme, eps, k)
            for eps in STIFFNESSES
            for scheme in NAMES
            for k in self.levels(budget)
            if (k == FIRST or scheme == UNIFORM) and not (eps == "0" and scheme == EXPLICIT)
        }

    def exhibit(self, evidence: ExperimentEvidence) -> Exhibit:
        """Return the errors against eps, and against h with their maximum."""
        levels = self.levels(evidence.budget)
        entries = [
            entry for scheme in NAMES for k in (levels if scheme == UNIFORM else (FIRST,)) for eps in STIFFNESSES
            for entry in _entries(evidence, scheme, eps, k)
        ]  # fmt: skip
        panels = (_schemes(evidence), _sizes(evidence, levels), _largest(evidence, levels))
        return Exhibit(tuple(entries), panels, tuple(_describe_losses(evidence)))


def _run(scheme: str, eps: str, k: int) -> SchemeRun:
    steps = 2**k * round(HORIZON / PAPERS_TIME)
    average = Note("mean", OBSERVABLE, range(round(BURN / HORIZON * steps) + 1, steps + 1), "mean")
    return SchemeRun(_problem(eps), scheme, steps, (average,))


def _problem(eps: str) -> str:
    return f"torus[eps={eps},horizon={HORIZON}]"


def exact(evidence: ExperimentEvidence, eps: str) -> float:
    """Return the invariant mean for a value of eps."""
    truths = evidence.problem(_problem(eps)).truths
    return next(each.value for each in truths if isinstance(each, InvariantMean) and each.observable == OBSERVABLE)


def stationary_mean(evidence: ExperimentEvidence, scheme: str, eps: str, k: int) -> Mean:
    """Return the mean of the time averages; NaN if paths are lost.

    Parameters
    ----------
    evidence : ExperimentEvidence
    scheme, eps : str
        Label of the scheme, and eps as in the plan.
    k : int
        Level of the run, with steps of T/2^k.
    """
    if scheme == EXPLICIT and eps == "0":
        return Mean(np.nan, np.nan, 0)
    return mean(evidence.values((scheme, eps, k), "mean")[-1])


def _entries(evidence: ExperimentEvidence, scheme: str, eps: str, k: int) -> Iterator[TableEntry]:
    found, known = stationary_mean(evidence, scheme, eps, k), exact(evidence, eps)
    if np.isfinite(found.value):
        yield found._replace(value=found.value - known).entry(
            f"error of the stationary mean of {OBSERVABLE}, {NAMES[scheme]}",
            {"h": f"10/2^{k}", "eps": eps, "mean": f"{found.value:.5f}"},
            more={"invariant_mean": known},
        )


def _curve(evidence: ExperimentEvidence, scheme: str, k: int, label: str, hue: int) -> Curve:
    eps = np.array([max(float(each), 1e-7) for each in STIFFNESSES])
    value, error, _ = np.array([stationary_mean(evidence, scheme, each, k) for each in STIFFNESSES]).T
    size = np.abs(value - [exact(evidence, each) for each in STIFFNESSES])
    low, high = np.maximum(size - 2.0 * error, 1e-5), size + 2.0 * error
    kept = np.isfinite(size)
    return Curve(label, eps[kept], size[kept], low[kept], high[kept], hue=hue)


X = "eps (0 is drawn at 1e-7)"


def _schemes(evidence: ExperimentEvidence) -> Panel:
    curves = [_curve(evidence, scheme, FIRST, name, hue) for hue, (scheme, name) in enumerate(NAMES.items())]
    return Panel("three schemes, h = 10/2^9", X, "|error of E |x|^2|, 2 standard errors", tuple(curves), "xy")


def _sizes(evidence: ExperimentEvidence, levels: range) -> Panel:
    curves = [_curve(evidence, UNIFORM, k, f"h = 10/2^{k}", hue) for hue, k in enumerate(levels)]
    return Panel("uniformly accurate, by h", X, "|error of E |x|^2|, 2 standard errors", tuple(curves), "xy")


def _largest(evidence: ExperimentEvidence, levels: range) -> Panel:
    h = PAPERS_TIME / 2.0 ** np.array(levels)
    each = [_curve(evidence, UNIFORM, k, "", 0) for k in levels]
    top = np.array([curve.y.max() for curve in each])
    bars = np.array([(curve.low[curve.y.argmax()], curve.high[curve.y.argmax()]) for curve in each])
    curves = (
        Curve("sup over eps", h, top, bars[:, 0], bars[:, 1]),
        Curve("h", h, top[0] * h / h[0], kind="guide"),
        Curve("h^(1/2), as proved", h, top[0] * np.sqrt(h / h[0]), kind="guide"),
    )
    return Panel("uniformly accurate, largest over eps", "h", "sup |error|", curves, "xy")


def _describe_losses(evidence: ExperimentEvidence) -> Iterator[str]:
    for scheme, name in NAMES.items():
        for eps in STIFFNESSES:
            noted = evidence.run((scheme, eps, FIRST)).noted.get("mean")
            if noted is None:
                continue
            for what, paths in (("are lost", noted.lost), ("meet a step without root", noted.without_root)):
                if paths.any():
                    count = int(paths[-1].sum())
                    yield f"{name}, eps = {eps}, h = 10/2^9: {count} of {paths.shape[1]} paths {what}"


@hookimpl
def sdaeverify_experiments() -> list[Experiment]:
    """Register the figure."""
    return [StationaryErrors()]
