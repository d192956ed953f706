"""Reproduction of tables and figures of papers: experiments and the command `reproduce`.

A plugin registers experiments by the hook ``sdaeverify_experiments``, a function without arguments that returns a
list of them, marked `hookimpl`, in a module that an entry point of the group ``sdaeverify.lab`` names. An experiment
is an `Experiment`, in most cases a `MeanTable`. It refers to schemes and problems by their registered labels.
"""

from .exhibit import Curve, Exhibit, Panel, Printed, Range, TableEntry
from .experiment import Budget, Experiment, Note, Probe, SchemeRun, SharedNoise, Work
from .mean_sample import MeanSample
from .mean_table import FineRun, MeanLine, MeanTable, Row
from .run import ExperimentEvidence

__all__ = [
    "Budget",
    "Curve",
    "Exhibit",
    "Experiment",
    "ExperimentEvidence",
    "FineRun",
    "MeanLine",
    "MeanSample",
    "MeanTable",
    "Note",
    "Panel",
    "Printed",
    "Probe",
    "Range",
    "Row",
    "SchemeRun",
    "SharedNoise",
    "TableEntry",
    "Work",
]
