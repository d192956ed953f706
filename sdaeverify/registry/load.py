"""Loading of the registry from entry points and files into immutable sorted maps.

A plugin that fails in any way is left out as a whole; its row gives the reason.
"""

import os
import sys
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import lru_cache, partial
from importlib import import_module
from importlib.metadata import EntryPoint
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple

from ..contracts.measure import followed_by
from ..contracts.scheme import Scheme
from ..contracts.specs import ProblemSpec
from ..contracts.spelling import did_you_mean
from ..errors import FAULTS, MissingLibraryError, PluginError, UsageError, one_line
from .contributions import (
    HOOKS,
    MEASURES,
    PROBLEMS,
    REPORT,
    SCHEMES,
    Entries,
    Registered,
    collect,
    known_hooks,
    word_of,
)
from .discovery import (
    DISABLED,
    LAB,
    OWN_DISTRIBUTION,
    Origin,
    disabled_plugins,
    entry_points,
    is_disabled,
    is_strict,
    load_file,
    names_of_plugins,
    normalise,
    origin_of,
    submodules,
    warn_unknown,
    warn_unmatched,
)
from .foreign_code import exits_raise, printed_to_stderr, same_folder
from .sources import absolute_plugin, plugin_of, split_source

ON_REQUEST, WHO_ASKS = "on request", "loaded by the commands that need it"


class PluginRow(NamedTuple):
    """Status of a plugin.

    Attributes
    ----------
    name, distribution, version, module : str
        As in `Origin`.
    status : str
        ``loaded``, ``disabled``, ``broken``, ``absent`` if the library it is made for is not installed, or
        ``on request`` if no command has requested it.
    reason : str
        Why it is not loaded, in one line.
    schemes, problems, measures : int
        Number of names it registers.
    further : tuple of (str, int)
        Hooks that plugins define, and the number of names it registers for each.
    """

    name: str
    distribution: str
    version: str
    module: str
    status: str
    reason: str = ""
    schemes: int = 0
    problems: int = 0
    measures: int = 0
    further: tuple[tuple[str, int], ...] = ()


class LoadedPlugin(NamedTuple):
    """A plugin's row and its registered objects, which are empty if it is not loaded."""

    row: PluginRow
    entries: Entries = MappingProxyType({})


