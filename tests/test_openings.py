"""Audit hooks: a process records opened files only if it simulates for a store of evidence."""

import subprocess
import sys
from pathlib import Path

import pytest

from facade import Limits, executor_for, opened_by

REFUSE = "import sys; sys.addaudithook = lambda hook: sys.exit('an audit hook')"
AT_EXIT = """
import atexit, os
from sdaeverify.contracts.opened import openings
openings()
class Late:
    def __del__(self, open=open, name=os.devnull):
        open(name).close()
import builtins
builtins.late = Late()
"""
READING = """
from pathlib import Path
TABLE = (Path(__file__).parent / "table.txt").read_text()
"""


def python(code):
    """Run a program in an interpreter of its own."""
    return subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)


def test_importing_the_package_installs_no_hook():
    """Reading a form, a scheme or the command's options leaves the process of the user as it is."""
    done = python(f"{REFUSE}; import sdaeverify; sdaeverify.SDE, sdaeverify.Scheme, sdaeverify.verify")
    assert (done.returncode, done.stderr) == (0, "")


def test_a_hook_is_silent_when_the_interpreter_ends():
    """A file that is opened after the names of the module are gone raises nothing in the code that opens it."""
    done = python(AT_EXIT)
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.long
def test_a_worker_records_what_a_plugin_opens_as_it_is_loaded(tmp_path):
    """The hook of a worker is installed before its plugins are."""
    plugin, table = tmp_path / "reading.py", tmp_path / "table.txt"
    plugin.write_text(READING)
    table.write_text("1.0")
    with executor_for(1, (str(plugin),), Limits()) as workers:
        assert workers is not None
        (found,) = workers.submit(opened_by, [Path(plugin)]).result()
    assert found[0].endswith("table.txt")
