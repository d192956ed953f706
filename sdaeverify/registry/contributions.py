"""Objects that one plugin registers, read through its hooks and checked.

Each plugin has its own plugin manager. So its hooks are called separately, errors name the plugin, and
a broken plugin leaves no trace in the registry.
"""

import pickle
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from functools import cache
from importlib.metadata import EntryPoint
from inspect import isfunction, isroutine
from typing import Any

import pluggy

from ..contracts.labels import Parameter, dataclass_parameters, function_parameters, read_values
from ..contracts.scheme import Scheme
from ..contracts.specs import (
    check_name,
    check_problem_function,
    check_scheme,
    describe,
    matrix_specs,
    problem_name,
    problem_spec,
)
from ..contracts.spelling import did_you_mean
from ..errors import FAULTS, ParameterError, PluginError, UsageError, one_line
from . import hookspecs
from .discovery import FURTHER, Origin, entry_points, is_disabled, origin_of

SCHEMES, PROBLEMS, MEASURES, REPORT = HOOKS = (
    "sdaeverify_schemes",
    "sdaeverify_problems",
    "sdaeverify_measures",
    "sdaeverify_report",
)


@dataclass(frozen=True)
class Registered:
    """Objects registered by a plugin under one name.

    Attributes
    ----------
    name : str
    things : tuple
        The default variants of a scheme, in the order given by their author; otherwise a single object: the function
        of a problem, a measure, or an object of a plugin's hook, such as an experiment.
    origin : Origin
    """

    name: str
    things: tuple[Any, ...]
    origin: Origin

    @property
    def thing(self) -> Any:
        """The single object, or the first variant of a scheme."""
        return self.things[0]

    @property
    def subject(self) -> Any:
        """The object that carries the docstring: the class of a scheme or measure, the function of a problem."""
        return self.thing if isfunction(self.thing) else type(self.thing)

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """The parameters of a scheme or problem; empty for other objects."""
        if isfunction(self.thing):
            return function_parameters(self.thing)
        return dataclass_parameters(self.subject) if isinstance(self.thing, Scheme) else ()

    @property
    def in_matrix(self) -> tuple[Any, ...]:
        """Objects of a run of everything: specifications of a problem, all variants of a scheme, a measure."""
        if isfunction(self.thing):
            return matrix_specs(self.thing)
        return () if all(getattr(thing, "on_request", False) for thing in self.things) else self.things

    @property
    def on_request(self) -> bool:
        """Whether a run of everything omits it."""
        return not self.in_matrix

    @property
    def variants(self) -> tuple[Any, ...]:
        """Objects that a glob selects: all variants of a scheme; the specifications of a problem, or its defaults."""
        if not isfunction(self.thing):
            return self.things
        return tuple(replace(spec, schemes=(), measures=()) for spec in self.in_matrix) or (self.make(),)

    def make(self, texts: Mapping[str, str] | None = None) -> Any:
        """Return a scheme, or the specification of a problem, with parameters given as the texts of a label.

        Raises
        ------
        ParameterError
            If a parameter is unknown or its value is not accepted.
        UsageError
            If the object is a measure, which has no parameters.
        """
        if isfunction(self.thing):
            return problem_spec(self.thing, texts)
        if not isinstance(self.thing, Scheme):
            if texts:
                raise UsageError(f"measure {self.name!r} takes no parameters")
            return self.thing
        owner = f"scheme {self.name!r}"
        values = read_values(owner, self.parameters, texts or {})
        try:
            return self.subject(**values)
        except FAULTS as error:
            raise ParameterError(f"{owner}: {one_line(error)}") from error


# Registered objects by hook and name.
Entries = Mapping[str, Mapping[str, Registered]]


def collect(plugin: object, origin: Origin, disabled: frozenset[str] = frozenset()) -> Entries:
    """Return the objects that a plugin registers, by hook; only hooks that it implements are included.

    Parameters
    ----------
    plugin : module or object with hooks
    origin : Origin
    disabled : frozenset of str
        Names of disabled plugins: the hooks that they define are not called, and register nothing.

    Raises
    ------
    PluginError, UsageError
        If a hook is misspelt, not marked or returns something unusable; errors of the hooks pass through.
    """
    manager = pluggy.PluginManager(hookspecs.PROJECT)
    manager.add_hookspecs(hookspecs)
    manager.register(plugin, origin.plugin)
    callers = {caller.name: caller for caller in manager.get_hookcallers(plugin) or ()}
    _check_hooks(plugin, callers)
    off = {hook for hook, entry in further_hooks().items() if is_disabled(origin_of(entry), disabled)}
    return {hook: {} if hook in off else _entries(hook, callers[hook], origin) for hook in sorted(callers)}


