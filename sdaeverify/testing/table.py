"""The table of checks: what the kit asks of a scheme, and of a problem."""

from collections.abc import Callable
from typing import Any

from ..conformance import contract
from ..errors import UsageError
from .check import Check
from .checks import (
    behaviour,
    declarations,
    discrimination,
    moments,
    problem_declarations,
    problem_functions,
    sampled,
    solutions,
    views,
)


def checks(kind: str) -> tuple[Check, ...]:
    """Return the checks of a ``scheme`` or of a ``problem``, in the order in which they are made.

    Raises
    ------
    UsageError
        If there is no such kind.
    """
    if kind not in TABLE:
        raise UsageError(f"there are checks of {' and '.join(TABLE)}, not of {kind!r}")
    return TABLE[kind]


def _of(category: str, *, each_problem: bool = False) -> Callable[..., Check]:
    def check(name: str, function: Callable[[Any], str], since: int = 1) -> Check:
        return Check(name, category, since, function, each_problem)

    return check


_api, _once, _truth = _of("api"), _of("behaviour"), _of("truths")
_step = _of("behaviour", each_problem=True)

SCHEME_CHECKS = (
    _api("declaration", declarations.usable),
    _api("label", declarations.named_again),
    _api("pickle", declarations.pickled),
    _api("frozen", declarations.unchangeable),
    _api("docstring", declarations.described),
    _api("source", declarations.sourced),
    _api("claims", declarations.claimed),
    _once("exact-on-trivial-equations", behaviour.exact),
    _step("inputs-untouched", behaviour.on_trials(contract.leaves_inputs_alone)),
    _step("state-like-its-own", behaviour.on_trials(contract.returns_its_kind)),
    _step("any-number-of-paths", behaviour.any_number),
    _step("finite", behaviour.on_trials(contract.stays_finite)),
    _step("same-call-same-bits", behaviour.on_trials(contract.repeats_itself)),
    _step("paths-in-any-order", behaviour.on_trials(contract.follows_the_paths)),
    _step("paths-alone", behaviour.alone),
    _step("declared-noise-only", behaviour.on_trials(contract.uses_declared_noise)),
    _step("noise-is-used", behaviour.on_trials(contract.hears_its_noise)),
    _step("own-memory", behaviour.on_trials(contract.keeps_no_noise)),
    _step("state-is-whole", behaviour.whole_state),
    _once("claims-tested", declarations.tested, since=2),
)
PROBLEM_CHECKS = (
    _api("declaration", problem_declarations.usable),
    _api("builds", problem_declarations.built),
    _api("label", problem_declarations.named_again),
    _api("pickle", problem_declarations.pickled),
    _api("docstring", problem_declarations.described),
    _api("source", problem_declarations.sourced),
    _api("in-matrix", problem_declarations.in_matrix),
    _api("relaxation", problem_declarations.relaxing),
    _once("consistent-start", problem_functions.consistent),
    _once("observables", problem_functions.observed),
    _once("path-by-path", problem_functions.path_by_path),
    _once("diffusion-product", problem_functions.multiplied),
    _once("diffusion-derivative", problem_functions.of_the_diffusion),
    _once("constraint-jacobian", problem_functions.of_the_constraint),
    _once("constraint-curvature", problem_functions.of_the_jacobian),
    _once("constraint-second-derivatives", problem_functions.of_the_gradients),
    _once("constraint-linearisation", problem_functions.structured),
    _once("force-derivatives", problem_functions.of_the_force),
    _once("delay-derivatives", problem_functions.of_a_delay_equation),
    _once("algebraic-solution", problem_functions.eliminated),
    _once("constraints-kept", views.kept),
    _once("view-equals-form", views.the_same),
    _once("traits", problem_declarations.traits_hold),
    _once("chart", problem_functions.charted),
    _truth("moments-start", moments.started),
    _truth("moments-rate", moments.moving),
    _truth("moments-settle", moments.settled),
    _truth("moments-simulated", sampled.moments_simulated),
    _truth("solution-start", solutions.started),
    _truth("solution-step", solutions.stepped),
    _truth("solution-still", solutions.still),
    _truth("solution-simulated", sampled.solution_simulated),
    _truth("solution-averaged", sampled.solution_averaged),
    _truth("controls", discrimination.discriminating),
)
TABLE = {"scheme": SCHEME_CHECKS, "problem": PROBLEM_CHECKS}
