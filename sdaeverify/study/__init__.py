"""Studies in three steps: plan the cells, run their blocks, judge the evidence."""

from .judging import CellResult
from .plan import Cell, Plan, ProblemPlan, plan
from .run import Advanced, Compared, Event, Finished, Study

__all__ = [
    "Advanced",
    "Cell",
    "CellResult",
    "Compared",
    "Event",
    "Finished",
    "Plan",
    "ProblemPlan",
    "Study",
    "plan",
]
