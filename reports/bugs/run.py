"""Public bug reports: judges the faulty and the mended scheme of each as ``matrix`` does.

``python reports/bugs/run.py [NAME ...]`` writes ``reports.csv`` and the table of ``README.md``; with names, these
reports are judged anew, others are kept. It ends with 1 if a faulty scheme is verified or a mended one refuted.
"""

import argparse
import csv
import importlib
import sys
import time
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import sdaeverify
from sdaeverify import Scheme

HERE = Path(__file__).resolve().parent
PAIRS, TABLE = HERE / "pairs", HERE / "reports.csv"
PATHS = 1024
MODULES = tuple(sorted(path.stem for path in PAIRS.glob("[a-z]*.py")))
CLAIMED = "verified", "refuted", "inconclusive", "error", "undecided"
BEGIN, END = "<!-- reports: written by run.py -->", "<!-- end of reports -->"
sys.path.insert(0, str(PAIRS))
if TYPE_CHECKING:
    from _report import Report


class Judged(NamedTuple):
    """What `verify` says about all claims of a scheme, on problems and for classes of equations.

    Attributes
    ----------
    verdict : str
        ``refuted`` if a claim is; ``verified`` if all claims are; else ``undecided``.
    counts : str
    reasons : tuple of str
        Of the claims that are refuted.
    seconds : float
        CPU time, without the start of Python.
    """

    verdict: str
    counts: str
    reasons: tuple[str, ...]
    seconds: float


def reports(names: Sequence[str] = ()) -> Iterator["Report"]:
    """Yield each report, or those that are named."""
    for module in MODULES:
        for report in importlib.import_module(module).REPORTS:
            if not names or report.name in names:
                yield report


def judge(scheme: Scheme, problems: str) -> Judged:
    """Return the verdict of `verify`, which is ``matrix`` without its start, on a scheme."""
    before = time.process_time()
    result = sdaeverify.verify([scheme], problems.split(","), paths=PATHS)
    tables = result.verdicts, result.classes
    rows = [row for table in tables for row in table.astype(object).where(table.notna(), "").to_dict("records")]
    return judged_by(rows, time.process_time() - before)


def judged_by(rows: Iterable[Mapping[str, Any]], seconds: float) -> Judged:
    """Return the verdict that rows of verdicts and of classes amount to."""
    # Where a premise of order conditions fails, they say nothing of a claim.
    said = (row for row in rows if not ("class" in row and row["verdict"] == "inconclusive"))
    claimed = [row for row in said if row["claim"] and row["verdict"] in CLAIMED]
    counts = {kind: sum(row["verdict"] == kind for row in claimed) for kind in CLAIMED}
    refuting = [row for row in claimed if row["verdict"] == "refuted"]
    whole = claimed and counts["verified"] == len(claimed)
    verdict = "refuted" if refuting else "verified" if whole else "undecided"
    told = ", ".join(f"{number} {kind}" for kind, number in counts.items() if number)
    return Judged(verdict, told, tuple(_reason(row) for row in refuting), seconds)


def _reason(row: Mapping[str, Any]) -> str:
    if "class" in row and not row["first"]:
        return f"{row['class']}: {row['premise']}"
    if "class" in row:
        return f"{row['class']}: {row['first']} found {row['found']}, wanted {row['wanted']}"
    return f"{row['problem']}: {row['reason']}"


def _rows(path: Path) -> list[dict[str, str]]:
    if not path.exists():
        return []
    with path.open(newline="") as file:
        return list(csv.DictReader(file))


def row_of(report: "Report") -> dict[str, str]:
    """Judge both schemes of a report and return its row of the table."""
    faulty, mended = (judge(report.scheme(mended=each), report.problems) for each in (False, True))
    pointing = [reason for reason in faulty.reasons if any(clue in reason for clue in report.clues)]
    return {
        "name": report.name,
        "report": report.url,
        "mistake": report.mistake,
        "problems": report.problems,
        "faulty": faulty.verdict,
        "mended": mended.verdict,
        "points_at_it": "yes" if pointing else "no",
        "reason": (pointing or [*faulty.reasons, ""])[0],
        "faulty_claims": faulty.counts,
        "mended_claims": mended.counts,
        "faulty_cpu_s": f"{faulty.seconds:.1f}",
        "mended_cpu_s": f"{mended.seconds:.1f}",
        "mended_refuted_by": (*mended.reasons, "")[0],
    }


def table_of(rows: Sequence[Mapping[str, str]]) -> list[str]:
    """Return the lines of the table of README.md."""
    lines = [
        "| report | mistake | faulty | mended | CPU s | does a reason point at it |",
        "|---|---|---|---|---|---|",
    ]
    for row in rows:
        shown = row["reason"].replace("|", "\\|")
        cut = shown if len(shown) <= 160 else f"{shown[:157]}..."
        cells = f"[{row['name']}]({row['report']})", row["mistake"], row["faulty"], row["mended"]
        lines.append(
            f"| {' | '.join(cells)} | {row['faulty_cpu_s']} / {row['mended_cpu_s']} | {row['points_at_it']}: {cut} |"
        )
    return lines


def write(rows: Sequence[Mapping[str, str]]) -> None:
    """Write reports.csv and the table of README.md."""
    with TABLE.open("w", newline="") as file:
        writer = csv.DictWriter(file, list(rows[0]), lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
    page = HERE / "README.md"
    before, rest = page.read_text().split(BEGIN)
    lines = [BEGIN, "", *table_of(rows), "", END]
    page.write_text(before + "\n".join(lines) + rest.split(END)[1])


def main() -> int:
    """Judge what is asked for and return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("names", nargs="*", help="reports that are judged anew; all if left out")
    names = parser.parse_args().names
    kept = {row["name"]: row for row in (_rows(TABLE) if names else [])}
    for report in reports(names):
        kept[report.name] = row = row_of(report)
        print(f"{row['name']}: faulty {row['faulty']}, mended {row['mended']}, points at it: {row['points_at_it']}")
    order = [report.name for report in reports()]
    rows = [kept[name] for name in order if name in kept]
    write(rows)
    wrong = [row["name"] for row in rows if row["faulty"] == "verified" or row["mended"] == "refuted"]
    print(f"{len(rows)} reports, wrong verdicts: {', '.join(wrong) or 'none'}")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
