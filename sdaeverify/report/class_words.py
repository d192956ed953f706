"""Verdicts on claims about classes in words, from the table of classes of a run."""

from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from math import isnan

from rich.text import Text

from .cells import Row, grouped, number, text
from .plain import visible
from .sentences import lines_of

CLAIMED = ("refuted", "error", "inconclusive", "verified")
NOTED = {"inconclusive": "without a verdict", "error": "in error"}
HOLD = (
    "the claim holds for every class that it is about: look at stability, smoothness, step sizes, states, "
    "and the problem's truth (sdaeverify check PROBLEM)"
)


def class_lines(rows: Sequence[Row], width: int) -> Iterator[Text]:
    """Yield what is said of the claims of a scheme, classes with the same verdict for the same reason together.

    Parameters
    ----------
    rows : sequence of mapping
        Of the table of classes.
    width : int
        Columns of the screen.
    """
    groups = grouped((row for row in rows if text(row, "verdict") in CLAIMED), _alike)
    for (verdict, claim, why), same in sorted(groups.items(), key=lambda item: CLAIMED.index(item[0][0])):
        names = ", ".join(map(_class_name, same))
        told = f"{claim} {verdict} for smooth equations of the class {names}{why and f': {why}'}"
        yield from lines_of(visible(f"  {told}"), width, "    ", verdict)


def _class_name(row: Row) -> str:
    """Return the name of a class, with the number of motions where the class itself does not tell it."""
    motions = text(row, "motions")
    return text(row, "class") + (f" (up to {motions} motions)" if motions > "1" else "")


def _alike(row: Row) -> tuple[str, str, str]:
    verdict = text(row, "verdict")
    return (
        verdict,
        text(row, "measure") + ("" if isnan(order := number(row, "claimed_order")) else f" order {order:g}"),
        "" if verdict == "verified" else why(row),
    )


def why(row: Row) -> str:
    """Return which condition fails, or why none decides."""
    if text(row, "verdict") == "refuted" and text(row, "first"):
        return f"{text(row, 'first')}: found {text(row, 'found')}, wanted {text(row, 'wanted')}"
    return text(row, "premise")


def class_notes(rows: Sequence[Row]) -> Iterator[str]:
    """Yield how many claims have which verdict for a class, and what refutes the first of them."""
    found = Counter(text(row, "verdict") for row in rows)
    if claimed := [f"{found[verdict]} {NOTED.get(verdict, verdict)}" for verdict in CLAIMED[::-1] if found[verdict]]:
        yield f"claims for classes of equations: {', '.join(claimed)}"
    for row in [row for row in rows if text(row, "verdict") == "refuted"][:1]:
        yield f"refuted: {text(row, 'scheme')}, {text(row, 'measure')} for the class {text(row, 'class')}: {why(row)}"


def hint(rows: Iterable[Row], scheme: str, measure: str, verdict: str) -> str:
    """Return the verdict for classes on a claim that is refuted on a problem, or refuted for a class alone.

    Parameters
    ----------
    rows : iterable of mapping
        Of the table of classes.
    scheme, measure : str
        Of the claim.
    verdict : str
        On a problem.

    Returns
    -------
    str
        Empty unless the two verdicts say more than one of them.
    """
    if verdict not in {"refuted", "verified"}:
        return ""
    own = [row for row in rows if (text(row, "scheme"), text(row, "measure")) == (scheme, measure)]
    wrong = next((row for row in own if text(row, "verdict") == "refuted"), None)
    if wrong is not None:
        also = ", too" if verdict == "refuted" else ""
        return f"refuted for the class {text(wrong, 'class')}{also}: {why(wrong)}"
    if verdict == "verified":
        return ""
    claimed = {text(row, "verdict") for row in own} & {*CLAIMED}
    return HOLD if claimed == {"verified"} else ""
