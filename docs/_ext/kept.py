"""What long commands came to, read from the results that are kept in `reports`: pieces that pages include."""

import csv
import json
from collections import Counter, defaultdict
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from markup import table

from sdaeverify.report.folders import read_verdicts

Row = Mapping[str, str]
# Cells whose orders are told: schemes of every order on an equation with a known solution, and a constrained one.
ORDERS = ("gbm", "pendulum")
PATHS = 400.0
COMPARED = ("printed_and_value", "value_and_expected", "printed_and_exact")


NOT_KEPT = "Not kept of this version: `python reports/measure.py {}` does it.\n"


def kept_pages(reports: Path) -> dict[str, str]:
    """Return the pieces by name."""
    known = json.loads((reports / "measured.json").read_text())
    rates = list(csv.DictReader((reports / "calibration" / "calibration.csv").read_text().splitlines()))
    verdicts = list(read_verdicts(reports / "reference").verdicts)
    sets = [json.loads(line) for line in (reports / "random-sets" / "sets.jsonl").read_text().splitlines()]
    wrong = list(csv.DictReader((reports / "wrong-schemes" / "schemes.csv").read_text().splitlines()))
    return {
        "pieces/costs.md": _costs(known),
        "pieces/gates.md": _gates(known),
        "pieces/selftest.md": _selftest(known),
        "pieces/ratios.md": _ratios(known),
        "pieces/orders.md": _orders(verdicts),
        "pieces/random-sets.md": _random_sets(sets),
        "pieces/wrong-schemes.md": _wrong_schemes(wrong),
        "pieces/calibration.md": _calibration(rates),
        "pieces/guards.md": _guards(
            list(csv.DictReader((reports / "guards" / "guards.csv").read_text().splitlines()))
        ),
        "pieces/papers.md": _papers(sorted((reports / "papers").glob("*/table.csv"))),
    }


def _costs(known: Mapping[str, Any]) -> str:
    """Return what each command took."""
    heads = ["command", "CPU time", "in units", "elapsed time", "cores", "exit code", "date"]
    return table(
        heads,
        (
            [
                f"`{run['command']}`",
                f"{run['cpu_seconds']:.0f} s",
                f"{run['cpu_seconds'] / run['unit_seconds']:.0f}" if "unit_seconds" in run else "",
                f"{run['wall_seconds']:.0f} s",
                str(run["cores"]),
                str(run["exit_code"]),
                run["date"],
            ]
            for run in known.values()
        ),
    )


def _guards(rows: Iterable[Row]) -> str:
    """Return the guards of verdicts with what becomes of their cells without them."""
    heads = ["guard", "bars", "tier", "because", "what would decide", "cell", "with all guards", "without this one"]
    names = ("guard", "bars", "tier", "reason", "remedy", "planted", "with", "without")
    return table(heads, ([row[name] for name in names] for row in rows))


def _gates(known: Mapping[str, Any]) -> str:
    """Return the number of claims by outcome, a line for each tier."""
    gates = {name: run["counts"] for name, run in known.items() if name.startswith("gate")}
    outcomes = sorted({outcome for counts in gates.values() for outcome in counts})
    return table(
        ["command", "claims", *outcomes],
        (
            [
                f"`{known[name]['command']}`",
                str(sum(counts.values())),
                *(str(counts.get(outcome, 0)) for outcome in outcomes),
            ]
            for name, counts in gates.items()
        ),
    )


def _selftest(known: Mapping[str, Any]) -> str:
    """Return its sentence."""
    return f"{known['selftest']['said']}.\n" if "selftest" in known else NOT_KEPT.format("selftest")


def _ratios(known: Mapping[str, Any]) -> str:
    """Return the ratios of the benchmarks beside their goals."""
    if "benchmarks" not in known:
        return NOT_KEPT.format("benchmarks")
    told = known["benchmarks"]["ratios"]
    return table(["what", "ratio", "goal"], ([each["what"], f"{each['ratio']:.3g}", each["goal"]] for each in told))


