"""Order of the supremum over eps of errors of a family's members with the same noise.

With D_l(eps) an error at level l = 0, ..., m, B(eps) that of its reference, p claimed and p_0 = p - margin, the
supremum over eps and observables falls faster than h^{p_0} if some D_0 outweighs all D_m,

    2^{-m p_0} (|D_0(eps')| - |B(eps')|) > |D_m(eps)| + |B(eps)|      for one eps' and for all eps,

and slower if the D_m of some eps outweighs all D_0 of its observable, both from the coarsest step on and over the
last two halvings, because steps that are too coarse are no evidence against an order. Observables are in units of
their standard deviations.

An eps with too many steps without a root has no errors. It is mentioned in the reason. Then the supremum over the
others can refute a claim about all eps, but not verify it.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
import scipy

from sdaeverify import Array
from sdaeverify.measuring import (
    Evidence,
    Finding,
    Kind,
    LevelFinding,
    Method,
    Opinion,
    Order,
    PathTests,
    Reason,
    Verdict,
    coverage,
    decide,
    finding,
    judge_claim,
    with_sample,
)
from sdaeverify.numerics import outweighs, sample_growth

from .paired_members import FAILED, PairedErrors, run_of

WEAK, STRONG = "weak", "strong"
METHODS = {
    WEAK: Method("supremum over eps of errors of means on the same noise", 3),
    STRONG: Method("supremum over eps of distances on the same noise", 3),
}
MEASURE, LAST = "uniformity", 2


class Bands(NamedTuple):
    """Suprema over eps and observables at L step sizes, with simultaneous lower and upper bounds.

    Attributes
    ----------
    value, low, high : ndarray, shape (L,)
    worst : ndarray of int, shape (L,)
        Flat index of the eps and the observable that attain the supremum, eps first.
    """

    value: Array
    low: Array
    high: Array
    worst: Array


@dataclass(frozen=True)
class PairedMeans:
    """Group means of the errors of one kind.

    Attributes
    ----------
    D : ndarray, shape (G, E, L, Q)
    B : ndarray, shape (G, E, Q)
    h, eps : ndarray, shape (L,) and (E,)
    power : float
        Power of the error in D: 2 if D are squares.
    names : tuple of str
        Of the observables.
    left_out : ndarray
        The eps without errors.
    """

    D: Array
    B: Array
    h: Array
    eps: Array
    power: float
    names: tuple[str, ...]
    left_out: Array

    @property
    def choices(self) -> int:
        """Number of pairs of an eps and an observable."""
        return len(self.eps) * len(self.names)

    def falls(self, order: float) -> float:
        """Return the p-value of the hypothesis that the supremum does not fall with an order."""
        means = np.abs(self.D[:, :, 0].mean(axis=0))
        # The maximum is chosen from the sample, so each candidate counts as a test.
        e, q = np.unravel_index(means.argmax(), means.shape)
        c = self._factor(0, order)
        largest, blur = c * self.D[:, e, 0, q], c * self.B[:, e, q]
        p = outweighs(largest[:, None, None], blur[:, None, None], self.D[:, :, -1], self.B)
        return min(1.0, self.choices * float(p.max()))

    def stays(self, order: float) -> tuple[float, int]:
        """Return the smallest p-value of the hypothesis that the supremum falls with an order, and its observable."""
        found = [self._stays(order, q) for q in range(len(self.names))]
        return min(1.0, self.choices * min(found)), int(np.argmin(found))

    def bands(self, confidence: float) -> Bands:
        """Return the suprema with simultaneous intervals."""
        t = float(
            scipy.special.stdtrit(len(self.D) - 1, 1.0 - 0.25 * (1.0 - confidence) / (len(self.h) * self.choices))
        )
        size, blur = np.abs(self.D.mean(axis=0)), np.abs(self.B.mean(axis=0))
        off = t * self._errors(self.D) + (blur + t * self._errors(self.B))[:, None]
        flat = [np.moveaxis(each, 1, 0).reshape(len(self.h), -1) for each in (size, size - off, size + off)]
        value, low, high = (each.max(axis=1) for each in flat)
        return Bands(value, np.maximum(low, 0.0), high, flat[0].argmax(axis=1))

    def of(self, observable: int) -> "PairedMeans":
        """Return the means of one observable."""
        q = slice(observable, observable + 1)
        return replace(self, D=self.D[..., q], B=self.B[..., q], names=self.names[q])

    def order(self, bands: Bands) -> Array:
        """Return the order of the supremum with the ends of its interval, shape (3,)."""
        ends = [(bands.value[0], bands.value[-1]), (bands.low[0], bands.high[-1]), (bands.high[0], bands.low[-1])]
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.array([np.log2(np.divide(a, b)) for a, b in ends]) / (self.power * (len(self.h) - 1))

    def place(self, bands: Bands, level: int) -> dict[str, object]:
        """Return the observable and the eps that attain the supremum at a level."""
        e, q = divmod(int(bands.worst[level]), len(self.names))
        return {"functional": self.names[q], "worst_eps": float(self.eps[e])}

    def _stays(self, order: float, q: int) -> float:
        e = np.abs(self.D[:, :, -1, q].mean(axis=0)).argmax()
        last, blur = self.D[:, e, -1, q][:, None], self.B[:, e, q][:, None]
        p = []
        for column in {0, max(len(self.h) - 1 - LAST, 0)}:
            c = self._factor(column, order)
            p.append(outweighs(last, blur, c * self.D[:, :, column, q], c * self.B[:, :, q]).max())
        return float(max(p))

    def _factor(self, column: int, order: float) -> float:
        return float(2.0 ** (-(len(self.h) - 1 - column) * self.power * order))

    def _errors(self, values: Array) -> Array:
        return np.asarray(values.std(axis=0, ddof=1) / np.sqrt(len(values)))


def paired_findings(evidence: Evidence, record: PairedErrors) -> Iterator[tuple[Finding, Iterator[LevelFinding]]]:
    """Yield the weak and the strong finding, each with its suprema."""
    for name in METHODS:
        sample = sample_of(evidence, record, name)
        yield _finding(evidence, record, name, sample), _levels(evidence, name, sample)


def sample_of(evidence: Evidence, record: PairedErrors, name: str) -> PairedMeans:
    """Return the errors of one kind for eps with at most one in a hundred paths with a step without a root.

    Levels start at the first or the second one, whichever keeps more values of eps.

    Parameters
    ----------
    evidence : Evidence
    record : PairedErrors
        Errors of members of the family with the same noise.
    name : str
        Kind of error: strong or weak.
    """
    bad = record.failed.sum(axis=1) > FAILED * record.counts.sum()
    first = min(range(2), key=lambda level: (bad[:, level:].any(axis=1).sum(), level))
    used, counts = ~bad[:, first:].any(axis=1), record.counts[:, None, None]
    h, eps, left_out = record.h[first:], record.eps[used], record.eps[~used]
    if name == STRONG:
        D = record.strong[used, :, first:].swapaxes(0, 1) / counts
        return PairedMeans(D[..., None], np.zeros((*D.shape[:2], 1)), h, eps, 2.0, ("x",), left_out)
    mean, square = np.moveaxis(record.values.sum(axis=1) / record.counts.sum(), 1, 0)
    spread = np.sqrt(np.maximum(square - mean**2, 0.0))[used].max(axis=0, initial=0.0)
    size = np.where(spread > 0.0, spread, 1.0)
    D = record.weak[used, :, first:].swapaxes(0, 1) / counts[..., None] / size
    B = record.blurred[used].swapaxes(0, 1) / counts / size
    return PairedMeans(D, B, h, eps, 1.0, tuple(evidence.view.observables), left_out)


def _finding(evidence: Evidence, record: PairedErrors, name: str, sample: PairedMeans) -> Finding:
    covered = coverage(evidence, MEASURE, name)
    order, details = np.full(3, np.nan), {}
    lost = Reason(f"for all eps a step has no root on more than {100.0 * FAILED:g} % of the paths")
    opinion = Opinion(Verdict.INCONCLUSIVE, lost)
    if len(sample.eps):
        bands = sample.bands(evidence.settings.confidence)
        order, details = sample.order(bands), sample.place(bands, -1)
        opinion = judge_claim(covered, lambda claim: _opinion(evidence, record, claim.value, sample))
    value, low, high = map(float, order)
    shown = {"estimate": value, "low": low, "high": high, "method": METHODS[name], "details": details}
    return finding(covered, opinion._replace(settled=True), **shown)


def _opinion(evidence: Evidence, record: PairedErrors, claim: Order, sample: PairedMeans) -> Opinion:
    paths = int(record.counts.sum())
    lost = record.lost[np.isin(record.eps, sample.eps)].sum(axis=1)
    if lost[:, -1].max() > FAILED * paths:
        where = f"h = {0.5 * record.h[-1]:.3g}, eps = {sample.eps[lost[:, -1].argmax()]:.3g}"
        return Opinion(Verdict.REFUTED, Reason(f"the error is not bounded: paths are not finite at {where}"))
    if lost.any():
        return Opinion(Verdict.INCONCLUSIVE, Reason(f"{int(lost.max())} of {paths} paths are not finite"))
    order = claim.floor
    falls, (stays, worst) = sample.falls(order), sample.stays(order)
    shown = sample.of(worst) if stays <= evidence.level else sample
    reason = _order(evidence, claim, shown, paths)
    if len(sample.left_out):
        rest = PathTests(1.0, stays, reason.then(_missing_eps(sample.left_out)))
        return decide(with_sample(rest, paths, heavy=False), evidence)
    opinion = decide(with_sample(PathTests(falls, stays, reason), paths, heavy=False), evidence)
    more = min(sample_growth(p, evidence.level, len(sample.D)) for p in (falls, stays))
    if opinion.verdict is Verdict.INCONCLUSIVE and np.isfinite(more):
        needed = {"paths": float(f"{run_of(more * paths):.1g}")}
        return opinion.plus(Reason("about {paths:.0f} paths would decide (--paths)", Kind.MORE_PATHS, needed))
    return opinion


def _order(evidence: Evidence, claim: Order, sample: PairedMeans, paths: int) -> Reason:
    bands = sample.bands(evidence.settings.confidence)
    (order, low, high), at = sample.order(bands), sample.place(bands, -1)
    over = f"{len(sample.eps)} eps from {sample.eps[0]:.3g} to {sample.eps[-1]:.3g}"
    text = "order {order:.2f} [{low:.2f}, {high:.2f}] of the supremum over {over}; {bar}"
    figures = {"order": order, "over": over, "low": low, "high": high, "bar": claim.bar}
    where = f"{at['functional']} at eps = {at['worst_eps']:.3g}, h = {sample.h[-1]:.3g}"
    return Reason(text, Kind.ORDER, figures).then(f"{where}, {paths} paths")


def _missing_eps(eps: Array) -> str:
    which = f"eps = {eps[0]:.3g}" if len(eps) == 1 else f"{len(eps)} eps from {eps[0]:.3g} to {eps[-1]:.3g}"
    return f"nothing is known for {which}, where a step has no root on more than {100.0 * FAILED:g} % of the paths"


def _levels(evidence: Evidence, name: str, sample: PairedMeans) -> Iterator[LevelFinding]:
    for index in range(len(sample.names) if len(sample.eps) else 0):
        one = sample.of(index)
        bands = one.bands(evidence.settings.confidence)
        for level, h in enumerate(sample.h):
            value, low, high = (float(part[level] ** (1.0 / sample.power)) for part in bands[:3])
            yield LevelFinding(
                name, None, value, 0.0, {"low": low, "high": high, **one.place(bands, level)}, float(h)
            )
