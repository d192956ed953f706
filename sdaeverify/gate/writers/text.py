"""A gate in words, for a terminal."""

from collections.abc import Iterator
from textwrap import shorten

from ...report.plain import visible
from ..gated import Gated, limit_lines
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
    full = [outcome for outcome in gated.not_passed if _needs_full_text(outcome, gated)]
    for outcome in full[:MOST]:
        yield from message(outcome, gated.settings, gated.command(outcome)).split("\n")
        yield ""
    if len(full) > MOST:
        yield f"and {len(full) - MOST} more that fail, see gate.json"
    yield from limit_lines(
        [_one_line_text(outcome) for outcome in gated.not_passed if not _needs_full_text(outcome, gated)], MOST
    )
    yield from (visible(f"lock file: {line}") for line in limit_lines(gated.violations, 2 * MOST))
    yield from (visible(f"warning: {line}") for line in gated.warnings)
    yield from (visible(f"note: {line}") for line in gated.notes)
    yield gated.budget
    yield gated.summary


def _one_line_text(outcome: Outcome) -> str:
    why = shorten(visible(remark(outcome)), LONGEST, placeholder=" ...")
    return f"{headline(outcome)}: {why}" if why else headline(outcome)


def _needs_full_text(outcome: Outcome, gated: Gated) -> bool:
    return outcome.status in FULL or gated.is_red(outcome)
