"""Experiments of papers, run again: resolve the labels, run the blocks, join the evidence, draw the pictures."""

from .experiment_plan import ExperimentPlan, experiment_plan
from .run import ExperimentRun, FoundEvidence

__all__ = ["ExperimentPlan", "ExperimentRun", "FoundEvidence", "experiment_plan"]
