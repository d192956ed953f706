"""Table of the checks of schemes and problems."""

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
        If `kind` is unknown.
    """
    if kind not in TABLE:
        raise UsageError(f"there are checks of {' and '.join(TABLE)}, not of {kind!r}")
    return TABLE[kind]


def _category(category: str, *, each_problem: bool = False) -> Callable[..., Check]:
    def check(name: str, function: Callable[[Any], str], since: int = 1) -> Check:
        return Check(name, category, since, function, each_problem)

    return check


_api, _once, _truth = _category("api"), _category("behaviour"), _category("truths")
_step = _category("behaviour", each_problem=True)

SCHEME_CHECKS = (
    _api("declaration", declarations.check_usable),
    _api("label", declarations.check_label),
    _api("pickle", declarations.check_pickling),
    _api("frozen", declarations.check_frozen),
    _api("docstring", declarations.check_docstring),
    _api("source", declarations.check_source),
    _api("claims", declarations.check_claims),
    _once("exact-on-trivial-equations", behaviour.check_exactness),
    _step("inputs-untouched", behaviour.on_trials(contract.leaves_inputs_alone)),
    _step("state-like-its-own", behaviour.on_trials(contract.returns_its_kind)),
    _step("any-number-of-paths", behaviour.check_any_number),
    _step("finite", behaviour.on_trials(contract.stays_finite)),
    _step("same-call-same-bits", behaviour.on_trials(contract.repeats_itself_for_long)),
    _step("paths-in-any-order", behaviour.on_trials(contract.follows_the_paths)),
    _step("paths-alone", behaviour.check_alone),
    _step("any-number-of-steps", behaviour.check_any_count, since=2),
    _step("declared-noise-only", behaviour.on_trials(contract.uses_declared_noise)),
    _step("equation-alone", behaviour.on_trials(contract.reads_only_the_equation), since=2),
    _step("noise-is-used", behaviour.on_trials(contract.hears_its_noise)),
    _step("own-memory", behaviour.on_trials(contract.keeps_no_noise)),
    _step("state-is-whole", behaviour.check_whole_state),
    _once("claims-tested", declarations.check_claims_tested, since=2),
)
PROBLEM_CHECKS = (
    _api("declaration", problem_declarations.check_usable),
    _api("builds", problem_declarations.check_builds),
    _api("label", problem_declarations.check_label),
    _api("pickle", problem_declarations.check_pickling),
    _api("docstring", problem_declarations.check_docstring),
    _api("source", problem_declarations.check_sources),
    _api("in-matrix", problem_declarations.check_in_matrix),
    _api("relaxation", problem_declarations.check_relaxation),
    _once("consistent-start", problem_functions.check_start),
    _once("observables", problem_functions.check_observables),
    _once("path-by-path", problem_functions.check_path_by_path),
    _once("finite-in-time", problem_functions.check_finite_in_time, since=2),
    _once("diffusion-product", problem_functions.check_diffusion_product),
    _once("diffusion-derivative", problem_functions.check_diffusion_derivative),
    _once("constraint-jacobian", problem_functions.check_jacobian),
    _once("constraint-curvature", problem_functions.check_curvature),
    _once("constraint-second-derivatives", problem_functions.check_second_derivatives),
    _once("constraint-linearisation", problem_functions.check_given_linearisation),
    _once("force-derivatives", problem_functions.check_force_derivatives),
    _once("delay-derivatives", problem_functions.check_delay_derivatives),
    _once("algebraic-solution", problem_functions.check_algebraic_solution),
    _once("constraints-kept", views.check_constraints_kept),
    _once("view-equals-form", views.check_same_equation),
    _once("traits", problem_declarations.check_traits),
    _once("chart", problem_functions.check_chart),
    _truth("moments-start", moments.check_start),
    _truth("moments-rate", moments.check_rate),
    _truth("moments-settle", moments.check_limit),
    _truth("moments-simulated", sampled.check_moments_simulated),
    _truth("solution-start", solutions.check_start),
    _truth("solution-step", solutions.check_step),
    _truth("solution-still", solutions.check_standstill),
    _truth("solution-simulated", sampled.check_solution_simulated),
    _truth("solution-averaged", sampled.check_solution_averaged),
    _truth("controls", discrimination.check_controls),
)
TABLE = {"scheme": SCHEME_CHECKS, "problem": PROBLEM_CHECKS}
