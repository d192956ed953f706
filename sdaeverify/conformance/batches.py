"""States and increments as batches of paths."""

from typing import Any

import numpy as np

from ..arrays import Array, arrays, each
from ..numerics.statistics import EPS


def equal(a: Any, b: Any) -> bool:
    """Tell whether two batches of the same kind agree to the last bit, NaN with NaN."""
    pairs = zip(arrays(a), arrays(b), strict=True)
    return all(np.array_equal(x, y, equal_nan=np.asarray(x).dtype.kind == "f") for x, y in pairs)


def freeze(batch: Any) -> Any:
    """Return a copy that cannot be written into."""

    def freeze_part(part: Array) -> Array:
        copy = np.array(part)
        copy.flags.writeable = False
        return copy

    return each(freeze_part, batch)


def take_paths(batch: Any, paths: Array | slice) -> Any:
    """Return some of the paths, as a copy that cannot be written into."""
    return freeze(each(lambda part: part[..., paths], batch))


def nudge(batch: Any) -> Any:
    """Return a batch with every number moved up by one rounding error, as a copy that cannot be written into."""
    return freeze(each(lambda part: part * (1.0 + EPS) if part.dtype.kind == "f" else part, batch))
