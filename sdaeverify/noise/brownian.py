"""Brownian noise by address: the increments of a path depend on (seed, problem, block, level) alone.

A path is drawn coarse and refined by bridging. Over a step of length h it is known through two
independent numbers a component,

    dW = W(t+h) - W(t)                                   variance h
    H  = (1/h) int_t^{t+h} (W(s) - W(t)) ds - dW/2       variance h/12   (space-time Levy area)

Refining a step keeps both of them, so a finer level leaves every coarser one as it was, to the last bit.
"""

import hashlib
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import scipy

from ..arrays import Array, arrays, each
from ..errors import SchemeError
from .records import NoiseRecord

# Steps of a level that are held at a time.
LONGEST = 16


class Increment(NamedTuple):
    """What drives one step: l Brownian motions on P paths and, where the problem has a delay, its past.

    Attributes
    ----------
    dW : ndarray, shape (l, P)
        Brownian increments, unit sqrt(time).
    H : ndarray, shape (l, P), or None
        Space-time Levy areas, unit sqrt(time), where the problem has them drawn.
    xi : ndarray, shape (k, P), or None
        Independent standard normals for a truth that needs functionals of W beyond dW and H.
    lagged, ahead : ndarray, shape (d, P), or None
        The state at the lag of the step's begin, and what is known of it at the lag of its end; see `Lag`.
    records : mapping of str to object
        What a form declares of noise beside Brownian motions, see `NoiseRecord`.
    """

    dW: Array
    H: Array | None
    xi: Array | None = None
    lagged: Array | None = None
    ahead: Array | None = None
    records: Mapping[str, Any] = {}

    def time_integral(self, h: float) -> Array:
        """Return int_t^{t+h} (W(s) - W(t)) ds = h (H + dW/2), shape (l, P)."""
        if self.H is None:
            raise SchemeError("H is not drawn for this problem; a scheme that uses it declares noise dW and H")
        return np.asarray(h * (self.H + 0.5 * self.dW))

    def uniform(self, h: float) -> Array:
        """Return Phi(sqrt(12/h) H), shape (l, P): uniform variables that are independent of dW, in place of H."""
        if self.H is None:
            raise SchemeError("H is not drawn for this problem; a scheme that uses it declares noise dW and H")
        return np.asarray(scipy.special.ndtr(np.sqrt(12.0 / h) * self.H))


class LevelNoise(NamedTuple):
    """Increments of successive steps of one level.

    Attributes
    ----------
    dW : ndarray, shape (steps, l, P)
    H : ndarray, shape (steps, l, P), or None
    records : mapping of str to object
        Arrays of the shape (steps, ..., P) of each `NoiseRecord`.
    """

    dW: Array
    H: Array | None
    records: Mapping[str, Any] = {}

    def increment(self, step: int) -> Increment:
        """Return the increment of one step."""
        records = each(lambda part: part[step], self.records)
        return Increment(self.dW[step], None if self.H is None else self.H[step], records=records)

    def part(self, begin: int, end: int) -> "LevelNoise":
        """Return the steps from `begin` up to `end`."""
        some: LevelNoise = each(lambda part: part[begin:end], self)
        return some

    def used(self, paths: int | None) -> "LevelNoise":
        """Return the same with the first so many paths of the records."""
        return self._replace(records=each(lambda part: part[..., :paths], self.records))


class Piece(NamedTuple):
    """A few successive steps of one level.

    Attributes
    ----------
    level : int
    noise : LevelNoise
        At most `LONGEST` steps.
    """

    level: int
    noise: LevelNoise


