"""Amounts of memory."""

import subprocess
import sys

import pytest

from facade import read_memory
from sdaeverify import UsageError

pytestmark = pytest.mark.long


@pytest.mark.parametrize(
    ("text", "size"),
    [
        ("2G", 2 * 2**30),
        ("512M", 2**29),
        ("524288.5 K", 2**29 + 512),
        ("1GiB", 2**30),
    ],
)
def test_amounts(text, size):
    """A number with a unit is a number of bytes, in powers of 1024."""
    assert read_memory("--memory", text) == size


@pytest.mark.parametrize("text", ["", "G", "-1G", "0", "1e3", "2 apples", "1.2.3M"])
def test_what_is_no_amount(text):
    """Anything else is an error that names the option."""
    with pytest.raises(UsageError, match="--memory expects an amount of memory"):
        read_memory("--memory", text)


@pytest.mark.parametrize("text", ["1", "100K", "255.9M", "0.2G"])
def test_less_than_a_worker_needs(text):
    """A worker that could not even load its libraries is refused before anything is run, with the bound."""
    with pytest.raises(UsageError, match=r"^--memory expects at least 256M, .*, got '") as found:
        read_memory("--memory", text)

    assert repr(text) in str(found.value)


def test_what_a_worker_needs_is_enough(tmp_path):
    """At the bound a problem and its controls are simulated."""
    words = ["-m", "sdaeverify", "matrix", "-s", "milstein", "-p", "gbm", "-m", "strong,weak", "--progress", "none"]
    budget = ["--paths", "80", "--block", "40", "--levels", "8..32", "-j", "1", "--memory", "256M"]

    ended = subprocess.run(
        [sys.executable, *words, *budget], capture_output=True, text=True, check=False, cwd=tmp_path
    )

    assert (ended.returncode, ended.stderr) == (0, "")
