r"""The golden transcript: the bytes of a conversation, for tests of clients in new languages.

Its program is Euler's scheme under the name ``golden-euler``. All numbers are short binary fractions, so that answers
do not depend on rounding. On disk each message follows a line, ``> 40`` for 40 bytes to the program and ``< 40`` for
40 bytes from it.
"""

from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np

from sdaeverify import Array

from .connection import Connection
from .messages import encode

GOLDEN = Path(__file__).with_name("golden.transcript")
HELLO = "name golden-euler\nform SDE\nnoise dW\nasks drift diffusion\n"
LINE_END = b"\n"


class Message(NamedTuple):
    """A message of a transcript.

    Attributes
    ----------
    sent : bool
        Whether the message is sent to the program.
    content : bytes
    """

    sent: bool
    content: bytes


def golden_conversation() -> Iterator[Message]:
    """Yield the golden transcript: hello, and Euler steps with one, three and five paths and several motions."""
    version = encode("hello", {"version": np.array([1.0])})
    yield from (Message(True, version), Message(False, HELLO.encode() + version))
    for d, l, paths in ((1, 1, 1), (2, 1, 3), (3, 2, 5)):
        yield from _euler_step(d, l, paths)


def _euler_step(d: int, l: int, paths: int) -> Iterator[Message]:
    t, h, x, dW = np.array([0.5]), np.array([0.25]), fractions(d, paths), fractions(l, paths)
    f, B = -0.5 * x, fractions(d, l, paths)
    yield Message(True, encode("step", {"t": t, "h": h, "x": x, "dW": dW}))
    yield Message(False, encode("ask drift", {"t": t, "x": x}))
    yield Message(True, encode("give", {"drift": f}))
    yield Message(False, encode("ask diffusion", {"t": t, "x": x}))
    yield Message(True, encode("give", {"diffusion": B}))
    yield Message(False, encode("done", {"x": x + h * f + np.einsum("dlp,lp->dp", B, dW)}))


def fractions(*shape: int) -> Array:
    """Return multiples of 1/8 between -1 and 1, with different neighbours."""
    numbers = (5 * np.arange(np.prod(shape)) + len(shape)) % 17 - 8
    return (numbers / 8.0).reshape(shape)


def written(messages: Iterable[Message]) -> bytes:
    """Encode a transcript."""
    return b"".join(b"%s %d\n%s\n" % (b"<>"[sent : sent + 1], len(content), content) for sent, content in messages)


def read(content: bytes) -> list[Message]:
    """Decode the messages of a transcript."""
    messages = []
    while content:
        line, _, content = content.partition(LINE_END)
        size = int(line[2:])
        messages.append(Message(line.startswith(b">"), content[:size]))
        content = content[size + len(LINE_END) :]
    return messages


def replay(program: Connection, messages: Iterable[Message]) -> int:
    """Play a transcript to a program that was just started, and return the number of compared answers.

    Raises
    ------
    SchemeError
        If an answer differs from the transcript.
    """
    compared = 0
    for number, (sent, content) in enumerate(messages, start=1):
        if sent:
            program.send(content)
            continue
        found = program.content(len(content))
        if found != content:
            at = next(i for i, (one, other) in enumerate(zip(found, content, strict=True)) if one != other)
            told = f"{found[at : at + 24]!r}, expected {content[at : at + 24]!r}"
            raise program.failure(f"differs from message {number} of the transcript at byte {at}: {told}")
        compared += 1
    return compared
