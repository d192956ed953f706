"""What a factor says: errors are the same, worse, better, or it cannot be told; as records, table and words."""

from collections import Counter
from collections.abc import Iterator, Sequence
from enum import StrEnum
from math import isfinite
from typing import NamedTuple

import numpy as np
from rich.table import Table
from rich.text import Text

from ...errors import UsageError
from ...study.holm import holm
from ..plain import empty_table, visible
from .cells import Comparison, Omitted
from .factors import Factor

HEADINGS = ("scheme", "problem", "measure", "quantity", "factor", "interval", "verdict")
MOST_TOLD = 20


class Change(StrEnum):
    """What became of the errors of a quantity."""

    SAME = "same"
    WORSE = "worse"
    BETTER = "better"
    UNDECIDED = "undecided"


class Changed(NamedTuple):
    """A factor with its interval, and what it says.

    Attributes
    ----------
    factor, low, high : float
        New error over old error, with an interval of level 1 - alpha, alike where nothing is sampled.
    change : Change
    """

    factor: float
    low: float
    high: float
    change: Change


def changes(factors: Sequence[Factor], margin: float = 1.1, alpha: float = 0.01) -> list[Changed]:
    """Return what factors say, the errors of all tests together being bounded.

    Worse is what is significantly larger than the margin, better what is significantly smaller than its inverse: by
    Holm's procedure, the probability that any of them is wrong is at most alpha for either. The same is what has all
    of its interval between the two. Where nothing is sampled the factor itself is compared.

    Parameters
    ----------
    factors : sequence of Factor
        Known ones.
    margin : float, optional
        Above 1.
    alpha : float, optional

    Raises
    ------
    UsageError
        If the margin or alpha is out of its range.
    """
    if not 1.0 < margin < float("inf"):
        raise UsageError(f"the factor must be above 1, got {margin}")
    if not 0.0 < alpha <= 0.5:
        raise UsageError(f"alpha must be above 0 and at most 0.5, got {alpha}")
    bound = float(np.log2(margin))
    tested = {(i, 0): each.log2 for i, each in enumerate(factors) if each.sampled}
    worse = holm({place: log2.p_above(bound) for place, log2 in tested.items()}, alpha)
    better = holm({place: log2.p_below(-bound) for place, log2 in tested.items()}, alpha)
    signs = [((i, 0) in worse) - ((i, 0) in better) for i in range(len(factors))]
    return [_judge_change(each, bound, alpha, sign) for each, sign in zip(factors, signs, strict=True)]


def _judge_change(found: Factor, bound: float, alpha: float, significant: int) -> Changed:
    value = found.log2.value
    low, high = found.log2.interval(1.0 - alpha) if found.sampled else (value, value)
    if not found.sampled:
        significant = int(value > bound) - int(value < -bound)
    change = Change.SAME if -bound <= low and high <= bound else Change.UNDECIDED
    if significant:
        change = Change.WORSE if significant > 0 else Change.BETTER
    return Changed(float(np.exp2(value)), float(np.exp2(low)), float(np.exp2(high)), change)


Rows = Sequence[tuple[Comparison, Changed]]

STYLES = {Change.WORSE: "bold red", Change.UNDECIDED: "yellow", Change.BETTER: "green", Change.SAME: "dim"}
WORDS = {
    Change.WORSE: "worse",
    Change.BETTER: "better",
    Change.SAME: "the same",
    Change.UNDECIDED: "undecided",
}


def records(rows: Rows) -> list[dict[str, object]]:
    """Return one record for each quantity; a number that is not finite is none in JSON."""
    return [
        {
            **dict(zip(HEADINGS[:4], compared, strict=False)),
            "factor": _number(changed.factor),
            "ci_low": _number(changed.low),
            "ci_high": _number(changed.high),
            "verdict": str(changed.change),
            "levels": compared.found.levels,
            "paths": compared.paths,
            "reason": compared.found.reason,
        }
        for compared, changed in rows
    ]


def comparison_table(rows: Rows) -> Table:
    """Return the factors, the worst verdicts first and the largest factors first in each."""
    table = empty_table(*HEADINGS)
    order = list(STYLES)
    for compared, changed in sorted(rows, key=lambda row: (order.index(row[1].change), -row[1].factor)):
        interval = f"{changed.low:.3f} to {changed.high:.3f}" if compared.found.sampled else compared.found.reason
        texts = (*compared[:4], f"{changed.factor:.3f}", interval)
        table.add_row(*(Text(visible(text)) for text in texts), Text(changed.change, style=STYLES[changed.change]))
    return table


def counts(rows: Rows) -> str:
    """Return in one sentence how many quantities became what."""
    found = Counter(changed.change for _, changed in rows)
    parts = (f"{found[change] or 'none'} {words}" for change, words in WORDS.items())
    return f"{len(rows)} {'quantity' if len(rows) == 1 else 'quantities'} compared: {', '.join(parts)}"


def list_omissions(omitted: Sequence[Omitted]) -> Iterator[str]:
    """Yield what is not compared, a line for each reason."""
    grouped: dict[str, list[Omitted]] = {}
    for each in omitted:
        grouped.setdefault(each.reason, []).append(each)
    for reason, cells in list(grouped.items())[:MOST_TOLD]:
        first = cells[0]
        what = f"{first.scheme} on {first.problem}, {first.measure} {first.quantity}".rstrip(", ")
        more = f" and {len(cells) - 1} more" if len(cells) > 1 else ""
        yield visible(f"not compared: {what}{more}: {reason}")
    if len(grouped) > MOST_TOLD:
        yield f"and {len(grouped) - MOST_TOLD} more reasons, see --json"


def _number(value: float) -> float | None:
    return value if isfinite(value) else None