class Source(NamedTuple):
    """Where a block's numbers come from.

    Attributes
    ----------
    seed : int
    problem : str
        Label of the problem: schemes do not enter, so that all of them share their noise.
    block : int
        Index of the block of paths.
    paths : int
        Number of paths of a full block: all are drawn, so that no path depends on how many are used.
    used : int or None
        Number of paths that are used; all of them if None.
    """

    seed: int
    problem: str
    block: int
    paths: int
    used: int | None = None

    def stream(self, purpose: str, level: int) -> np.random.Generator:
        """Return the generator at address (seed, problem, purpose, level, block).

        The Philox key is a hash of the first three; level and block are the high words of the counter,
        whose low words count the numbers drawn.
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
        Index of the finest level; level j has 2^j steps inside a coarsest one.
    areas : bool
        Whether H is drawn beside dW. The two ways of drawing give different paths.
    records : tuple of NoiseRecord
        Further noise, each with streams of its own.
    """

    source: Source
    dimension: int
    h: float
    finest: int
    areas: bool = True
    records: tuple[NoiseRecord, ...] = ()

    def pieces(self) -> Iterator[Iterator[Piece]]:
        """Yield, for one coarsest step after the other, its pieces at all levels.

        Each level's pieces come in time order, a coarse one before the finer ones inside it, and each is at most
        `LONGEST` steps long: memory does not depend on how fine the finest level is. The pieces of a coarsest step
        must be used up before the next one is asked for.
        """
        purposes = ("brownian", *(record.name for record in self.records))
        streams = [{name: self.source.stream(name, n) for name in purposes} for n in range(self.finest + 1)]
        while True:
            xi = self._normals(streams[0]["brownian"], 1)
            H = np.sqrt(self.h / 12) * xi[1] if self.areas else None
            records = {r.name: r.begin(streams[0][r.name], self.h, self.source.paths) for r in self.records}
            yield self._descend(Piece(0, _frozen(LevelNoise(np.sqrt(self.h) * xi[0], H, records))), streams)

    def _descend(self, piece: Piece, streams: Sequence[Mapping[str, np.random.Generator]]) -> Iterator[Piece]:
        # Records are refined as they are drawn, on all paths of a full block; those that are used are shown.
        yield Piece(piece.level, piece.noise.used(self.source.used)) if self.records else piece
        level, steps = piece.level + 1, len(piece.noise.dW)
        if level > self.finest:
            return
        for begin in range(0, steps, LONGEST // 2):
            coarse, h = piece.noise.part(begin, begin + LONGEST // 2), self.h / 2**piece.level
            fine = refine(coarse, h, self._normals(streams[level]["brownian"], len(coarse.dW)))
            records = {r.name: r.refined(coarse.records[r.name], h, streams[level][r.name]) for r in self.records}
            yield from self._descend(Piece(level, _frozen(fine._replace(records=records))), streams)

    def _normals(self, stream: np.random.Generator, steps: int) -> Array:
        # Drawn in time order, so that pieces of any length give the same numbers.
        xi = stream.standard_normal((steps, 2 if self.areas else 1, self.dimension, self.source.paths))
        return np.moveaxis(xi[..., : self.source.used], 1, 0)


def brownian_steps(source: Source, dimension: int, h: float, finest: int) -> Iterator[tuple[LevelNoise, ...]]:
    """Yield the noise of one coarsest step after the other, each level in one array.

    For studies of a few steps, whose memory does not matter; see `Brownian` for the parameters.
    """
    for pieces in Brownian(source, dimension, h, finest).pieces():
        levels: list[list[LevelNoise]] = [[] for _ in range(finest + 1)]
        for piece in pieces:
            levels[piece.level].append(piece.noise)
        yield tuple(_frozen(_concatenated(level)) for level in levels)


def refine(coarse: LevelNoise, h: float, xi: Array) -> LevelNoise:
    """Halve every step of length h, given its dW and, if there is one, its H.

    With D = dW_1 - dW_2 and S = H_1 + H_2, E = H_1 - H_2 of the two halves,

        D = 3 H + (sqrt(h)/2) xi_1,   S = 2 H - D/2,   E = sqrt(h/12) xi_2;   without H:   D = sqrt(h) xi_1.

    Parameters
    ----------
    coarse : LevelNoise
        Arrays of shape (n, l, P).
    h : float
        Length of the steps that are halved, unit time.
    xi : ndarray, shape (2, n, l, P), or (1, n, l, P) without H
        Independent standard normals.

    Returns
    -------
    LevelNoise
        Arrays of shape (2 n, l, P).
    """
    if coarse.H is None:
        return LevelNoise(_halves(coarse.dW, np.sqrt(h) * xi[0]), None)
    D = 3.0 * coarse.H + (0.5 * np.sqrt(h)) * xi[0]
    S = 2.0 * coarse.H - 0.5 * D
    E = np.sqrt(h / 12) * xi[1]
    return LevelNoise(_halves(coarse.dW, D), _halves(S, E))


def aggregate(fine: LevelNoise) -> LevelNoise:
    """Join neighbouring steps, the inverse of `refine`.

    dW = dW_1 + dW_2,   H = (H_1 + H_2)/2 + (dW_1 - dW_2)/4.

    Parameters
    ----------
    fine : LevelNoise
        Arrays of shape (2 n, l, P).

    Returns
    -------
    LevelNoise
        Arrays of shape (n, l, P).
    """
    W1, W2 = fine.dW[0::2], fine.dW[1::2]
    if fine.H is None:
        return LevelNoise(W1 + W2, None)
    return LevelNoise(W1 + W2, 0.5 * (fine.H[0::2] + fine.H[1::2]) + 0.25 * (W1 - W2))


def fingerprint(seed: int) -> str:
    """Return a hash of the first raw words and normals of a seed, to tell whether two builds draw alike."""
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


def _concatenated(pieces: Sequence[LevelNoise]) -> LevelNoise:
    areas = [piece.H for piece in pieces if piece.H is not None]
    return LevelNoise(np.concatenate([piece.dW for piece in pieces]), np.concatenate(areas) if areas else None)


def _frozen(noise: LevelNoise) -> LevelNoise:
    # A scheme that writes into its noise would change what the next scheme sees: let it fail instead.
    for part in arrays(noise):
        part.flags.writeable = False
    return noise
