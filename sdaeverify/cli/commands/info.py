"""``info``: print everything known about a registered entry or a term of the framework, heading first.

Terms are explained by docstrings and by registered entries: forms, traits, noise and the like.
"""

import inspect
from collections import Counter
from collections.abc import Callable, Collection, Iterator, Mapping
from itertools import chain
from typing import Any

import click
import numpy as np
from rich.console import Console
from rich.text import Text

import sdaeverify

from ... import forms
from ...contracts.labels import REQUIRED, Parameter, describe_kind, parse_label
from ...contracts.scheme import Claim, Scheme
from ...contracts.specs import ProblemSpec
from ...contracts.spelling import did_you_mean
from ...errors import FAULTS, ProblemError, SdaeverifyError, UsageError, one_line
from ...forms import Delayed, Dissipation, Problem, known_traits
from ...forms.guides import guide_of
from ...noise.brownian import Increment
from ...noise.records import NoiseRecord
from ...probe.linear.delay_equation import LARGE, SMALL, at_rest, is_autonomous, is_scalar, linear_delay
from ...registry.contributions import Registered
from ...registry.load import Registry
from ...report.passports import Passport, docstring, measure_passport, problem_passport, scheme_passport
from ...report.plain import visible
from ..completion import names_of
from ..console import output, output_to_stderr, print_json, print_texts
from ..exit_codes import ExitCode
from ..loading import load_quietly
from ..options import plugins

THETAS = (0.0, 0.25, 0.5, 1.0)
LISTED, TOLD_ABOVE = {"claims", "truths", "controls"}, {"label", "text", "parameters"}


@click.command(short_help="Describe a scheme, a problem, a measure, a plugin or a term.")
@click.argument("name", metavar="NAME[PARAMETERS]", shell_complete=names_of("schemes", "problems", "measures"))
@click.option("--json", "as_json", is_flag=True, help="For programs: a list of objects, one for each kind of thing.")
@plugins
def info(name: str, plugins: tuple[str, ...], as_json: bool) -> ExitCode:
    """Show all about a scheme, a problem, a measure or a plugin: equations, claims, truths, sources.

    NAME may also be a term: a form such as SDE, traits, noise, claims, measures, or a public name such as Scheme.
    """
    registry, label = load_quietly(plugins), parse_label(name)
    if label.name not in _names(registry):
        registry = load_quietly(plugins, lab=True)
    if label.name not in (known := _names(registry)):
        raise UsageError(
            f"no scheme, problem, measure or plugin is named {label.name!r}"
            f"{did_you_mean(label.name, known) or '; sdaeverify list shows all'}"
        )
    with output_to_stderr():
        told = list(_tell(registry, label.name, label.parameters or {}))
    if as_json:
        print_json([record for record, _ in told])
    else:
        _print(output(), [lines for _, lines in told])
    return ExitCode.OK


def _names(registry: Registry) -> set[str]:
    kinds = (registry.schemes, registry.problems, registry.measures, [row.name for row in registry.plugins])
    return {name for kind in kinds for name in kind} | concept_names(registry)


def _tell(registry: Registry, name: str, texts: Mapping[str, str]) -> Iterator[tuple[Passport, list[str]]]:
    """Yield each entry with the given name, as a record and as lines, heading first."""
    for kind in (registry.schemes, registry.problems, registry.measures):
        if name in kind:
            yield _tell_entry(kind[name], texts)
    if name in concept_names(registry):
        lines = describe_concept(name, registry)
        yield {"kind": "word", "text": "\n".join(lines)}, lines
    for row in registry.plugins:
        if row.name == name:
            record = row._asdict()
            yield record, [f"plugin {name}", *(f"{key}: {value}" for key, value in record.items() if value != "")]


def _print(console: Console, sections: list[list[str]]) -> None:
    for number, lines in enumerate(sections):
        if number:
            console.print()
        console.print(Text(visible(lines[0]), style="bold"), soft_wrap=True)
        print_texts(console, lines[1:])


def stability_lines(given: Problem) -> list[str]:
    """Return growth rates, condition (4.1), its constants and its step sizes; empty without delay."""
    problem = given.capability(Delayed)
    if problem is None:
        return []
    lines = [*_growth(problem), *(_condition(problem.dissipation) if problem.dissipation else [])]
    own = problem.dissipation_without_y
    if own and not (problem.dissipation and own.C <= problem.dissipation.C):
        lines += [f"with y eliminated, {line}" for line in _condition(own)]
    return ["mean-square stability:", *(f"  {line}" for line in lines)] if lines else []


