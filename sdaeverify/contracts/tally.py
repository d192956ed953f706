"""Mergeable evidence: sums, maxima and largest values over paths, block by block."""

from collections.abc import Callable, Hashable, Mapping
from dataclasses import dataclass, field
from typing import Any, TypeVar

import numpy as np

from ..arrays import Array

Record = TypeVar("Record")
Found = TypeVar("Found")

# Number of largest values stored of each block, independent of the number of paths, so that paths can be added later.
EXTREMES = 128


@dataclass(frozen=True, eq=False)
class Tally:
    """Sufficient statistics of a set of paths, by name.

    Attributes
    ----------
    sums, maxima : mapping of str to ndarray
        Merged by addition (NaN propagates) and by elementwise maximum (NaN is ignored).
    largest : mapping of str to ndarray, shape (..., k)
        Descending along the last axis; merging keeps as many values as the longer array has.
    """

    sums: Mapping[str, Array] = field(default_factory=dict)
    maxima: Mapping[str, Array] = field(default_factory=dict)
    largest: Mapping[str, Array] = field(default_factory=dict)
    _readings: dict[tuple[object, ...], Any] = field(default_factory=dict, init=False, repr=False)

    def __post_init__(self) -> None:
        # The rounding of a sum depends on the memory layout, so arrays have the layout they have when read from a
        # file.
        for kind in ("sums", "maxima", "largest"):
            given: Mapping[str, Array] = getattr(self, kind)
            object.__setattr__(self, kind, {name: np.asarray(value, order="C") for name, value in given.items()})

    def __reduce__(self) -> tuple[type["Tally"], tuple[Mapping[str, Array], ...]]:
        return Tally, (self.sums, self.maxima, self.largest)

    def read(self, reading: Callable[..., Found], *given: Hashable) -> Found:
        """Return the value of a pure function of the evidence and of further arguments; computed once and cached."""
        if (reading, *given) not in self._readings:
            self._readings[reading, *given] = reading(self, *given)
        found: Found = self._readings[reading, *given]
        return found

    def merge(self, other: "Tally") -> "Tally":
        """Return the evidence of the union of two disjoint sets of paths; a name in only one of them is copied."""
        if not (other.sums or other.maxima or other.largest):
            return self
        if not (self.sums or self.maxima or self.largest):
            return other
        return Tally(
            _merge(self.sums, other.sums, np.add),
            _merge(self.maxima, other.maxima, np.fmax),
            _merge(self.largest, other.largest, _join),
        )


def packed(prefix: str, record: Any) -> Tally:
    """Store a NamedTuple of numbers and arrays as evidence, under names that begin with a prefix."""
    return Tally(
        sums={f"{prefix} {name}": np.asarray(value, dtype=float) for name, value in record._asdict().items()}
    )


def unpacked(prefix: str, kind: type[Record], tally: Tally) -> Record | None:
    """Return the NamedTuple that `packed` stored under a prefix, as arrays; None if there is none.

    Parameters
    ----------
    prefix : str
        As given to `packed`.
    kind : type of NamedTuple
    tally : Tally
    """
    fields = kind._fields  # type: ignore[attr-defined]
    if not all(f"{prefix} {name}" in tally.sums for name in fields):
        return None
    return kind(*(tally.sums[f"{prefix} {name}"] for name in fields))


def largest(values: Array, k: int) -> Array:
    """Return the k largest values along the last axis, descending; NaN counts as largest."""
    return np.sort(values, axis=-1)[..., ::-1][..., :k]


def _join(a: Array, b: Array) -> Array:
    return largest(np.concatenate([a, b], axis=-1), max(a.shape[-1], b.shape[-1]))


def _merge(
    a: Mapping[str, Array], b: Mapping[str, Array], operation: Callable[[Array, Array], Array]
) -> dict[str, Array]:
    both = {name: operation(a[name], b[name]) for name in a if name in b}
    return {**a, **b, **both}
