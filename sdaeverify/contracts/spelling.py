"""Suggestions of known names for mistyped ones, and plurals."""

from collections.abc import Iterable
from difflib import SequenceMatcher

# Longer words are not compared: they are not misspelt names, and comparison is slow.
LONGEST = 100


def did_you_mean(word: str, known: Iterable[str], prefix: str = "") -> str:
    """Return ``; did you mean a or b?`` with the closest known words, or an empty string.

    Parameters
    ----------
    word : str
        The unknown word.
    known : iterable of str
    prefix : str, optional
        Common prefix of all words, such as ``--``, ignored by the comparison.
    """
    if len(word) > LONGEST:
        return ""
    bare = word.removeprefix(prefix).lower()
    scores = {
        other: SequenceMatcher(None, bare, other.removeprefix(prefix).lower()).ratio() for other in sorted(known)
    }
    least = max(0.6, max(scores.values(), default=0.0) - 0.1)
    close = [other for other, score in scores.items() if score >= least]
    close = close or [other for other in scores if word and word.lower() in other.lower()]
    return f"; did you mean {' or '.join(close[:3])}?" if close else ""


def counted(number: int, word: str) -> str:
    """Return a number with its noun, such as ``1 cell`` and ``2 cells``."""
    return f"{number} {word}{'s' * (number != 1)}"