def _growth(problem: Delayed) -> list[str]:
    if not (is_scalar(problem) and at_rest(problem) and is_autonomous(problem)):
        return []
    small, large = (linear_delay(problem, size).growth_rate for size in (SMALL, LARGE))
    between = (
        "" if abs(large - small) <= 1e-9 * (1.0 + abs(small)) else f" at small states, {large:.5g} at large ones"
    )
    return [f"growth rate of E x^2: {small:.5g}{between}"]


def _condition(known: Dissipation) -> list[str]:
    constants = ", ".join(f"{name} = {value:g}" for name, value in known._asdict().items())
    if known.C <= 0.0:
        return [f"condition (4.1) fails: C = {known.C:g}; {constants}"]
    steps = ((theta, known.largest_step(theta), known.sharp_step(theta)) for theta in THETAS)
    bounds = [f"theta = {theta:g}: stable below h_0 = {h:.5g}, sharpened {more:.5g}" for theta, h, more in steps]
    return [f"condition (4.1) holds: C = {known.C:g}; {constants}", *bounds]


def _tell_entry(entry: Registered, texts: Mapping[str, str]) -> tuple[Passport, list[str]]:
    """Return the passport of a scheme, problem or measure, and its lines.

    Parameters
    ----------
    entry : Registered
    texts : mapping of str to str
        Parameters as written in a label.

    Raises
    ------
    UsageError
        If a parameter is unknown or its value is not accepted.
    ProblemError
        If the problem cannot be built.
    """
    thing, stability = entry.make(texts), list[str]()
    if isinstance(thing, Scheme):
        kind, told = "scheme", scheme_passport(thing)
    elif isinstance(thing, ProblemSpec):
        problem = make(thing.label, thing.build, given=bool(texts))
        kind, told, stability = "problem", problem_passport(thing, problem), stability_lines(problem)
    else:
        kind, told = "measure", measure_passport(thing)
    parts = (told["text"].splitlines(), _parameters(entry), [*_facts(told), *stability], [f"from {entry.origin}"])
    lines = (line for part in parts if part for line in ("", *part))
    return {"kind": kind, **told}, [f"{kind} {told['label']}", *lines]


def _facts(told: Passport) -> Iterator[str]:
    """Yield the lines of a passport other than label, text and parameters, under its keys."""
    for name, value in told.items():
        if name in LISTED:
            yield f"{name}:" if value else f"{name}: none"
            yield from (f"  {_item(each)}" for each in value)
        elif name not in TOLD_ABOVE:
            yield f"{name}: {(', '.join(value) if isinstance(value, list) else value) or 'none'}"


def _item(told: str | Mapping[str, Any]) -> str:
    if isinstance(told, str):
        return told
    (_, what), (_, value), *others = told.items()
    words = (f"{key} {', '.join(each) if isinstance(each, list) else each}" for key, each in others if each)
    return "; ".join([f"{what}: {value}", *words])


def _parameters(entry: Registered) -> list[str]:
    if not entry.parameters:
        return []
    choices = entry.thing.choices if isinstance(entry.thing, Scheme) else {}
    return ["parameters and defaults:", *(f"  {_parameter(p, choices.get(p.name, ()))}" for p in entry.parameters)]


def _parameter(told: Parameter, choices: Collection[str]) -> str:
    value = "required" if told.default is REQUIRED else told.default
    kind = f"one of {', '.join(choices)}" if choices else describe_kind(told.default)
    return f"{told.name} = {value}  ({kind})"


def make(label: str, build: Callable[[], Problem], *, given: bool) -> Problem:
    """Build a problem and raise the error that fits the origin of its parameters.

    Parameters
    ----------
    label : str
        Problem with its parameters, for messages.
    build : callable, () -> Problem
    given : bool
        Whether the parameters come from the user, so that a rejected one is a usage error.

    Raises
    ------
    UsageError
        If the parameters are not accepted.
    ProblemError
        If the problem cannot be built.
    """
    try:
        # The problem reports numbers that are not finite, in one line.
        with np.errstate(all="ignore"):
            return build()
    except FAULTS as error:
        kind = UsageError if given and isinstance(error, SdaeverifyError) else ProblemError
        raise kind(f"problem {label} cannot be built: {one_line(error)}") from error