def _orders(rows: Iterable[Row]) -> str:
    """Return claimed, local and sampled strong orders of the full state, and of the multipliers."""
    chosen = [
        row
        for row in rows
        if row["problem"] in ORDERS and row["measure"] == "strong" and row["quantity"] in {"state", "x", "mu"}
        if row["claim"] and row["local_order"]
    ]
    lines = (
        [
            f"`{row['scheme']}`",
            f"`{row['problem']}`",
            f"`{row['quantity']}`",
            row["claim"],
            _rounded(row["local_order"]),
            _interval(row),
            row["verdict"],
        ]
        for row in sorted(chosen, key=lambda row: (row["problem"], row["scheme"], row["quantity"]))
    )
    return table(["scheme", "problem", "quantity", "claim", "local order", "order along paths", "verdict"], lines)


def _interval(row: Row) -> str:
    if not row["path_order"]:
        return ""
    return f"{_rounded(row['path_order'])} [{_rounded(row['path_low'])}, {_rounded(row['path_high'])}]"


def _rounded(number: str) -> str:
    return f"{float(number):.3f}" if number else ""


def _random_sets(sets: Iterable[Mapping[str, Any]]) -> str:
    """Return the number of sets, of those about which something is claimed, and of findings by verdict."""
    sets = list(sets)
    found = Counter()
    for each in sets:
        found.update(each["counts"])
    decided = {verdict: n for verdict, n in found.items() if verdict not in {"out_of_scope", "not_applicable"}}
    claimed = sum(bool(set(each["counts"]) & set(decided)) for each in sets)
    verdicts = sorted({*decided, "refuted"})
    return table(
        ["sets", "with a claim", *(f"claims {verdict}" for verdict in verdicts)],
        [[str(len(sets)), str(claimed), *(str(decided.get(verdict, 0)) for verdict in verdicts)]],
    )


def _wrong_schemes(lines: Iterable[Row]) -> str:
    """Return the number of wrong schemes and of their claims, and what these come to, measure by measure."""
    lines = list(lines)
    outcomes = sorted({line["outcome"] for line in lines})
    found = Counter((line["measure"], line["outcome"]) for line in lines)
    return table(
        ["measure", "schemes", "claims", *outcomes],
        [
            [
                measure,
                str(len({line["number"] for line in lines if line["measure"] == measure})),
                str(sum(line["measure"] == measure for line in lines)),
                *(str(found[measure, outcome]) for outcome in outcomes),
            ]
            for measure in sorted({line["measure"] for line in lines})
        ],
    )


def _papers(tables: Iterable[Path]) -> str:
    """Return for each experiment how many of its numbers agree with what is printed, expected and exact."""
    lines = [
        [f"`{path.parent.name}`", *_agreement(list(csv.DictReader(path.read_text().splitlines())))] for path in tables
    ]
    heads = [
        "experiment",
        "numbers",
        "ours and the print",
        "ours and what is expected",
        "the print and the exact number",
    ]
    return (
        table(heads, lines) if lines else "No tables are kept of this version: the commands of the page print them.\n"
    )


def _agreement(rows: list[Row]) -> list[str]:
    found = [Counter(row[name] for row in rows if row.get(name)) for name in COMPARED]
    return [str(len(rows)), *(", ".join(f"{n} {word}" for word, n in sorted(each.items())) for each in found)]


def _calibration(rates: Iterable[Row]) -> str:
    """Return the lowest and the highest rate of each statistic over its cells, and what is promised."""
    found = defaultdict(list)
    for rate in rates:
        if rate["study"] != "slope" or float(rate["paths"]) == PATHS:
            study = f"slope, {PATHS:.0f} paths" if rate["study"] == "slope" else rate["study"]
            found[study, rate["statistic"], rate["promised"]].append(rate)
    lines = (
        [
            study,
            statistic,
            str(len(cells)),
            _range([float(cell["rate"]) for cell in cells]),
            promised,
            "all" if all(cell["agrees"] == "True" for cell in cells) else "not all",
        ]
        for (study, statistic, promised), cells in sorted(found.items())
    )
    return table(["study", "statistic", "cells", "rates", "promised", "agree"], lines)


def _range(rates: list[float]) -> str:
    low, high = f"{min(rates):.3f}", f"{max(rates):.3f}"
    return low if low == high else f"{low} to {high}"
