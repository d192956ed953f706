"""A study in three steps: plan the cells, run their blocks, judge the evidence."""

from .judging import CellResult
from .plan import Cell, Plan, ProblemPlan, plan
from .run import Advanced, Event, Finished, Study

__all__ = [
    "Advanced",
    "Cell",
    "CellResult",
    "Event",
    "Finished",
    "Plan",
    "ProblemPlan",
    "Study",
    "plan",
]
