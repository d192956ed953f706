"""Differences between the tables of two runs: verdicts, leading errors, and the settings of the noise."""

from collections.abc import Mapping
from typing import Any, NamedTuple

from sdaeverify.studying import StoredRun

NAMES = ("scheme", "problem", "measure", "quantity")


class Key(NamedTuple):
    """Key of a quantity: labels of scheme and problem, names of measure and quantity."""

    scheme: str
    problem: str
    measure: str = ""
    quantity: str = ""

    def __str__(self) -> str:
        return f"{self.scheme} on {self.problem}, {self.measure} {self.quantity}".rstrip(", ")


def verdict_pairs(old: StoredRun, new: StoredRun) -> list[dict[str, str]]:
    """Return the verdicts of two runs on all quantities that both judged: names, before, after.

    A verdict on a whole cell, such as a broken contract, counts for each quantity that the other run has there.
    """
    befores, afters = old.verdicts, new.verdicts
    both = ((key, _verdict_in(befores, key), _verdict_in(afters, key)) for key in {**befores, **afters})
    return [{**key._asdict(), "before": before, "after": after} for key, before, after in both if before and after]


def _verdict_in(verdicts: Mapping[Any, str], key: Any) -> str:
    return verdicts.get(key, verdicts.get(key._replace(quantity=""), ""))


class ConstantChange(NamedTuple):
    """A leading error, known without sampling, that is another one in a later run.

    Attributes
    ----------
    key : Key
    before, after : str
        The leading error in words, such as ``-0.184 h``.
    """

    key: Key
    before: str
    after: str


def constant_changes(old: StoredRun, new: StoredRun) -> list[ConstantChange]:
    """Return the leading errors of two runs that differ by more than the bounds of their errors."""
    befores, afters = old.leading_errors, new.leading_errors
    pairs = [(Key(*key), befores[key], afters[key]) for key in befores if key in afters]
    return [
        ConstantChange(key, str(a), str(b))
        for key, (a, known), (b, known_now) in pairs
        if a.power != b.power or abs(a.constant - b.constant) > known + known_now
    ]


def why_not_on_common_noise(old: StoredRun, new: StoredRun) -> str:
    """Return how noise or step sizes of two runs differ, or an empty string."""
    pairs = {name: (value, new.noise[name]) for name, value in old.noise.items()}
    different = [f"{name} {a} in {old.folder} and {b} in {new.folder}" for name, (a, b) in pairs.items() if a != b]
    return f"errors are compared on common noise, with the same settings: {'; '.join(different)}" if different else ""
