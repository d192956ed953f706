"""Selections: which schemes, problems and measures a request means.

::

    half-explicit-euler                    the scheme with its default parameters
    half-explicit-euler[truncation=none]   the scheme with these parameters
    half-*                                 all default variants of all names that match; ? is one character
    half-*[truncation=none]                each name that matches, with these parameters
    euler-maruyama,milstein                several; brackets keep their commas
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from fnmatch import fnmatchcase
from typing import Any, Protocol, TypeVar

from ..contracts.labels import parse_label, split_list
from ..contracts.scheme import Scheme
from ..contracts.specs import ProblemSpec, check_scheme, describe, problem_spec, unknown
from ..errors import UsageError
from ..forms import Problem
from .contributions import ProblemEntry, SchemeEntry
from .load import Registry

Texts = Mapping[str, str] | None


class Labelled(Protocol):
    """Anything with a name and a canonical label."""

    @property
    def name(self) -> str:
        """Registered name."""
        ...

    @property
    def label(self) -> str:
        """Canonical label."""
        ...


Entry = TypeVar("Entry")
Thing = TypeVar("Thing", bound=Labelled)


def select_schemes(registry: Registry, wanted: str | Scheme | Sequence[str | Scheme] = ()) -> list[Scheme]:
    """Return the schemes that are meant, without repetition, in the order of the registry.

    Parameters
    ----------
    registry : Registry
    wanted : sequence of str or Scheme
        Patterns and schemes, mixed; empty for all variants of everything that is not marked as run on request.

    Raises
    ------
    UsageError
        If a name is unknown, a pattern matches nothing, or two different schemes have one label.
    ParameterError
        If a parameter is unknown or its value is not accepted.
    """
    if not wanted and not isinstance(wanted, str):
        chosen = [one for entry in registry.schemes.values() if not entry.on_request for one in entry.variants]
    else:
        chosen = list(_chosen_schemes(registry, wanted))
    unique = _unique("scheme", chosen, type)
    return sorted(unique, key=lambda scheme: (scheme.name, _position(scheme, registry.schemes), scheme.label))


def select_problems(
    registry: Registry,
    wanted: str | ProblemSpec | Callable[..., Problem] | Sequence[str | ProblemSpec | Callable[..., Problem]] = (),
) -> list[ProblemSpec]:
    """Return the recipes of the problems that are meant, without repetition, in the order of the registry.

    Parameters
    ----------
    registry : Registry
    wanted : sequence of str, ProblemSpec or callable
        Patterns, recipes and problem functions, mixed; empty for everything with its parameters in the matrix, which
        are the defaults where a problem function is not marked with others or as run on request.

    Raises
    ------
    UsageError
        If a name is unknown, a pattern matches nothing, or two different problems have one label.
    ParameterError
        If a parameter is unknown or its text is no value of its type.
    """
    if not wanted and not isinstance(wanted, str):
        return [spec for _, entry in sorted(registry.problems.items()) for spec in entry.in_matrix]
    chosen: list[ProblemSpec] = []
    for item in _items("problem", wanted):
        if isinstance(item, str):
            for entry, texts, is_glob in _matches("problem", item, registry.problems):
                chosen += entry.variants if is_glob and texts is None else [entry.make(texts)]
        else:
            chosen.append(_recipe(item))
    unique = _unique("problem", chosen, lambda spec: spec.function)
    return sorted(unique, key=lambda spec: (spec.name, _place_in_matrix(spec, registry.problems), spec.label))


def select_measures(registry: Registry, wanted: Any = ()) -> list[Any]:
    """Return the measures that are meant, without repetition, sorted by name.

    Parameters
    ----------
    registry : Registry
    wanted : sequence of str or measure
        Patterns and measures, mixed; empty for everything.

    Raises
    ------
    UsageError
        If a name is unknown, a pattern matches nothing or has parameters, or two measures have one name.
    """
    chosen: dict[str, Any] = {}
    for item in _items("measure", wanted):
        found = _measures(registry, item) if isinstance(item, str) else [_measure(item)]
        for measure in found:
            if chosen.setdefault(measure.name, measure) is not measure:
                raise UsageError(f"two different measures are named {measure.name!r}; select one of them")
    return [chosen[name] for name in sorted(chosen)]


def only(kind: str, wanted: object, found: Sequence[Entry]) -> Entry:
    """Return the one thing that a label means.

    Parameters
    ----------
    kind, wanted : str
        What kind of thing is wanted, and the label.
    found : sequence
        What it means.

    Raises
    ------
    UsageError
        If it means none or several.
    """
    if len(found) != 1:
        raise UsageError(f"expected the label of one {kind}, got {wanted!r}, which means {len(found)}")
    return found[0]


def _chosen_schemes(registry: Registry, wanted: Any) -> Iterator[Scheme]:
    for item in _items("scheme", wanted):
        if isinstance(item, str):
            for entry, texts, is_glob in _matches("scheme", item, registry.schemes):
                yield from entry.variants if is_glob and texts is None else [entry.make(texts)]
        else:
            check_scheme(item)
            _require_own_name(item, registry)
            yield item


def _require_own_name(scheme: Scheme, registry: Registry) -> None:
    """Check that no other scheme is registered under the name of a given one: controls are found by their names."""
    entry = registry.schemes.get(scheme.name)
    if entry is not None and not registry.names(scheme):
        raise UsageError(
            f"a scheme that is given is named {scheme.name!r}, which is registered by {entry.origin}; "
            "give it a name of its own"
        )


def _items(kind: str, wanted: Any) -> Iterator[Any]:
    if wanted is not None and (isinstance(wanted, bytes) or not isinstance(wanted, Iterable)):
        # A single thing; whoever asked for it checks what it is.
        wanted = [wanted]
    everything = ["*"] if not wanted and not isinstance(wanted, str) else wanted
    for item in [everything] if isinstance(everything, str) else everything:
        patterns = split_list(item) if isinstance(item, str) else [item]
        if not patterns:
            raise UsageError(f"empty selection of {kind}s: {item!r}")
        yield from patterns


def _matches(kind: str, pattern: str, entries: Mapping[str, Entry]) -> Iterator[tuple[Entry, Texts, bool]]:
    name, texts = parse_label(pattern)
    is_glob = "*" in name or "?" in name
    names = [known for known in entries if fnmatchcase(known, name)] if is_glob else [name]
    # "*" alone asks for everything there is, which may be nothing.
    if (not names and name != "*") or (not is_glob and name not in entries):
        raise unknown(kind, name, entries)
    yield from ((entries[known], texts, is_glob) for known in names)


def _unique(kind: str, things: Iterable[Thing], identity: Callable[[Thing], object]) -> list[Thing]:
    chosen: dict[str, Thing] = {}
    for thing in things:
        if identity(chosen.setdefault(thing.label, thing)) is not identity(thing):
            raise UsageError(f"two different {kind}s are labelled {thing.label!r}; select one of them")
    return list(chosen.values())


def _position(scheme: Scheme, entries: Mapping[str, SchemeEntry]) -> int:
    variants = [variant.label for variant in entries[scheme.name].variants] if scheme.name in entries else []
    return variants.index(scheme.label) if scheme.label in variants else len(variants)


def _place_in_matrix(spec: ProblemSpec, entries: Mapping[str, ProblemEntry]) -> int:
    labels = [known.label for known in entries[spec.name].in_matrix] if spec.name in entries else []
    return labels.index(spec.label) if spec.label in labels else len(labels)


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


def _measures(registry: Registry, pattern: str) -> list[Any]:
    found = []
    for entry, texts, _ in _matches("measure", pattern, registry.measures):
        if texts:
            raise UsageError(f"measure {entry.name!r} takes no parameters, got {pattern!r}")
        found.append(entry.thing)
    return found
