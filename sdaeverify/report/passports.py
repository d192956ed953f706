"""Passports: descriptions of schemes, problems and measures as records of text for the page and for JSON."""

import inspect
from collections.abc import Callable
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from ..contracts.claimed import Order
from ..contracts.labels import dataclass_parameters, function_parameters
from ..contracts.measure import Measure
from ..contracts.scheme import Claim, Scheme, form_names
from ..contracts.specs import ProblemSpec
from ..errors import FAULTS, one_line
from ..forms import Problem
from ..forms.truths import InvariantMean, Moment, MomentEquation, Pathwise, Truth
from ..noise.laws import GAUSSIAN

if TYPE_CHECKING:
    from ..study import Plan

Passport = dict[str, Any]


def passports(plan: "Plan") -> dict[str, dict[str, Passport]]:
    """Return the passports of all schemes, problems and measures of a plan, by label or name."""
    schemes = {cell.scheme.label: cell.scheme for cell in plan.cells}
    problems = {made.spec.label: (made.spec, made.problem) for made in plan.problems}
    measures = {cell.measure.name: cell.measure for cell in plan.cells}
    return {
        "schemes": {label: _tell(label, scheme_passport, scheme) for label, scheme in schemes.items()},
        "problems": {label: _tell(label, problem_passport, *made) for label, made in problems.items()},
        "measures": {name: _tell(name, measure_passport, measure) for name, measure in measures.items()},
    }


def _tell(label: str, tell: Callable[..., Passport], *things: Any) -> Passport:
    """Return a passport, or a record with the error if the code of a plugin fails."""
    try:
        return tell(*things)
    except FAULTS as error:
        return {"label": label, "text": f"not known: {one_line(error)}"}


def scheme_passport(scheme: Scheme) -> Passport:
    """Return the description of a scheme: formula, parameters, form, claims, source."""
    given = {parameter.name: str(getattr(scheme, parameter.name)) for parameter in dataclass_parameters(type(scheme))}
    return {
        "label": scheme.label,
        "text": docstring(type(scheme)),
        "form": form_names(scheme),
        "noise": noise_in_words(scheme),
        "parameters": given,
        "claims": [_claim(claim) for claim in scheme.promises],
        "source": scheme.source,
    }


def noise_in_words(scheme: Scheme) -> str:
    """Return the random variables that a scheme needs, such as dW and areas A, and their law if not normal."""
    needed = ", ".join(sorted(scheme.noise, key=lambda name: (name != "dW", name))) or "none"
    return needed if scheme.law is GAUSSIAN else f"{needed} ({scheme.law.name})"


def problem_passport(spec: ProblemSpec, problem: Problem | None) -> Passport:
    """Return the description of a problem: equation, parameters, traits, truths, controls, source."""
    defaults = {p.name: str(p.default) for p in function_parameters(spec.function)}
    known = {
        "label": spec.label,
        "text": docstring(spec.function),
        "parameters": {**defaults, **{name: str(value) for name, value in dict(spec.parameters).items()}},
    }
    if problem is None:
        return known
    return {
        **known,
        "form": type(problem).__name__,
        "noise": problem.noise_dim,
        "horizon": problem.horizon,
        "units": problem.units,
        "traits": sorted(problem.traits),
        "observables": list(problem.observables),
        "truths": [truth_in_words(truth) for truth in problem.truths],
        "controls": [asdict(control) for control in problem.controls],
        "source": problem.source,
    }


def measure_passport(measure: Measure) -> Passport:
    """Return the description of a measure, from the docstrings of its class and of its module."""
    module = inspect.cleandoc(getattr(inspect.getmodule(type(measure)), "__doc__", None) or "")
    return {"label": measure.name, "text": "\n\n".join(filter(None, (docstring(type(measure)), module)))}


def docstring(thing: object) -> str:
    """Return the docstring of a class or function, or an empty string."""
    own = vars(thing).get("__doc__") if isinstance(thing, type) else thing.__doc__
    text = inspect.cleandoc(own or "")
    # dataclasses replaces a missing docstring by the signature.
    return "" if isinstance(thing, type) and text.startswith(f"{thing.__name__}(") else text


def truth_in_words(truth: Truth) -> str:
    """Return the kind of a truth and its source in words."""
    if isinstance(truth, Pathwise):
        kind = "exact" if truth.exact else f"by a reference of strong order {truth.order}"
        return f"the path, {kind} ({truth.source})"
    if isinstance(truth, Moment):
        return f"E {truth.observable} at every time ({truth.source})"
    if isinstance(truth, InvariantMean):
        return f"E {truth.observable} = {truth.value:.6g} under the invariant law ({truth.source})"
    if isinstance(truth, MomentEquation):
        return f"E {truth.name} = 0 under the invariant law, L the generator ({truth.source})"
    return f"mean-square {'stable' if truth.stable else 'not stable'} ({truth.source})"


def _claim(claim: Claim) -> Passport:
    return {
        "measure": claim.measure,
        "claim": str(claim),
        "quantities": list(claim.quantities),
        "when": sorted(claim.when),
        "sense": claim.sense,
        "margin": claim.value.margin if isinstance(claim.value, Order) else None,
        "source": claim.source,
    }
