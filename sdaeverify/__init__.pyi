# The public names, each with the module that has it: for type checkers, and for the package when it is asked for one.
from .api import Result as Result, load as load, verify as verify
from .arrays import Array as Array, Mask as Mask, Parts as Parts
from .contracts.scheme import Claim as Claim, Scheme as Scheme, Step as Step
from .contracts.settings import Settings as Settings
from .contracts.specs import in_matrix as in_matrix, on_request as on_request
from .errors import (
    ParameterError as ParameterError,
    ProblemError as ProblemError,
    SchemeError as SchemeError,
    SdaeverifyError as SdaeverifyError,
    UsageError as UsageError,
)
from .forms.chart import Angle as Angle, Chart as Chart, Line as Line
from .forms.controls import Control as Control
from .forms.delay.delay_sdae import DelaySDAE as DelaySDAE, DelayState as DelayState
from .forms.delay.dissipation import Dissipation as Dissipation
from .forms.delay.index_one import IndexOneSDAE as IndexOneSDAE
from .forms.delay.mesh import Lag as Lag
from .forms.delay.partials import Partials as Partials
from .forms.domain import Domain as Domain
from .forms.langevin.langevin import Langevin as Langevin
from .forms.mechanics.holonomic import HolonomicSDAE as HolonomicSDAE, HolonomicState as HolonomicState
from .forms.mechanics.jacobian import (
    ConstraintJacobian as ConstraintJacobian,
    DenseJacobian as DenseJacobian,
    Gram as Gram,
)
from .forms.mechanics.structure import Structure as Structure
from .forms.overdamped.constrained_langevin import (
    ConstrainedLangevin as ConstrainedLangevin,
    ConstraintGeometry as ConstraintGeometry,
)
from .forms.problem import Problem as Problem, Residual as Residual
from .forms.sde.sde import SDE as SDE
from .forms.traits import Trait as Trait
from .forms.features import Feature as Feature
from .forms.trivial import Trivial as Trivial
from .forms.truths import (
    InvariantMean as InvariantMean,
    MeanSquareStability as MeanSquareStability,
    Moment as Moment,
    MomentEquation as MomentEquation,
    Pathwise as Pathwise,
    Truth as Truth,
)
from .report.sampling import Paths as Paths, sample as sample
from .noise.brownian import Increment as Increment
from .noise.laws import (
    GAUSSIAN as GAUSSIAN,
    THREE_POINT as THREE_POINT,
    TWO_POINT as TWO_POINT,
    Law as Law,
)
from .registry.hookspecs import hookimpl as hookimpl

__version__: str
__all__: list[str]
