"""What one plugin registers, read through its hooks and checked.

Each plugin gets a plugin manager of its own. So its hooks are called alone, what fails names its culprit, and
a broken plugin leaves nothing behind.
"""

import pickle
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from difflib import SequenceMatcher
from functools import cache
from importlib.metadata import EntryPoint
from inspect import isroutine
from types import ModuleType, SimpleNamespace
from typing import Any, NamedTuple

import pluggy

from ..contracts.labels import dataclass_parameters, did_you_mean, read_values
from ..contracts.scheme import Scheme
from ..contracts.specs import (
    ProblemSpec,
    check_name,
    check_problem_function,
    check_scheme,
    describe,
    matrix_specs,
    problem_name,
    problem_spec,
)
from ..errors import FAULTS, ParameterError, PluginError, one_line
from ..forms import Problem
from . import hookspecs
from .discovery import FURTHER, Origin, entry_points

# From this likeness on, a name of a function is taken for a misspelt hook.
ALIKE = 0.82
# What the marker of pluggy leaves on a function.
MARK = f"{hookspecs.PROJECT}_impl"
HOOKS = tuple(sorted(name for name in vars(hookspecs) if name.startswith(f"{hookspecs.PROJECT}_")))


@dataclass(frozen=True)
class SchemeEntry:
    """A registered scheme: its default variants, in the order its author gave them."""

    name: str
    variants: tuple[Scheme, ...]
    origin: Origin

    @property
    def on_request(self) -> bool:
        """Whether a run of everything leaves it out."""
        return all(scheme.on_request for scheme in self.variants)

    def make(self, texts: Mapping[str, str] | None = None) -> Scheme:
        """Return the scheme with parameters given as the texts of a label.

        Raises
        ------
        ParameterError
            If a parameter is unknown or the scheme does not accept its value.
        """
        make: Callable[..., Scheme] = type(self.variants[0])
        owner = f"scheme {self.name!r}"
        values = read_values(owner, dataclass_parameters(type(self.variants[0])), texts or {})
        try:
            return make(**values)
        except FAULTS as error:
            raise ParameterError(f"{owner}: {one_line(error)}") from error


@dataclass(frozen=True)
class ProblemEntry:
    """A registered problem function."""

    name: str
    function: Callable[..., Problem]
    origin: Origin

    @property
    def on_request(self) -> bool:
        """Whether a run of everything leaves it out."""
        return not self.in_matrix

    @property
    def in_matrix(self) -> tuple[ProblemSpec, ...]:
        """The recipes that a run of everything takes."""
        return matrix_specs(self.function)

    @property
    def variants(self) -> tuple[ProblemSpec, ...]:
        """The recipes that a glob means: those in the matrix, or the defaults of a problem on request."""
        return tuple(replace(spec, schemes=(), measures=()) for spec in self.in_matrix) or (self.make(),)

    def make(self, texts: Mapping[str, str] | None = None) -> ProblemSpec:
        """Return the recipe of the problem with parameters given as the texts of a label.

        Raises
        ------
        ParameterError
            If a parameter is unknown or its text is no value of its type.
        """
        return problem_spec(self.function, texts)


@dataclass(frozen=True)
class Registered:
    """What is registered as it is: a measure, or what the hook of a plugin brings, such as an experiment."""

    name: str
    thing: Any
    origin: Origin


# Fields of a contribution, and the words for one of each.
KINDS = {
    "schemes": "scheme",
    "problems": "problem",
    "measures": "measure",
}


class Contribution(NamedTuple):
    """What one plugin registers: entries by name, its report hook, and by hook what hooks of plugins register."""

    schemes: Mapping[str, SchemeEntry] = {}
    problems: Mapping[str, ProblemEntry] = {}
    measures: Mapping[str, Registered] = {}
    report: Callable[..., object] | None = None
    further: Mapping[str, Mapping[str, Registered]] = {}


def collect(plugin: object, origin: Origin) -> Contribution:
    """Return what a plugin registers.

    Parameters
    ----------
    plugin : module or object with hooks
    origin : Origin

    Raises
    ------
    PluginError, UsageError
        If a hook is misspelt, not marked or returns something unusable; errors of the hooks pass through.
    """
    hooks = _check_hooks(plugin)
    manager = _manager(plugin, hooks, origin.plugin)
    schemes = _variants(_call(manager, "sdaeverify_schemes"))
    functions = _by_name("problem", _call(manager, "sdaeverify_problems"), _problem_name)
    measures = _by_name("measure", _call(manager, "sdaeverify_measures"), _measure_name)
    return Contribution(
        {name: SchemeEntry(name, variants, origin) for name, variants in schemes.items()},
        {name: ProblemEntry(name, function, origin) for name, function in functions.items()},
        {name: Registered(name, measure, origin) for name, measure in measures.items()},
        getattr(manager.hook, "sdaeverify_report", None),
        {hook: _further(manager, hook, origin) for hook in sorted(set(hooks.values()) - set(HOOKS))},
    )


def _further(manager: pluggy.PluginManager, hook: str, origin: Origin) -> dict[str, Registered]:
    kind = further_hooks()[hook].load()

    def name_of(thing: Any) -> str:
        if not isinstance(thing, kind):
            raise PluginError(f"{hook} expects each to be {kind.__name__}, got {describe(thing)}")
        name = str(getattr(thing, "label", None) or thing.name)
        _check_pickles(f"{kind.__name__} {name!r}", thing)
        return name

    things = _by_name(kind.__name__, _call(manager, hook), name_of)
    return {name: Registered(name, thing, origin) for name, thing in things.items()}


