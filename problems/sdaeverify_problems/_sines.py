"""Hyperbolic sines of normal variables: derivative and expectations."""

import numpy as np

from sdaeverify import Array

SOURCE = "Kloeden & Platen 1992, section 4.4: sinh of a process with additive noise, by Ito's formula"


def slope(x: Array) -> Array:
    """Return sqrt(1 + x^2) = cosh(arsinh x)."""
    root: Array = np.sqrt(1.0 + x * x)
    return root


def mean_sine(m: float, v: float) -> float:
    """Return E sinh y for y of mean m and variance v."""
    return float(np.exp(0.5 * v) * np.sinh(m))


def mean_cosine(m: float, v: float) -> float:
    """Return E cosh y for y of mean m and variance v."""
    return float(np.exp(0.5 * v) * np.cosh(m))


def mean_square(m: float, v: float) -> float:
    """Return E sinh^2 y = (E cosh 2y - 1)/2 for y of mean m and variance v."""
    return 0.5 * (mean_cosine(2.0 * m, 4.0 * v) - 1.0)