@dataclass(frozen=True)
class Registry:
    """All registered objects, by hook and by name, sorted by name.

    Attributes
    ----------
    entries : mapping of str to (mapping of str to Registered)
    plugins : tuple of PluginRow
        In the order they were loaded.
    warnings : tuple of str
        Warnings about environment variables and claims, one line each.
    files : tuple of str
        Plugins that were named for this registry: absolute paths of files, and texts of sources.
    """

    entries: Entries
    plugins: tuple[PluginRow, ...] = ()
    warnings: tuple[str, ...] = ()
    files: tuple[str, ...] = ()

    @property
    def paths(self) -> tuple[str, ...]:
        """Paths of plugin files: a worker process loads them by `load_file` before it unpickles anything."""
        return tuple(each for each in self.files if not split_source(each)[0])

    @property
    def sourced(self) -> tuple[str, ...]:
        """Names of the schemes of sources, such as a program that was named on the command line."""
        made = {each for each in self.files if split_source(each)[0]}
        return tuple(name for name, entry in self.schemes.items() if entry.origin.module in made)

    @property
    def complaints(self) -> tuple[str, ...]:
        """The warnings, and a line for each broken plugin."""
        broken = (row for row in self.plugins if row.status == "broken")
        places = ((row, f"{row.distribution} {row.version}".strip() or row.module) for row in broken)
        lines = (f"plugin {row.name} ({place}) is broken and left out: {row.reason}" for row, place in places)
        return (*self.warnings, *lines)

    @property
    def schemes(self) -> Mapping[str, Registered]:
        """Schemes by name."""
        return self.entries.get(SCHEMES, {})

    @property
    def problems(self) -> Mapping[str, Registered]:
        """Problems by name."""
        return self.entries.get(PROBLEMS, {})

    @property
    def measures(self) -> Mapping[str, Registered]:
        """Measures by name."""
        return self.entries.get(MEASURES, {})

    @property
    def followed(self) -> dict[str, str]:
        """`Measure.follows` of the measures whose claims imply that steps follow the equation, by name."""
        return followed_by(entry.thing for entry in self.measures.values())

    @property
    def modules(self) -> tuple[str, ...]:
        """Modules that a worker imports before anything else: measures, and plugins of other distributions."""
        loaded = (row for row in self.plugins if row.status == "loaded" and row.distribution)
        wanted = (row for row in loaded if row.measures or normalise(row.distribution) != OWN_DISTRIBUTION)
        named = (row.module.partition(":")[0] for row in wanted)
        return tuple(dict.fromkeys(named))

    def names(self, given: Scheme | ProblemSpec) -> bool:
        """Return whether a scheme or problem is the one registered under its name, so that commands can name it."""
        known = self.schemes if isinstance(given, Scheme) else self.problems
        subject: object = type(given) if isinstance(given, Scheme) else given.function
        entry = known.get(given.name)
        return entry is not None and entry.subject is subject

    def things(self, hook: str) -> dict[str, Any]:
        """Return the objects registered by a plugin's hook, by name."""
        return {name: entry.thing for name, entry in self.entries.get(hook, {}).items()}

    def report(self, folder: Path, result: object) -> tuple[str, ...]:
        """Call the report hook of each plugin; return one line for each failure."""
        failures = []
        for entry in self.entries.get(REPORT, {}).values():
            try:
                entry.thing(folder=folder, result=result)
            except FAULTS as error:
                failures.append(f"report of plugin {entry.origin.plugin}: {one_line(error)}")
        return tuple(failures)


def load_registry(
    paths: Sequence[str | Path] = (), environ: Mapping[str, str] | None = None, *, lab: bool = False
) -> Registry:
    """Load all plugins: those of this distribution, then other entry points by name, then files.

    Parameters
    ----------
    paths : sequence of str or Path
        Plugin files and texts of sources; an error in one of them is raised, because the user has requested it.
    environ : mapping of str to str
        By default that of the process. ``SDAEVERIFY_DISABLED_PLUGINS`` names plugins, entry points or
        distributions that are left out; with ``SDAEVERIFY_STRICT_PLUGINS`` a broken plugin is an error.
    lab : bool
        Whether to load the plugins of the group ``sdaeverify.lab``, too; runs do not need them.

    Raises
    ------
    PluginError
        If a file cannot be used or makes a claim about an unregistered measure, or if a plugin is broken and broken
        plugins are forbidden.
    UsageError
        If an environment variable has an invalid value.
    """
    # Standard output is for results; text printed by plugins during import goes to stderr.
    with printed_to_stderr(), same_folder(), exits_raise():
        return _load(paths, os.environ if environ is None else environ, lab=lab)


def _load(paths: Sequence[str | Path], environ: Mapping[str, str], *, lab: bool) -> Registry:
    if isinstance(paths, str | bytes | Path) or not isinstance(paths, Iterable):
        raise UsageError(f"plugins expects a list of Python files, got {paths!r:.200}")
    # Resolve paths before loading plugins, which might change the working directory.
    named = tuple(dict.fromkeys(map(absolute_plugin, paths)))
    disabled = disabled_plugins(environ)
    entries, further = entry_points(), entry_points(LAB)
    outcomes = _from_entry_points([*entries, *further] if lab else entries, disabled)
    outcomes += [] if lab else [_for_the_lab(origin_of(entry), disabled) for entry in further]
    if is_strict(environ):
        _refuse_broken([outcome.row for outcome in outcomes])
    for each in named:
        load = _from_source if split_source(each)[0] else _from_file
        outcomes.append(load(each, disabled, outcomes))
    _refuse_unknown_measures(outcomes, strict=is_strict(environ))
    known = names_of_plugins() | {outcome.row.name for outcome in outcomes}
    return _assemble(outcomes, warn_unknown(environ) + warn_unmatched(disabled, known), named)


