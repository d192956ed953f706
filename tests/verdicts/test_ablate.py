"""The program that takes guards out."""

import runpy
from pathlib import Path

PROGRAM = Path(__file__).parents[2] / "reports" / "ablate.py"


def test_an_unknown_guard_costs_a_line(capsys):
    """A misspelt name ends with 2 and the known names, and no cell is judged."""
    main = runpy.run_path(str(PROGRAM))["main"]

    assert main(["of_smooth", "hold back"]) == 2
    told = capsys.readouterr()
    assert told.out == ""
    assert told.err.startswith("unknown guard of_smooth (known: of smooth, of law,")
