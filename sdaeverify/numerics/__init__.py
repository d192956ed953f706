"""Numerical tools with paths last: derivatives, small linear algebra, Newton's method."""

from .block_banded import BlockBanded, identity, overlap
from .block_systems import solve_blocks
from .derivatives import directional, is_analytic, jacobian, matches_differences, second_directional
from .elimination import Elimination, eliminated
from .linalg import all_finite, apply, apply_transposed, determinant, largest, norm, product_transposed, solve
from .newton import Root, newton, update_tolerance
from .tridiagonal import Tridiagonal

__all__ = [
    "BlockBanded",
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
