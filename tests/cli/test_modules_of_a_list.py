"""What the program loads to list what is registered: its time is that of its imports."""

import subprocess
import sys

UNUSED = {"pandas", "matplotlib", "multiprocessing", "sdaeverify.gate", "sdaeverify.store", "sdaeverify.study"}
# Those of the framework: measures and what they probe with, forms, contracts and the command itself.
MOST = 190
PROGRAM = """
import sys
from sdaeverify.cli.program import conclude
conclude(["list"])
print(*sys.modules, sep="\\n", file=sys.stderr)
"""


def test_a_list_loads_what_it_tells_of_and_no_more():
    """Neither tables nor studies nor parts of scipy are loaded, and few modules of the framework."""
    outcome = subprocess.run([sys.executable, "-c", PROGRAM], capture_output=True, text=True, check=True)
    loaded = set(outcome.stderr.split())

    assert not UNUSED & loaded
    assert not {f"scipy.{part}" for part in ("linalg", "optimize", "special", "stats")} & loaded
    assert len([name for name in loaded if name.partition(".")[0] == "sdaeverify"]) <= MOST
