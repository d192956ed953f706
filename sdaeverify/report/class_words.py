"""Verdicts on claims about classes of equations in words, from the table of classes of a run."""

from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from math import isnan

from rich.text import Text

from .cells import Row, grouped, number, text
from .plain import visible
from .sentences import wrap_styled

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
        told = f"{claim} {verdict} for smooth equations of the class {names}{_begun(why)}"
        yield from wrap_styled(visible(f"  {told}"), width, "    ", verdict)


def equation_lines(rows: Sequence[Row]) -> Iterator[str]:
    """Yield the modified equations of a scheme, with classes of the same terms under the first of them.

    Parameters
    ----------
    rows : sequence of mapping
        Rows of the table of classes.
    """
    known = [row for row in rows if text(row, "modified")]
    for same in grouped(known, lambda row: text(row, "modified_terms") or text(row, "modified")).values():
        yield ""
        yield from text(same[0], "modified").replace("\\n", "\n").split("\n")
        further = dict.fromkeys(text(row, "class") for row in same if text(row, "class") != text(same[0], "class"))
        if further:
            yield f"    the same for the class {', '.join(further)}"


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
    """Return the mistake, if it is known, and the condition that fails; or why no condition decides."""
    if text(row, "verdict") == "refuted" and text(row, "first"):
        failing = f"{text(row, 'first')}: found {text(row, 'found')}, wanted {text(row, 'wanted')}"
        return text(row, "reason").removesuffix(".") or failing
    return text(row, "premise")


def _begun(why: str) -> str:
    """Return a reason as the continuation of a statement: a new sentence, or words after a colon."""
    return f"{'.' if why[:1].isupper() else ':'} {why}" if why else ""


def class_notes(rows: Sequence[Row]) -> Iterator[str]:
    """Yield the number of claims with each verdict for a class, and the condition that refutes the first."""
    found = Counter(text(row, "verdict") for row in rows)
    if claimed := [f"{found[verdict]} {NOTED.get(verdict, verdict)}" for verdict in CLAIMED[::-1] if found[verdict]]:
        yield f"claims for classes of equations: {', '.join(claimed)}"
    for row in [row for row in rows if text(row, "verdict") == "refuted"][:1]:
        claim = f"{text(row, 'scheme')}, {text(row, 'measure')} for the class {text(row, 'class')}"
        yield f"refuted: {claim}{_begun(why(row))}"


def class_summary(rows: Sequence[Row]) -> Iterator[str]:
    """Yield the modified equations of refuted schemes, followed by the number of claims with each verdict.

    Parameters
    ----------
    rows : sequence of mapping
        Rows of the table of classes.
    """
    yield from equation_lines([row for row in rows if text(row, "verdict") == "refuted"])
    yield ""
    yield from class_notes(rows)


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
        return f"refuted for the class {text(wrong, 'class')}{also}{_begun(why(wrong))}"
    if verdict == "verified":
        return ""
    claimed = {text(row, "verdict") for row in own} & {*CLAIMED}
    return HOLD if claimed == {"verified"} else ""