class _Installed(NamedTuple):
    """Outcomes of entry points, and the times at which the files that they depend on were changed last."""

    outcomes: tuple[LoadedPlugin, ...]
    changed: Mapping[str, int | None]


def _from_entry_points(entries: Iterable[EntryPoint], disabled: frozenset[str]) -> list[LoadedPlugin]:
    """Load the plugins of entry points; those of an earlier call are returned again while no file has changed.

    An outcome with a broken plugin is not kept, because its author may repair it in a file that is not known here.
    """
    given = tuple(entries), disabled, tuple(sys.path)
    found = _load_installed(*given)
    if any(_changed(file) != known for file, known in found.changed.items()):
        _load_installed.cache_clear()
        found = _load_installed(*given)
    if any(outcome.row.status == "broken" for outcome in found.outcomes):
        _load_installed.cache_clear()
    return [*found.outcomes]


@lru_cache(maxsize=4)
def _load_installed(entries: tuple[EntryPoint, ...], disabled: frozenset[str], path: tuple[str, ...]) -> _Installed:
    outcomes = list[LoadedPlugin]()
    for entry in entries:
        outcomes += _from_entry_point(entry, disabled, outcomes)
    return _Installed(tuple(outcomes), {file: _changed(file) for file in (*_files_of(entries), *path)})


def _files_of(entries: Iterable[EntryPoint]) -> set[str]:
    """Return the files and folders of all imported modules of some packages; a new module changes its folder."""
    packages = tuple(f"{entry.value.partition(':')[0]}." for entry in entries)
    modules = [module for name, module in [*sys.modules.items()] if f"{name}.".startswith(packages)]
    folders = (folder for module in modules for folder in getattr(module, "__path__", ()))
    return {*folders, *(file for module in modules if (file := getattr(module, "__file__", None)))}


def _changed(file: str) -> int | None:
    with suppress(OSError):
        return os.stat(file or os.curdir).st_mtime_ns
    return None


def _assemble(outcomes: Sequence[LoadedPlugin], warnings: tuple[str, ...], given: tuple[str, ...]) -> Registry:
    def named(hook: str) -> Mapping[str, Registered]:
        parts = (outcome.entries.get(hook, {}) for outcome in outcomes)
        return MappingProxyType(dict(sorted((name, entry) for part in parts for name, entry in part.items())))

    entries = {hook: named(hook) for hook in known_hooks()}
    warnings = (*warnings, *_idle_claims(entries[SCHEMES], entries[MEASURES]))
    return Registry(entries, tuple(outcome.row for outcome in outcomes), warnings, given)


def _refuse_unknown_measures(outcomes: Sequence[LoadedPlugin], *, strict: bool) -> None:
    """Raise if a plugin makes a claim about an unregistered measure: any plugin if `strict`, else plugin files only.

    If a plugin is left out, no error is raised, because that plugin may register the measure.
    """
    left_out = (each.row for each in outcomes if each.row.status in {"disabled", "broken", "absent"})
    if any(row.status != "absent" or normalise(row.distribution) != OWN_DISTRIBUTION for row in left_out):
        return
    measures = {name for each in outcomes for name in each.entries.get(MEASURES, {})}
    for row, entries in outcomes:
        for why in _idle_claims(entries.get(SCHEMES, {}), measures) if strict or not row.distribution else ():
            raise PluginError(f"plugin {row.module}: {why}")


def _idle_claims(schemes: Mapping[str, Registered], measures: Collection[str]) -> Iterator[str]:
    """Yield a line for each unregistered measure that a claim names."""
    for name, entry in schemes.items():
        claimed = {claim.measure for variant in entry.variants for claim in variant.promises}
        for measure in sorted(claimed - set(measures)):
            hint = did_you_mean(measure, measures)
            yield f"scheme {name} claims about measure {measure!r}, which is not registered{hint}"


