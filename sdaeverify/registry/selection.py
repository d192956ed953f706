"""Selection of schemes, problems and measures by name, pattern or object.

::

    half-explicit-euler                    the scheme with its default parameters
    half-explicit-euler[truncation=none]   the scheme with these parameters
    half-*                                 all default variants of all names that match; ? is one character
    half-*[truncation=none]                each name that matches, with these parameters
    euler-maruyama,milstein                several; commas inside brackets do not separate
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from fnmatch import fnmatchcase
from typing import Any, TypeVar

from ..contracts.labels import parse_label, split_list
from ..contracts.scheme import Scheme
from ..contracts.specs import ProblemSpec, check_scheme, describe, problem_spec, unknown
from ..errors import UsageError
from ..forms import Problem
from .contributions import Registered
from .discovery import OWN_DISTRIBUTION
from .load import Registry

Thing = TypeVar("Thing")


def select_schemes(registry: Registry, wanted: str | Scheme | Sequence[str | Scheme] = ()) -> list[Scheme]:
    """Return the selected schemes, without repetition, in the order of the registry.

    Parameters
    ----------
    registry : Registry
    wanted : sequence of str or Scheme
        Patterns and schemes, mixed; if empty, all variants of all schemes not marked as run on request.

    Raises
    ------
    UsageError
        If a name is unknown, a pattern matches no scheme, or two different schemes have one label.
    ParameterError
        If a parameter is unknown or its value is not accepted.
    """

    def given(scheme: Any) -> Any:
        check_scheme(scheme)
        # A given scheme must not share the name of another registered one, because controls are found by name.
        entry = registry.schemes.get(scheme.name)
        if entry is not None and not registry.names(scheme):
            raise UsageError(
                f"the given scheme is named {scheme.name!r}, like one registered by {entry.origin}; "
                "give it another name"
            )
        return scheme

    return _select("scheme", registry, wanted, given)


def select_problems(
    registry: Registry,
    wanted: str | ProblemSpec | Callable[..., Problem] | Sequence[str | ProblemSpec | Callable[..., Problem]] = (),
) -> list[ProblemSpec]:
    """Return the specifications of the selected problems, without repetition, in the order of the registry.

    Parameters
    ----------
    registry : Registry
    wanted : sequence of str, ProblemSpec or callable
        Patterns, specifications and problem functions, mixed; if empty, all problems with their parameters in the
        matrix. These are the defaults unless the problem function is marked with others or as run on request.

    Raises
    ------
    UsageError
        If a name is unknown, a pattern matches no problem, or two different problems have one label.
    ParameterError
        If a parameter is unknown or its text cannot be converted to its type.
    """
    found = _select("problem", registry, wanted, _recipe)
    return [replace(spec, bound=_known_schemes(registry, spec)) if spec.schemes else spec for spec in found]


def select_measures(registry: Registry, wanted: Any = ()) -> list[Any]:
    """Return the selected measures, without repetition, sorted by name.

    Parameters
    ----------
    registry : Registry
    wanted : sequence of str or measure
        Patterns and measures, mixed; if empty, all measures.

    Raises
    ------
    UsageError
        If a name is unknown, a pattern matches no measure or has parameters, or two measures have one name.
    """
    return _select("measure", registry, wanted, _measure)


def _known_schemes(registry: Registry, spec: ProblemSpec) -> frozenset[str] | None:
    """Return the names of the schemes that a problem's author could name; None if the problem has no plugin.

    These schemes belong to the framework, or to the distribution or file of the problem.
    """
    if spec.name not in registry.problems:
        return None
    authors = {OWN_DISTRIBUTION, registry.problems[spec.name].origin.author}
    return frozenset(name for name, entry in registry.schemes.items() if entry.origin.author in authors)


def only(kind: str, wanted: object, found: Sequence[Thing]) -> Thing:
    """Return the only object that a label selects.

    Parameters
    ----------
    kind, wanted : str
        The kind of object, and the label.
    found : sequence
        The objects selected by the label.

    Raises
    ------
    UsageError
        If there is not exactly one object.
    """
    if len(found) != 1:
        raise UsageError(f"expected the label of one {kind}, got {wanted!r}, which matches {len(found)}")
    return found[0]


def _select(kind: str, registry: Registry, wanted: Any, given: Callable[[Any], Any]) -> list[Any]:
    """Return the selected objects, each once; `given` checks items that are not patterns."""
    entries = _kinds(registry)[kind]
    if not wanted and not isinstance(wanted, str):
        found: Iterable[Any] = (thing for entry in entries.values() for thing in entry.in_matrix)
    else:
        found = _chosen(kind, registry, wanted, given)
    chosen: dict[str, Any] = {}
    for thing in found:
        if _identity(chosen.setdefault(_label(thing), thing)) is not _identity(thing):
            raise UsageError(f"two different {kind}s are labelled {_label(thing)!r}; select one of them")
    places = {
        name: {_label(variant): place for place, variant in enumerate(entries[name].variants)}
        for name in {thing.name for thing in chosen.values()} & entries.keys()
    }

    def rank(thing: Any) -> tuple[str, int, str]:
        known = places.get(thing.name, {})
        return thing.name, known.get(_label(thing), len(known)), _label(thing)

    return sorted(chosen.values(), key=rank)


def _label(thing: Any) -> str:
    return str(getattr(thing, "label", thing.name))


def _identity(thing: Any) -> object:
    """Return the object by which two selected objects with the same label are compared."""
    if isinstance(thing, ProblemSpec):
        return thing.function
    return type(thing) if isinstance(thing, Scheme) else thing


def _kinds(registry: Registry) -> dict[str, Mapping[str, Registered]]:
    return {"scheme": registry.schemes, "problem": registry.problems, "measure": registry.measures}


def _unknown(kind: str, name: str, registry: Registry) -> UsageError:
    """Return the error for an unknown name, which says if the name is registered as another kind."""
    others = [other for other, entries in _kinds(registry).items() if other != kind and name in entries]
    if others:
        return UsageError(f"expected a {kind}, {name!r} is a {others[0]}; sdaeverify list {kind}s shows all {kind}s")
    return unknown(kind, name, _kinds(registry)[kind])


def _chosen(kind: str, registry: Registry, wanted: Any, given: Callable[[Any], Any]) -> Iterator[Any]:
    entries = _kinds(registry)[kind]
    for item in _items(kind, wanted):
        if not isinstance(item, str):
            yield given(item)
            continue
        name, texts = parse_label(item)
        is_glob = "*" in name or "?" in name
        names = [known for known in entries if fnmatchcase(known, name)] if is_glob else [name]
        # "*" alone selects all objects, of which there may be none.
        if (not names and name != "*") or (not is_glob and name not in entries):
            raise _unknown(kind, name, registry)
        for entry in (entries[known] for known in names):
            yield from entry.variants if is_glob and texts is None else [entry.make(texts)]


def _items(kind: str, wanted: Any) -> Iterator[Any]:
    # A single object may be given; the caller's `given` checks its type.
    several = isinstance(wanted, Iterable) and not isinstance(wanted, bytes | str)
    for item in wanted if several else [wanted]:
        patterns = split_list(item) if isinstance(item, str) else [item]
        if not patterns:
            raise UsageError(f"empty selection of {kind}s: {item!r}")
        yield from patterns


def _recipe(item: object) -> ProblemSpec:
    if isinstance(item, ProblemSpec):
        return item
    if isinstance(item, Problem):
        raise UsageError(f"expected a function that returns a problem, got {describe(item)}: pass it uncalled")
    return problem_spec(item)  # type: ignore[arg-type] # checked there


def _measure(item: Any) -> Any:
    if isinstance(item, type | Scheme) or not isinstance(getattr(item, "name", None), str):
        raise UsageError(f"expected a measure or its name, got {describe(item)}")
    return item
