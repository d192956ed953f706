"""sdaeverify tells whether a numerical scheme for stochastic differential-algebraic equations keeps its promises."""

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .api import Result, verify
    from .arrays import Array, Mask, Parts
    from .contracts.calibrated import CalibrationCase
    from .contracts.exhibit import Curve, Exhibit, Panel, Printed, Range, TableEntry
    from .contracts.experiment import (
        Budget,
        Experiment,
        ExperimentEvidence,
        Note,
        Probe,
        SchemeRun,
        SharedNoise,
        Work,
    )
    from .contracts.mean_sample import MeanSample
    from .contracts.mean_table import FineRun, MeanLine, MeanTable, Row
    from .contracts.planted import Planted
    from .contracts.scheme import Claim, Scheme, Step
    from .contracts.settings import Settings
    from .contracts.specs import in_matrix, on_request
    from .errors import ParameterError, PluginError, ProblemError, SchemeError, SdaeverifyError, UsageError
    from .forms.chart import Angle, Chart, Line
    from .forms.controls import Control
    from .forms.delay.delay_sdae import DelaySDAE, DelayState
    from .forms.delay.dissipation import Dissipation
    from .forms.delay.index_one import IndexOneSDAE
    from .forms.delay.mesh import Lag, Mesh
    from .forms.delay.partials import Partials
    from .forms.langevin.langevin import Langevin
    from .forms.mechanics.holonomic import HolonomicSDAE, HolonomicState
    from .forms.mechanics.jacobian import ConstraintJacobian, DenseJacobian, Gram
    from .forms.mechanics.structure import Structure
    from .forms.overdamped.constrained_langevin import ConstrainedLangevin, ConstraintGeometry
    from .forms.problem import Problem, Residual
    from .forms.sde.sde import SDE
    from .forms.traits import Trait
    from .forms.trivial import Trivial
    from .forms.truths import InvariantMean, MeanSquareStability, Moment, Pathwise, Truth
    from .lab.sampling import Paths, sample
    from .noise.brownian import Increment
    from .noise.laws import GAUSSIAN, THREE_POINT, TWO_POINT, Law, clipped_gaussian
    from .noise.records import NoiseRecord
    from .registry.hookspecs import hookimpl

__version__ = "0.1.0"

__all__ = [
    "GAUSSIAN",
    "SDE",
    "THREE_POINT",
    "TWO_POINT",
    "Angle",
    "Array",
    "Budget",
    "CalibrationCase",
    "Chart",
    "Claim",
    "ConstrainedLangevin",
    "ConstraintGeometry",
    "ConstraintJacobian",
    "Control",
    "Curve",
    "DelaySDAE",
    "DelayState",
    "DenseJacobian",
    "Dissipation",
    "Exhibit",
    "Experiment",
    "ExperimentEvidence",
    "FineRun",
    "Gram",
    "HolonomicSDAE",
    "HolonomicState",
    "Increment",
    "IndexOneSDAE",
    "InvariantMean",
    "Lag",
    "Langevin",
    "Law",
    "Line",
    "Mask",
    "MeanLine",
    "MeanSample",
    "MeanSquareStability",
    "MeanTable",
    "Mesh",
    "Moment",
    "NoiseRecord",
    "Note",
    "Panel",
    "ParameterError",
    "Partials",
    "Parts",
    "Paths",
    "Pathwise",
    "Planted",
    "PluginError",
    "Printed",
    "Probe",
    "Problem",
    "ProblemError",
    "Range",
    "Residual",
    "Result",
    "Row",
    "Scheme",
    "SchemeError",
    "SchemeRun",
    "SdaeverifyError",
    "Settings",
    "SharedNoise",
    "Step",
    "Structure",
    "TableEntry",
    "Trait",
    "Trivial",
    "Truth",
    "UsageError",
    "Work",
    "__version__",
    "clipped_gaussian",
    "hookimpl",
    "in_matrix",
    "on_request",
    "sample",
    "verify",
]


# Whoever asks for a name pays for its module: every run of pytest imports the plugin of this package, most of them
# without need of numpy; tables need pandas, which workers do not.
_NAMES = {
    "api": "Result verify",
    "arrays": "Array Mask Parts",
    "contracts.calibrated": "CalibrationCase",
    "forms.chart": "Angle Chart Line",
    "forms.controls": "Control",
    "errors": "ParameterError PluginError ProblemError SchemeError SdaeverifyError UsageError",
    "contracts.exhibit": "Curve Exhibit Panel Printed Range TableEntry",
    "contracts.experiment": "Budget Experiment ExperimentEvidence Note Probe SchemeRun SharedNoise Work",
    "contracts.mean_sample": "MeanSample",
    "contracts.mean_table": "FineRun MeanLine MeanTable Row",
    "forms.delay.delay_sdae": "DelaySDAE DelayState",
    "forms.delay.dissipation": "Dissipation",
    "forms.delay.index_one": "IndexOneSDAE",
    "forms.delay.mesh": "Lag Mesh",
    "forms.delay.partials": "Partials",
    "forms.langevin.langevin": "Langevin",
    "forms.mechanics.holonomic": "HolonomicSDAE HolonomicState",
    "forms.mechanics.jacobian": "ConstraintJacobian DenseJacobian Gram",
    "forms.mechanics.structure": "Structure",
    "forms.overdamped.constrained_langevin": "ConstrainedLangevin ConstraintGeometry",
    "forms.problem": "Problem Residual",
    "forms.sde.sde": "SDE",
    "registry.hookspecs": "hookimpl",
    "lab.sampling": "Paths sample",
    "noise.laws": "GAUSSIAN THREE_POINT TWO_POINT Law clipped_gaussian",
    "noise.brownian": "Increment",
    "noise.records": "NoiseRecord",
    "forms.traits": "Trait",
    "forms.trivial": "Trivial",
    "contracts.planted": "Planted",
    "contracts.scheme": "Claim Scheme Step",
    "contracts.settings": "Settings",
    "contracts.specs": "in_matrix on_request",
    "forms.truths": "InvariantMean MeanSquareStability Moment Pathwise Truth",
}


_WHERE = {name: module for module, names in _NAMES.items() for name in names.split()}


def __getattr__(name: str) -> object:
    if name not in _WHERE:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f".{_WHERE[name]}", __name__), name)


def __dir__() -> list[str]:
    return __all__
