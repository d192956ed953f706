"""The array conventions of the package, and batches of arrays with common paths.

Paths come last: a state of n components on P paths has shape ``(n, P)``, a matrix ``(m, n, P)``.
An array of real numbers may be complex if a derivative is computed by a complex step.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]
Mask = NDArray[np.bool_]
Parts = Mapping[str, Array]


def each(change: Callable[[Array], Array], batch: Any) -> Any:
    """Return a batch of paths with a function applied to every array; tuples, mappings and None are preserved."""
    if isinstance(batch, tuple):
        parts: list[Any] = [each(change, part) for part in batch]
        return _named(batch, parts)
    if isinstance(batch, Mapping):
        return {name: each(change, part) for name, part in batch.items()}
    return None if batch is None else change(batch)


def join_batches(batches: Sequence[Any], axis: int = 0) -> Any:
    """Join batches of the same structure along an axis: 0, or -1 for the paths."""
    first = batches[0]
    if isinstance(first, tuple):
        parts: list[Any] = [join_batches(part, axis) for part in zip(*batches, strict=True)]
        return _named(first, parts)
    if isinstance(first, Mapping):
        return {name: join_batches([batch[name] for batch in batches], axis) for name in first}
    return None if first is None else np.concatenate(batches, axis=axis)


def _named(model: tuple[Any, ...], parts: list[Any]) -> Any:
    """Return parts as a NamedTuple of the model's type; raise TypeError if the model is a plain tuple."""
    if type(model) is tuple:
        expected = "a state of several arrays is a NamedTuple, such as the one that the step was given"
        raise TypeError(f"{expected}; got a plain tuple of {len(model)}")
    return type(model)(*parts)


def arrays(batch: Any) -> Iterator[Array]:
    """Yield the arrays of a batch."""
    if isinstance(batch, tuple | Mapping):
        for part in batch.values() if isinstance(batch, Mapping) else batch:
            yield from arrays(part)
    elif batch is not None:
        yield batch
