"""What the program loads to list what is registered: its time is that of its imports."""

import subprocess
import sys

UNUSED = {"pandas", "matplotlib", "pytest"}
PROGRAM = """
import sys
from sdaeverify.cli.program import conclude
conclude(["list"])
print(*sys.modules, sep="\\n", file=sys.stderr)
"""


def test_a_list_loads_what_it_tells_of_and_no_more():
    """Neither what tables and pictures are made with nor parts of scipy are loaded."""
    outcome = subprocess.run([sys.executable, "-c", PROGRAM], capture_output=True, text=True, check=True)
    loaded = set(outcome.stderr.split())

    assert not UNUSED & loaded
    assert not {f"scipy.{part}" for part in ("linalg", "optimize", "special", "stats")} & loaded
