"""Run random sets one after the other and note each: `python tests/statistical/search.py sets.jsonl 0-999`.

A line a set: its number, seconds, problem and scheme, how often each verdict came, and the rows that are refuted or
in error. Sets that are in the file already are not run again. Blocks of paths have ten minutes, so that a slow or
busy machine changes no verdict.
"""

import json
import sys
import time
from collections.abc import Iterator, Sequence
from concurrent.futures import Executor
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))

from statistical.random_problems import drawn, verdicts, watched

TIMEOUT = 600.0
WRONG = ["refuted", "error"]
KEPT = ["scheme", "problem", "measure", "quantity", "verdict", "reason", "reproduce"]


def noted(number: int, executor: Executor) -> dict[str, object]:
    """Return what is noted of a set."""
    begun, chosen = time.monotonic(), drawn(number)
    table = verdicts(chosen, executor)
    return {
        "number": number,
        "seconds": round(time.monotonic() - begun, 1),
        "problem": chosen.problem.label,
        "schemes": chosen.schemes,
        "counts": table.verdict.value_counts().to_dict(),
        "wrong": table.loc[table.verdict.isin(WRONG), KEPT].to_dict("records"),
    }


def search(log: Path, numbers: Sequence[int]) -> None:
    """Run the sets that are not in the file, and append them."""
    known = {json.loads(line)["number"] for line in log.read_text().splitlines()} if log.exists() else set()
    with watched(TIMEOUT) as executor, log.open("a") as out:
        for number in (number for number in numbers if number not in known):
            print(json.dumps(noted(number, executor), default=str), file=out, flush=True)


def _numbers(ranges: Sequence[str]) -> Iterator[int]:
    for text in ranges:
        first, _, last = text.partition("-")
        yield from range(int(first), int(last or first) + 1)


if __name__ == "__main__":
    search(Path(sys.argv[1]), list(_numbers(sys.argv[2:])))
