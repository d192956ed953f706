"""The evidence on one component's pathwise errors, its statistics, and its level rows."""

from collections.abc import Container, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import chain
from math import inf, nan
from typing import NamedTuple

import numpy as np

from ...arrays import Array
from ...contracts.finding import Finding, Judgement, LevelFinding, Opinion
from ...contracts.measure import Evidence
from ...contracts.scheme import AT_T
from ...contracts.tally import Tally
from ...numerics.statistics import (
    EPS,
    GROUPS,
    Estimate,
    Tail,
    estimates,
    leave_out,
    log_norms,
    slope_weights,
)
from ...verdicts.coverage import Coverage, coverage
from ...verdicts.opinions import leave_open
from ...verdicts.rules import withhold_in_doubt
from ..slopes import Slopes
from .errors import ERROR, POWERS


@dataclass(frozen=True)
class Quantity(Slopes):
    """The evidence on one component: y = log2 E e, for errors e along paths.

    Attributes
    ----------
    name : str
    h : ndarray, shape (L,)
        Step sizes.
    error : ndarray, shape (G, L, 3) or (G, L, 4)
        Sums of e_l^p over groups, p = 1/2, 1, 2 and, on request, 4.
    difference : ndarray, shape (G, L - 1)
        Sums of |x_l - x_{l+1}|.
    blurred : ndarray, shape (G, L), or None
        Sums of e_l relative to the truth at half its resolution, if the truth has a discretisation error.
    relative : ndarray, shape (G, L), or None
        Sums of |x_l - x|/|x| over groups, at T.
    counts : ndarray, shape (G,)
    largest : ndarray, shape (L, k)
    size, moved : float
        Largest value of the true component, and its largest distance from its initial value.
    motion : float
        Mean over paths of the component's distance from its initial value; infinite if it was not recorded.
    """

    name: str
    h: Array
    error: Array
    difference: Array
    blurred: Array | None
    relative: Array | None
    counts: Array
    largest: Array
    size: float
    moved: float
    motion: float = inf

    @property
    def paths(self) -> int:
        """Number of paths."""
        return int(self.counts.sum())

    @property
    def totals(self) -> Array:
        """Sums of e_l^p over all paths, shape (L, 3) or (L, 4)."""
        return np.asarray(self.error.sum(axis=0))

    def rounding(self, steps: Array) -> Array:
        """Return eps sqrt(N) times the component's size: the rounding error accumulated over N steps."""
        return np.asarray(EPS * self.size * np.sqrt(steps))

    def means(self, power: int = 1) -> Array:
        """Return E e_l^p, shape (L,)."""
        return np.asarray(self.totals[:, power] / self.paths)

    def find_logarithms(self) -> Array:
        """Return log2 (E e_l^p)^(1/p) of all levels, one power after the other, log2 E d_l, and blurred errors."""
        blurred = [] if self.blurred is None else [self.blurred.T]
        columns = np.concatenate([self.error.T.reshape(-1, len(self.counts)), self.difference.T, *blurred])
        p = np.ones(len(columns))
        p[: self.powers * self.levels] = np.repeat(POWERS[: self.powers], self.levels)
        # Each column is contiguous over groups. Levels that are not used in fits are included.
        with np.errstate(all="ignore"):
            return log_norms(leave_out(np.ascontiguousarray(columns).T, self.counts), p)

    @property
    def levels(self) -> int:
        """Number of levels with known errors."""
        return int(self.error.shape[1])

    @property
    def powers(self) -> int:
        """Number of `POWERS` that were recorded."""
        return int(self.error.shape[2])

    def linear(self, levels: Array, weights: Array, power: int = 1) -> Estimate:
        """Return sum_l w_l y_l, y = log2 (E e^p)^(1/p), on some levels.

        Parameters
        ----------
        levels : ndarray of int
        weights : ndarray, shape of levels
        power : int
            Index of p in `POWERS`.
        """
        return super().linear(levels + power * self.levels, weights)

    def slope_in(self, levels: Array, power: int) -> Estimate:
        """Return the least-squares slope of log2 (E e^p)^(1/p), where `power` is the index of p in `POWERS`."""
        return self.linear(levels, slope_weights(np.log2(self.h[levels])), power)

    def contrast(self, levels: Array, share: float = 1.0) -> Estimate:
        """Return the slope of log2 E e_{l+1} minus `share` times that of log2 E d_l on the same levels l.

        With `share` 1 it is 0 in the limit h -> 0, if the limit is right.
        """
        coarse, fine = levels[:-1], levels[1:]
        weights = slope_weights(np.log2(self.h[coarse]))
        columns = np.concatenate([fine + self.levels, coarse + self.powers * self.levels])
        return super().linear(columns, np.concatenate([weights, -share * weights]))

    def contrast_rise(self, levels: Array) -> Estimate:
        """Return the increase of the contrast from the last three levels but one to the last three.

        Errors towards a wrong limit level off further with each halving, so it is negative then.
        """
        weights = np.array([-1.0, 2.0, -1.0])
        columns = np.concatenate([levels[-3:] + self.levels, levels[-4:-1] + self.powers * self.levels])
        return super().linear(columns, np.concatenate([weights, -weights]))

    def ahead(self, levels: Array) -> Estimate:
        """Return the local order at the next step size, extrapolated linearly from the last two."""
        return self.linear(levels[-3:], np.array([-1.0, 3.0, -2.0]))

    def blur(self, levels: Array, weights: Array) -> Estimate:
        """Return the change of sum_l w_l y_l if the truth is replaced by that at half its resolution."""
        assert self.blurred is not None
        last = self.logarithms.shape[-1] - self.levels
        columns = np.concatenate([levels + self.levels, levels + last])
        return super().linear(columns, np.concatenate([-weights, weights]))

    @property
    def local_orders(self) -> tuple[Estimate, ...]:
        """Order between each level and the previous one, without the coarsest level; empty for one level."""
        if self.levels < 2:
            return ()
        x, y = np.log2(self.h[: self.levels]), self.logarithms[:, self.levels : 2 * self.levels]
        weights = np.stack([slope_weights(x[level : level + 2]) for level in range(len(x) - 1)], axis=1)
        # Also evaluated for levels and quantities without errors.
        with np.errstate(invalid="ignore"):
            return estimates(weights[0] * y[:, :-1] + weights[1] * y[:, 1:])

    @property
    def relative_errors(self) -> tuple[Estimate, ...]:
        """E |x_l - x|/|x| at T of each level; empty if it was not recorded."""
        return () if self.relative is None else estimates(leave_out(np.asfortranarray(self.relative), self.counts))

    def tail(self, level: int) -> Tail:
        """Return the tail diagnostics of a level."""
        return Tail.of(float(self.totals[level, 1]), float(self.totals[level, 2]), self.largest[level], self.paths)


