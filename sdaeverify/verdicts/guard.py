"""The record of a guard: a check that bars a verdict, and the test cell that is judged wrongly without it."""

from collections.abc import Callable
from typing import Any, NamedTuple

from ..contracts.finding import Verdict

VERIFY, REFUTE = frozenset({Verdict.VERIFIED}), frozenset({Verdict.REFUTED})
DECIDE = VERIFY | REFUTE


class Guard(NamedTuple):
    """Check that bars verdicts which the evidence alone would allow.

    Attributes
    ----------
    asks : callable
        Function that raises the doubt. To run without the guard, replace it by a function that returns its first
        argument if that is an opinion, tests or findings, and False, an empty text, 1 or None otherwise.
    bars : frozenset of Verdict
        Verdicts that are excluded while the doubt stands.
    tier : int or None
        Tier of the doubted evidence; None if the guard applies to all tiers.
    reason : str
        Why the verdict is barred, in a sentence.
    remedy : str
        Evidence or change that would decide; empty if none would.
    planted : str
        Name of the cell in `tests/guard_cells.py` that is judged wrongly without the guard.
    """

    asks: Callable[..., Any]
    bars: frozenset[Verdict]
    tier: int | None
    reason: str
    remedy: str
    planted: str

    @property
    def name(self) -> str:
        """Qualified name of `asks` in words: the function name, or class and method."""
        return self.asks.__qualname__.strip("_").replace("_", " ").replace(".", ": ")
