"""Detection of the library of a bridge without importing it."""

from functools import cache
from importlib.metadata import PackageNotFoundError, version
from importlib.util import find_spec
from typing import NamedTuple

from sdaeverify.errors import MissingLibraryError


class Library(NamedTuple):
    """A library with bridged solvers.

    Attributes
    ----------
    name : str
        Name of the distribution and of the package.
    version : str
        Installed version, empty if missing. It is part of the key of stored evidence.
    extra : str
        Extra of sdaeverify that installs the library.
    """

    name: str
    version: str
    extra: str

    @classmethod
    def find(cls, name: str, extra: str = "") -> "Library":
        """Return the record of a library; the extra has the same name by default."""
        return cls(name, _version(name), extra or name)

    def require(self) -> None:
        """Raise if the library is not installed.

        Raises
        ------
        MissingLibraryError
            If it is not installed. The plugin is then left out, with that reason.
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
