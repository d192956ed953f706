"""What a run came to in sentences, from the texts of its tables."""

from collections import Counter
from collections.abc import Iterable

WORDS = {"out_of_scope": "without a claim", "not_run": "not run", "error": "in error"}
# Always told first, then what else there is, worst first.
FIRST = ("verified", "refuted")
REST = ("diverged", "error", "inconclusive", "not_run", "out_of_scope")
ABSENT = "not_applicable"


def counts_in_words(verdicts: Iterable[str]) -> str:
    """Return in one sentence how many quantities got which verdict."""
    found = Counter(str(verdict) for verdict in verdicts)
    absent = found.pop(ABSENT, 0)
    order = (*FIRST, *(verdict for verdict in REST if verdict in found))
    parts = [f"{found[verdict] or 'none'} {WORDS.get(verdict, verdict)}" for verdict in order]
    total = found.total()
    tail = f"; {absent} cells do not apply" if absent else ""
    return f"{total} {'quantity' if total == 1 else 'quantities'}: {', '.join(parts)}{tail}"
