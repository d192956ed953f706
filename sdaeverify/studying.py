"""The public names for programs that plan and run their own studies: labels, plans, noise and the time loop.

Labels are resolved by the `Registry` that a command loads::

    schemes, problems = select_schemes(registry, "euler-*"), select_problems(registry, "gbm")
    study = Study(plan(schemes, problems, select_measures(registry)), Settings(paths=1000))
    results = [*study.run()] and study.results()

Other programs advance a scheme themselves: a `Track` is one step size on one block of paths, advanced by
the increments that `follow` yields in order, which a `Source` determines by seed, label and block.
"""

from .contracts.finding import UNMEASURED, tier_name
from .contracts.labels import parse_label
from .contracts.matching import match
from .contracts.specs import ProblemSpec, check_scheme, unknown
from .noise.brownian import Brownian, LevelNoise, Piece, Source, refine
from .noise.records import NoiseRecord
from .registry.load import Registry
from .registry.selection import only, select_measures, select_problems, select_schemes
from .simulate.chains import Chains
from .simulate.ensemble import Entry, SchemeEvidence, Task, one_thread, run_block
from .simulate.tracks import Track, follow
from .study import Advanced, Cell, CellResult, Plan, ProblemPlan, Study, plan
from .study.class_results import class_results, is_of_class
from .study.examination import Examination
from .study.holm import holm
from .study.order_report import OrderReport
from .verdicts.path_tests import DEEP_PATHS, RESOLVED
from .workers.pool import in_turn

__all__ = [
    "DEEP_PATHS",
    "RESOLVED",
    "UNMEASURED",
    "Advanced",
    "Brownian",
    "Cell",
    "CellResult",
    "Chains",
    "Entry",
    "Examination",
    "LevelNoise",
    "NoiseRecord",
    "OrderReport",
    "Piece",
    "Plan",
    "ProblemPlan",
    "ProblemSpec",
    "Registry",
    "SchemeEvidence",
    "Source",
    "Study",
    "Task",
    "Track",
    "check_scheme",
    "class_results",
    "follow",
    "holm",
    "in_turn",
    "is_of_class",
    "match",
    "one_thread",
    "only",
    "parse_label",
    "plan",
    "refine",
    "run_block",
    "select_measures",
    "select_problems",
    "select_schemes",
    "tier_name",
    "unknown",
]