def quantities_of(evidence: Evidence, kind: str = ERROR) -> tuple[Quantity, ...]:
    """Return the quantities of a cell in the order of the evidence.

    Parameters
    ----------
    evidence : Evidence
    kind : str, optional
        Kind of errors, as given to `tally_errors`; that of `ErrorObserver` if omitted.
    """
    return evidence.along_paths.read(_quantities, kind, evidence.settings.extremes, *evidence.step_sizes)


def _quantities(tally: Tally, kind: str, extremes: int, *step_sizes: float) -> tuple[Quantity, ...]:
    sums, prefix = tally.sums, f"{kind} "
    names = [name.removeprefix(prefix) for name in sums if name.startswith(prefix)]
    h, nothing, own = np.array(step_sizes), np.empty((GROUPS, 0)), kind == ERROR
    return tuple(
        Quantity(
            name=name,
            h=h,
            error=sums[prefix + name],
            difference=sums[f"difference {name}"] if own else nothing,
            blurred=sums.get(f"blurred {name}") if own else None,
            relative=sums.get(f"relative {name}"),
            counts=sums["paths"],
            largest=tally.largest[name if own else prefix + name][..., :extremes],
            size=float(tally.maxima[f"size {name.removesuffix(AT_T)}"][0]),
            moved=float(tally.maxima[f"moved {name.removesuffix(AT_T)}"][0]),
            motion=_mean(sums.get(f"motion {name}"), sums["paths"]),
        )
        for name in names
    )


