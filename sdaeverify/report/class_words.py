"""Verdicts on claims about classes of equations in words, from the table of classes of a run."""

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
    """Yield the verdicts on claims of a scheme, with classes of the same verdict and reason on one line.

    Parameters
    ----------
    rows : sequence of mapping
        Rows of the table of classes.
    width : int
        Width of the screen in characters.
    """
    groups = grouped((row for row in rows if text(row, "verdict") in CLAIMED), _alike)
    for (verdict, claim, why), same in sorted(groups.items(), key=lambda item: CLAIMED.index(item[0][0])):
        names = ", ".join(map(_class_name, same))
        told = f"{claim} {verdict} for smooth equations of the class {names}{why and f': {why}'}"
        yield from lines_of(visible(f"  {told}"), width, "    ", verdict)


def _class_name(row: Row) -> str:
    """Return the name of a class, with the number of Brownian motions if it exceeds 1."""
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
    """Return which condition fails, or why no condition decides."""
    if text(row, "verdict") == "refuted" and text(row, "first"):
        return f"{text(row, 'first')}: found {text(row, 'found')}, wanted {text(row, 'wanted')}"
    return text(row, "premise")


def class_notes(rows: Sequence[Row]) -> Iterator[str]:
    """Yield the number of claims with each verdict for a class, and the condition that refutes the first."""
    found = Counter(text(row, "verdict") for row in rows)
    if claimed := [f"{found[verdict]} {NOTED.get(verdict, verdict)}" for verdict in CLAIMED[::-1] if found[verdict]]:
        yield f"claims for classes of equations: {', '.join(claimed)}"
    for row in [row for row in rows if text(row, "verdict") == "refuted"][:1]:
        yield f"refuted: {text(row, 'scheme')}, {text(row, 'measure')} for the class {text(row, 'class')}: {why(row)}"


def hint(rows: Iterable[Row], scheme: str, measure: str, verdict: str) -> str:
    """Return the verdict for classes on a claim, if it adds to the verdict on a problem.

    Parameters
    ----------
    rows : iterable of mapping
        Rows of the table of classes.
    scheme, measure : str
        Labels of the scheme and of the measure of the claim.
    verdict : str
        Verdict on a problem.

    Returns
    -------
    str
        Empty unless the verdict for classes adds information.
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
