"""Numerical tools with paths last: derivatives, small linear algebra, Newton's method."""

from .derivatives import directional, is_analytic, jacobian, matches_differences, second_directional
from .linalg import all_finite, apply, apply_transposed, determinant, norm, product_transposed, solve
from .manifold import onto_manifold
from .newton import Root, newton

__all__ = [
    "Root",
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
    "onto_manifold",
    "product_transposed",
    "second_directional",
    "solve",
]
