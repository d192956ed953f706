"""A plugin to begin with: a package with one scheme, one problem, their claims, tests, lock file and workflow."""

from .write import Names, names_of, write_plugin

__all__ = ["Names", "names_of", "write_plugin"]
