"""The registry: entry points and files in, immutable sorted maps out.

A plugin that fails in any way is left out as a whole; its row says why.
"""

import os
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from importlib import import_module
from importlib.metadata import EntryPoint
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple, TypeVar

from ..contracts.labels import did_you_mean
from ..contracts.scheme import Scheme
from ..contracts.specs import ProblemSpec
from ..errors import FAULTS, MissingLibraryError, PluginError, UsageError, one_line
from .contributions import (
    KINDS,
    Contribution,
    ProblemEntry,
    Registered,
    SchemeEntry,
    collect,
    further_hooks,
    hooks_of,
)
from .discovery import (
    DISABLED,
    LAB,
    OWN_DISTRIBUTION,
    Origin,
    absolute,
    entry_points,
    is_disabled,
    load_file,
    normalise,
    origin_of,
    read_settings,
    submodules,
    warn_unmatched,
)
from .foreign_code import printed_to_stderr, same_folder

Entry = TypeVar("Entry")
ON_REQUEST, WHO_ASKS = "on request", "loaded by the commands that need it"


class PluginRow(NamedTuple):
    """What became of a plugin.

    Attributes
    ----------
    name, distribution, version, module : str
        As in `Origin`.
    status : str
        ``loaded``, ``disabled``, ``broken``, ``absent`` where the library it is made for is not installed, or
        ``on request`` where nobody has asked for it.
    reason : str
        Why it is not loaded, in one line.
    schemes, problems, measures : int
        How many names it registers.
    further : tuple of (str, int)
        Hooks that plugins bring, and how many names it registers by each.
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
    """A plugin's row and what it registers: nothing if it is disabled or broken."""

    row: PluginRow
    contribution: Contribution = Contribution()


@dataclass(frozen=True)
class Registry:
    """All that is registered, by name and sorted by name.

    Attributes
    ----------
    schemes : mapping of str to SchemeEntry
    problems : mapping of str to ProblemEntry
    measures : mapping of str to Registered
    plugins : tuple of PluginRow
        In the order they were loaded.
    warnings : tuple of str
        What is odd about the environment, one line each.
    files : tuple of str
        Plugin files, absolute: a worker process loads them by `load_file` before it unpickles anything.
    reports : tuple of (str, callable)
        Plugins with a report hook.
    further : mapping of str to (mapping of str to Registered)
        By hook, what is registered by the hooks that plugins bring.
    """

    schemes: Mapping[str, SchemeEntry]
    problems: Mapping[str, ProblemEntry]
    measures: Mapping[str, Registered]
    plugins: tuple[PluginRow, ...] = ()
    warnings: tuple[str, ...] = ()
    files: tuple[str, ...] = ()
    reports: tuple[tuple[str, Callable[..., object]], ...] = ()
    further: Mapping[str, Mapping[str, Registered]] = field(default_factory=dict)

    @property
    def modules(self) -> tuple[str, ...]:
        """Modules that a worker imports before anything else: measures, and plugins of other distributions."""
        loaded = (row for row in self.plugins if row.status == "loaded" and row.distribution)
        wanted = (row for row in loaded if row.measures or normalise(row.distribution) != OWN_DISTRIBUTION)
        named = (row.module.partition(":")[0] for row in wanted)
        return tuple(dict.fromkeys(named))

    def names(self, given: Scheme | ProblemSpec) -> bool:
        """Tell whether a scheme or problem is the registered one of its name, so that a command can name it."""
        if isinstance(given, Scheme):
            scheme = self.schemes.get(given.name)
            return scheme is not None and type(scheme.variants[0]) is type(given)
        problem = self.problems.get(given.name)
        return problem is not None and problem.function is given.function

    def things(self, hook: str) -> dict[str, Any]:
        """Return what the hook of a plugin registers, by name."""
        return {name: entry.thing for name, entry in self.further.get(hook, {}).items()}

    def report(self, folder: Path, result: object) -> tuple[str, ...]:
        """Let each plugin write beside the report of a result; return one line for each that failed."""
        failures = []
        for plugin, write in self.reports:
            try:
                write(folder=folder, result=result)
            except FAULTS as error:
                failures.append(f"report of plugin {plugin}: {one_line(error)}")
        return tuple(failures)


def load_registry(
    paths: Sequence[str | Path] = (), environ: Mapping[str, str] | None = None, *, lab: bool = False
) -> Registry:
    """Load all plugins: those of this distribution, then other entry points by name, then files.

    Parameters
    ----------
    paths : sequence of str or Path
        Plugin files; as they were asked for, they may not fail.
    environ : mapping of str to str
        By default that of the process. ``SDAEVERIFY_DISABLED_PLUGINS`` names plugins, entry points or
        distributions that are left out; with ``SDAEVERIFY_STRICT_PLUGINS`` no plugin may be broken.
    lab : bool
        Whether the plugins of the group ``sdaeverify.lab`` are loaded, too, of which a run needs none.

    Raises
    ------
    PluginError
        If a file cannot be used, or a plugin is broken and that is not allowed.
    """
    # What a plugin prints as it loads is no result.
    with printed_to_stderr(), same_folder():
        return _load(paths, os.environ if environ is None else environ, lab=lab)


