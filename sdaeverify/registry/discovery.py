"""Sources of plugins: entry points of distributions, files named by the user, the environment."""

import hashlib
import os
import pkgutil
import re
import sys
from collections.abc import Iterable, Mapping
from functools import lru_cache
from importlib import metadata
from pathlib import Path
from types import ModuleType
from typing import Any, NamedTuple

from ..contracts.spelling import did_you_mean
from ..errors import FAULTS, PluginError, UsageError, one_line

GROUP = "sdaeverify"
# Plugins for some commands only: planted bugs, calibration cases and experiments.
LAB = "sdaeverify.lab"
# Entry-point groups for hooks and commands that plugins define.
FURTHER, COMMANDS = "sdaeverify.hooks", "sdaeverify.commands"
OWN_DISTRIBUTION = "sdaeverify"
PREFIX = "SDAEVERIFY_"
# Prefix of the module names of plugin files.
FILE_PREFIX = "sdaeverify_file_"
DISABLED = "SDAEVERIFY_DISABLED_PLUGINS"
STRICT = "SDAEVERIFY_STRICT_PLUGINS"
YES, NO = frozenset({"1", "true", "yes"}), frozenset({"", "0", "false", "no"})


class Origin(NamedTuple):
    """Origin of a plugin.

    Attributes
    ----------
    plugin : str
    distribution, version : str
        Empty for a file.
    module : str
        Module, ``module:object`` or path of the file.
    """

    plugin: str
    distribution: str
    version: str
    module: str

    @property
    def author(self) -> str:
        """Identifier shared by all plugins of one author: the distribution, or the path of a file."""
        return normalise(self.distribution) or self.module

    def __str__(self) -> str:
        where = f"{self.distribution} {self.version}" if self.distribution else self.module
        return f"plugin {self.plugin} ({where})"


def disabled_plugins(environ: Mapping[str, str]) -> frozenset[str]:
    """Return the names of plugins, entry points or distributions that the environment disables."""
    return frozenset(name.strip() for name in environ.get(DISABLED, "").split(",") if name.strip())


def is_strict(environ: Mapping[str, str]) -> bool:
    """Return whether the environment variable `STRICT` forbids broken plugins.

    Raises
    ------
    UsageError
        If its value is not a word for yes or no.
    """
    given = environ.get(STRICT, "").strip().lower()
    if given not in YES | NO:
        raise UsageError(f"environment variable {STRICT} expects 0 or 1, got {given!r:.200}")
    return given in YES


def warn_unknown(environ: Mapping[str, str]) -> tuple[str, ...]:
    """Return a warning for each unknown environment variable ``SDAEVERIFY_*``."""
    unknown = sorted(name for name in environ if name.startswith(PREFIX) and name not in {DISABLED, STRICT})
    return tuple(f"unknown environment variable {name}{did_you_mean(name, (DISABLED, STRICT))}" for name in unknown)


def entry_points(group: str = GROUP) -> list[metadata.EntryPoint]:
    """Return the entry points of a group: those of this distribution first, then by name.

    If two plugins register the same name, the first one in this order keeps it.
    """

    def rank(entry: metadata.EntryPoint) -> tuple[bool, str, str]:
        distribution = normalise(origin_of(entry).distribution)
        return distribution != OWN_DISTRIBUTION, entry.name, distribution

    return sorted(metadata.entry_points(group=group), key=rank)


def origin_of(entry: metadata.EntryPoint) -> Origin:
    """Return the origin of an entry point."""
    name, version = _name_and_version(entry.dist) if entry.dist else ("", "")
    return Origin(entry.name, name or "unknown", version or "unknown", entry.value)


@lru_cache
def _name_and_version(distribution: metadata.Distribution) -> tuple[str, str]:
    """Return the name and the version of a distribution; each access to an attribute parses its whole metadata."""
    fields = distribution.metadata
    return fields["Name"], fields["Version"]


def normalise(distribution: str) -> str:
    """Return the normalised name of a distribution, as package indexes compare names."""
    return re.sub(r"[-_.]+", "-", distribution).lower()


def is_disabled(origin: Origin, disabled: Iterable[str]) -> bool:
    """Return whether a plugin is disabled, by its own name or its distribution's."""
    names = set(disabled)
    return origin.plugin in names or normalise(origin.distribution) in set(map(normalise, names))


