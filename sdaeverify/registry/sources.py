"""Plugins made from a text by a source, which is an entry point of the group ``sdaeverify.sources``.

The source ``wire`` makes a plugin of ``wire:./my_solver``. Each command with ``--plugin`` has an option of its name,
``--wire ./my_solver``, and a policy a table, ``[tool.sdaeverify.wire]``.
"""

from collections.abc import Callable, Mapping, Sequence
from importlib.metadata import EntryPoint
from pathlib import Path
from typing import Any, NamedTuple

from ..errors import FAULTS, PluginError, SdaeverifyError, one_line
from .discovery import absolute, enabled_entry_points, load_entry, origin_of

SOURCES = "sdaeverify.sources"
SEPARATOR = ":"


class PluginSource(NamedTuple):
    """A source of plugins.

    Attributes
    ----------
    metavar, about : str
        Placeholder of a text, and help of the option, in one line.
    absolute : callable, (str, Path) -> str
        Returns a text that means the same in any current folder; relative paths are relative to the given folder.
    plugin : callable, str -> object
        Returns an object with hooks, from a text that `absolute` returned. Worker processes do not call it: they
        unpickle its schemes, whose modules have to be importable.
    texts : callable, mapping -> sequence of str
        Returns the texts of a table of a policy.

    Each function raises `UsageError` if what it is given is wrong.
    """

    metavar: str
    about: str
    absolute: Callable[[str, Path], str]
    plugin: Callable[[str], object]
    texts: Callable[[Mapping[str, Any]], Sequence[str]]


def plugin_sources() -> Mapping[str, EntryPoint]:
    """Return the entry points of sources by name, without those that the environment disables."""
    return {entry.name: entry for entry in enabled_entry_points(SOURCES)}


def load_source_of(name: str) -> PluginSource:
    """Return a source.

    Raises
    ------
    PluginError
        If it cannot be loaded.
    """
    entry = plugin_sources()[name]
    found = load_entry(entry, f"source {name}")
    if not isinstance(found, PluginSource):
        raise PluginError(f"source {name} of {origin_of(entry)} is broken: it is {found!r:.60}, no PluginSource")
    return found


def split_source(given: object) -> tuple[str, str]:
    """Return the source and the text of a plugin; the source is empty for a plugin file."""
    name, separator, text = given.partition(SEPARATOR) if isinstance(given, str) else ("", "", "")
    return (name, text) if separator and name in plugin_sources() else ("", str(given))


def absolute_plugin(given: str | Path, folder: Path | None = None) -> str:
    """Return a plugin as it can be named in any current folder: the path of a file, or the text of a source.

    Parameters
    ----------
    given : str or Path
    folder : Path, optional
        Folder of relative paths; by default the current one.

    Raises
    ------
    PluginError
        If the path is invalid, or the source is broken.
    UsageError
        If the source does not accept the text.
    """
    name, text = split_source(given)
    if name:
        return f"{name}{SEPARATOR}{load_source_of(name).absolute(text, folder or Path.cwd())}"
    return str(absolute(given if folder is None else folder / given))


def plugin_of(given: str) -> object:
    """Return the plugin that a source makes from a text.

    Raises
    ------
    PluginError
        If it cannot be made.
    """
    name, text = split_source(given)
    try:
        return load_source_of(name).plugin(text)
    except SdaeverifyError as error:
        raise PluginError(f"--{name} {error}") from error
    except FAULTS as error:
        raise PluginError(f"--{name} {text}: {one_line(error)}") from error


def plugin_options(named: Sequence[str]) -> list[str]:
    """Return the words of a command line that name plugins."""
    pairs = (split_source(each) for each in named)
    return [word for name, text in pairs for word in (f"--{name}" if name else "--plugin", text)]


def plugins_of_tables(table: Mapping[str, Any], folder: Path) -> tuple[dict[str, Any], tuple[str, ...]]:
    """Return a table without those of sources, and the plugins that these name.

    Parameters
    ----------
    table : mapping
        Of a policy.
    folder : Path
        Folder of relative paths.

    Raises
    ------
    UsageError
        If a source does not accept its table.
    """
    plugins = list[str]()
    for name in plugin_sources().keys() & table.keys():
        texts = load_source_of(name).texts(table[name])
        plugins += [absolute_plugin(f"{name}{SEPARATOR}{text}", folder) for text in texts]
    return {key: value for key, value in table.items() if key not in plugin_sources()}, tuple(plugins)
