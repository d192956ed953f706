"""sdaeverify tells whether a numerical scheme for stochastic differential-algebraic equations keeps its promises."""

from typing import TYPE_CHECKING

from .arrays import Array, Mask, Parts
from .calibrated import CalibrationCase
from .chart import Angle, Chart, Line
from .controls import Control
from .errors import ParameterError, PluginError, ProblemError, SchemeError, SdaeverifyError, UsageError
from .experiment import Experiment, FineRun, Printed, Row
from .forms import (
    SDE,
    ConstrainedLangevin,
    ConstraintGeometry,
    ConstraintJacobian,
    DelaySDAE,
    DelayState,
    DenseJacobian,
    Dissipation,
    Gram,
    HolonomicSDAE,
    HolonomicState,
    Lag,
    Langevin,
    Mesh,
    Partials,
    Problem,
    Residual,
    Structure,
)
from .hookspecs import hookimpl
from .laws import GAUSSIAN, THREE_POINT, TWO_POINT, Law, clipped_gaussian
from .noise import Increment
from .planted import Planted
from .scheme import Claim, Scheme, Step
from .settings import Settings
from .specs import on_request
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
    "ConstrainedLangevin",
    "ConstraintGeometry",
    "ConstraintJacobian",
    "Control",
    "DelaySDAE",
    "DelayState",
    "DenseJacobian",
    "Dissipation",
    "Experiment",
    "FineRun",
    "Gram",
    "HolonomicSDAE",
    "HolonomicState",
    "Increment",
    "InvariantMean",
    "Lag",
    "Langevin",
    "Law",
    "Line",
    "Mask",
    "MeanSquareStability",
    "Mesh",
    "Moment",
    "ParameterError",
    "Partials",
    "Parts",
    "Pathwise",
    "Planted",
    "PluginError",
    "Printed",
    "Problem",
    "ProblemError",
    "Residual",
    "Result",
    "Row",
    "Scheme",
    "SchemeError",
    "SdaeverifyError",
    "Settings",
    "Step",
    "Structure",
    "Truth",
    "UsageError",
    "__version__",
    "clipped_gaussian",
    "hookimpl",
    "on_request",
    "verify",
]


def __getattr__(name: str) -> object:
    # Tables need pandas, which workers and plugins do not: it is imported by whoever asks for a table.
    if name in {"Result", "verify"}:
        from . import api  # noqa: PLC0415

        return getattr(api, name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
