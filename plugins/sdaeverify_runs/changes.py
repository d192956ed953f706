"""Changes between runs: classification of factors as same, worse, better or undecided; records and text."""

from collections import Counter
from collections.abc import Iterator, Sequence
from enum import StrEnum
from math import isfinite
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from sdaeverify import UsageError
from sdaeverify.studying import holm

from .cells import Comparison
from .factors import Factor
from .tables import ConstantChange

# Smallest change of an order that is reported.
ORDER = 0.01
MOST_TOLD = 20


class Change(StrEnum):
    """Change of the errors of a quantity."""

    SAME = "same"
    WORSE = "worse"
    BETTER = "better"
    UNDECIDED = "undecided"


class Changed(NamedTuple):
    """A factor with its interval and its classification.

    Attributes
    ----------
    factor, low, high : float
        New error over old error, with an interval of level 1 - alpha; all three are equal without sampling.
    change : Change
    order_moved : bool
        Whether the order has changed by more than `ORDER`, and by more than chance explains.
    """

    factor: float
    low: float
    high: float
    change: Change
    order_moved: bool = False


def changes(factors: Sequence[Factor], margin: float = 1.1, alpha: float = 0.01) -> list[Changed]:
    """Classify factors with a bound on the probability of error of all tests together.

    A factor is worse if it is significantly larger than the margin, and better if it is significantly smaller than
    its inverse. By Holm's procedure, the probability of any wrong classification is at most alpha for either. It is
    the same if its interval lies between the two. Without sampling, the factor itself is compared.

    Parameters
    ----------
    factors : sequence of Factor
        Known factors.
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
    moved = _moved_orders(factors, alpha)
    return [
        _judge_change(each, bound, alpha, sign)._replace(order_moved=i in moved)
        for i, (each, sign) in enumerate(zip(factors, signs, strict=True))
    ]


def _moved_orders(factors: Sequence[Factor], alpha: float) -> set[int]:
    """Return the indices of factors whose order has changed, at family-wise error rate alpha."""
    sides = {(i, 0): (each.order.p_above(ORDER), each.order.p_below(-ORDER)) for i, each in enumerate(factors)}
    return {i for i, _ in holm({place: min(1.0, 2.0 * min(pair)) for place, pair in sides.items()}, alpha)}


def _judge_change(found: Factor, bound: float, alpha: float, significant: int) -> Changed:
    value = found.log2.value
    low, high = found.log2.interval(1.0 - alpha) if found.sampled else (value, value)
    if not found.sampled:
        significant = int(value > bound) - int(value < -bound)
    if found.is_order_alone:
        significant = int(found.order.value < -ORDER) - int(found.order.value > ORDER)
    change = Change.SAME if -bound <= low and high <= bound else Change.UNDECIDED
    if significant:
        change = Change.WORSE if significant > 0 else Change.BETTER
    return Changed(float(np.exp2(value)), float(np.exp2(low)), float(np.exp2(high)), change)


Rows = Sequence[tuple[Comparison, Changed]]
WORDS = {
    Change.WORSE: "worse",
    Change.BETTER: "better",
    Change.SAME: "the same",
    Change.UNDECIDED: "undecided",
}
REFUTED = "refuted"


def counted(number: int, noun: str) -> str:
    """Return a number with its noun in the singular or plural."""
    return f"{number} {noun}{'' if number == 1 else 's'}"


class RunPair(NamedTuple):
    """Changes from one run to the next.

    Attributes
    ----------
    old, new : Path
        Folders of the runs.
    judged : list of mapping of str to str
        Verdicts on quantities that both runs judged.
    rows : sequence of (Comparison, Changed)
        Comparison of each quantity whose errors are known in both runs.
    omitted : list of Comparison
        Quantities that could not be compared.
    constants : list of ConstantChange
        Leading errors that differ.
    """

    old: Path
    new: Path
    judged: list[dict[str, str]]
    rows: Rows
    omitted: list[Comparison]
    constants: Sequence[ConstantChange] = ()

    @property
    def verdicts(self) -> list[dict[str, str]]:
        """Verdicts that changed."""
        return [each for each in self.judged if each["before"] != each["after"]]

    @property
    def grown(self) -> int:
        """Number of quantities whose errors have grown beyond the factor."""
        return sum(changed.change is Change.WORSE for _, changed in self.rows)

    @property
    def refuted(self) -> int:
        """Number of quantities with a newly refuted claim."""
        return sum(verdict["after"] == REFUTED for verdict in self.verdicts)

    @property
    def on_other_noise(self) -> bool:
        """Whether the runs have no noise in common, so that only verdicts are compared."""
        return any(not each.key.scheme for each in self.omitted)


def records(pair: RunPair) -> dict[str, Any]:
    """Return a pair of runs for JSON, in which numbers that are not finite are null."""
    return {
        "old": str(pair.old),
        "new": str(pair.new),
        "verdicts": pair.verdicts,
        "quantities": [_record(*row) for row in pair.rows],
        "constants": [{**each.key._asdict(), "before": each.before, "after": each.after} for each in pair.constants],
        "omitted": [{**each.key._asdict(), "reason": each.found.reason} for each in pair.omitted],
    }


def _record(compared: Comparison, changed: Changed) -> dict[str, object]:
    numbers = {"factor": changed.factor, "ci_low": changed.low, "ci_high": changed.high}
    numbers |= {"order_change": compared.found.order.value, "order_std_error": compared.found.order.se}
    return {
        **compared.key._asdict(),
        **{name: value if isfinite(value) else None for name, value in numbers.items()},
        "verdict": str(changed.change),
        "order_moved": changed.order_moved,
        "levels": compared.found.levels,
        "paths": compared.paths,
        "reason": compared.found.reason,
    }


def pair_in_words(pair: RunPair, *, every: bool) -> Iterator[str]:
    """Yield the changes, one per line: verdicts, then errors, worst classification and largest factors first."""
    for change in pair.verdicts:
        yield "{} on {}, {} {}: {} -> {}".format(*change.values())
    for each in pair.constants:
        yield f"{each.key}: leading error without sampling {each.before} -> {each.after}"
    order = list(WORDS)
    for compared, changed in sorted(pair.rows, key=lambda row: (order.index(row[1].change), -row[1].factor)):
        if every or changed.change is not Change.SAME or changed.order_moved:
            yield f"{compared.key}: {changed.change}, {_in_words(compared.found, changed)}"


def _in_words(found: Factor, changed: Changed) -> str:
    interval = f" ({changed.low:.3f} to {changed.high:.3f})" if found.sampled else ""
    order = f", order {found.order.value:+.3f}" if changed.order_moved else ""
    return f"error x {changed.factor:.3f}{interval}{order}" + (f"; {found.reason}" if found.reason else "")


def counts(pair: RunPair) -> str:
    """Return a sentence with the number of changed verdicts and of quantities in each class."""
    found = Counter(changed.change for _, changed in pair.rows)
    parts = ", ".join(f"{found[change] or 'none'} {words}" for change, words in WORDS.items())
    moved = sum(changed.order_moved for _, changed in pair.rows)
    many = f"{len(pair.rows)} {'quantity' if len(pair.rows) == 1 else 'quantities'} compared"
    changed = f"{len(pair.verdicts)} of {counted(len(pair.judged), 'verdict')} changed"
    return f"{changed}; {many}: {parts}; {counted(moved, 'order')} moved"


def advice(pair: RunPair) -> Iterator[str]:
    """Yield how to decide undecided quantities."""
    if any(changed.change is Change.UNDECIDED for _, changed in pair.rows):
        yield "undecided: more paths would decide; run both with --paths N --max-looks 1, which uses all N"


def list_omissions(omitted: Sequence[Comparison]) -> Iterator[str]:
    """Yield the quantities that are not compared, one line for each reason."""
    reasons: dict[str, list[Comparison]] = {}
    for each in omitted:
        reasons.setdefault(each.found.reason, []).append(each)
    for reason, cells in list(reasons.items())[:MOST_TOLD]:
        more = f" and {len(cells) - 1} more" if len(cells) > 1 else ""
        yield f"not compared: {cells[0].key}{more}: {reason}" if cells[0].key.scheme else reason
    if len(reasons) > MOST_TOLD:
        yield f"and {len(reasons) - MOST_TOLD} more reasons, see --json"
