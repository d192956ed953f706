"""Steps at many times and of many sizes in a single call, if the map accepts arrays over paths for these.

A probe makes a step at many times or of many sizes, on a few paths each, and most of the time is the overhead of the
calls. A step written in array arithmetic also accepts t and h as arrays over paths, shape (P,), and gives the same
result as with numbers, to the last bit. Schemes do not declare this: the first batch, the last one and one in
between are also made separately. If one of these three differs in a bit, or the call with arrays raises, every batch
is made separately.
"""

from collections.abc import Callable, Iterable, Iterator, Sequence
from itertools import accumulate, pairwise
from typing import Any, NamedTuple
from zlib import crc32

import numpy as np

from ...arrays import Array, arrays, each, join_batches
from ...errors import FAULTS
from ...noise.brownian import Increment

# With fewer batches, a call with arrays saves no time over its three separate checks.
# Size: batches.
FEWEST = 5
# Most paths of a call: beyond, its overhead is small, and the arrays do not fit the processor's caches.
# Size: of a batch.
MOST = 2048
# A map (x, t, h, noise) -> batch of paths, with numbers or arrays over paths for t and h.
Map = Callable[[Any, Any, Any, Increment], Any]


class PathBatch(NamedTuple):
    """Paths on which a step begins at the same time and has the same size.

    Attributes
    ----------
    x : ndarray, shape (d, P), or NamedTuple of ndarray
        States: components of the equation, or a scheme's state.
    t, h : float
        Start and size of the step.
    noise : Increment
    """

    x: Any
    t: float
    h: float
    noise: Increment

    @property
    def paths(self) -> int:
        """Number P of paths."""
        return int(self.noise.dW.shape[-1])


def together(step: Map, batches: Iterable[PathBatch]) -> Iterator[Any]:
    """Yield the result of a map for every batch, as if each were computed separately.

    Parameters
    ----------
    step : callable, (x, t, h, noise) -> batch of paths
        Stateless; paths come last in every array of its result.
    batches : iterable of PathBatch
        Their x and noise are of the same kind.
    """
    for group in _groups(batches):
        yield from _make(step, group)


def _groups(batches: Iterable[PathBatch]) -> Iterator[list[PathBatch]]:
    """Yield successive batches with at most `MOST` paths together, or a single larger batch."""
    group: list[PathBatch] = []
    paths = 0
    for batch in batches:
        if group and paths + batch.paths > MOST:
            yield group
            group, paths = [], 0
        group.append(batch)
        paths += batch.paths
    yield group


def _make(step: Map, batches: Sequence[PathBatch]) -> Iterable[Any]:
    made = _made_in_one_call(step, batches) if len(batches) >= FEWEST else None
    if made is None:
        return (step(*batch) for batch in batches)
    for place in (0, _in_between(batches), len(batches) - 1):
        alone = step(*batches[place])
        if _to_bits(alone) != _to_bits(made[place]):
            return (step(*batch) for batch in batches)
    return made


def _made_in_one_call(step: Map, batches: Sequence[PathBatch]) -> list[Any] | None:
    """Return the results for all batches from a call with arrays over paths; None if the map rejects arrays."""
    x, t, h, noise = zip(*batches, strict=True)
    ends = [0, *accumulate(batch.paths for batch in batches)]
    try:
        made = step(join_batches(x, -1), _over_paths(batches, t), _over_paths(batches, h), join_batches(noise, -1))
        if any(np.shape(part)[-1:] != (ends[-1],) for part in arrays(made)):
            return None
    except FAULTS:
        return None
    return [_part(made, begin, end) for begin, end in pairwise(ends)]


def _part(made: Any, begin: int, end: int) -> Any:
    # Copied, because sums over paths have another order if these are not contiguous in memory.
    return each(lambda part: np.ascontiguousarray(part[..., begin:end]), made)


def _over_paths(batches: Sequence[PathBatch], values: Sequence[float]) -> Array | float:
    """Return the common value of all batches, or an array with the value of each path."""
    if len(set(values)) == 1:
        return values[0]
    return np.repeat(values, [batch.paths for batch in batches])


def _in_between(batches: Sequence[PathBatch]) -> int:
    """Return an index between first and last, drawn by a hash, so that it is the same in every process."""
    drawn = crc32(np.array([(batch.t, batch.h) for batch in batches]).tobytes())
    return 1 + drawn % (len(batches) - 2)


def _to_bits(made: Any) -> list[tuple[Any, ...]]:
    told = [np.ascontiguousarray(part) for part in arrays(made)]
    return [(part.shape, part.dtype, part.tobytes()) for part in told]
