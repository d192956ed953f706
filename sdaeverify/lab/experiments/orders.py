"""Orders of convergence from the rows that have a reference: how mean squares fall with the step size."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ...arrays import Array
from ...contracts.experiment import FineRun
from ...numerics.statistics import Estimate, jackknife, slope_weights
from .tables import Line

# Step sizes that make a fit.
FEWEST = 3


class Order(NamedTuple):
    """The slope of log2 (E e^2)^(1/2) over log2 h.

    Attributes
    ----------
    problem, scheme, observable : str
    reference : FineRun
    step_sizes : int
        Number of rows.
    estimate : Estimate
        With the standard error of all rows together: they share their paths.
    """

    problem: str
    scheme: str
    observable: str
    reference: FineRun
    step_sizes: int
    estimate: Estimate

    def record(self) -> dict[str, object]:
        """Return it as a mapping of names to texts and numbers."""
        value, std_error = self.estimate
        fields = {"problem": self.problem, "scheme": self.scheme, "observable": self.observable}
        against = {"reference_scheme": self.reference.scheme, "reference_steps": self.reference.steps}
        return {**fields, **against, "step_sizes": self.step_sizes, "order": value, "std_error": std_error}


def orders(found: Sequence[Line]) -> list[Order]:
    """Return the orders of all rows that differ in nothing but their step size, where there are three or more."""
    fits: dict[tuple[object, ...], list[Line]] = {}
    for line in found:
        if line.row.reference is not None and line.sample.value > 0.0:
            row = line.row
            fits.setdefault((row.problem, row.scheme, row.observable, row.reference, line.time), []).append(line)
    return [_order(lines) for lines in fits.values() if len({line.h for line in lines}) >= FEWEST]


def _order(lines: Sequence[Line]) -> Order:
    row, h = lines[0].row, np.array([line.h for line in lines])
    groups = np.array([line.sample.groups for line in lines])
    weights = slope_weights(np.log2(h))

    def slope(means: Array) -> float:
        return float(weights @ np.log2(np.sqrt(means)))

    assert row.reference is not None
    estimate = jackknife(groups[..., 1].T, groups[0, :, 0], slope)
    return Order(row.problem, row.scheme, row.observable, row.reference, len(lines), estimate)
