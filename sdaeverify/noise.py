"""Brownian noise by address: the increments of a path depend on (seed, problem, block, level) alone.

A path is drawn coarse and refined by bridging. Over a step of length h it is known through two
independent numbers a component,

    dW = W(t+h) - W(t)                                   variance h
    H  = (1/h) int_t^{t+h} (W(s) - W(t)) ds - dW/2       variance h/12   (space-time Levy area)

Refining a step keeps both of them, so a finer level leaves every coarser one as it was, to the last bit.
"""

import hashlib
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from .arrays import Array


class Increment(NamedTuple):
    """The noise of one step for l Brownian motions on P paths.

    Attributes
    ----------
    dW : ndarray, shape (l, P)
        Brownian increments, unit sqrt(time).
    H : ndarray, shape (l, P)
        Space-time Levy areas, unit sqrt(time).
    xi : ndarray, shape (k, P), or None
        Independent standard normals for a truth that needs functionals of W beyond dW and H.
    """

    dW: Array
    H: Array
    xi: Array | None = None

    def time_integral(self, h: float) -> Array:
        """Return int_t^{t+h} (W(s) - W(t)) ds = h (H + dW/2), shape (l, P)."""
        return h * (self.H + 0.5 * self.dW)


class LevelNoise(NamedTuple):
    """All increments of one level inside one coarsest step.

    Attributes
    ----------
    dW, H : ndarray, shape (steps, l, P)
    """

    dW: Array
    H: Array

    def increment(self, step: int) -> Increment:
        """Return the increment of one step."""
        return Increment(self.dW[step], self.H[step])


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
        Number of paths of a full block.
    """

    seed: int
    problem: str
    block: int
    paths: int

    def stream(self, purpose: str, level: int) -> np.random.Generator:
        """Return the generator at address (seed, problem, purpose, level, block).

        The Philox key is a hash of the first three; level and block are the high words of the counter,
        whose low words count the numbers drawn.
        """
        digest = hashlib.blake2b(f"{self.seed}|{self.problem}|{purpose}".encode(), digest_size=16).digest()
        key = np.frombuffer(digest, dtype="<u8").astype(np.uint64)
        counter = np.array([0, 0, level, self.block], dtype=np.uint64)
        return np.random.Generator(np.random.Philox(key=key, counter=counter))


def brownian_steps(source: Source, dimension: int, h: float, finest: int) -> Iterator[tuple[LevelNoise, ...]]:
    """Yield the noise of one coarsest step after the other, at all levels.

    Parameters
    ----------
    source : Source
    dimension : int
        Number l of Brownian motions.
    h : float
        Length of the coarsest step, unit time.
    finest : int
        Index of the finest level; level j has 2^j steps inside a coarsest one.

    Yields
    ------
    tuple of LevelNoise
        Levels 0 to `finest`.
    """
    streams = [source.stream("brownian", level) for level in range(finest + 1)]
    shape = (2, 1, dimension, source.paths)
    while True:
        xi = streams[0].standard_normal(shape)
        levels = [_frozen(LevelNoise(np.sqrt(h) * xi[0], np.sqrt(h / 12) * xi[1]))]
        for level in range(1, finest + 1):
            xi = streams[level].standard_normal((2, 2 ** (level - 1), dimension, source.paths))
            levels.append(_frozen(refine(levels[-1], h / 2 ** (level - 1), xi)))
        yield tuple(levels)


def refine(coarse: LevelNoise, h: float, xi: Array) -> LevelNoise:
    """Halve every step of length h, given its dW and H.

    With D = dW_1 - dW_2 and S = H_1 + H_2, E = H_1 - H_2 of the two halves,

        D = 3 H + (sqrt(h)/2) xi_1,   S = 2 H - D/2,   E = sqrt(h/12) xi_2.

    Parameters
    ----------
    coarse : LevelNoise
        Arrays of shape (n, l, P).
    h : float
        Length of the steps that are halved, unit time.
    xi : ndarray, shape (2, n, l, P)
        Independent standard normals.

    Returns
    -------
    LevelNoise
        Arrays of shape (2 n, l, P).
    """
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
    W1, W2, H1, H2 = fine.dW[0::2], fine.dW[1::2], fine.H[0::2], fine.H[1::2]
    return LevelNoise(W1 + W2, 0.5 * (H1 + H2) + 0.25 * (W1 - W2))


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


def _frozen(noise: LevelNoise) -> LevelNoise:
    # A scheme that writes into its noise would change what the next scheme sees: let it fail instead.
    noise.dW.flags.writeable = False
    noise.H.flags.writeable = False
    return noise
