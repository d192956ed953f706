"""Take each guard of verdicts out in turn, and judge its planted cell again.

    python reports/ablate.py [NAME ...]

Writes `reports/guards/guards.csv`: a row a guard, with the verdicts of its cell in `tests/guard_cells.py` with all
guards and without this one. Ends with 1 if a guard changes nothing there, with 2 if a name is unknown.
"""

import csv
import sys
import warnings
from collections.abc import Iterator, Mapping
from pathlib import Path

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT / "tests"))

from ablation import without  # noqa: E402
from guard_cells import CELLS  # noqa: E402
from sdaeverify.contracts.finding import Verdict, tier_name  # noqa: E402
from sdaeverify.verdicts.guard import Guard  # noqa: E402
from sdaeverify.verdicts.guards import GUARDS  # noqa: E402

TABLE = ROOT / "reports" / "guards" / "guards.csv"
COLUMNS = ("guard", "bars", "tier", "reason", "remedy", "planted", "wrong", "with", "without")


def count(verdicts: Mapping[str, Verdict]) -> str:
    """Return how many quantities have which verdict."""
    found = list(verdicts.values())
    return ", ".join(f"{found.count(each)} {each}" for each in dict.fromkeys(sorted(found)))


def row(guard: Guard) -> dict[str, str]:
    """Return the row of a guard."""
    known = {
        "guard": guard.name,
        "bars": " and ".join(sorted(map(str, guard.bars))),
        "tier": "any" if guard.tier is None else tier_name(guard.tier),
        "reason": guard.reason,
        "remedy": guard.remedy,
        "planted": guard.planted,
    }
    if not guard.planted:
        return known
    cell = CELLS[guard.planted]
    guarded = cell.verdicts()
    with without(guard):
        open_ = cell.verdicts()
    return {**known, "wrong": str(cell.wrong), "with": count(guarded), "without": count(open_)}


def is_needed(found: Mapping[str, str]) -> bool:
    """Return whether more claims of the cell have the wrong verdict without the guard."""
    judged, open_ = (dict(_pairs(found[name])) for name in ("with", "without"))
    return open_.get(found["wrong"], 0) > judged.get(found["wrong"], 0)


def _pairs(text: str) -> Iterator[tuple[str, int]]:
    for part in filter(None, text.split(", ")):
        number, verdict = part.split(" ")
        yield verdict, int(number)


def main(names: list[str]) -> int:
    """Write the table of some guards, or of all."""
    known = [guard.name for guard in GUARDS]
    if unknown := [name for name in names if name not in known]:
        print(f"unknown guard {', '.join(unknown)} (known: {', '.join(known)})", file=sys.stderr)
        return 2
    warnings.simplefilter("ignore")
    rows = []
    for guard in GUARDS:
        if not names or guard.name in names:
            rows.append(found := row(guard))
            said = "no planted cell" if not guard.planted else "" if is_needed(found) else "CHANGES NOTHING"
            print(f"{guard.name}: {found.get('with', '')} -> {found.get('without', '')} {said}", flush=True)
    if not names:
        TABLE.parent.mkdir(exist_ok=True)
        with TABLE.open("w", newline="", encoding="utf-8") as file:
            table = csv.DictWriter(file, COLUMNS, restval="", lineterminator="\n")
            table.writeheader()
            table.writerows(rows)
    return int(any(each["planted"] and not is_needed(each) for each in rows))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
