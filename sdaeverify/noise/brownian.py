"""Brownian noise by address: the increments of a path depend on (seed, problem, block, level) alone.

A path is drawn coarse and refined by bridging. Over a step of length h it is known through two
independent numbers a component,

    dW = W(t+h) - W(t)                                   variance h
    H  = (1/h) int_t^{t+h} (W(s) - W(t)) ds - dW/2       variance h/12   (space-time Levy area)

Refining a step keeps both of them, so a finer level leaves every coarser one as it was, to the last bit. Where it is
asked for there is a third one, drawn and refined like them, whose paths are then others,

    K  = (1/h^2) int_t^{t+h} (W(s) - W(t) - (s - t) dW/h) (t + h/2 - s) ds        variance h/720   (second area)

and the Levy areas A between components (`areas`), which change nothing of dW, H and K. They are put together from the
finest level: with another finest level they are others, as the law allows where the rest of the path is as it is.
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

# Steps of a level that are held at a time.
LONGEST = 16
# Of a step's length, the variances of dW, H and K are these parts.
PARTS = {"dW": 1, "H": 12, "K": 720}
# What can be drawn: increments, space-time Levy areas, and Levy areas between components; and what usually is.
BROWNIAN = ("dW", "H", "K", "A")
USUAL = frozenset({"dW", "H"})


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
    K : ndarray, shape (l, P), or None
        Second space-time Levy areas, unit sqrt(time), where the problem has them drawn.
    A : ndarray, shape (l (l - 1)/2, P), or None
        Levy areas A_ij of the pairs (0, 1), (0, 2), ..., (1, 2), ..., unit time, where the problem has them drawn;
        see `double_integrals`.

    Notes
    -----
    A scheme declares what it needs beside dW: ``noise = frozenset({"dW", "H"})``. Given h, dW and H are independent
    normals of variances h and h/12: ``dW/sqrt(h)`` and ``sqrt(12/h) H`` are two independent standard normals a step
    for each Brownian motion.
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
        """Return Phi(sqrt(12/h) H), shape (l, P): uniform variables that are independent of dW, in place of H."""
        if self.H is None:
            raise _not_drawn("H")
        return np.asarray(scipy.special.ndtr(np.sqrt(12.0 / h) * self.H))

    def double_integrals(self, h: float) -> Array:
        """Return Ito's double integrals, shape (l, l, P): entry [i, j] is int_t^{t+h} (W_i(s) - W_i(t)) dW_j(s).

        It is (dW_i dW_j - h delta_ij)/2 + A_ij, where 2 A_ij is int (W_i - W_i(t)) dW_j - int (W_j - W_j(t)) dW_i. Of
        one Brownian motion there is no area.
        """
        l = len(self.dW)
        if self.A is None and l > 1:
            raise _not_drawn("A")
        symmetric: Array = 0.5 * (self.dW[:, None] * self.dW - h * np.eye(l)[..., None])
        return symmetric if self.A is None else symmetric + antisymmetric(self.A, l)


def _not_drawn(name: str) -> SchemeError:
    drawn = ", ".join(repr(each) for each in BROWNIAN if each in USUAL | {name})
    return SchemeError(
        f"{name} is not drawn for this problem, which draws it with noise=frozenset({{{drawn}}}); a scheme that uses "
        f"it declares noise = frozenset({{'dW', {name!r}}})"
    )


class LevelNoise(NamedTuple):
    """Increments of successive steps of one level.

    Attributes
    ----------
    dW : ndarray, shape (steps, l, P)
    H : ndarray, shape (steps, l, P), or None
    records : mapping of str to object
        Arrays of the shape (steps, ..., P) of each `NoiseRecord`.
    K : ndarray, shape (steps, l, P), or None
    A : ndarray, shape (steps, l (l - 1)/2, P), or None
    """

    dW: Array
    H: Array | None
    records: Mapping[str, Any] = {}
    K: Array | None = None
    A: Array | None = None

    def increment(self, step: int) -> Increment:
        """Return the increment of one step."""
        H, K, A = (None if part is None else part[step] for part in (self.H, self.K, self.A))
        records = each(lambda part: part[step], self.records) if self.records else self.records
        return Increment(self.dW[step], H, records=records, K=K, A=A)

    def part(self, begin: int, end: int) -> "LevelNoise":
        """Return the steps from `begin` up to `end`."""
        some: LevelNoise = each(lambda part: part[begin:end], self)
        return some

    def first_paths(self, paths: int | None) -> "LevelNoise":
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
    fields : frozenset of str
        What is drawn: ``dW``, with H or with H and K beside it, which are three ways of drawing that give different
        paths; and ``A``, which changes nothing of them, where H is drawn.
    records : tuple of NoiseRecord
        Further noise, each with streams of its own.
    """

    source: Source
    dimension: int
    h: float
    finest: int
    fields: frozenset[str] = USUAL
    records: tuple[NoiseRecord, ...] = ()

    def pieces(self) -> Iterator[Iterator[Piece]]:
        """Yield, for one coarsest step after the other, its pieces at all levels.

        Each level's pieces come in time order, a coarse one before the finer ones inside it, and each is at most
        `LONGEST` steps long: memory does not depend on how fine the finest level is, unless areas are asked for,
        which need a coarsest step as a whole. The pieces of a coarsest step must be used up before the next one is
        asked for.
        """
        purposes = ("brownian", *(record.name for record in self.records))
        streams = [{name: self.source.stream(name, n) for name in purposes} for n in range(self.finest + 1)]
        rest = self.source.stream("areas", self.finest)
        while True:
            xi = self._normals(streams[0]["brownian"], 1)
            named = (np.sqrt(self.h / PARTS[name]) * each for name, each in zip(PARTS, xi, strict=False))
            first = LevelNoise(**{"H": None, **dict(zip(PARTS, named, strict=False))})
            records = {r.name: r.begin(streams[0][r.name], self.h, self.source.paths) for r in self.records}
            descent = self._descend(Piece(0, _freeze(first._replace(records=records))), streams)
            yield self._with_areas(descent, rest) if "A" in self.fields else descent

    def _descend(self, piece: Piece, streams: Sequence[Mapping[str, np.random.Generator]]) -> Iterator[Piece]:
        # Records are refined as they are drawn, on all paths of a full block; those that are used are shown.
        yield Piece(piece.level, piece.noise.first_paths(self.source.used)) if self.records else piece
        level, steps = piece.level + 1, len(piece.noise.dW)
        if level > self.finest:
            return
        for begin in range(0, steps, LONGEST // 2):
            coarse, h = piece.noise.part(begin, begin + LONGEST // 2), self.h / 2**piece.level
            fine = refine(coarse, h, self._normals(streams[level]["brownian"], len(coarse.dW)))
            records = {r.name: r.refined(coarse.records[r.name], h, streams[level][r.name]) for r in self.records}
            yield from self._descend(Piece(level, _freeze(fine._replace(records=records))), streams)

    def _with_areas(self, descent: Iterator[Piece], rest: np.random.Generator) -> Iterator[Piece]:
        pieces = list(descent)
        levels = _levels(pieces, self.finest)
        areas = [self._finest_areas(levels[-1], rest)]
        for fine in reversed(levels[1:]):
            areas.insert(0, join_areas(areas[0], fine.dW))
        done = [0] * len(levels)
        for piece in pieces:
            level, begin, noise = piece.level, done[piece.level], piece.noise
            done[level] = begin + len(noise.dW)
            yield Piece(level, _freeze(noise._replace(A=areas[level][begin : done[level]])))

    def _finest_areas(self, noise: LevelNoise, rest: np.random.Generator) -> Array:
        def normals(rows: int) -> Array:
            return rest.standard_normal((len(noise.dW), rows, self.source.paths))[..., : self.source.used]

        return draw_areas(noise, self.h / 2**self.finest, normals)

    def _normals(self, stream: np.random.Generator, steps: int) -> Array:
        # Drawn in time order, so that pieces of any length give the same numbers.
        fields = 1 + len(self.fields & {"H", "K"})
        xi = stream.standard_normal((steps, fields, self.dimension, self.source.paths))
        return np.moveaxis(xi[..., : self.source.used], 1, 0)


def brownian_steps(
    source: Source,
    dimension: int,
    h: float,
    finest: int,
    fields: frozenset[str] = USUAL,
    records: tuple[NoiseRecord, ...] = (),
) -> Iterator[tuple[LevelNoise, ...]]:
    """Yield the noise of one coarsest step after the other, each level in one array.

    For studies of a few steps, whose memory does not matter; see `Brownian` for the parameters.

    Parameters
    ----------
    source : Source
        Seed, name and paths.
    dimension : int
        Number l of Brownian motions.
    h : float
        Coarsest step size.
    finest : int
        Finest level: its steps are h/2^finest long.
    fields : frozenset of str
        What is drawn, of "dW", "H", "K", "A".
    records : tuple of NoiseRecord
        What is drawn beside the Brownian motions, such as jumps.
    """
    for pieces in Brownian(source, dimension, h, finest, fields, records).pieces():
        yield _levels(pieces, finest)


def _levels(pieces: Iterable[Piece], finest: int) -> tuple[LevelNoise, ...]:
    """Return the noise of a coarsest step, each level in one array."""
    levels: list[list[LevelNoise]] = [[] for _ in range(finest + 1)]
    for piece in pieces:
        levels[piece.level].append(piece.noise)
    return tuple(_freeze(join_batches(level)) for level in levels)


def complete(noise: Increment, h: Array | float, fields: frozenset[str], rng: np.random.Generator) -> Increment:
    """Return an increment of dW and H with K and A beside them, drawn as far as they are among the fields.

    Parameters
    ----------
    noise : Increment
        With dW and H, shape (l, P).
    h : ndarray or float
        Length of the step; an array where it differs by path.
    fields : frozenset of str
        What the increment is to hold, of "dW", "H", "K", "A".
    rng : numpy.random.Generator
        Draws what is missing.
    """
    K = np.sqrt(h / PARTS["K"]) * rng.standard_normal(noise.dW.shape) if "K" in fields else None
    if "A" not in fields:
        return noise._replace(K=K)
    drawn = LevelNoise(noise.dW, noise.H, K=K)
    return noise._replace(K=K, A=draw_areas(drawn, h, lambda rows: rng.standard_normal((rows, noise.dW.shape[-1]))))


def draw_areas(noise: LevelNoise, h: Array | float, normals: Callable[[int], Array]) -> Array:
    """Draw areas given the rest of the noise of steps of length h; normals(rows) are so many a step and path.

    Parameters
    ----------
    noise : LevelNoise
        dW and H, and K where it is known.
    h : ndarray or float
        Length of the steps.
    normals : callable, rows -> ndarray of shape (..., rows, P)
        Draws independent standard normals.
    """
    l = noise.dW.shape[-2]
    if noise.H is None:
        raise SchemeError("areas are drawn around what dW and H tell of them, and H is not drawn")
    K = np.sqrt(h / PARTS["K"]) * normals(l) if noise.K is None else noise.K
    areas: Array = known_part(noise.dW, noise.H, K) + np.sqrt(REST) * h * normals(l * (l - 1) // 2)
    return areas


def refine(coarse: LevelNoise, h: float, xi: Array) -> LevelNoise:
    """Halve every step of length h, given its dW and, if there is one, its H.

    With D = dW_1 - dW_2 and S = H_1 + H_2, E = H_1 - H_2 of the two halves,

        D = 3 H + (sqrt(h)/2) xi_1,   S = 2 H - D/2,   E = sqrt(h/12) xi_2;   without H:   D = sqrt(h) xi_1;

    and where there is K, with T = K_1 + K_2, U = K_1 - K_2,

        E = (15/2) K + sqrt(h/192) xi_2,   T = 4 K - E/2,   U = sqrt(h/720) xi_3.

    Parameters
    ----------
    coarse : LevelNoise
        Arrays of shape (n, l, P).
    h : float
        Length of the steps that are halved, unit time.
    xi : ndarray, shape (k, n, l, P)
        Independent standard normals: one for each of dW, H and K that there is.

    Returns
    -------
    LevelNoise
        Arrays of shape (2 n, l, P).
    """
    if coarse.H is None:
        return LevelNoise(_halves(coarse.dW, np.sqrt(h) * xi[0]), None)
    D = 3.0 * coarse.H + (0.5 * np.sqrt(h)) * xi[0]
    S = 2.0 * coarse.H - 0.5 * D
    if coarse.K is None:
        E = np.sqrt(h / 12) * xi[1]
        return LevelNoise(_halves(coarse.dW, D), _halves(S, E))
    E = 7.5 * coarse.K + np.sqrt(h / 192) * xi[1]
    K = _halves(4.0 * coarse.K - 0.5 * E, np.sqrt(h / 720) * xi[2])
    return LevelNoise(_halves(coarse.dW, D), _halves(S, E), K=K)


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


def _freeze(noise: LevelNoise) -> LevelNoise:
    # A scheme that writes into its noise would change what the next scheme sees: let it fail instead.
    for part in arrays(noise):
        part.flags.writeable = False
    return noise
