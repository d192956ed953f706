"""Numerical tools with paths last: derivatives, small linear algebra, Newton's method."""

from .derivatives import directional, is_analytic, jacobian, matches_differences, second_directional
from .linalg import all_finite, apply, apply_transposed, determinant, norm, product_transposed, solve
from .newton import Root, newton
from .tridiagonal import Tridiagonal

__all__ = [
    "Root",
    "Tridiagonal",
    "all_finite",
    "apply",
    "apply_transposed",
    "determinant",
    "directional",
    "is_analytic",
    "jacobian",
    "matches_differences",
    "newton",
    "norm",
    "product_transposed",
    "second_directional",
    "solve",
]
