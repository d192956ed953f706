"""A gate in words: every outcome that did not pass, then what is noted, then the counts."""

from collections.abc import Iterator
from textwrap import shorten

from ...report.plain import visible
from ..gated import Gated, shortened
from ..outcomes import Outcome, Status
from .messages import headline, message, remark

MOST = 20
# Letters of a reason; most have half as many.
LONGEST = 240
# Told in full; of the others the first line says enough.
FULL = frozenset({Status.FAILED, Status.UNMEASURED, Status.XPASSED})


def text_report(gated: Gated) -> Iterator[str]:
    """Yield the lines of a report.

    Parameters
    ----------
    gated : Gated
    """
    full = [outcome for outcome in gated.told if _in_full(outcome, gated)]
    for outcome in full[:MOST]:
        yield from message(outcome, gated.settings, gated.command(outcome)).split("\n")
        yield ""
    if len(full) > MOST:
        yield f"and {len(full) - MOST} more that fail, see gate.md"
    yield from shortened([_in_a_line(outcome) for outcome in gated.told if not _in_full(outcome, gated)], MOST)
    yield from (visible(f"lock file: {line}") for line in shortened(gated.lock.violations, 2 * MOST))
    yield from (visible(f"warning: {line}") for line in gated.warnings)
    yield from (visible(f"note: {line}") for line in (*gated.lock.notes, *gated.notes))
    yield gated.budget
    yield gated.summary


def _in_a_line(outcome: Outcome) -> str:
    why = shorten(visible(remark(outcome)), LONGEST, placeholder=" ...")
    return f"{headline(outcome)}: {why}" if why else headline(outcome)


def _in_full(outcome: Outcome, gated: Gated) -> bool:
    return outcome.status in FULL or gated.red(outcome)
