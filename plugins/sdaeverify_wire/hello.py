"""The hello of a program: its name, forms, noise and claims."""

import re
from collections.abc import Callable
from contextlib import suppress
from typing import Any, NamedTuple

import numpy as np

from sdaeverify import GAUSSIAN, THREE_POINT, TWO_POINT, Claim, SchemeError

from .coefficients import FORMS
from .connection import Connection
from .messages import VERSION, encode

# Largest number of lines of a hello, beyond which the output is not a hello.
MOST_LINES = 200
CLAIM = re.compile(
    r"(?P<measure>\S+) (?P<value>.+?)(?: of (?P<quantities>\S+))?(?: when (?P<when>\S+))? source (?P<source>.+)"
)
MEMORY = re.compile(r"(?P<number>[1-9][0-9]{0,3})?(?P<letter>[a-z])?(?<=.)")
CLAIM_LINE = "claim MEASURE VALUE [of QUANTITY,...] [when TRAIT,...] source TEXT"


# Fields of an increment, in the order in which they are sent with a step.
FIELDS = ("dW", "H", "K", "A")
LAWS = {law.name: law for law in (GAUSSIAN, THREE_POINT, TWO_POINT)}
# Words after ``is``, with the class variable that each sets, and its value.
FLAGS = {
    "discontinuous-in-noise": ("discontinuous_in_noise", True),
    "corrected-later": ("local_order_is_global", False),
}


class Hello(NamedTuple):
    """Contents of a program's hello.

    Attributes
    ----------
    name : str
    form : tuple of str
        Names of the forms that the program solves.
    noise : frozenset of str
        Fields of the increment that the program receives.
    asks : frozenset of str
        Coefficients that the program may request; a problem without them is refused.
    needs : tuple of frozenset of str
        Sets of traits, of each of which a problem must have at least one.
    most : tuple of (str, int)
        Letters of shapes with their largest values, for example ``m`` and 1 for one constraint.
    gives : tuple of str
        Components of the solution that the state contains; empty for all.
    memory : str
        Number of rows of additional state: a number, a letter of a shape, or both, as in ``2d``; empty for none.
    law : str
        Law of ``dW``, a key of `LAWS`.
    flags : frozenset of str
        Keys of `FLAGS` that apply to the steps.
    claims : tuple of Claim
    source, about : str
        Source of the method, and its description in one line.
    """

    name: str
    form: tuple[str, ...]
    noise: frozenset[str] = frozenset({"dW"})
    asks: frozenset[str] = frozenset()
    needs: tuple[frozenset[str], ...] = ()
    most: tuple[tuple[str, int], ...] = ()
    gives: tuple[str, ...] = ()
    memory: str = ""
    law: str = GAUSSIAN.name
    flags: frozenset[str] = frozenset()
    claims: tuple[Claim, ...] = ()
    source: str = ""
    about: str = ""


def greet(program: Connection) -> Hello:
    """Exchange hellos with a program that was just started.

    Raises
    ------
    SchemeError
        If the output is not a hello of this version, or its numbers have another byte order.
    """
    program.send(encode("hello", {"version": np.array([float(VERSION)])}))
    said = []
    while not (text := program.text()).startswith("hello "):
        said.append(text)
        if len(said) > MOST_LINES:
            raise program.failure(f"sent {MOST_LINES} lines without a hello")
    if text != "hello version=1":
        raise program.failure(f"sent {text!r:.80}, expected the line 'hello version=1' and one number")
    version = float(program.array((1,))[0])
    if version != VERSION:
        swapped = float(np.array(version).byteswap())
        why = ": its numbers are big-endian, expected little-endian float64" if swapped == VERSION else ""
        raise program.failure(f"speaks version {version:g} of the wire, expected {VERSION}{why}")
    try:
        return read_hello(said)
    except SchemeError as error:
        raise program.failure(str(error)) from error


