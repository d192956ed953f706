"""Brownian noise by address: the increments of a path depend only on (seed, problem, block, level).

A path is drawn coarse and refined by Brownian bridges. A step of length h is described by two
independent numbers per component,

    dW = W(t+h) - W(t)                                   variance h
    H  = (1/h) int_t^{t+h} (W(s) - W(t)) ds - dW/2       variance h/12   (space-time Levy area)

Refinement preserves both, so that a finer level leaves every coarser one unchanged, to the last bit. On request there
is a third number, drawn and refined in the same way; the paths then differ from those without it,

    K  = (1/h^2) int_t^{t+h} (W(s) - W(t) - (s - t) dW/h) (t + h/2 - s) ds        variance h/720   (second area)

and there are Levy areas A between components (`areas`), which do not change dW, H and K. Areas are computed from the
finest level: another finest level gives other areas, with their law given the rest of the path.
"""

import hashlib
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import scipy

from ..arrays import Array, arrays, each, join_batches
from ..errors import SchemeError
from ..numerics import antisymmetric
from .areas import REST, join_areas, known_part
from .records import NoiseRecord

# Number of steps of a level in memory at a time.
LONGEST = 16
# Divisors of the step's length that give the variances of dW, H and K.
PARTS = {"dW": 1, "H": 12, "K": 720}
# All kinds of noise: increments, space-time Levy areas, second areas, Levy areas between components; and the usual
# ones.
BROWNIAN = ("dW", "H", "K", "A")
USUAL = frozenset({"dW", "H"})


class Increment(NamedTuple):
    """Noise of one step: l Brownian motions on P paths and, if the problem has a delay, lagged states.

    Attributes
    ----------
    dW : ndarray, shape (l, P)
        Brownian increments, unit sqrt(time).
    H : ndarray, shape (l, P), or None
        Space-time Levy areas, unit sqrt(time); None if the problem does not draw them.
    xi : ndarray, shape (k, P), or None
        Independent standard normals for an exact solution that needs functionals of W beyond dW and H.
    lagged, ahead : ndarray, shape (d, P), or None
        Lagged state at the start of the step, and the known part of the lagged state at its end; see `Lag`.
    records : mapping of str to object
        Noise other than Brownian motions that the form declares, see `NoiseRecord`.
    K : ndarray, shape (l, P), or None
        Second space-time Levy areas, unit sqrt(time); None if the problem does not draw them.
    A : ndarray, shape (l (l - 1)/2, P), or None
        Levy areas A_ij of the pairs (0, 1), (0, 2), ..., (1, 2), ..., unit time; None if the problem does not draw
        them. See `double_integrals`.

    Notes
    -----
    A scheme declares the noise it needs other than dW: ``noise = frozenset({"dW", "H"})``. Given h, dW and H
    are independent normals of variances h and h/12: ``dW/sqrt(h)`` and ``sqrt(12/h) H`` are two independent standard
    normals per step and Brownian motion.
    """

    dW: Array
    H: Array | None
    xi: Array | None = None
    lagged: Array | None = None
    ahead: Array | None = None
    records: Mapping[str, Any] = {}
    K: Array | None = None
    A: Array | None = None

    def time_integral(self, h: float) -> Array:
        """Return int_t^{t+h} (W(s) - W(t)) ds = h (H + dW/2), shape (l, P)."""
        if self.H is None:
            raise _not_drawn("H")
        return np.asarray(h * (self.H + 0.5 * self.dW))

    def uniform(self, h: float) -> Array:
        """Return Phi(sqrt(12/h) H), shape (l, P): uniform variables independent of dW, a function of H."""
        if self.H is None:
            raise _not_drawn("H")
        return np.asarray(scipy.special.ndtr(np.sqrt(12.0 / h) * self.H))

    def double_integrals(self, h: float) -> Array:
        """Return Ito's double integrals, shape (l, l, P): entry [i, j] is int_t^{t+h} (W_i(s) - W_i(t)) dW_j(s).

        They equal (dW_i dW_j - h delta_ij)/2 + A_ij with the areas
        A_ij = (1/2) (int (W_i - W_i(t)) dW_j - int (W_j - W_j(t)) dW_i). A single Brownian motion needs no area.
        """
        l = len(self.dW)
        if self.A is None and l > 1:
            raise _not_drawn("A")
        symmetric: Array = 0.5 * (self.dW[:, None] * self.dW - h * np.eye(l)[..., None])
        return symmetric if self.A is None else symmetric + antisymmetric(self.A, l)


