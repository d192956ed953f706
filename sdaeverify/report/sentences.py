"""Summary of a run in words, from the rows of its tables: at most 40 lines, counts first."""

from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from math import inf, isfinite, isinf, isnan

from rich.table import Table
from rich.text import Text

from ..contracts.spelling import counted
from .cells import grouped
from .plain import TOGETHER, empty_table, visible, wrap_text
from .verdict_row import ORDER, Interval, VerdictRow

WORDS = {"out_of_scope": "without a claim", "not_run": "not run", "error": "in error"}
# Symbol, ASCII substitute and style, worst first.
SYMBOLS = {
    "refuted": ("✗", "X", "bold red"),
    "diverged": ("!", "!", "bold magenta"),
    "error": ("!", "!", "bold magenta"),
    "inconclusive": ("?", "?", "yellow"),
    "not_run": ("…", "~", "dim"),
    "verified": ("✓", "v", "green"),
    "out_of_scope": ("○", "o", "dim"),
    "not_applicable": ("·", ".", "dim"),
}
FIRST = ("verified", "refuted")
ATTENTION = ("refuted", "diverged", "error", "inconclusive", "not_run")
ABSENT = "not_applicable"
ACCEPTED = "accepted ≥"
BRIEF = ("", "quantity", "claim", "one step", "along paths", ACCEPTED, "by")
TIERS = {
    "T0": "by the contract of a step",
    "T1": "from one step, without sampling, with the one-step tolerance that the reason names",
    "T2": "from all steps at once, without sampling",
    "T3": "along paths, which are sampled",
}
MOST_LINES = 40
# Largest number of lines for an undecided and for a failed group.
FEW, MANY = 4, 5
# Largest number of schemes, or quantities of a measure, named in one line.
MOST_NAMED = 3


def wrap_styled(text: str, width: int, indent: str = "", verdict: str = "", most: int = 0) -> list[Text]:
    """Wrap a text into lines in the style of a verdict.

    Parameters
    ----------
    text : str
    width : int
    indent : str
    verdict : str
        Empty for no style.
    most : int
        Largest number of lines; see `wrap_text`.
    """
    style = SYMBOLS[verdict][2] if verdict else ""
    return [Text(line, style=style) for line in wrap_text(text, width, indent, most)]


def in_cells(row: VerdictRow, *, plain: bool = False) -> dict[str, str]:
    """Return the cells of a row as tables show them: verdict, names, claim, orders, tier and reason."""
    told = {
        "": mark(row.verdict, plain=plain),
        "scheme": row.scheme,
        "problem": row.problem,
        "quantity": f"{row.measure} {row.quantity}".strip(),
        "claim": row.claim if isnan(row.claimed_order) else f"{at_least(plain=plain)} {row.claimed_order}",
        "one step": local_order(row),
        "along paths": interval(row.path) or other_value(row),
        # The tolerance of one step differs, and is given in the reason.
        ACCEPTED: "" if isnan(row.claimed_order) else f"{row.claimed_order - row.margin:.3g}",
        "by": row.decided_by,
        "why": row.reason,
    }
    return {name: visible(cell) for name, cell in told.items()}


def quantity_table(rows: Iterable[VerdictRow], *, plain: bool = False) -> Table:
    """Return the table of the quantities of a cell, with each row in the style of its verdict."""
    table = empty_table(*(_in_letters(heading) if plain else heading for heading in BRIEF))
    for row in rows:
        told = in_cells(row, plain=plain)
        table.add_row(*(Text(told[name]) for name in BRIEF), style=SYMBOLS[row.verdict][2])
    return table


def overview(rows: Iterable[VerdictRow], *, plain: bool = False) -> Iterator[Text | Table]:
    """Yield a table of the quantities for each cell, followed by an explanation of the columns."""
    every = list(rows)
    for (scheme, problem), found in grouped(every, lambda row: (row.scheme, row.problem)).items():
        yield Text(f"\n{visible(f'{scheme} on {problem}')}")
        yield quantity_table(found, plain=plain)
    yield from _tiers_in_words(every, plain=plain)


def _tiers_in_words(rows: Sequence[VerdictRow], *, plain: bool) -> Iterator[Text]:
    """Yield a line that explains the tiers of the tables and the accepted order."""
    told = [f"{tier}: {TIERS[tier]}" for tier in sorted({row.decided_by for row in rows}) if tier in TIERS]
    if not all(isnan(row.claimed_order) for row in rows):
        heading = _in_letters(ACCEPTED) if plain else ACCEPTED
        told.append(f"{heading}: the least order along paths that the claim allows, the claim less its margin")
    if told:
        yield Text("; ".join(told), style="dim")


