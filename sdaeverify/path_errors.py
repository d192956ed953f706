"""The public names for authors of measures of errors along paths, which are noted, fitted and judged in one way.

Such a measure is one as `sdaeverify.measuring` explains it, made of these parts::

    ErrorObserver(parts, settings)                          # its observer: errors on the coarsest grid, in a tally
    for quantity in quantities_of(evidence):                # of each component: the errors of all step sizes
        usable, left_out = usable_levels(evidence, quantity)
        fitted = fit(evidence, quantity, usable, left_out)  # their order, with an interval and the reference's bias
        tests = path_tests(fitted, claim)                   # what that says of a claimed order
        tests = resolve_lower_order(tests, fitted, order)   # the same where paths alone decide
    judge_together(judged, others, norms)                   # the judgement: findings, and rows of each step size

Errors
    `tally_errors` notes errors of another kind than those of the observer, and ``quantities_of(evidence, kind)``
    reads them. `judge_exact` has the opinion where they are rounding alone; `unknown_components` are those without
    errors, as the truth does not know them.
One step
    `probe_consistency` asks whether one step follows the equation, and `consistency_opinions` says it of each
    component; `beside` keeps paths from verifying what one step speaks against.
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
