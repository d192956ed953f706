"""sdaeverify tells whether a numerical scheme for stochastic differential-algebraic equations keeps its promises."""

from typing import TYPE_CHECKING

from .arrays import Array, Mask, Parts
from .calibrated import CalibrationCase
from .chart import Angle, Chart, Line
from .controls import Control
from .errors import ParameterError, PluginError, ProblemError, SchemeError, SdaeverifyError, UsageError
from .forms import (
    SDE,
    ConstraintJacobian,
    DenseJacobian,
    Gram,
    HolonomicSDAE,
    HolonomicState,
    Langevin,
    Problem,
    Residual,
)
from .hookspecs import hookimpl
from .laws import GAUSSIAN, THREE_POINT, TWO_POINT, Law
from .noise import Increment
from .planted import Planted
from .scheme import Claim, Scheme, Step
from .settings import Settings
from .truths import InvariantMean, MeanSquareStability, Moment, Pathwise, Truth

if TYPE_CHECKING:
    from .api import Result, verify

__version__ = "0.1.0"

__all__ = [
    "GAUSSIAN",
    "SDE",
    "THREE_POINT",
    "TWO_POINT",
    "Angle",
    "Array",
    "CalibrationCase",
    "Chart",
    "Claim",
    "ConstraintJacobian",
    "Control",
    "DenseJacobian",
    "Gram",
    "HolonomicSDAE",
    "HolonomicState",
    "Increment",
    "InvariantMean",
    "Langevin",
    "Law",
    "Line",
    "Mask",
    "MeanSquareStability",
    "Moment",
    "ParameterError",
    "Parts",
    "Pathwise",
    "Planted",
    "PluginError",
    "Problem",
    "ProblemError",
    "Residual",
    "Result",
    "Scheme",
    "SchemeError",
    "SdaeverifyError",
    "Settings",
    "Step",
    "Truth",
    "UsageError",
    "__version__",
    "hookimpl",
    "verify",
]


def __getattr__(name: str) -> object:
    # Tables need pandas, which workers and plugins do not: it is imported by whoever asks for a table.
    if name in {"Result", "verify"}:
        from . import api  # noqa: PLC0415

        return getattr(api, name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
