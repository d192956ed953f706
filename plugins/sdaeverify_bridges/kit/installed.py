"""Whether the library of a bridge is installed, without loading it."""

from functools import cache
from importlib.metadata import PackageNotFoundError, version
from importlib.util import find_spec
from typing import NamedTuple

from sdaeverify.errors import MissingLibraryError


class Library(NamedTuple):
    """A library whose solvers are bridged.

    Attributes
    ----------
    name : str
        Of its distribution and its package.
    version : str
        Empty where it is not installed. It is part of what determines evidence.
    extra : str
        What is to be installed with sdaeverify to have it.
    """

    name: str
    version: str
    extra: str

    @classmethod
    def find(cls, name: str, extra: str = "") -> "Library":
        """Return the library of a name; the extra has the same name unless it is given."""
        return cls(name, _version(name), extra or name)

    def require(self) -> None:
        """Refuse to go on without the library.

        Raises
        ------
        MissingLibraryError
            If it is not installed: the plugin is left out, with that reason.
        """
        if not self.version:
            raise MissingLibraryError(f"{self.name} is not installed; pip install 'sdaeverify[{self.extra}]'")

    def __str__(self) -> str:
        return f"{self.name} {self.version or 'not installed'}"


@cache
def _version(name: str) -> str:
    if find_spec(name) is None:
        return ""
    try:
        return version(name)
    except PackageNotFoundError:
        return "unknown"