def _load(paths: Sequence[str | Path], environ: Mapping[str, str], *, lab: bool) -> Registry:
    if isinstance(paths, str | bytes | Path) or not isinstance(paths, Iterable):
        raise UsageError(f"plugins expects a list of Python files, got {paths!r:.200}")
    # Before any plugin is loaded, which might change the folder that they are relative to.
    files = tuple(dict.fromkeys(str(absolute(path)) for path in paths))
    settings = read_settings(environ)
    entries, further, outcomes = entry_points(), entry_points(LAB), list[LoadedPlugin]()
    for entry in (*entries, *further) if lab else entries:
        outcomes += _from_entry_point(entry, settings.disabled, outcomes)
    outcomes += [] if lab else [_for_the_lab(origin_of(entry), settings.disabled) for entry in further]
    if settings.strict:
        _refuse_broken([outcome.row for outcome in outcomes])
    for file in files:
        outcomes.append(_from_file(file, outcomes))
    known = {entry.name for entry in (*entries, *further)} | {outcome.row.name for outcome in outcomes}
    known |= {normalise(outcome.row.distribution) for outcome in outcomes}
    return _assemble(outcomes, settings.warnings + warn_unmatched(settings.disabled, known), files)


def _assemble(outcomes: Sequence[LoadedPlugin], warnings: tuple[str, ...], files: tuple[str, ...]) -> Registry:
    def merge_maps(maps: Iterable[Mapping[str, Entry]]) -> Mapping[str, Entry]:
        return MappingProxyType(dict(sorted((name, entry) for one in maps for name, entry in one.items())))

    parts = [outcome.contribution for outcome in outcomes]
    schemes, measures = merge_maps(part.schemes for part in parts), merge_maps(part.measures for part in parts)
    return Registry(
        schemes,
        merge_maps(part.problems for part in parts),
        measures,
        tuple(outcome.row for outcome in outcomes),
        (*warnings, *_idle_claims(schemes, measures)),
        files,
        tuple((row.name, part.report) for row, part in outcomes if part.report),
        {hook: merge_maps(part.further.get(hook, {}) for part in parts) for hook in further_hooks()},
    )


def _idle_claims(schemes: Mapping[str, SchemeEntry], measures: Mapping[str, object]) -> Iterator[str]:
    """Yield a warning for each measure that a claim names and that is not registered."""
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


def _from_file(path: str, before: Sequence[LoadedPlugin]) -> LoadedPlugin:
    origin = Origin(Path(path).stem, "", "", path)
    plugin = load_file(path)
    try:
        return _load_plugin(plugin, origin, before)
    except FAULTS as error:
        raise PluginError(f"plugin file {path}: {one_line(error)}") from error


def _from_entry_point(
    entry: EntryPoint, disabled: frozenset[str], before: Sequence[LoadedPlugin]
) -> list[LoadedPlugin]:
    origin = origin_of(entry)
    if is_disabled(origin, disabled):
        return [_skip(origin)]
    try:
        plugin = entry.load()
        modules = [] if hooks_of(plugin) else submodules(plugin, origin)
        if not modules:
            return [_load_plugin(plugin, origin, before)]
    except FAULTS as error:
        return [_reject(origin, error)]
    outcomes = _from_modules(modules, disabled, before)
    return outcomes or [_reject(origin, PluginError("neither the package nor one of its modules implements a hook"))]


def _from_modules(
    modules: Sequence[Origin], disabled: frozenset[str], before: Sequence[LoadedPlugin]
) -> list[LoadedPlugin]:
    outcomes: list[LoadedPlugin] = []
    for module in modules:
        outcomes += _from_module(module, disabled, [*before, *outcomes])
    return outcomes


def _from_module(origin: Origin, disabled: frozenset[str], before: Sequence[LoadedPlugin]) -> list[LoadedPlugin]:
    if is_disabled(origin, disabled):
        return [_skip(origin)]
    try:
        plugin = import_module(origin.module)
        if hooks_of(plugin):
            return [_load_plugin(plugin, origin, before)]
    except FAULTS as error:
        return [_reject(origin, error)]
    # A module without hooks is a helper of its neighbours, a package without hooks a family of plugins.
    return _from_modules(submodules(plugin, origin), disabled, before)


def _skip(origin: Origin) -> LoadedPlugin:
    return LoadedPlugin(PluginRow(*origin, "disabled", f"named in {DISABLED}"))


def _for_the_lab(origin: Origin, disabled: frozenset[str]) -> LoadedPlugin:
    return _skip(origin) if is_disabled(origin, disabled) else LoadedPlugin(PluginRow(*origin, ON_REQUEST, WHO_ASKS))


def _reject(origin: Origin, error: BaseException) -> LoadedPlugin:
    status = "absent" if isinstance(error, MissingLibraryError) else "broken"
    return LoadedPlugin(PluginRow(*origin, status, one_line(error)))


def _load_plugin(plugin: object, origin: Origin, before: Sequence[LoadedPlugin]) -> LoadedPlugin:
    part = collect(plugin, origin)
    _refuse_taken(part, [outcome.contribution for outcome in before], origin)
    schemes, problems, measures = (len(getattr(part, kind)) for kind in KINDS)
    further = tuple((hook, len(things)) for hook, things in part.further.items())
    return LoadedPlugin(PluginRow(*origin, "loaded", "", schemes, problems, measures, further), part)


def _refuse_taken(part: Contribution, before: Sequence[Contribution], origin: Origin) -> None:
    for kind, own in _entries(part).items():
        for known in (_entries(other).get(kind, {}) for other in (before if own else ())):
            for name in sorted(own.keys() & known.keys()):
                raise PluginError(f"{kind} {name!r} of {origin} is already registered by {known[name].origin}")


def _entries(part: Contribution) -> Mapping[str, Mapping[str, Any]]:
    """Return what a plugin registers by the word for one of each."""
    return {word: getattr(part, kind) for kind, word in KINDS.items()} | {
        hook.partition("_")[2]: things for hook, things in part.further.items()
    }
