"""Base classes and tools for schemes that delegate their steps to another library.

A bridge is a `Bridge` with a name, the noise it draws, the claims of the library's documentation, and one method that
makes the library's step from the problem's formulas. The formulas of the problem, written with NumPy, are run on the
library's arrays (`Coefficients`), traced and compiled once for all steps, step sizes and blocks.
"""

from sdaeverify.probing import linear_equation, why_not_linear_equation

from .batches import in_batches, vectorised
from .bridge import Bridge, Compiled
from .coefficients import (
    SEPARATE,
    Coefficients,
    stratonovich_drift,
    why_not_bridged,
    why_not_temperature,
    why_not_without_areas,
)
from .foreign import Foreign, TorchFunctions, why_not_run
from .formulas import Formulas
from .installed import Library

__all__ = [
    "SEPARATE",
    "Bridge",
    "Coefficients",
    "Compiled",
    "Foreign",
    "Formulas",
    "Library",
    "TorchFunctions",
    "in_batches",
    "linear_equation",
    "stratonovich_drift",
    "vectorised",
    "why_not_bridged",
    "why_not_linear_equation",
    "why_not_run",
    "why_not_temperature",
    "why_not_without_areas",
]