def _not_drawn(name: str) -> SchemeError:
    drawn = ", ".join(repr(each) for each in BROWNIAN if each in USUAL | {name})
    return SchemeError(
        f"{name} is not drawn for this problem, which needs noise=frozenset({{{drawn}}}) for it; a scheme that uses "
        f"{name} declares noise = frozenset({{'dW', {name!r}}})"
    )


class LevelNoise(NamedTuple):
    """Noise of successive steps of one level.

    Attributes
    ----------
    dW : ndarray, shape (steps, l, P)
    H : ndarray, shape (steps, l, P), or None
    records : mapping of str to object
        Data of each `NoiseRecord`, arrays of shape (steps, ..., P).
    K : ndarray, shape (steps, l, P), or None
    A : ndarray, shape (steps, l (l - 1)/2, P), or None
    """

    dW: Array
    H: Array | None
    records: Mapping[str, Any] = {}
    K: Array | None = None
    A: Array | None = None

    def increment(self, step: int) -> Increment:
        """Return the increment of the step with a given index."""
        H, K, A = (None if part is None else part[step] for part in (self.H, self.K, self.A))
        records = each(lambda part: part[step], self.records) if self.records else self.records
        return Increment(self.dW[step], H, records=records, K=K, A=A)

    def part(self, begin: int, end: int) -> "LevelNoise":
        """Return the steps from index `begin` up to, but without, index `end`."""
        some: LevelNoise = each(lambda part: part[begin:end], self)
        return some

    def first_paths(self, paths: int | None) -> "LevelNoise":
        """Return the same noise with the records restricted to the first `paths` paths."""
        return self._replace(records=each(lambda part: part[..., :paths], self.records))

    def halved(self, h: float, xi: Array) -> "LevelNoise":
        """Halve every step of length h, conditionally on its dW and, if given, its H and K.

        With D = dW_1 - dW_2 and S = H_1 + H_2, E = H_1 - H_2 of the two halves,

            D = 3 H + (sqrt(h)/2) xi_1,   S = 2 H - D/2,   E = sqrt(h/12) xi_2;   without H:   D = sqrt(h) xi_1;

        and with K, for T = K_1 + K_2, U = K_1 - K_2,

            E = (15/2) K + sqrt(h/192) xi_2,   T = 4 K - E/2,   U = sqrt(h/720) xi_3.

        Parameters
        ----------
        h : float
            Length of the steps to halve, unit time.
        xi : ndarray, shape (k, n, l, P)
            Independent standard normals for the n steps, one row for each given one of dW, H and K.

        Returns
        -------
        LevelNoise
            Arrays of shape (2 n, l, P).
        """
        if self.H is None:
            return LevelNoise(_halves(self.dW, np.sqrt(h) * xi[0]), None)
        D = 3.0 * self.H + (0.5 * np.sqrt(h)) * xi[0]
        S = 2.0 * self.H - 0.5 * D
        if self.K is None:
            E = np.sqrt(h / 12) * xi[1]
            return LevelNoise(_halves(self.dW, D), _halves(S, E))
        E = 7.5 * self.K + np.sqrt(h / 192) * xi[1]
        K = _halves(4.0 * self.K - 0.5 * E, np.sqrt(h / 720) * xi[2])
        return LevelNoise(_halves(self.dW, D), _halves(S, E), K=K)


class Source(NamedTuple):
    """Address of a block's random numbers.

    Attributes
    ----------
    seed : int
    problem : str
        Label of the problem; schemes are not part of the address, so that all of them share their noise.
    block : int
        Index of the block of paths.
    paths : int
        Number of paths of a full block; all are drawn, so that no path depends on the number of used paths.
    used : int or None
        Number of used paths; all of them if None.
    """

    seed: int
    problem: str
    block: int
    paths: int
    used: int | None = None

    def stream(self, purpose: str, level: int) -> np.random.Generator:
        """Return the generator at address (seed, problem, purpose, level, block).

        The Philox key is a hash of the first three; level and block are the high words of the counter,
        and its low words count the numbers drawn.
        """
        digest = hashlib.blake2b(f"{self.seed}|{self.problem}|{purpose}".encode(), digest_size=16).digest()
        key = np.frombuffer(digest, dtype="<u8").astype(np.uint64)
        counter = np.array([0, 0, level, self.block], dtype=np.uint64)
        return np.random.Generator(np.random.Philox(key=key, counter=counter))