def read_hello(lines: list[str]) -> Hello:
    """Parse the lines of a hello.

    Raises
    ------
    SchemeError
        If a line is unknown, repeated or missing.
    """
    said: dict[str, Any] = {}
    for line in lines:
        word, _, rest = line.partition(" ")
        if word not in READERS or not rest.strip():
            raise SchemeError(f"said {line!r:.120} as its hello, expected one of {', '.join(READERS)} and a value")
        value = READERS[word](rest)
        if word in REPEATED:
            said[REPEATED[word]] = (*said.get(REPEATED[word], ()), value)
        elif RENAMED.get(word, word) in said:
            raise SchemeError(f"said {word} twice in its hello")
        else:
            said[RENAMED.get(word, word)] = value
    if missing := {"name", "form"} - set(said):
        raise SchemeError(f"said no {' and no '.join(sorted(missing))} in its hello")
    _check_asks(said["form"], said.get("asks", frozenset()))
    letters = {letter for form in said["form"] for letter in FORMS[form].letters}
    named = {letter for letter, _ in said.get("most", ())} | {*filter(str.isalpha, said.get("memory", ""))}
    if unknown := sorted(named - letters):
        raise SchemeError(f"said the length {unknown[0]!r:.60}, expected one of {', '.join(sorted(letters))}")
    return Hello(**said)


def _check_asks(forms: tuple[str, ...], asks: frozenset[str]) -> None:
    if unknown := sorted(set(forms) - set(FORMS)):
        raise SchemeError(f"said form {unknown[0]!r:.60} in its hello, expected one or more of {', '.join(FORMS)}")
    known = {name for form in forms for name in FORMS[form].answers}
    if unknown := sorted(asks - known):
        raise SchemeError(
            f"said that it asks {unknown[0]!r:.60}; of {' or '.join(forms)} it may ask {', '.join(sorted(known))}"
        )


def _read_claim(text: str) -> Claim:
    match = CLAIM.fullmatch(text)
    if match is None:
        raise SchemeError(f"said 'claim {text:.100}' in its hello, expected {CLAIM_LINE}")
    value: float | str = match["value"]
    with suppress(ValueError):
        value = float(value)
    listed = {name: tuple(filter(None, (match[name] or "").split(","))) for name in ("quantities", "when")}
    try:
        return Claim(
            measure=match["measure"],
            value=value,
            source=match["source"],
            quantities=listed["quantities"],
            when=frozenset(listed["when"]),
        )
    except ValueError as error:
        raise SchemeError(f"said 'claim {text:.100}' in its hello: {error}") from error


def _read_most(text: str) -> tuple[tuple[str, int], ...]:
    pairs = [word.partition("=") for word in text.split()]
    if not all(number.isdecimal() and len(number) < 10 for _, _, number in pairs):
        raise SchemeError(f"said 'most {text:.60}' in its hello, expected letters of shapes with numbers such as m=1")
    return tuple((letter, int(number)) for letter, _, number in pairs)


def _read_noise(text: str) -> frozenset[str]:
    if unknown := sorted(set(text.split()) - set(FIELDS)):
        raise SchemeError(f"said 'noise {unknown[0]:.60}' in its hello, expected some of {', '.join(FIELDS)}")
    return frozenset(text.split())


def _read_memory(text: str) -> str:
    if MEMORY.fullmatch(text.strip()) is None:
        raise SchemeError(f"said 'memory {text:.60}' in its hello, expected a number of rows such as 3, d or 2d")
    return text.strip()


def _read_law(text: str) -> str:
    if text.strip() not in LAWS:
        raise SchemeError(f"said 'law {text:.60}' in its hello, expected one of {', '.join(LAWS)}")
    return text.strip()


def _read_flags(text: str) -> frozenset[str]:
    if unknown := sorted(set(text.split()) - set(FLAGS)):
        raise SchemeError(f"said 'is {unknown[0]:.60}' in its hello, expected one of {', '.join(FLAGS)}")
    return frozenset(text.split())


def _words(text: str) -> tuple[str, ...]:
    return tuple(text.split())


def _set(text: str) -> frozenset[str]:
    return frozenset(text.split())


def _text(text: str) -> str:
    return text.strip()


READERS: dict[str, Callable[[str], Any]] = {
    "name": _text,
    "form": _words,
    "noise": _read_noise,
    "asks": _set,
    "needs": _set,
    "most": _read_most,
    "gives": _words,
    "memory": _read_memory,
    "law": _read_law,
    "is": _read_flags,
    "claim": _read_claim,
    "source": _text,
    "about": _text,
}
# Lines that may be repeated, and lines whose field has another name.
REPEATED = {"claim": "claims", "needs": "needs"}
RENAMED = {"is": "flags"}
