"""What is taken from the runs of a block: observables on its paths, and the samples that come of them."""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from ...arrays import Array
from ...contracts.scheme import Scheme
from .sample import Sample


class Value(NamedTuple):
    """An observable on every path after `at` of `steps` steps of a scheme."""

    scheme: Scheme
    steps: int
    observable: str
    at: int


class Noted(NamedTuple):
    """A value on the paths of a block, or why there is none.

    Attributes
    ----------
    values : ndarray, shape (P,)
        NaN on paths that are lost.
    without_root, lost : ndarray of bool, shape (P,)
        Paths on which a step found no root, and which are not finite or blew up, so far.
    error : str
        Empty if there are values.
    """

    values: Array = np.zeros(0)
    without_root: Array = np.zeros(0, dtype=bool)
    lost: Array = np.zeros(0, dtype=bool)
    error: str = ""


class Quantity(NamedTuple):
    """A mean of phi, or of (phi - phi_reference)^2 where there is a reference.

    Attributes
    ----------
    value : Value
    reference : Value or None
    """

    value: Value
    reference: Value | None = None

    @property
    def values(self) -> tuple[Value, ...]:
        """All values it is taken from."""
        return (self.value, self.reference) if self.reference else (self.value,)

    def sample(self, noted: Mapping[Value, Noted]) -> Sample:
        """Return its sample on the paths of a block."""
        found = [noted[value] for value in self.values]
        if error := next((each.error for each in found if each.error), ""):
            return Sample(error=error)
        values = (found[0].values - found[1].values) ** 2 if self.reference else found[0].values
        without_root = np.any([each.without_root for each in found], axis=0)
        lost = np.any([each.lost for each in found], axis=0)
        return Sample.of(values, int(without_root.sum()), int(lost.sum()))