def word_of(hook: str) -> str:
    """Return the noun for an object that a hook registers, such as ``scheme``."""
    return hook.partition("_")[2].removesuffix("s")


@cache
def further_hooks() -> Mapping[str, EntryPoint]:
    """Return the hooks that plugins define, each with the entry point of the class of its objects."""
    return {entry.name: entry for entry in entry_points(FURTHER)}


def known_hooks() -> list[str]:
    """Return the sorted names of all hooks."""
    return sorted({*HOOKS, *further_hooks()})


def _check_hooks(plugin: object, callers: Mapping[str, pluggy.HookCaller]) -> None:
    known = known_hooks()
    functions = {impl.function.__name__ for caller in callers.values() for impl in caller.get_hookimpls()}
    for name in sorted(set(known) - set(callers) - functions):
        if isroutine(getattr(plugin, name, None)):
            raise PluginError(f"function {name} is not marked as a hook; put @hookimpl above it")
    for hook in sorted(set(callers) - set(known)):
        raise PluginError(f"unknown hook {hook}{did_you_mean(hook, known)} (known: {', '.join(known)})")


def _entries(hook: str, caller: pluggy.HookCaller, origin: Origin) -> dict[str, Registered]:
    if hook == REPORT:
        return {str(origin): Registered(str(origin), (caller,), origin)}
    name_of = NAMING.get(hook) or _naming(hook)
    found: dict[str, Registered] = {}
    for thing in _call(caller):
        name = name_of(thing)
        _check_pickles(f"{word_of(hook)} {getattr(thing, 'label', name)!r}", thing)
        known = found[name].things if name in found else ()
        for other in known:
            if hook != SCHEMES or type(other) is not type(thing) or other.label == thing.label:
                pair = " and ".join(getattr(each, "__qualname__", type(each).__qualname__) for each in (other, thing))
                raise PluginError(f"{word_of(hook)} {name!r} is registered twice by this plugin: {pair}")
        found[name] = Registered(name, (*known, thing), origin)
    return found


def _call(caller: pluggy.HookCaller) -> list[Any]:
    results = caller()
    if len(results) < len(caller.get_hookimpls()):
        raise PluginError(f"{caller.name} returned None, expected an iterable")
    for result in results:
        if not isinstance(result, Iterable):
            raise PluginError(f"{caller.name} returned {result!r}, expected an iterable")
    return [thing for result in results for thing in result]


def _scheme_name(scheme: Scheme) -> str:
    check_scheme(scheme)
    return scheme.name


def _problem_name(function: Callable[..., object]) -> str:
    check_problem_function(function)
    return problem_name(function)  # type: ignore[arg-type] # its return type is checked when it is called


def _measure_name(measure: Any) -> str:
    if isinstance(measure, type):
        raise PluginError(f"expected a measure, got the class {measure.__name__}; write {measure.__name__}()")
    check_name("measure", getattr(measure, "name", None))
    return str(measure.name)


def _naming(hook: str) -> Callable[[Any], str]:
    """Return a function that checks and names the objects of a hook that a plugin defines."""
    kind = further_hooks()[hook].load()

    def name_of(thing: Any) -> str:
        if not isinstance(thing, kind):
            raise PluginError(f"{hook} expects each to be {kind.__name__}, got {describe(thing)}")
        return str(getattr(thing, "label", None) or thing.name)

    return name_of


# Functions that check that an object can be registered, and return its name.
NAMING: Mapping[str, Callable[[Any], str]] = {
    SCHEMES: _scheme_name,
    PROBLEMS: _problem_name,
    MEASURES: _measure_name,
}


def _check_pickles(what: str, thing: object) -> None:
    try:
        pickle.dumps(thing)
    except FAULTS as error:
        raise PluginError(
            f"{what} cannot be sent to worker processes ({one_line(error)}); define it at the top level of its module"
        ) from error
