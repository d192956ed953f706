"""Numerical tools with paths last: derivatives, small linear algebra, Newton's method, statistics of samples."""

from .block_banded import BlockBanded, solve_blocks
from .derivatives import (
    directional,
    is_analytic,
    jacobian,
    second_directional,
)
from .lambert import lambert_of_log
from .linalg import (
    Dense,
    Tridiagonal,
    antisymmetric,
    apply,
    apply_transposed,
    determinant,
    largest,
    norm,
    product_transposed,
    solve,
)
from .newton import Root, newton, update_tolerance
from .outweighed import outweighs, sample_growth
from .statistics import GROUPS, Tail, chernoff, clopper_pearson, log_norms, pseudo_values, slope_weights

__all__ = [
    "GROUPS",
    "BlockBanded",
    "Dense",
    "Root",
    "Tail",
    "Tridiagonal",
    "antisymmetric",
    "apply",
    "apply_transposed",
    "chernoff",
    "clopper_pearson",
    "determinant",
    "directional",
    "is_analytic",
    "jacobian",
    "lambert_of_log",
    "largest",
    "log_norms",
    "newton",
    "norm",
    "outweighs",
    "product_transposed",
    "pseudo_values",
    "sample_growth",
    "second_directional",
    "slope_weights",
    "solve",
    "solve_blocks",
    "update_tolerance",
]