class Brownian(NamedTuple):
    """Brownian motions of one block of paths.

    Attributes
    ----------
    source : Source
    dimension : int
        Number l of Brownian motions.
    h : float
        Length of the coarsest step, unit time.
    finest : int
        Index of the finest level; level j has 2^j steps in each coarsest step.
    fields : frozenset of str
        Kinds of noise to draw: ``dW``, dW and H, or dW, H and K, which are three ways of drawing that give different
        paths; and ``A``, which leaves the others unchanged and requires H.
    records : tuple of NoiseRecord
        Other noise, each record with its own random streams.
    """

    source: Source
    dimension: int
    h: float
    finest: int
    fields: frozenset[str] = USUAL
    records: tuple[NoiseRecord, ...] = ()

    def pieces(self) -> Iterator[Iterator[tuple[int, LevelNoise]]]:
        """Yield, for each coarsest step in turn, an iterator over its pieces at all levels: the level, and its noise.

        The pieces of each level come in time order, a coarse one before the finer ones inside it, and each is at most
        `LONGEST` steps long. So memory does not depend on the finest level, unless areas are drawn, which need all
        pieces of a coarsest step at once. The pieces of a coarsest step must be consumed before the next iterator is
        requested.
        """
        purposes = ("brownian", *(record.name for record in self.records))
        streams = [{name: self.source.stream(name, n) for name in purposes} for n in range(self.finest + 1)]
        rest = self.source.stream("areas", self.finest)
        while True:
            xi = self._normals(streams[0]["brownian"], 1)
            named = (np.sqrt(self.h / PARTS[name]) * each for name, each in zip(PARTS, xi, strict=False))
            first = LevelNoise(**{"H": None, **dict(zip(PARTS, named, strict=False))})
            records = {r.name: r.begin(streams[0][r.name], self.h, self.source.paths) for r in self.records}
            descent = self._descend(0, _freeze(first._replace(records=records)), streams)
            yield self._with_areas(descent, rest) if "A" in self.fields else descent

    def follow(
        self, steps: int, advance: Callable[[int, LevelNoise], None], note: Callable[[], None] | None = None
    ) -> None:
        """Pass the noise to `advance` piece by piece, level by level: the loop over time of all simulations.

        Parameters
        ----------
        steps : int
            Number of coarsest steps.
        advance : callable, (int, LevelNoise) -> None
            Makes the steps of a piece of noise of a level.
        note : callable, optional
            Called without arguments at the end of each coarsest step.
        """
        for _, pieces in zip(range(steps), self.pieces(), strict=False):
            for level, noise in pieces:
                advance(level, noise)
            if note is not None:
                note()

    def steps(self) -> Iterator[tuple[LevelNoise, ...]]:
        """Yield the noise of each coarsest step in turn, one array per level.

        For studies of a few steps, since all levels of a coarsest step are held in memory; see `pieces`.
        """
        for pieces in self.pieces():
            yield _levels(pieces, self.finest)

    def _descend(
        self, level: int, noise: LevelNoise, streams: Sequence[Mapping[str, np.random.Generator]]
    ) -> Iterator[tuple[int, LevelNoise]]:
        # Records are refined on all paths of a full block; only the used paths are yielded.
        yield level, noise.first_paths(self.source.used) if self.records else noise
        if level == self.finest:
            return
        finer, h = streams[level + 1], self.h / 2**level
        for begin in range(0, len(noise.dW), LONGEST // 2):
            coarse = noise.part(begin, begin + LONGEST // 2)
            fine = coarse.halved(h, self._normals(finer["brownian"], len(coarse.dW)))
            records = {r.name: r.refined(coarse.records[r.name], h, finer[r.name]) for r in self.records}
            yield from self._descend(level + 1, _freeze(fine._replace(records=records)), streams)

    def _with_areas(
        self, descent: Iterator[tuple[int, LevelNoise]], rest: np.random.Generator
    ) -> Iterator[tuple[int, LevelNoise]]:
        pieces = list(descent)
        levels = _levels(pieces, self.finest)
        areas = [self._finest_areas(levels[-1], rest)]
        for fine in reversed(levels[1:]):
            areas.insert(0, join_areas(areas[0], fine.dW))
        done = [0] * len(levels)
        for level, noise in pieces:
            begin, done[level] = done[level], done[level] + len(noise.dW)
            yield level, _freeze(noise._replace(A=areas[level][begin : done[level]]))

    def _finest_areas(self, noise: LevelNoise, rest: np.random.Generator) -> Array:
        def normals(rows: int) -> Array:
            return rest.standard_normal((len(noise.dW), rows, self.source.paths))[..., : self.source.used]

        return draw_areas(noise, self.h / 2**self.finest, normals)

    def _normals(self, stream: np.random.Generator, steps: int) -> Array:
        # Drawn in time order, so that pieces of any length contain the same numbers.
        fields = 1 + len(self.fields & {"H", "K"})
        xi = stream.standard_normal((steps, fields, self.dimension, self.source.paths))
        return np.moveaxis(xi[..., : self.source.used], 1, 0)


def _levels(pieces: Iterable[tuple[int, LevelNoise]], finest: int) -> tuple[LevelNoise, ...]:
    """Return the noise of a coarsest step, one array per level."""
    levels: list[list[LevelNoise]] = [[] for _ in range(finest + 1)]
    for level, noise in pieces:
        levels[level].append(noise)
    return tuple(_freeze(join_batches(level)) for level in levels)


def complete(noise: Increment, h: Array | float, fields: frozenset[str], rng: np.random.Generator) -> Increment:
    """Return an increment of dW and H completed by random K and A, if these are among `fields`.

    Parameters
    ----------
    noise : Increment
        Has dW and H, shape (l, P).
    h : ndarray or float
        Length of the step; an array if it differs by path.
    fields : frozenset of str
        Kinds of noise of the result, of "dW", "H", "K", "A".
    rng : numpy.random.Generator
        Draws the missing ones.
    """
    K = np.sqrt(h / PARTS["K"]) * rng.standard_normal(noise.dW.shape) if "K" in fields else None
    if "A" not in fields:
        return noise._replace(K=K)
    drawn = LevelNoise(noise.dW, noise.H, K=K)
    return noise._replace(K=K, A=draw_areas(drawn, h, lambda rows: rng.standard_normal((rows, noise.dW.shape[-1]))))


def draw_areas(noise: LevelNoise, h: Array | float, normals: Callable[[int], Array]) -> Array:
    """Draw areas given the other noise of steps of length h.

    Parameters
    ----------
    noise : LevelNoise
        dW and H, and K if it is known; otherwise K is drawn.
    h : ndarray or float
        Length of the steps.
    normals : callable, rows -> ndarray of shape (..., rows, P)
        Draws `rows` independent standard normals for each step and path.
    """
    l = noise.dW.shape[-2]
    if noise.H is None:
        raise SchemeError("areas are drawn conditionally on dW and H, and H is not drawn")
    K = np.sqrt(h / PARTS["K"]) * normals(l) if noise.K is None else noise.K
    areas: Array = known_part(noise.dW, noise.H, K) + np.sqrt(REST) * h * normals(l * (l - 1) // 2)
    return areas


def fingerprint(seed: int) -> str:
    """Return a hash of the first raw words and normals of a seed, equal for builds that draw the same numbers."""
    source = Source(seed, "fingerprint", 0, 1)
    words = source.stream("words", 0).bit_generator.random_raw(16)
    normals = source.stream("normals", 0).standard_normal(16)
    return hashlib.blake2b(np.asarray(words).tobytes() + normals.tobytes(), digest_size=8).hexdigest()


def _halves(total: Array, difference: Array) -> Array:
    fine = np.empty((2 * total.shape[0], *total.shape[1:]))
    np.add(total, difference, out=fine[0::2])
    np.subtract(total, difference, out=fine[1::2])
    fine *= 0.5
    return fine


def _freeze(noise: LevelNoise) -> LevelNoise:
    # A scheme that writes into its noise would change the noise of the next scheme; read-only arrays raise an error
    # instead.
    for part in arrays(noise):
        part.flags.writeable = False
    return noise
