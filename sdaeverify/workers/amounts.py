"""Amounts of memory as people write them."""

import re

from ..errors import UsageError

UNITS = {"": 1, "K": 2**10, "M": 2**20, "G": 2**30, "T": 2**40}
# Measured: libraries that a worker loads as it begins, and gbm and the pendulum on all measures, take 50M to 100M.
LEAST = 2**28
_AMOUNT = re.compile(r"([0-9]{1,15}(?:\.[0-9]{1,6})?) ?([KMGT]?)i?B?")


def read_memory(name: str, text: str) -> int:
    """Return the number of bytes that a worker may have.

    Parameters
    ----------
    name : str
        Of the option or key, for the message.
    text : str
        A number with K, M, G or T behind it, for powers of 1024: ``2G``.

    Raises
    ------
    UsageError
        If it is no such amount, or less than a worker needs whatever it runs.
    """
    match = _AMOUNT.fullmatch(text.strip())
    size = int(float(match[1]) * UNITS[match[2]]) if match else 0
    if size < 1:
        raise UsageError(f"{name} expects an amount of memory such as 500M or 2G, got {text!r}")
    if size < LEAST:
        raise UsageError(f"{name} expects at least {LEAST >> 20}M, since a worker needs some itself, got {text!r}")
    return size