def _mean(sums: Array | None, counts: Array) -> float:
    return inf if sums is None else float(sums.sum() / counts.sum())


ERROR_COLUMNS = {
    "estimate_L2": "the error in the L2 norm",
    "local_order": "order between this step size and the one before",
    "local_order_std_error": "its standard error",
    "fitted": "whether the order is fitted to this level",
}
# Confidence of the interval of the mean relative error at T, as in Lindner et al. (2018), section 4.2.
# Level: of an interval that is reported and enters no verdict.
RELATIVE_CONFIDENCE = 0.9


def level_rows(quantity: Quantity, fitted: Container[int], norms: Mapping[str, int]) -> Iterator[LevelFinding]:
    """Yield E e_l with its standard error, and further columns.

    Parameters
    ----------
    quantity : Quantity
    fitted : container of int
        Levels to which the slope was fitted.
    norms : mapping of str to int
        Further norms (E e_l^p)^{1/p} by name, as indices of p in `POWERS`.

    Yields
    ------
    LevelFinding
    """
    means, orders = quantity.totals / quantity.paths, quantity.local_orders
    roots = [(f"estimate_{name}", p, 1.0 / POWERS[p]) for name, p in norms.items()]
    for level, (_, one, two, *_) in enumerate(means):
        spread = np.sqrt(max(two - one**2, 0.0) / quantity.paths)
        known = level and one and means[level - 1, 1]
        local = orders[level - 1] if known else Estimate(nan, nan)
        details = {
            **{name: float(means[level, p] ** root) for name, p, root in roots},
            "local_order": local.value,
            "local_order_std_error": local.se,
            "fitted": level in fitted,
            **_relative(quantity, level),
        }
        yield LevelFinding(quantity.name, level, float(one), float(spread), details)


class JudgedQuantity(NamedTuple):
    """The finding on a quantity, and the levels to which its slope was fitted."""

    quantity: Quantity
    finding: Finding
    fitted: Container[int] = frozenset()


def judge_together(
    judged: Sequence[JudgedQuantity], others: Iterable[Finding], norms: Mapping[str, int]
) -> Judgement:
    """Return the judgement of a measure; no finding is verified if another quantity tends to a wrong limit.

    Parameters
    ----------
    judged : sequence of JudgedQuantity
    others : iterable of Finding
        Findings on quantities without errors along paths.
    norms : mapping of str to int
        Norms in the level rows, see `level_rows`.
    """
    findings = withhold_in_doubt([*(each.finding for each in judged), *others])
    rows = (level_rows(each.quantity, each.fitted, norms) for each in judged)
    return Judgement(tuple(findings), chain.from_iterable(rows))


def unknown_components(evidence: Evidence, measure: str, suffix: str = "") -> Iterator[tuple[str, Coverage, Opinion]]:
    """Yield the components that the truth lacks, the claim that covers each, and an opinion that leaves it open.

    Parameters
    ----------
    evidence : Evidence
    measure : str
        Name of the measure in claims.
    suffix : str
        Suffix of a component's name in the name of the quantity.
    """
    known, view = {each.name for each in quantities_of(evidence)}, evidence.view
    start = evidence.scheme.start(view, 1, evidence.step_sizes[0])
    for name in evidence.scheme.parts(view, start):
        if name not in known:
            covered = coverage(evidence, measure, f"{name}{suffix}")
            yield name, covered, leave_open(covered, f"the problem's truth does not provide {name}")


def _relative(quantity: Quantity, level: int) -> dict[str, float]:
    """Return the mean over paths of |x_l - x|/|x| at T, with its interval."""
    if quantity.relative is None:
        return {}
    mean = quantity.relative_errors[level]
    low, high = mean.interval(RELATIVE_CONFIDENCE)
    return {"relative": mean.value, "relative_low": low, "relative_high": high}
