"""The public names for authors of measures of errors along paths: common observers, fits and judgements.

Such a measure is a measure as described in `sdaeverify.measuring`, built from these parts::

    ErrorObserver(parts, settings)                          # its observer: errors on the coarsest grid, in a tally
    for quantity in quantities_of(evidence):                # of each component: the errors of all step sizes
        usable, left_out = usable_levels(evidence, quantity)
        fitted = fit(evidence, quantity, usable, left_out)  # their order, with an interval and the reference's bias
        tests = path_tests(fitted, claim)                   # tests of a claimed order
        tests = resolve_lower_order(tests, fitted, order)   # the same where paths alone decide
    judge_together(judged, others, norms)                   # the judgement: findings, and rows of each step size

Errors
    `tally_errors` tallies errors of a kind that the observer does not compute, and ``quantities_of(evidence, kind)``
    reads them. `judge_exact` returns the opinion if errors are rounding only; `unknown_components` are those without
    errors, because the truth does not include them.
One step
    `probe_consistency` evaluates whether one step follows the equation, and `consistency_opinions` returns the
    opinion on each component; `beside` prevents paths from verifying a claim that one step contradicts.
"""

from .measures.path_errors.consistency import consistency_opinions, probe_consistency
from .measures.path_errors.errors import STATE, ErrorObserver, tally_errors
from .measures.path_errors.order import (
    RIGHT_LIMIT,
    Bias,
    Fit,
    fit,
    judge_exact,
    path_tests,
    resolve_lower_order,
    usable_levels,
)
from .measures.path_errors.quantity import (
    ERROR_COLUMNS,
    JudgedQuantity,
    Quantity,
    judge_together,
    quantities_of,
    unknown_components,
)
from .verdicts.opinions import beside

__all__ = [
    "ERROR_COLUMNS",
    "RIGHT_LIMIT",
    "STATE",
    "Bias",
    "ErrorObserver",
    "Fit",
    "JudgedQuantity",
    "Quantity",
    "beside",
    "consistency_opinions",
    "fit",
    "judge_exact",
    "judge_together",
    "path_tests",
    "probe_consistency",
    "quantities_of",
    "resolve_lower_order",
    "tally_errors",
    "unknown_components",
    "usable_levels",
]
