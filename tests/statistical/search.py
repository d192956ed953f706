"""Run random sets one after the other and note each: `python tests/statistical/search.py sets.jsonl 0-999`.

A line a set: its number, seconds, problem and scheme, how often each verdict came, and the rows that are refuted or
in error. Sets that are in the file already are not run again, so that a search goes on where it was ended. Blocks of
paths have ten minutes, so that a slow or busy machine changes no verdict. What a number means depends on which
problems are shipped: with another list of them a file is begun anew.

At the end it counts the verdicts, and its exit code is 1 if a claim is refuted.
"""

import json
import sys
import time
from collections import Counter
from collections.abc import Iterator, Sequence
from concurrent.futures import Executor
from pathlib import Path
from typing import Any

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
    known = {line["number"] for line in lines_of(log)}
    with watched(TIMEOUT) as executor, log.open("a") as out:
        for number in (number for number in numbers if number not in known):
            print(json.dumps(noted(number, executor), default=str), file=out, flush=True)


def lines_of(log: Path) -> list[dict[str, Any]]:
    """Return what is noted in a file, nothing where there is none."""
    return [json.loads(line) for line in log.read_text().splitlines()] if log.exists() else []


def summary(log: Path) -> tuple[str, bool]:
    """Return what a file comes to in one line, and whether a claim is refuted."""
    lines, counts = lines_of(log), Counter[str]()
    for line in lines:
        counts.update(line["counts"])
    words = ", ".join(f"{count} {verdict}" for verdict, count in counts.most_common())
    return f"{len(lines)} sets in {sum(line['seconds'] for line in lines):.0f} s: {words}", counts["refuted"] > 0


def numbers(ranges: Sequence[str]) -> Iterator[int]:
    """Yield the numbers of ranges such as ``0-99`` and of single numbers."""
    for text in ranges:
        first, _, last = text.partition("-")
        yield from range(int(first), int(last or first) + 1)


def main(log: Path, ranges: Sequence[str]) -> int:
    """Run the sets, print what they come to and return the exit code."""
    search(log, list(numbers(ranges)))
    text, refuted = summary(log)
    print(text)
    return int(refuted)


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1]), sys.argv[2:]))
