"""The public names for programs that plan and run their own studies: labels, plans, noise and the time loop.

Labels are resolved by the `Registry` that a command loads::

    schemes, problems = select_schemes(registry, "euler-*"), select_problems(registry, "gbm")
    study = Study(plan(schemes, problems, select_measures(registry)), Settings(paths=1000))
    results = [*study.run()] and study.results()

Other programs advance a scheme themselves: a `Track` is one step size on one block of paths, advanced by
the increments that ``Brownian.follow`` passes in order, which a `Source` determines by seed, label and block.
"""

from .conformance.own_numbers import draws_own_numbers
from .conformance.violation import violation
from .contracts.finding import tier_name
from .contracts.labels import parse_label
from .contracts.matching import match
from .contracts.specs import ProblemSpec, check_scheme, unknown
from .noise.brownian import Brownian, LevelNoise, Source
from .probe.named_mistake import named_mistake
from .registry.load import Registry, load_registry
from .registry.selection import select_measures, select_problems, select_schemes
from .report.tables.stored_run import StoredRun
from .simulate.chains import Chains
from .simulate.ensemble import Entry, SchemeEvidence, Task, one_thread, run_block
from .simulate.tracks import Track
from .store.code import code_key
from .study import Advanced, Cell, CellResult, Plan, ProblemPlan, Study, plan
from .study.class_tests import ClassTests
from .study.examination import Completed, Examination
from .study.holm import holm
from .verdicts.path_tests import CALIBRATED_PATHS, DEEP_PATHS, RESOLVED
from .workers.calls import call_in_turn
from .workers.pool import in_turn

__all__ = [
    "CALIBRATED_PATHS",
    "DEEP_PATHS",
    "RESOLVED",
    "Advanced",
    "Brownian",
    "Cell",
    "CellResult",
    "Chains",
    "ClassTests",
    "Completed",
    "Entry",
    "Examination",
    "LevelNoise",
    "Plan",
    "ProblemPlan",
    "ProblemSpec",
    "Registry",
    "SchemeEvidence",
    "Source",
    "StoredRun",
    "Study",
    "Task",
    "Track",
    "call_in_turn",
    "check_scheme",
    "code_key",
    "draws_own_numbers",
    "holm",
    "in_turn",
    "load_registry",
    "match",
    "named_mistake",
    "one_thread",
    "parse_label",
    "plan",
    "run_block",
    "select_measures",
    "select_problems",
    "select_schemes",
    "tier_name",
    "unknown",
    "violation",
]