def enabled_entry_points(group: str) -> list[metadata.EntryPoint]:
    """Return the entry points of a group without those that the environment disables."""
    disabled = disabled_plugins(os.environ)
    return [entry for entry in entry_points(group) if not is_disabled(origin_of(entry), disabled)]


def names_of_plugins() -> set[str]:
    """Return the names of entry points in all groups of this project, and the normalised ones of distributions."""
    known = metadata.entry_points()
    groups = [name for name in known.groups if name == GROUP or name.startswith(f"{GROUP}.")]
    origins = [origin_of(entry) for group in groups for entry in known.select(group=group)]
    return {name for origin in origins for name in (origin.plugin, normalise(origin.distribution))}


def load_entry(entry: metadata.EntryPoint, what: str) -> Any:
    """Return the object of an entry point.

    Parameters
    ----------
    entry : EntryPoint
    what : str
        Name of the object for the message.

    Raises
    ------
    PluginError
        If it cannot be imported.
    """
    try:
        return entry.load()
    except FAULTS as error:
        raise PluginError(f"{what} of {origin_of(entry)} is broken: {one_line(error)}") from error


def submodules(package: object, origin: Origin) -> list[Origin]:
    """Return the modules of a package, each as a separate plugin; empty if `package` is not a package.

    Names with a leading underscore are skipped.
    """
    if not (isinstance(package, ModuleType) and hasattr(package, "__path__")):
        return []
    names = sorted(found.name for found in pkgutil.iter_modules(package.__path__))
    public = [name for name in names if not name.startswith("_")]
    return [origin._replace(plugin=f"{origin.plugin}.{name}", module=f"{package.__name__}.{name}") for name in public]


def absolute(path: str | Path) -> Path:
    """Return the absolute path of a plugin file, which need not exist.

    Raises
    ------
    PluginError
        If the path is invalid: its name is too long, contains NUL, or is a loop of links.
    """
    try:
        return Path(path).expanduser().resolve()
    except (OSError, ValueError, RuntimeError, TypeError) as error:
        raise PluginError(f"plugin file {path}: no such file: {getattr(error, 'strerror', None) or error}") from error


def load_file(path: str | Path) -> ModuleType:
    """Import a file as a module, with its folder appended to `sys.path`.

    So it can import modules of its folder, and these hide no others. The module's name is a hash of the path and the
    content: another process that loads the same file can unpickle its objects, and one that finds it changed cannot
    mistake it for the old one.

    Raises
    ------
    PluginError
        If there is no such Python file, or it fails when it is imported.
    """
    file = absolute(path)
    if os.path.isdir(file):
        raise PluginError(f"plugin file {path}: is a folder, expected a Python file; install it as a package instead")
    if file.suffix != ".py" or not os.path.isfile(file):
        raise PluginError(f"plugin file {path}: expected an existing file that ends in .py")
    if str(file.parent) not in sys.path:
        sys.path.append(str(file.parent))
    try:
        return load_source(file, file.read_bytes())
    except FAULTS as error:
        raise PluginError(f"plugin file {path}: {one_line(error)}") from error


def load_source(file: Path, source: bytes) -> ModuleType:
    """Import the content of a file, possibly from another machine, as `load_file` does; the file need not exist."""
    digest = hashlib.blake2b(str(file).encode() + b"\0" + source, digest_size=8).hexdigest()
    name = f"{FILE_PREFIX}{re.sub(r'[^0-9a-zA-Z]', '_', file.stem)}_{digest}"
    if name in sys.modules:
        return sys.modules[name]
    # Compile here, because the bytecode cache of the import system misses two edits within a second.
    code = compile(source, str(file), "exec", dont_inherit=True)
    module = ModuleType(name)
    module.__file__ = str(file)
    # The source that runs, even if the file changes later.
    vars(module)["__source__"] = source
    sys.modules[name] = module
    try:
        exec(code, module.__dict__)
    except BaseException:
        del sys.modules[name]
        raise
    return module


def warn_unmatched(disabled: Iterable[str], known: Iterable[str]) -> tuple[str, ...]:
    """Return a warning for each disabled name that matches no plugin."""
    names = set(known)
    missing = sorted(name for name in disabled if not {name, normalise(name)} & names)
    return tuple(f"{DISABLED} names {name!r}, which is no plugin{did_you_mean(name, names)}" for name in missing)
