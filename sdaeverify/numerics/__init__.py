"""Numerical tools with paths last: derivatives, small linear algebra, Newton's method."""

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

__all__ = [
    "BlockBanded",
    "Dense",
    "Elimination",
    "Root",
    "Tridiagonal",
    "all_finite",
    "apply",
    "apply_transposed",
    "determinant",
    "directional",
    "eliminated",
    "identity",
    "is_analytic",
    "jacobian",
    "jacobian_at_once",
    "lambert_of_log",
    "largest",
    "matches_differences",
    "newton",
    "norm",
    "overlap",
    "product_transposed",
    "second_directional",
    "solve",
    "solve_blocks",
    "update_tolerance",
]
