"""Numerical tools with paths last: derivatives, small linear algebra, Newton's method, statistics of samples."""

from .block_banded import BlockBanded, identity, overlap, solve_blocks
from .derivatives import (
    directional,
    is_analytic,
    jacobian,
    jacobian_at_once,
    matches_differences,
    second_directional,
)
from .lambert import lambert_of_log
from .linalg import (
    Dense,
    Elimination,
    Tridiagonal,
    all_finite,
    antisymmetric,
    apply,
    apply_transposed,
    determinant,
    eliminated,
    largest,
    norm,
    product_transposed,
    solve,
)
from .newton import Root, newton, update_tolerance
from .outweighed import outweighs, sample_growth
from .statistics import GROUPS, Tail, chernoff, clopper_pearson, log_norms, pseudo_values, slope_weights, tail

__all__ = [
    "GROUPS",
    "BlockBanded",
    "Dense",
    "Elimination",
    "Root",
    "Tail",
    "Tridiagonal",
    "all_finite",
    "antisymmetric",
    "apply",
    "apply_transposed",
    "chernoff",
    "clopper_pearson",
    "determinant",
    "directional",
    "eliminated",
    "identity",
    "is_analytic",
    "jacobian",
    "jacobian_at_once",
    "lambert_of_log",
    "largest",
    "log_norms",
    "matches_differences",
    "newton",
    "norm",
    "outweighs",
    "overlap",
    "product_transposed",
    "pseudo_values",
    "sample_growth",
    "second_directional",
    "slope_weights",
    "solve",
    "solve_blocks",
    "tail",
    "update_tolerance",
]