def counts_in_words(verdicts: Iterable[str]) -> str:
    """Return a sentence with the number of quantities of each verdict."""
    found = Counter(str(verdict) for verdict in verdicts)
    absent = found.pop(ABSENT, 0)
    order = (*FIRST, *(verdict for verdict in SYMBOLS if verdict in found and verdict not in FIRST))
    parts = [f"{found[verdict] or 'none'} {WORDS.get(verdict, verdict)}" for verdict in order]
    total = found.total()
    tail = f"; {counted(absent, 'cell')} {'does' if absent == 1 else 'do'} not apply" if absent else ""
    return f"{total} {'quantity' if total == 1 else 'quantities'}: {', '.join(parts)}{tail}"


def counts_of(rows: Iterable[VerdictRow], absent: Iterable[object]) -> str:
    """Return a sentence with the number of rows of each verdict, including those that do not apply."""
    return counts_in_words([*(row.verdict for row in rows), *(ABSENT for _ in absent)])


def ending(
    sentence: str, rows: Sequence[VerdictRow], notes: Sequence[str], width: int, *, plain: bool = False
) -> list[Text]:
    """Return the final lines of a run: counts, quantities that need attention, schemes by measure, notes.

    Parameters
    ----------
    sentence : str
        Sentence with the counts.
    rows : sequence of VerdictRow
        Rows of all cells that apply.
    notes : sequence of str
        Final paragraphs.
    width : int
        Width of a line; names and numbers are never broken.
    plain : bool
        Whether the output is restricted to ASCII.
    """
    first = wrap_styled(sentence, width)
    last = [line for note in notes for line in wrap_styled(visible(note), width, "  ")]
    room = MOST_LINES - len(first) - len(last) - 2
    needs, schemes = list(_attention(rows, width, plain=plain)), by_scheme(rows, width, plain=plain)
    share = max(room - len(schemes), room // 2)
    shown = _fit(needs, share, "more of them; show --open has all")
    table = [[line] for line in schemes]
    return [*first, *_space(shown), *_space(_fit(table, room - len(shown), "more schemes; show has all")), *last]


def estimate_in_words(row: VerdictRow) -> str:
    """Return the order along paths, or else the local order, or else the estimate of the measure."""
    if row.path.known:
        return f"{interval(row.path)} along paths"
    if row.local_order == inf:
        return "exact in one step"
    if not isnan(row.local_order):
        return f"{row.local_order:.2f} in one step"
    if not row.estimate.known:
        return ""
    if ORDER in row.value_of:
        return interval(row.estimate)
    return f"{row.value:.4g} ({row.value_of})"


def interval(estimate: Interval, digits: int = 2) -> str:
    """Return an order with its interval; an interval without a finite upper end reads "at least" its lower end."""
    if not estimate.known:
        return ""
    if isfinite(estimate.low) and not isfinite(estimate.high):
        return f"at least {estimate.low:.{digits}f}"
    ends = f" [{estimate.low:.{digits}f}, {estimate.high:.{digits}f}]" if isfinite(estimate.low) else ""
    return f"{estimate.value:.{digits}f}{ends}"


def local_order(row: VerdictRow, digits: int = 2) -> str:
    """Return the order of one step as text, or an empty string if it is unknown."""
    return "" if isnan(row.local_order) else f"{row.local_order:.{digits}f}"


def claim_in_words(row: VerdictRow, *, plain: bool = False) -> str:
    """Return a claim with the least order along paths that verifies it."""
    if not row.claim:
        return "no claim"
    if isnan(row.claimed_order) or isnan(row.margin):
        return row.claim
    sign = at_least(plain=plain)
    return f"order {sign} {row.claimed_order} (sampled: {sign} {row.claimed_order - row.margin:.3g})"


def at_least(*, plain: bool = False) -> str:
    """Return the sign of a lower bound, ``>=`` if the output is restricted to ASCII."""
    return _in_letters("≥") if plain else "≥"


def _in_letters(text: str) -> str:
    return text.replace("≥", ">=")


def resolution_in_words(row: VerdictRow) -> str:
    """Return the least detectable error of the limit, or an empty string if no limit is tested."""
    if isnan(row.resolution):
        return ""
    return "no resolution" if isinf(row.resolution) else f"resolution {row.resolution:.2g}"


def mark(verdict: str, *, plain: bool = False) -> str:
    """Return the symbol of a verdict, or its ASCII substitute."""
    return SYMBOLS[verdict][plain]


def other_value(row: VerdictRow) -> str:
    """Return the estimate of the measure if no order of one step is known."""
    return estimate_in_words(row) if row.estimate.known and isnan(row.local_order) else ""


def quantity_lines(row: VerdictRow, width: int, *, plain: bool = False) -> list[Text]:
    """Return all known about a quantity: claim, orders, deciding tier, guard, reason.

    Parameters
    ----------
    row : VerdictRow
    width : int
    plain : bool
        Whether the output is restricted to ASCII.
    """
    local = local_order(row, 3)
    told = [
        claim_in_words(row, plain=plain),
        local and f"local order {local}",
        f"order along paths {interval(row.path, 3)}" if row.path.known else "",
        other_value(row),
        f"decided by {row.decided_by}" if row.decided_by else "",
        *row.labelled,
        resolution_in_words(row),
    ]
    # The verdict on a scheme as a whole names no quantity.
    what = f"{row.quantity}: " if row.quantity else ""
    head = f"  {mark(row.verdict, plain=plain)} {visible(what + '; '.join(filter(None, told)))}"
    return [
        *wrap_styled(head, width, "    ", row.verdict),
        *wrap_styled(f"    {visible(row.reason)}", width, "    "),
    ]


def by_scheme(rows: Iterable[VerdictRow], width: int, *, plain: bool = False) -> list[Text]:
    """Return the counts of claims by measure for each scheme, worst schemes first.

    Parameters
    ----------
    rows : iterable of VerdictRow
        Rows of the table of verdicts.
    width : int
        Width of the screen in characters.
    plain : bool
        Whether the output is restricted to ASCII.
    """
    schemes = grouped((row for row in rows if row.verdict != "out_of_scope"), lambda row: visible(row.scheme))
    order = list(SYMBOLS)
    names = sorted(schemes, key=lambda name: (min(order.index(row.verdict) for row in schemes[name]), name))
    told = (f"{name}: {_counts_by_measure(schemes[name], plain=plain)}" for name in names)
    return [line for text in told for line in wrap_styled(text, width, "    ")]


def _counts_by_measure(rows: Sequence[VerdictRow], *, plain: bool) -> str:
    measures = sorted(grouped(rows, lambda row: visible(row.measure)).items())
    counted = ((measure, Counter(row.verdict for row in found)) for measure, found in measures)
    signs = {verdict: mark(verdict, plain=plain) for verdict in ("verified", *ATTENTION)}
    told = (" ".join([name, *(f"{signs[v]}{found[v]}" for v in signs if found[v])]) for name, found in counted)
    return ", ".join(words.replace(" ", TOGETHER) for words in told)


def _attention(rows: Iterable[VerdictRow], width: int, *, plain: bool) -> Iterator[list[Text]]:
    groups = grouped((row for row in rows if row.verdict in ATTENTION), _what_is_wrong)
    for (verdict, *_), group in sorted(groups.items(), key=lambda item: ATTENTION.index(item[0][0])):
        most = FEW if verdict == "inconclusive" else MANY
        yield wrap_styled(_group_words(group, plain=plain), width, "    ", verdict, most)


def _what_is_wrong(row: VerdictRow) -> tuple[str, ...]:
    # An error of a scheme as a whole is reported once for all its measures.
    of = (row.measure, claim_in_words(row)) if estimate_in_words(row) else ()
    return (row.verdict, row.problem, row.reason_kind or row.reason, *of)


def _group_words(group: Sequence[VerdictRow], *, plain: bool) -> str:
    row, schemes = group[0], [one.scheme for one in group]
    measures = grouped(group, lambda one: one.measure).items()
    what = [f"{name} {_some_of([one.quantity for one in found])}".strip() for name, found in measures]
    found = estimate_in_words(row)
    claims = dict.fromkeys(claim_in_words(one, plain=plain) for one in group if one.claim) or ["no claim"]
    sign = at_least(plain=plain)
    claim = visible(" and ".join(claims)).replace(f" {sign} ", f"{TOGETHER}{sign}{TOGETHER}")
    claim = claim.replace("(sampled: ", f"(sampled:{TOGETHER}") + (f", found {found}" if found else "")
    symbol = f"{mark(row.verdict, plain=plain)}{TOGETHER}{WORDS.get(row.verdict, row.verdict)}"
    where = visible(f"{_some_of(schemes)} on {row.problem}, {', '.join(what)}")
    joint = " not tested: " if row.verdict == "error" and any(one.claim for one in group) else ". "
    return f"{symbol}: {where}: {claim}{joint}{visible(row.reason)}"


def _some_of(names: Iterable[str]) -> str:
    """Return the first distinct names and the number of the others."""
    different = list(dict.fromkeys(names))
    others = len(different) - MOST_NAMED
    return ", ".join(different[:MOST_NAMED]) + (f" and {others} more" if others > 0 else "")


def _fit(blocks: Sequence[Sequence[Text]], room: int, rest: str) -> list[Text]:
    """Return as many blocks of lines as fit, followed by the number of omitted blocks."""
    lines: list[Text] = []
    for number, block in enumerate(blocks):
        left = len(blocks) - number
        if len(lines) + len(block) + (left > 1) > room:
            return [*lines, Text(f"and {left} {rest}")]
        lines += block
    return lines


def _space(lines: Sequence[Text]) -> Sequence[Text]:
    return [*lines, Text()] if lines else []
