r"""Messages of the wire: one line of ASCII that names the following arrays, then the arrays.

    step t=1 h=1 x=2x1024 dW=1x1024\n

A shape consists of its lengths separated by ``x``. Arrays follow in the order of the line without separators, in
little-endian float64, with the last axis, that of paths, varying fastest.
"""

import re
from collections.abc import Mapping
from functools import lru_cache
from math import prod
from typing import NamedTuple

import numpy as np

from sdaeverify import Array, SchemeError

VERSION = 1
# Largest length of a line in characters, and of an array in bytes.
LONGEST_LINE, LARGEST = 4096, 2**31
NUMBER = np.dtype("<f8")
FIELD = re.compile(r"([A-Za-z][A-Za-z0-9_.]*)=([0-9]{1,10}(?:x[0-9]{1,10}){0,3})")
Shape = tuple[int, ...]


class Line(NamedTuple):
    """The line of a message.

    Attributes
    ----------
    word : str
        Kind of the message: ``hello``, ``step``, ``ask``, ``give``, ``done`` or ``error``.
    about : str
        Requested coefficient, or text of an error; otherwise empty.
    shapes : mapping of str to tuple of int
        Shapes of the following arrays, in order.
    """

    word: str
    about: str = ""
    shapes: Mapping[str, Shape] = {}


def encode(words: str, arrays: Mapping[str, Array]) -> bytes:
    """Return a message as bytes.

    Parameters
    ----------
    words : str
        First words of the line.
    arrays : mapping of str to ndarray
    """
    fields = [f"{name}={shape_text(array.shape)}" for name, array in arrays.items()]
    line = " ".join([words, *fields]) + "\n"
    return b"".join([line.encode("ascii"), *(np.asarray(array, NUMBER).tobytes() for array in arrays.values())])


def shape_text(shape: Shape) -> str:
    """Return a shape as written in a line."""
    return "x".join(map(str, shape))


# A run has few different lines, each repeated many times.
@lru_cache(maxsize=256)
def read_line(text: str) -> Line:
    """Parse the line of a message.

    Raises
    ------
    SchemeError
        If it is malformed, or announces an array twice or more numbers than permitted.
    """
    word, _, rest = text.partition(" ")
    if word == "error":
        return Line(word, rest)
    about, _, rest = rest.partition(" ") if word == "ask" else ("", "", rest)
    shapes: dict[str, Shape] = {}
    for token in rest.split():
        match = FIELD.fullmatch(token)
        if match is None:
            raise SchemeError(f"sent {token!r:.80} in the line {text!r:.120}, expected name=shape such as x=2x1024")
        shape = tuple(map(int, match[2].split("x")))
        if match[1] in shapes:
            raise SchemeError(f"sent {match[1]} twice in the line {text!r:.120}")
        if NUMBER.itemsize * prod(shape) > LARGEST:
            raise SchemeError(f"announces {match[1]} of shape {match[2]}, more than {LARGEST} bytes")
        shapes[match[1]] = shape
    return Line(word, about, shapes)