def _refuse_broken(rows: Iterable[PluginRow]) -> None:
    broken = [
        f"{row.name} ({row.distribution} {row.version}): {row.reason}" for row in rows if row.status == "broken"
    ]
    if broken:
        raise PluginError(f"broken plugins: {'; '.join(broken)}")


def _no_hook() -> str:
    return f"implements no hook; expected one of {', '.join(known_hooks())}, marked @hookimpl"


def _from_file(path: str, disabled: frozenset[str], before: Sequence[LoadedPlugin]) -> LoadedPlugin:
    origin = Origin(Path(path).stem, "", "", path)
    if origin.plugin in disabled:
        raise PluginError(f"plugin file {path}: {DISABLED} disables {origin.plugin}; remove the name or the file")
    plugin = load_file(path)
    try:
        entries = collect(plugin, origin, disabled)
        if not entries:
            raise PluginError(_no_hook())
        return _loaded(entries, origin, before)
    except FAULTS as error:
        raise PluginError(f"plugin file {path}: {one_line(error)}") from error


def _from_source(named: str, disabled: frozenset[str], before: Sequence[LoadedPlugin]) -> LoadedPlugin:
    origin = Origin(split_source(named)[0], "", "", named)
    return _loaded(collect(plugin_of(named), origin, disabled), origin, before)


def _from_entry_point(
    entry: EntryPoint, disabled: frozenset[str], before: Sequence[LoadedPlugin]
) -> list[LoadedPlugin]:
    origin = origin_of(entry)
    return _load_plugins(entry.load, origin, disabled, before) or [_reject(origin, PluginError(_no_hook()))]


def _load_plugins(
    load: Callable[[], Any], origin: Origin, disabled: frozenset[str], before: Sequence[LoadedPlugin]
) -> list[LoadedPlugin]:
    """Load a plugin, or all plugins of a package; return an empty list if there are no hooks."""
    if is_disabled(origin, disabled):
        return [_skip(origin)]
    try:
        plugin = load()
        if entries := collect(plugin, origin, disabled):
            return [_loaded(entries, origin, before)]
        modules = submodules(plugin, origin)
    except FAULTS as error:
        return [_reject(origin, error)]
    # A module without hooks is a helper of other modules; a package without hooks is a collection of plugins.
    outcomes: list[LoadedPlugin] = []
    for module in modules:
        outcomes += _load_plugins(partial(import_module, module.module), module, disabled, [*before, *outcomes])
    return outcomes


def _skip(origin: Origin) -> LoadedPlugin:
    return LoadedPlugin(PluginRow(*origin, "disabled", f"named in {DISABLED}"))


def _for_the_lab(origin: Origin, disabled: frozenset[str]) -> LoadedPlugin:
    return _skip(origin) if is_disabled(origin, disabled) else LoadedPlugin(PluginRow(*origin, ON_REQUEST, WHO_ASKS))


def _reject(origin: Origin, error: BaseException) -> LoadedPlugin:
    status = "absent" if isinstance(error, MissingLibraryError) else "broken"
    return LoadedPlugin(PluginRow(*origin, status, one_line(error)))


def _loaded(entries: Entries, origin: Origin, before: Sequence[LoadedPlugin]) -> LoadedPlugin:
    for hook, own in entries.items():
        for known in (other.entries.get(hook, {}) for other in before):
            for name in sorted(own.keys() & known.keys()):
                raise PluginError(
                    f"{word_of(hook)} {name!r} of {origin} is already registered by {known[name].origin}"
                )
    schemes, problems, measures = (len(entries.get(hook, {})) for hook in (SCHEMES, PROBLEMS, MEASURES))
    further = tuple((hook, len(things)) for hook, things in entries.items() if hook not in HOOKS)
    return LoadedPlugin(PluginRow(*origin, "loaded", "", schemes, problems, measures, further), entries)
