"""States and increments as batches of paths."""

from typing import Any

import numpy as np

from ..arrays import Array, arrays, each
from ..numerics.statistics import EPS


def equal(a: Any, b: Any) -> bool:
    """Return whether two batches of the same kind agree to the last bit; NaN equals NaN."""
    pairs = zip(arrays(a), arrays(b), strict=True)
    return all(np.array_equal(x, y, equal_nan=np.asarray(x).dtype.kind == "f") for x, y in pairs)


def freeze(batch: Any) -> Any:
    """Return a read-only copy of a batch."""

    def freeze_part(part: Array) -> Array:
        copy = np.array(part)
        copy.flags.writeable = False
        return copy

    return each(freeze_part, batch)


def take_paths(batch: Any, paths: Array | slice) -> Any:
    """Return a read-only copy of some of the paths."""
    return freeze(each(lambda part: part[..., paths], batch))


def nudge(batch: Any) -> Any:
    """Return a read-only copy with every floating-point number increased by one relative rounding error."""
    return freeze(each(lambda part: part * (1.0 + EPS) if part.dtype.kind == "f" else part, batch))
