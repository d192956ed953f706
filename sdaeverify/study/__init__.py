"""Studies in three steps: plan the cells, run their blocks, judge the evidence."""

from .judging import CellResult
from .plan import Cell, Plan, ProblemPlan, plan
from .run import Advanced, Compared, Event, Study

__all__ = [
    "Advanced",
    "Cell",
    "CellResult",
    "Compared",
    "Event",
    "Plan",
    "ProblemPlan",
    "Study",
    "plan",
]
