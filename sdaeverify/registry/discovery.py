"""Where plugins come from: entry points of distributions, files named by the user, the environment."""

import hashlib
import os
import pkgutil
import re
import sys
from collections.abc import Iterable, Mapping
from importlib import metadata
from pathlib import Path
from types import ModuleType
from typing import NamedTuple

from ..contracts.spelling import did_you_mean
from ..errors import FAULTS, PluginError, UsageError, one_line

GROUP = "sdaeverify"
# Plugins that only some commands ask for: planted bugs, calibration cases and experiments.
LAB = "sdaeverify.lab"
# Hooks that plugins bring, and their commands.
FURTHER, COMMANDS = "sdaeverify.hooks", "sdaeverify.commands"
OWN_DISTRIBUTION = "sdaeverify"
PREFIX = "SDAEVERIFY_"
# Of the names of modules that are plugin files.
FILE_PREFIX = "sdaeverify_file_"
DISABLED = "SDAEVERIFY_DISABLED_PLUGINS"
STRICT = "SDAEVERIFY_STRICT_PLUGINS"
YES, NO = frozenset({"1", "true", "yes"}), frozenset({"", "0", "false", "no"})


class Origin(NamedTuple):
    """Who brings a plugin.

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
        """What all plugins of one author share: the distribution, or the path of a file."""
        return normalise(self.distribution) or self.module

    def __str__(self) -> str:
        where = f"{self.distribution} {self.version}" if self.distribution else self.module
        return f"plugin {self.plugin} ({where})"


def disabled_plugins(environ: Mapping[str, str]) -> frozenset[str]:
    """Return the names of plugins, entry points or distributions that the environment leaves out."""
    return frozenset(name.strip() for name in environ.get(DISABLED, "").split(",") if name.strip())


def is_strict(environ: Mapping[str, str]) -> bool:
    """Return whether the environment variable `STRICT` forbids broken plugins.

    Raises
    ------
    UsageError
        If its value is no word for yes or no.
    """
    given = environ.get(STRICT, "").strip().lower()
    if given not in YES | NO:
        raise UsageError(f"environment variable {STRICT} expects 0 or 1, got {given!r:.200}")
    return given in YES


def warn_unknown(environ: Mapping[str, str]) -> tuple[str, ...]:
    """Return a warning for each variable ``SDAEVERIFY_*`` that means nothing."""
    unknown = sorted(name for name in environ if name.startswith(PREFIX) and name not in {DISABLED, STRICT})
    return tuple(f"unknown environment variable {name}{did_you_mean(name, (DISABLED, STRICT))}" for name in unknown)


def entry_points(group: str = GROUP) -> list[metadata.EntryPoint]:
    """Return the entry points of a group, those of this distribution first, then by name.

    The order decides who keeps a name that two plugins register.
    """

    def rank(entry: metadata.EntryPoint) -> tuple[bool, str, str]:
        distribution = normalise(origin_of(entry).distribution)
        return distribution != OWN_DISTRIBUTION, entry.name, distribution

    return sorted(metadata.entry_points(group=group), key=rank)


def origin_of(entry: metadata.EntryPoint) -> Origin:
    """Return who declares an entry point."""
    name, version = (entry.dist.name, entry.dist.version) if entry.dist else ("", "")
    return Origin(entry.name, name or "unknown", version or "unknown", entry.value)


def normalise(distribution: str) -> str:
    """Return the name of a distribution as package indexes compare it."""
    return re.sub(r"[-_.]+", "-", distribution).lower()


def is_disabled(origin: Origin, disabled: Iterable[str]) -> bool:
    """Tell whether a plugin is among the disabled ones, by its own name or its distribution's."""
    names = set(disabled)
    return origin.plugin in names or normalise(origin.distribution) in set(map(normalise, names))


def submodules(package: object, origin: Origin) -> list[Origin]:
    """Return the modules of a package, each as a plugin of its own; none if it is no package.

    Names with a leading underscore are left out.
    """
    if not (isinstance(package, ModuleType) and hasattr(package, "__path__")):
        return []
    names = sorted(found.name for found in pkgutil.iter_modules(package.__path__))
    public = [name for name in names if not name.startswith("_")]
    return [origin._replace(plugin=f"{origin.plugin}.{name}", module=f"{package.__name__}.{name}") for name in public]


def absolute(path: str | Path) -> Path:
    """Return the absolute path of a plugin file, which need not be there.

    Raises
    ------
    PluginError
        If there can be no such file: its name is too long, holds NUL, or is a loop of links.
    """
    try:
        return Path(path).expanduser().resolve()
    except (OSError, ValueError, RuntimeError, TypeError) as error:
        raise PluginError(f"plugin file {path}: no such file: {getattr(error, 'strerror', None) or error}") from error


def load_file(path: str | Path) -> ModuleType:
    """Import a file as a module of its own; modules beside it are found where it imports them, and hide no others.

    The module's name is made of the path and the content: another process that loads the same file can
    unpickle what the file defines, and one that finds it changed cannot mistake it for the old one.

    Raises
    ------
    PluginError
        If there is no such Python file, or it fails as it is imported.
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
    """Import what a file holds, or held on another machine, as `load_file` does; it need not be there."""
    digest = hashlib.blake2b(str(file).encode() + b"\0" + source, digest_size=8).hexdigest()
    name = f"{FILE_PREFIX}{re.sub(r'[^0-9a-zA-Z]', '_', file.stem)}_{digest}"
    if name in sys.modules:
        return sys.modules[name]
    # Compiled here and not by the import system, whose bytecode cache overlooks two edits within a second.
    code = compile(source, str(file), "exec", dont_inherit=True)
    module = ModuleType(name)
    module.__file__ = str(file)
    # It is what runs, whatever is saved there later.
    vars(module)["__source__"] = source
    sys.modules[name] = module
    try:
        exec(code, module.__dict__)
    except BaseException:
        del sys.modules[name]
        raise
    return module


def warn_unmatched(disabled: Iterable[str], known: Iterable[str]) -> tuple[str, ...]:
    """Return a warning for each disabled name that names nothing."""
    names = set(known)
    missing = sorted(name for name in disabled if not {name, normalise(name)} & names)
    return tuple(f"{DISABLED} names {name!r}, which is no plugin{did_you_mean(name, names)}" for name in missing)
