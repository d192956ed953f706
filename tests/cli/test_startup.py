"""What a command imports: libraries and plugins that it needs, and no others."""

import json
import subprocess
import sys

import pytest

# Each takes longer to load than all that a list needs.
HEAVY = ("pandas", "scipy.linalg", "scipy.optimize", "scipy.sparse", "scipy.special", "scipy.stats")
LAB = ("sdaeverify_lab", "sdaeverify_papers", "sdaeverify_planted")
PROGRAM = """
import json, sys
from contextlib import redirect_stdout
from sdaeverify.cli.program import execute

with redirect_stdout(sys.stderr):
    execute(sys.argv[1:])
print(json.dumps(sorted(sys.modules)))
"""


def modules(*arguments: str) -> list[str]:
    """Return what a process has imported at the end of a command."""
    done = subprocess.run([sys.executable, "-c", PROGRAM, *arguments], check=True, capture_output=True, text=True)
    found: list[str] = json.loads(done.stdout)
    return found


@pytest.mark.parametrize("command", ["list", "info"])
def test_catalogue_needs_no_heavy_library(command: str) -> None:
    """Names and docstrings are shown without scipy's numerical parts, tables, or plugins that nobody asked for."""
    found = modules(command, *(["gbm"] if command == "info" else []))

    assert "sdaeverify_schemes.euler_maruyama" in found
    assert [name for name in found if name.startswith((*HEAVY, *LAB))] == []


def test_lab_is_loaded_when_asked_for() -> None:
    """Planted bugs are found where somebody asks for one of their plugins by name."""
    assert "sdaeverify_planted.higher_orders" in modules("info", "sdaeverify-planted.higher_orders")