def concept_names(registry: Registry) -> set[str]:
    """Return the terms that `describe_concept` explains."""
    return {*CONCEPTS, *_forms(registry), *sdaeverify.__all__}


def describe_concept(name: str, registry: Registry) -> list[str]:
    """Return the explanation of a term as lines of text, heading first.

    Parameters
    ----------
    name : str
        Element of `concept_names`.
    registry : Registry
    """
    if name in CONCEPTS:
        return [name, *CONCEPTS[name](registry)]
    if name in (known := _forms(registry)):
        return [f"form {name}", *_form(known[name], registry)]
    return [f"sdaeverify.{name}", "", *docstring(getattr(sdaeverify, name)).splitlines()]


def _forms(registry: Registry) -> dict[str, type[Problem]]:
    """Return the forms by name: those of the package, and those of registered schemes."""
    used = (form for scheme in _schemes(registry) for form in scheme.forms)
    own = (each for each in vars(forms).values() if isinstance(each, type) and issubclass(each, Problem))
    return {form.__name__: form for form in (*own, *used) if form is not Problem}


def _schemes(registry: Registry) -> list[Scheme]:
    return [entry.thing for entry in registry.schemes.values()]


def _form(form: type[Problem], registry: Registry) -> Iterator[str]:
    yield from ("", *docstring(form).splitlines(), "")
    if guide := guide_of(form):
        yield from ("A scheme for it", "---------------", *guide.splitlines(), "")
    solving = [scheme.name for scheme in _schemes(registry) if issubclass(form, scheme.forms)]
    yield f"schemes that solve it: {', '.join(solving) or 'none'}"
    functions = ((entry, inspect.signature(entry.thing)) for entry in registry.problems.values())
    having = [entry for entry, signature in functions if signature.return_annotation in {form, form.__name__}]
    if having:
        example = having[0].make({})
        problem = make(example.label, example.build, given=False)
        seen = [
            scheme.name for scheme in _schemes(registry) if scheme.view_of(problem) and scheme.name not in solving
        ]
        if seen:
            yield f"schemes that solve {example.label} in another form: {', '.join(seen)}"
    yield f"problems of this form: {', '.join(entry.name for entry in having) or 'none'}"
    yield f"traits that it declares: {', '.join(map(str, form.declared_traits)) or 'none'}"


def _traits(registry: Registry) -> Iterator[str]:
    declared = {name: trait for form in _forms(registry).values() for name, trait in known_traits(form).items()}
    for name, trait in sorted(declared.items()):
        asking = (
            scheme.name for scheme in _schemes(registry) if any(name in claim.when for claim in scheme.promises)
        )
        yield from ("", name, f"  {trait.meaning}", f"  asked for by claims of: {', '.join(asking) or 'none'}")


def _noise(registry: Registry) -> Iterator[str]:
    yield from ("", *docstring(Increment).splitlines(), "", "methods of an increment:", *_methods(Increment), "")
    yield from (*docstring(NoiseRecord).splitlines(), "")
    for name in sorted({name for scheme in _schemes(registry) for name in scheme.noise}):
        needing = (scheme.name for scheme in _schemes(registry) if name in scheme.noise)
        yield f"schemes that need {name}: {', '.join(needing)}"


def _methods(kind: type) -> Iterator[str]:
    """Yield the public methods of a class with their arguments and the first line of their docstring."""
    for name, method in vars(kind).items():
        if inspect.isfunction(method) and not name.startswith("_"):
            arguments = [each for each in inspect.signature(method).parameters if each != "self"]
            yield f"  {name}({', '.join(arguments)}): {docstring(method).partition(chr(10))[0]}"


def _claims(registry: Registry) -> Iterator[str]:
    yield from ("", *docstring(Claim).splitlines(), "")
    for measure, count in _count(registry).items():
        yield f"schemes with claims about {measure}: {count}"


def _measures(registry: Registry) -> Iterator[str]:
    count = _count(registry)
    for name, entry in registry.measures.items():
        lines = docstring(entry.subject).splitlines() or [""]
        yield from ("", name, f"  {lines[0]}", f"  schemes with claims about it: {count[name]}")


def _count(registry: Registry) -> Counter[str]:
    claimed = (dict.fromkeys(claim.measure for claim in scheme.promises) for scheme in _schemes(registry))
    return Counter(chain.from_iterable(claimed))


CONCEPTS: dict[str, Callable[[Registry], Iterator[str]]] = {
    "claims": _claims,
    "measures": _measures,
    "noise": _noise,
    "traits": _traits,
}
