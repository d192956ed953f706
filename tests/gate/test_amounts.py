"""Amounts of memory."""

import pytest

from sdaeverify.errors import UsageError
from sdaeverify.gate.amounts import read_memory


@pytest.mark.parametrize(
    ("text", "size"),
    [("2G", 2 * 2**30), ("512M", 2**29), ("1.5 K", 1536), ("300", 300), ("1GiB", 2**30), ("2GB", 2**31)],
)
def test_amounts(text, size):
    """A number with a unit is a number of bytes, in powers of 1024."""
    assert read_memory("--memory", text) == size


@pytest.mark.parametrize("text", ["", "G", "-1G", "0", "1e3", "2 apples", "1.2.3M"])
def test_what_is_no_amount(text):
    """Anything else is an error that names the option."""
    with pytest.raises(UsageError, match="--memory expects an amount of memory"):
        read_memory("--memory", text)
