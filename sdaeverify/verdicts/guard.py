"""A guard as data: what bars a verdict that the evidence by itself would allow, and the cell that needs it."""

from collections.abc import Callable
from typing import Any, NamedTuple

from ..contracts.finding import Verdict

VERIFY, REFUTE = frozenset({Verdict.VERIFIED}), frozenset({Verdict.REFUTED})
DECIDE = VERIFY | REFUTE


class Guard(NamedTuple):
    """A guard.

    Attributes
    ----------
    asks : callable
        The function that finds the doubt. A run without the guard is one in which it returns its first argument, if
        it returns an opinion, tests or findings, or else False, an empty text, 1 or None.
    bars : frozenset of Verdict
        Verdicts that cannot be given as long as the doubt stands.
    tier : int or None
        Tier of the evidence that is doubted; None if it is any.
    reason : str
        Why the verdict is barred, in a sentence.
    remedy : str
        What would decide; empty if nothing does.
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
        """Name of the function, in words; of a method with its class."""
        return self.asks.__qualname__.strip("_").replace("_", " ").replace(".", ": ")
