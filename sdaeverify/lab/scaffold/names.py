"""The names of a new plugin: of its distribution, its module, its scheme and its problem."""

import keyword
import os
import re
import sys
from importlib.util import find_spec
from pathlib import Path
from typing import NamedTuple

from ...errors import UsageError

# Modules that a plugin needs itself, or that pip would put beside it: their name is no name for another one.
TAKEN = frozenset({"sdaeverify", "numpy", "scipy", "pandas", "pluggy", "pytest", "click", "rich", "test", "tests"})
LONGEST = 60

_DISTRIBUTION = re.compile(r"[a-z][a-z0-9]*(-[a-z0-9]+)*")


class Names(NamedTuple):
    """What is filled into the template.

    Attributes
    ----------
    distribution : str
        Lower case with hyphens.
    module : str
        The same with underscores.
    """

    distribution: str
    module: str

    @property
    def scheme(self) -> str:
        """Registered name of the scheme: no two plugins made in this way share it."""
        return f"{self.distribution}-platen"

    @property
    def problem(self) -> str:
        """Registered name of the problem."""
        return f"{self.distribution}-sinh"


def names_of(folder: Path, name: str | None = None) -> Names:
    """Return the names of the plugin in a folder.

    Parameters
    ----------
    folder : Path
        Its last part is the name if none is given.
    name : str, optional
        Any spelling that package indexes take for the same: ``My_Schemes`` is ``my-schemes``.

    Raises
    ------
    UsageError
        If it cannot be the name of a distribution and of a module.
    """
    given = Path(os.path.realpath(folder)).name if name is None else name
    distribution = re.sub(r"[-_.]+", "-", given).lower()
    module = distribution.replace("-", "_")
    where = "; choose another with --name" if name is None else ""
    if not _DISTRIBUTION.fullmatch(distribution) or len(distribution) > LONGEST:
        expected = f"at most {LONGEST} letters a to z, digits and hyphens, beginning with a letter"
        raise UsageError(f"{given!r} cannot be the name of a plugin: expected {expected}{where}")
    if keyword.iskeyword(module) or module in sys.stdlib_module_names or module in TAKEN:
        raise UsageError(f"{given!r} cannot be the name of a plugin: {module} is a name of Python's or ours{where}")
    if _is_installed(module):
        raise UsageError(f"{given!r} cannot be the name of a plugin: a module {module} is installed already{where}")
    return Names(distribution, module)


def _is_installed(module: str) -> bool:
    """Tell whether a module of this name can be imported; a mere folder of that name is none."""
    try:
        found = find_spec(module)
    except (ImportError, ValueError):
        return True
    return found is not None and found.origin is not None
