"""Random-access standard normal variables: a hash of an address replaces a sequential stream."""

import hashlib

import numpy as np
import scipy

from sdaeverify import Array
from sdaeverify.studying import Source

# SplitMix64, Steele, Lea & Flood 2014: the odd number next to 2^64 over the golden ratio, and the mixing function.
GOLDEN = np.uint64(0x9E3779B97F4A7C15)
FIRST, SECOND = np.uint64(0xBF58476D1CE4E5B9), np.uint64(0x94D049BB133111EB)
BITS = 53


def key_of(source: Source) -> int:
    """Return the key of a block of paths."""
    text = f"{source.seed}|{source.problem}|adaptive|{source.block}"
    return int.from_bytes(hashlib.blake2b(text.encode(), digest_size=8).digest(), "little")


def mixed(word: Array) -> Array:
    """Apply a bijection of 64-bit words in which each bit of the result depends on all bits of the word."""
    word = (word ^ (word >> np.uint64(30))) * FIRST
    word = (word ^ (word >> np.uint64(27))) * SECOND
    return np.asarray(word ^ (word >> np.uint64(31)))


def normals(key: int, node: Array, row: Array, shape: tuple[int, ...]) -> Array:
    """Return Phi^{-1}(u) for uniform numbers u that are the hash of (key, node, row, index in the shape).

    Parameters
    ----------
    key : int
        Key of the block.
    node, row : ndarray of int, shape (P,)
        Address of each path's numbers.
    shape : tuple of int
        Shape of the numbers at each address.

    Returns
    -------
    ndarray, shape (*shape, P)
    """
    word = np.array([key], dtype=np.uint64)
    for part in (node, row):
        word = mixed(word + (np.asarray(part).astype(np.uint64) + np.uint64(1)) * GOLDEN)
    place = np.arange(1, np.prod(shape) + 1, dtype=np.uint64).reshape(*shape, 1)
    bits = mixed(word + place * GOLDEN) >> np.uint64(64 - BITS)
    return np.asarray(scipy.special.ndtri((bits.astype(float) + 0.5) * 2.0**-BITS))
