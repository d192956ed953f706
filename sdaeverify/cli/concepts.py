"""Words of the framework, told by its docstrings and by what is registered: forms, traits, noise and the like."""

import inspect
from collections import Counter
from collections.abc import Callable, Iterator

from ..contracts.scheme import Claim, Scheme
from ..forms import Problem, known_traits
from ..noise.brownian import Increment
from ..noise.records import NoiseRecord
from ..registry.load import Registry
from ..report.passports import docstring
from .commands.catalogue import subject


def concept_names(registry: Registry) -> set[str]:
    """Return the words that `describe_concept` knows."""
    return {*CONCEPTS, *_forms(registry)}


def describe_concept(name: str, registry: Registry) -> list[str]:
    """Return what a word means, as lines of text: heading first.

    Parameters
    ----------
    name : str
        One of `concept_names`.
    registry : Registry
    """
    if name in CONCEPTS:
        return [name, *CONCEPTS[name](registry)]
    return [f"form {name}", *_form(_forms(registry)[name], registry)]


def _forms(registry: Registry) -> dict[str, type[Problem]]:
    """Return the forms that have a name of their own: those of the package, and those that a plugin uses."""
    found, waiting = dict[str, type[Problem]](), [Problem]
    while waiting:
        for form in waiting.pop().__subclasses__():
            waiting.append(form)
            found[form.__name__] = form
    used = {form.__name__ for scheme in _schemes(registry) for form in scheme.forms}
    return {name: form for name, form in found.items() if name in used or form.__module__.startswith("sdaeverify.")}


def _schemes(registry: Registry) -> list[Scheme]:
    return [entry.variants[0] for entry in registry.schemes.values()]


def _form(form: type[Problem], registry: Registry) -> Iterator[str]:
    yield from ("", *docstring(form).splitlines(), "")
    solving = (scheme.name for scheme in _schemes(registry) if form in scheme.forms)
    yield f"schemes that solve it: {', '.join(solving) or 'none'}"
    families = ((entry.name, inspect.signature(entry.family)) for entry in registry.problems.values())
    having = (name for name, signature in families if signature.return_annotation in {form, form.__name__})
    yield f"problems that are declared to have it: {', '.join(having) or 'none'}"
    yield f"traits that it declares: {', '.join(map(str, form.declared_traits)) or 'none'}"


def _traits(registry: Registry) -> Iterator[str]:
    for name, trait in sorted(known_traits().items()):
        asking = (
            scheme.name for scheme in _schemes(registry) if any(name in claim.when for claim in scheme.promises)
        )
        yield from ("", name, f"  {trait.meaning}", f"  asked for by claims of: {', '.join(asking) or 'none'}")


def _noise(registry: Registry) -> Iterator[str]:
    yield from ("", *docstring(Increment).splitlines(), "", *docstring(NoiseRecord).splitlines(), "")
    for name in sorted({name for scheme in _schemes(registry) for name in scheme.noise}):
        needing = (scheme.name for scheme in _schemes(registry) if name in scheme.noise)
        yield f"schemes that need {name}: {', '.join(needing)}"


def _claims(registry: Registry) -> Iterator[str]:
    yield from ("", *docstring(Claim).splitlines(), "")
    for measure, count in _count(registry).items():
        yield f"schemes with claims about {measure}: {count}"


def _measures(registry: Registry) -> Iterator[str]:
    count = _count(registry)
    for name, entry in registry.measures.items():
        lines = docstring(subject(entry)).splitlines() or [""]
        yield from ("", name, f"  {lines[0]}", f"  schemes with claims about it: {count[name]}")


def _count(registry: Registry) -> Counter[str]:
    return Counter(measure for scheme in _schemes(registry) for measure in {c.measure for c in scheme.promises})


CONCEPTS: dict[str, Callable[[Registry], Iterator[str]]] = {
    "claims": _claims,
    "measures": _measures,
    "noise": _noise,
    "traits": _traits,
}
