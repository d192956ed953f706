"""Steps from many times and of many sizes in a single call, where the map takes these path by path.

A probe makes the same step at many times or of many sizes, on a few paths each, and most of the work is the call. A
step that is written in arithmetic on arrays takes t and h as arrays over paths, shape (P,), too, and goes to the same
place as with numbers, to the last bit. No scheme declares that it does: the first batch, the last one and one in
between are made alone as well. Where one of these three differs in a bit, or the call with arrays raises, every batch
is made alone.
"""

from collections.abc import Callable, Iterable, Iterator, Sequence
from itertools import accumulate, pairwise
from typing import Any, NamedTuple
from zlib import crc32

import numpy as np

from ...arrays import Array, arrays, each, join_batches
from ...errors import FAULTS
from ...noise.brownian import Increment

# Of fewer batches than this, three that are made alone and a call with arrays save nothing.
# Size: batches.
FEWEST = 5
# Paths of a call: of more, the call is a small part of what a step takes, and arrays do not stay near the processor.
# Size: of a batch.
MOST = 2048
# A map (x, t, h, noise) -> batch of paths, with numbers or arrays over paths for t and h.
Map = Callable[[Any, Any, Any, Increment], Any]


class PathBatch(NamedTuple):
    """Paths on which a step begins at the same time and has the same size.

    Attributes
    ----------
    x : ndarray, shape (d, P), or NamedTuple of ndarray
        Where they are: components of the equation, or a scheme's state.
    t, h : float
        Start of the step, and its size.
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
    """Yield what a map makes of every batch, as if each were made alone.

    Parameters
    ----------
    step : callable, (x, t, h, noise) -> batch of paths
        Stateless; paths come last in every array of its result.
    batches : iterable of PathBatch
        All of the same kind of x and noise.
    """
    for group in _groups(batches):
        yield from _make(step, group)


def _groups(batches: Iterable[PathBatch]) -> Iterator[list[PathBatch]]:
    """Yield successive batches of `MOST` paths at most, one batch if it has more."""
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
    """Return what a call with arrays over paths makes of the batches, or None where the map takes no arrays."""
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
    # As a copy: sums over paths are taken in another order where these lie apart in memory.
    return each(lambda part: np.ascontiguousarray(part[..., begin:end]), made)


def _over_paths(batches: Sequence[PathBatch], values: Sequence[float]) -> Array | float:
    """Return one number for all batches, or an array of one for each path."""
    if len(set(values)) == 1:
        return values[0]
    return np.repeat(values, [batch.paths for batch in batches])


def _in_between(batches: Sequence[PathBatch]) -> int:
    """Return a place between the first and the last one, drawn by a hash: the same in every process."""
    drawn = crc32(np.array([(batch.t, batch.h) for batch in batches]).tobytes())
    return 1 + drawn % (len(batches) - 2)


def _to_bits(made: Any) -> list[tuple[Any, ...]]:
    told = [np.ascontiguousarray(part) for part in arrays(made)]
    return [(part.shape, part.dtype, part.tobytes()) for part in told]
