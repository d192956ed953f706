"""An executable that makes one step a call: the plugin of the page, and its program."""

import csv
import shutil
import subprocess
import sys

import pytest

from wire import one_call
from wire.compiling import built_c


@pytest.mark.long
def test_executable_of_one_step_is_verified(tmp_path):
    """Its claim is verified on gbm, by a process for each step."""
    built_c(tmp_path, "one_call")
    shutil.copy(one_call.__file__, tmp_path)
    given = ["-s", "one-call", "-p", "gbm", "-m", "strong", "--paths", "512", "--out", "run"]
    command = [sys.executable, "-m", "sdaeverify", "matrix", "--plugin", "one_call.py", *given]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)

    assert done.returncode == 0, done.stderr
    with (tmp_path / "run" / "verdicts.csv").open() as file:
        assert {row["verdict"] for row in csv.DictReader(file)} == {"verified"}
