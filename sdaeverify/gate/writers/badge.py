"""A badge as shields.io reads it from an address: JSON with a label, a message and a colour."""

from ..gated import WORDS, Gated
from ..outcomes import ORDER, Status

GOOD, OPEN, BAD = "brightgreen", "yellow", "red"


def badge(gated: Gated) -> dict[str, object]:
    """Return a badge that is never green while a claim is undecided or expected to fail.

    Parameters
    ----------
    gated : Gated

    Returns
    -------
    dict
    """
    counts = gated.counts
    others = [f"{counts[s]} {WORDS[s]}" for s in ORDER if counts[s] and s is not Status.PASSED]
    message = f"verified {counts[Status.PASSED]}/{len(gated.outcomes)}"
    colour = BAD if gated.code else OPEN if others else GOOD
    return {"schemaVersion": 1, "label": "sdaeverify", "message": ", ".join([message, *others]), "color": colour}