class _Hooks(SimpleNamespace):
    """Hooks and nothing else: pluggy looks at all that `dir` names."""

    def __dir__(self) -> Iterable[str]:
        return list(vars(self))


def _manager(plugin: object, hooks: Mapping[str, str], name: str) -> pluggy.PluginManager:
    """Return a manager of the hooks of one plugin alone."""
    manager = pluggy.PluginManager(hookspecs.PROJECT)
    specs = _Hooks(**{hook: getattr(hookspecs, hook) for hook in hooks.values() if hook in HOOKS})
    if vars(specs):
        manager.add_hookspecs(specs)  # type: ignore[arg-type] # any object with functions will do
    manager.register(_Hooks(**{function: getattr(plugin, function) for function in hooks}), name)
    return manager


def hooks_of(plugin: object) -> dict[str, str | None]:
    """Return the functions of a plugin that are hooks, or are named like one, and the hook they implement.

    It is None where the function is not marked. A function whose name merely begins as all hooks do is nobody's hook:
    a distribution ``sdaeverify-mine`` has a problem function ``sdaeverify_mine_sinh``.
    """
    # What is marked shows without the specifications.
    manager = pluggy.PluginManager(hookspecs.PROJECT)
    found: dict[str, str | None] = {}
    names = vars(plugin) if isinstance(plugin, ModuleType) else dir(plugin)
    for name in sorted(name for name in names if not name.startswith("__")):
        if isinstance(plugin, ModuleType) and not _may_be_a_hook(name, vars(plugin)[name]):
            continue
        options = manager.parse_hookimpl_opts(plugin, name)
        if options is not None:
            found[name] = options.get("specname") or name
        elif _names_a_hook(name) and isroutine(getattr(plugin, name)):
            found[name] = None
    return found


def _may_be_a_hook(name: str, value: object) -> bool:
    """Tell at once of most that a module holds that pluggy need not look at it."""
    # The question that costs most comes last.
    return (name.startswith(hookspecs.PROJECT) or hasattr(value, MARK)) and isroutine(value)


def _names_a_hook(name: str) -> bool:
    """Tell whether a name is that of a hook, or one of it with a letter or two wrong."""
    prefix, _, rest = name.partition("_")
    likeness = (SequenceMatcher(None, rest, hook.partition("_")[2]).ratio() for hook in _known_hooks())
    return prefix == hookspecs.PROJECT and max(likeness) >= ALIKE


@cache
def further_hooks() -> Mapping[str, EntryPoint]:
    """Return the hooks that plugins bring, each with the entry point of the class of what it returns."""
    return {entry.name: entry for entry in entry_points(FURTHER)}


def _known_hooks() -> list[str]:
    return sorted({*HOOKS, *further_hooks()})


def _check_hooks(plugin: object) -> dict[str, str]:
    hooks, checked = hooks_of(plugin), dict[str, str]()
    if not hooks:
        raise PluginError(f"implements no hook; expected one of {', '.join(_known_hooks())}, marked @hookimpl")
    for name, hook in hooks.items():
        if hook is None:
            raise PluginError(f"function {name} is not marked as a hook; put @hookimpl above it")
        if hook not in (known := _known_hooks()):
            raise PluginError(f"unknown hook {hook}{did_you_mean(hook, known)} (known: {', '.join(known)})")
        checked[name] = hook
    return checked


def _call(manager: pluggy.PluginManager, hook: str) -> list[Any]:
    caller = getattr(manager.hook, hook, None)
    if caller is None:
        return []
    results = caller()
    if len(results) < len(caller.get_hookimpls()):
        raise PluginError(f"{hook} returned None, expected an iterable")
    for result in results:
        if not isinstance(result, Iterable):
            raise PluginError(f"{hook} returned {result!r}, expected an iterable")
    return [thing for result in results for thing in result]


def _variants(schemes: Iterable[Scheme]) -> dict[str, tuple[Scheme, ...]]:
    variants: dict[str, dict[str, Scheme]] = {}
    for scheme in schemes:
        check_scheme(scheme)
        _check_pickles(f"scheme {scheme.label!r}", scheme)
        known = variants.setdefault(scheme.name, {})
        for label, other in known.items():
            if label == scheme.label or type(other) is not type(scheme):
                pair = f"{type(other).__qualname__} and {type(scheme).__qualname__}"
                raise PluginError(f"scheme {scheme.label!r} is registered twice by this plugin: {pair}")
        known[scheme.label] = scheme
    return {name: tuple(known.values()) for name, known in variants.items()}


def _by_name(kind: str, things: Iterable[Any], name_of: Callable[[Any], str]) -> dict[str, Any]:
    found: dict[str, Any] = {}
    for thing in things:
        name = name_of(thing)
        if name in found:
            raise PluginError(f"{kind} {name!r} is registered twice by this plugin")
        found[name] = thing
    return found


def _problem_name(function: Callable[..., Problem]) -> str:
    check_problem_function(function)
    _check_pickles(f"problem {problem_name(function)!r}", function)
    return problem_name(function)


def _measure_name(measure: Any) -> str:
    if isinstance(measure, type):
        raise PluginError(f"expected a measure, got the class {measure.__name__}; write {measure.__name__}()")
    check_name("measure", getattr(measure, "name", None))
    return str(measure.name)


def _check_pickles(what: str, thing: object) -> None:
    try:
        pickle.dumps(thing)
    except FAULTS as error:
        raise PluginError(
            f"{what} cannot be sent to worker processes ({one_line(error)}); define it at the top level of its module"
        ) from error
