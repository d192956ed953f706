"""Experiments of papers, run again: resolve the labels, run the blocks, set the means beside print and truth."""

from .orders import Order, orders
from .plan import ExperimentPlan, experiment_plan
from .run import ExperimentRun
from .tables import Line, in_words, lines, table

__all__ = [
    "ExperimentPlan",
    "ExperimentRun",
    "Line",
    "Order",
    "experiment_plan",
    "in_words",
    "lines",
    "orders",
    "table",
]
