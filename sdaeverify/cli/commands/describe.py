"""All that is known of one registered thing, as lines of text: heading first."""

import inspect
from collections.abc import Callable, Mapping

import numpy as np

from ...contracts.labels import REQUIRED, describe_kind
from ...contracts.scheme import Claim, Scheme, form_names
from ...errors import FAULTS, ProblemError, SdaeverifyError, UsageError, one_line
from ...forms import Delayed, Dissipation, Problem
from ...forms.controls import Control
from ...probe.linear.delay_map import LARGE, SMALL, at_rest, is_autonomous, is_scalar, linear_delay
from ...registry.contributions import MeasureEntry, ProblemEntry, SchemeEntry
from ...registry.load import PluginRow
from ...report.passports import docstring, truth_in_words
from .catalogue import AnyEntry, parameters_of, subject

# What is known of the mean-square stability of an equation with a delay, in lines for the terminal.


THETAS = (0.0, 0.25, 0.5, 1.0)


def stability_lines(given: Problem) -> list[str]:
    """Return growth rates, condition (4.1) with its constants and the step sizes it promises; empty without delay."""
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
    steps = ((theta, known.largest_step(theta), known.sharpened(theta)) for theta in THETAS)
    bounds = [f"theta = {theta:g}: stable below h_0 = {h:.5g}, sharpened {more:.5g}" for theta, h, more in steps]
    return [f"condition (4.1) holds: C = {known.C:g}; {constants}", *bounds]


def describe_entry(entry: AnyEntry, texts: Mapping[str, str]) -> list[str]:
    """Describe a scheme, problem or measure.

    Parameters
    ----------
    entry : SchemeEntry, ProblemEntry or MeasureEntry
    texts : mapping of str to str
        Parameters as written in a label.

    Raises
    ------
    UsageError
        If a parameter is unknown or its value is not accepted.
    ProblemError
        If the problem cannot be built.
    """
    lines = [*_docstring(entry), *_parameters(entry)]
    if isinstance(entry, SchemeEntry):
        scheme = entry.make(texts)
        lines = [f"scheme {scheme.label}", *lines, *_scheme(scheme)]
    elif isinstance(entry, ProblemEntry):
        spec = entry.make(texts)
        lines = [f"problem {spec.label}", *lines, *_problem(built(spec.label, spec.build, given=bool(texts)))]
    else:
        if texts:
            raise UsageError(f"measure {entry.name!r} takes no parameters")
        lines = [f"measure {entry.name}", *lines]
    return [*lines, "", f"from {entry.origin}"]


def describe_plugin(row: PluginRow) -> list[str]:
    """Describe a plugin."""
    return [f"plugin {row.name}", *(f"{key}: {value}" for key, value in row._asdict().items() if value != "")]


def _docstring(entry: AnyEntry) -> list[str]:
    thing = subject(entry)
    texts = [docstring(thing)]
    if isinstance(entry, MeasureEntry):
        # What a measure asks and how it judges stands at the top of its file.
        texts.append(inspect.cleandoc(getattr(inspect.getmodule(thing), "__doc__", None) or ""))
    return [line for text in texts if text for line in ("", *text.splitlines())]


def _parameters(entry: AnyEntry) -> list[str]:
    parameters = parameters_of(entry)
    if not parameters:
        return []
    lines = [
        f"  {p.name} = {'required' if p.default is REQUIRED else p.default}  ({describe_kind(p.default)})"
        for p in parameters
    ]
    return ["", "parameters and defaults:", *lines]


def _scheme(scheme: Scheme) -> list[str]:
    claims = [f"  {claim.measure}: {_claim(claim)}" for claim in scheme.promises]
    heading = "claims:" if claims else "claims: none"
    return ["", f"form: {form_names(scheme)}", heading, *claims, f"source: {scheme.source or 'not given'}"]


def _claim(claim: Claim) -> str:
    of = f" of {', '.join(claim.quantities)}" if claim.quantities else ""
    when = f" for problems with {', '.join(sorted(claim.when))}" if claim.when else ""
    return f"{claim}{of}{when}, margin {claim.margin} ({claim.source})"


def built(label: str, build: Callable[[], Problem], *, given: bool) -> Problem:
    """Return a problem; `given` tells whether the user chose its parameters.

    Raises
    ------
    UsageError
        If the parameters are not accepted.
    ProblemError
        If it cannot be built.
    """
    try:
        # A number that is not finite is said in one line, by the problem.
        with np.errstate(all="ignore"):
            return build()
    except FAULTS as error:
        kind = UsageError if given and isinstance(error, SdaeverifyError) else ProblemError
        raise kind(f"problem {label} cannot be built: {one_line(error)}") from error


def _problem(problem: Problem) -> list[str]:
    lines = [
        f"form: {type(problem).__name__}",
        f"Brownian motions: {problem.noise_dim}",
        f"horizon: {problem.horizon}",
        f"units: {problem.units}",
        f"traits: {', '.join(sorted(problem.traits)) or 'none'}",
        f"observables: {', '.join(problem.observables) or 'none'}",
        "truths:" if problem.truths else "truths: none",
    ]
    truths = [f"  {truth_in_words(truth)}" for truth in problem.truths]
    truths += stability_lines(problem)
    controls = ["controls:", *(f"  {_control(control)}" for control in problem.controls)]
    return ["", *lines, *truths, *(controls if problem.controls else ["controls: none"]), f"source: {problem.source}"]


def _control(control: Control) -> str:
    return f"{control.measure} order {control.order}: {control.positive}, and not {control.negative}"
