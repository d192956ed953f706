"""Names of a new plugin."""

from pathlib import Path

import pytest

from facade import names_of
from sdaeverify import UsageError


@pytest.mark.parametrize("given", ["my-schemes", "My_Schemes", "my.schemes", "MY--schemes"])
def test_spellings_of_one_name_are_normalised(given):
    """The distribution is in lower case with hyphens, the module the same with underscores."""
    assert names_of(Path(), given) == ("my-schemes", "my_schemes")


def test_name_is_the_last_part_of_the_folder(tmp_path):
    """Without a name, the folder has it, even where it is written in a roundabout way."""
    assert names_of(tmp_path / "sub" / ".." / "rodeo").distribution == "rodeo"


@pytest.mark.parametrize(
    "given",
    ["", "3body", "my schemes", "schémas", "-x-", "a/b", "x\n", "x'", "class", "SdaeVerify", "json", "x" * 61],
)
def test_names_that_cannot_be_are_refused(given):
    """What is no name of a distribution, or is one of Python's or ours, is refused in one line."""
    with pytest.raises(UsageError, match="cannot be the name of a plugin") as caught:
        names_of(Path(), given)

    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("given", ["sdaeverify-schemes", "sdaeverify-problems", "hypothesis"])
def test_names_of_installed_modules_are_refused(given):
    """A plugin must not come in the place of what is installed: the shipped schemes, or another package."""
    with pytest.raises(UsageError, match=r"a module \w+ is installed already"):
        names_of(Path(), given)


def test_a_bad_folder_hints_at_the_option():
    """Where the name is from the folder, the message says how to give another."""
    with pytest.raises(UsageError, match="choose another with --name"):
        names_of(Path("3body"))
