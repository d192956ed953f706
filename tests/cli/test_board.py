"""The table on a terminal that fills while a run is under way."""

import pytest
from rich.console import Console

from sdaeverify.contracts.finding import Finding, Verdict
from sdaeverify.registry.load import load_registry
from sdaeverify.registry.selection import select_measures, select_problems, select_schemes
from sdaeverify.report.progress import Board
from sdaeverify.study import Advanced, Cell, CellResult, Finished, Screened

SCHEMES = "euler-maruyama,heun,milstein"


@pytest.fixture(scope="module")
def cells():
    """Return a cell for each of three schemes on a problem."""
    registry = load_registry()
    (spec,), (measure,) = select_problems(registry, "gbm"), select_measures(registry, "strong")
    return [Cell(scheme, spec, measure) for scheme in select_schemes(registry, SCHEMES)]


def results(cells, *verdicts):
    """Return what is found of the first cells."""
    return tuple(
        CellResult(cell, tuple(Finding(quantity=str(n), verdict=verdict) for n, verdict in enumerate(found)))
        for cell, found in zip(cells, verdicts, strict=False)
    )


def lines(board, width=80, most=20):
    """Return the table as it is printed."""
    console = Console(width=width, color_system=None)
    with console.capture() as capture:
        console.print(board.table(most))
    return capture.get().splitlines()


def test_it_fills_with_what_needs_no_paths_and_then_with_what_paths_add(cells):
    """A mark for each scheme, the worst of its verdicts; dots where paths are still to be drawn."""
    board = Board()
    board.hear(Advanced(0, 9, "gbm"))
    first = results(cells, (Verdict.VERIFIED,))
    board.hear(Finished(results(cells[1:], (Verdict.VERIFIED,))))
    board.hear(Finished(results(cells, *[(Verdict.OUT_OF_SCOPE,)] * 3)))
    assert lines(board)[-1].split() == ["gbm", "○○○"]
    board.hear(Screened("ou", tuple, 5))
    assert lines(board)[-1].split() == ["ou", "………", "5"]
    board.hear(Screened("gbm", lambda: first, 2))
    assert lines(board)[-1].split() == ["gbm", "✓", "2"]
    board.hear(Finished(results(cells, (Verdict.VERIFIED, Verdict.REFUTED), (Verdict.VERIFIED,), (Verdict.ERROR,))))
    assert lines(board)[-1].split() == ["gbm", "✗✓!"]


@pytest.mark.parametrize("width", [60, 80, 200])
def test_it_is_as_wide_and_as_high_as_the_terminal_allows(cells, width):
    """Problems that were heard of last stay; no line is wider than the terminal."""
    board = Board()
    for number in range(30):
        board.worst[f"problem-{number}"] = dict.fromkeys((f"s{n}" for n in range(60)), "verified")
        board.waiting[f"problem-{number}"] = 0
    shown = lines(board, width, most=4)
    assert max(map(len, shown)) <= width
    assert [line.split()[0] for line in shown if line.startswith("problem-")] == [
        f"problem-{n}" for n in range(26, 30)
    ]
