"""Results in words and tables for a terminal."""

import re

import pytest
from rich.console import Console

from facade import (
    Cell,
    CellResult,
    _classify,
    load_registry,
    select_measures,
    select_problems,
    select_schemes,
    visible,
)
from sdaeverify.measuring import Finding, Reason, Verdict
from sdaeverify.report.terminal import break_label, counts, drifts, summary_tables, windows


@pytest.fixture(scope="module")
def cell():
    """Return a cell by the names of its scheme, problem and measure."""
    registry = load_registry()

    def make(scheme: str, problem: str, measure: str = "drift", view: str = "") -> Cell:
        (one,), (spec,), (question,) = (
            select_schemes(registry, scheme),
            select_problems(registry, problem),
            select_measures(registry, measure),
        )
        return Cell(one, spec, question, view)

    return make


def finding(quantity: str, verdict: Verdict, reason: str = "", **details: object) -> Finding:
    return Finding(quantity=quantity, verdict=verdict, reason=Reason(reason), estimate=0.99, details=details)


def printed(tables: list[object], width: int) -> list[str]:
    console = Console(width=width, color_system=None)
    with console.capture() as capture:
        for table in tables:
            console.print(table)
    return capture.get().splitlines()


@pytest.mark.parametrize("width", [60, 80, 200])
def test_table_never_exceeds_the_width(cell, width):
    """However many problems there are, the table is cut into pieces that fit, and no cell is lost."""
    problems = ["gbm", "ou", "pendulum-velocity-noise", *(f"pendulum[c_g={i}.25,theta_0=0.125]" for i in range(9))]
    results = [
        CellResult(cell(scheme, problem, "strong"), (finding("x", verdict),))
        for problem in problems
        for scheme, verdict in [
            ("milstein", Verdict.VERIFIED),
            ("half-explicit-euler[truncation=none]", Verdict.REFUTED),
        ]
    ]

    lines = printed(summary_tables(results, width), width)

    assert max(map(len, lines)) <= width
    text = "\n".join(lines)
    assert text.count("strong ✓1") == len(problems)
    assert text.count("strong ✗1") == len(problems)


def test_worst_verdict_comes_first(cell):
    """A cell counts its verdicts, the worst first, and a measure that does not apply is left out."""
    order = [Verdict.VERIFIED, Verdict.VERIFIED, Verdict.INCONCLUSIVE, Verdict.REFUTED]
    results = [
        CellResult(cell("milstein", "gbm", "strong"), tuple(finding(str(i), v) for i, v in enumerate(order))),
        CellResult(cell("milstein", "gbm", "drift"), (finding("", Verdict.NOT_APPLICABLE),)),
        CellResult(cell("euler-maruyama", "gbm", "drift"), (finding("", Verdict.NOT_APPLICABLE),)),
    ]

    *_, euler, milstein = printed(summary_tables(results, 80), 80)

    assert milstein.split() == ["milstein", "strong", "✗1", "?1", "✓2"]
    assert euler.split() == ["euler-maruyama", "·"]
    *_, milstein = printed(summary_tables(results, 80, plain=True), 80)
    assert milstein.split() == ["milstein", "strong", "X1", "?1", "v2"]


@pytest.mark.parametrize(
    ("slope", "sup", "words"),
    [
        (0.99, 1.0, "euler-maruyama drifts off g on pendulum (inherent SDE) at order 0.99 in h"),
        (-0.5, 1.0, "euler-maruyama drifts off g on pendulum (inherent SDE), the more the smaller h is"),
        (0.0, 1e-6, "euler-maruyama keeps g on pendulum (inherent SDE) to a tolerance only"),
        (0.0, 1.0, "euler-maruyama drifts off g on pendulum (inherent SDE) by as much at every h"),
    ],
)
def test_drift_in_words(cell, slope, sup, words):
    """Every class of drift but round-off has its sentence."""
    where = cell("euler-maruyama", "pendulum", view="inherent SDE")
    kind = {"class": _classify(slope, sup, 1.0)}

    assert drifts([CellResult(where, (finding("g", Verdict.VERIFIED, **kind),))]) == [words]
    assert drifts([CellResult(where, (finding("g", Verdict.VERIFIED, **{"class": "round-off"}),))]) == []


def test_two_constraints_in_one_sentence(cell):
    """Orders of several constraints are told together."""
    both = tuple(finding(name, Verdict.VERIFIED, **{"class": "order 0.99"}) for name in ("g", "Dg v"))

    (line,) = drifts([CellResult(cell("euler-maruyama", "pendulum"), both)])

    assert line == "euler-maruyama drifts off g and Dg v on pendulum at order 0.99 and 0.99 in h"


def test_counts(cell):
    """The counts are one sentence that always says how many are verified and refuted."""
    some = tuple(finding(str(v), v) for v in (Verdict.VERIFIED, Verdict.INCONCLUSIVE, Verdict.OUT_OF_SCOPE))
    none = (finding("", Verdict.NOT_APPLICABLE),)
    results = [CellResult(cell("milstein", "gbm"), some), CellResult(cell("milstein", "ou"), none)]

    expected = "3 quantities: 1 verified, none refuted, 1 inconclusive, 1 without a claim; 1 cells do not apply"
    assert counts(results) == expected


def test_control_characters_become_visible():
    """No text of a plugin can move the cursor or hide what it says."""
    assert visible("a\x1b[31m\n\u202eb\udc80é") == "a\\x1b[31m\\n\\u202eb\\udc80é"


@pytest.mark.parametrize("width", [8, 12, 20, 60])
def test_labels_are_broken_at_their_joints(width):
    """A label is broken after hyphens and commas and before brackets, and stays whole where there is room."""
    label = "half-explicit-euler[truncation=none,no_root=hold]"
    lines = break_label(label, width).plain.split("\n")

    assert "".join(lines) == label
    assert all(len(line) <= width or len(re.split(r"(?<=[-,])|(?=\[)", line.rstrip("-,"))) <= 2 for line in lines)
    assert break_label(label, 60).plain == label


def test_windows_in_words(cell):
    """Of every finding that has them, with a claim or without."""
    where = cell("stochastic-theta", "linear-test")
    stable = finding("second moment", Verdict.OUT_OF_SCOPE, windows="h < 0.5", growth_rate=-1.25)
    line = "stochastic-theta on linear-test, second moment: stable windows h < 0.5; growth rate of the equation -1.25"
    assert windows([CellResult(where, (stable, finding("x", Verdict.VERIFIED)))]) == [line]
