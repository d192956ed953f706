"""States and increments as batches of paths: one array, or a NamedTuple of arrays of which some may be None."""

from collections.abc import Callable
from typing import Any

import numpy as np

from ..arrays import Array
from ..numerics.statistics import EPS


def each(change: Callable[[Array], Array], batch: Any) -> Any:
    """Return a batch with every array changed."""
    if isinstance(batch, tuple):
        parts: list[Any] = [None if part is None else change(part) for part in batch]
        return type(batch)(*parts)
    return change(batch)


def equal(a: Any, b: Any) -> bool:
    """Tell whether two batches of the same kind agree to the last bit, NaN with NaN."""
    if not isinstance(a, tuple):
        return bool(np.array_equal(a, b, equal_nan=np.asarray(a).dtype.kind == "f"))
    return all(equal(x, y) for x, y in zip(a, b, strict=True) if x is not None)


def frozen(batch: Any) -> Any:
    """Return a copy that cannot be written into."""

    def closed(part: Array) -> Array:
        copy = np.array(part)
        copy.flags.writeable = False
        return copy

    return each(closed, batch)


def taken(batch: Any, paths: Array | slice) -> Any:
    """Return some of the paths, as a copy that cannot be written into."""
    return frozen(each(lambda part: part[..., paths], batch))


def nudged(batch: Any) -> Any:
    """Return a batch with every number moved up by one rounding error, as a copy that cannot be written into."""
    return frozen(each(lambda part: part * (1.0 + EPS) if part.dtype.kind == "f" else part, batch))
