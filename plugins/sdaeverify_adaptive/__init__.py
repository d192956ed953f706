"""Adaptive solvers and their tolerances: the command `adaptive`, and the contract of a solver.

A plugin registers solvers by the hook ``sdaeverify_adaptive``, a function without arguments that returns a list of
them, marked `hookimpl`. A solver is an `Adaptive`: it solves a problem along a `Path` with a tolerance and returns a
`Solved`. Its name, form, claims and parameters are those of a scheme; only its step is not defined. A gate includes
its claims if the policy has a table ``[tool.sdaeverify.examinations.adaptive]``.
"""

from .contract import Adaptive, Solved
from .path import TICKS, Path, Point, brownian_path

__all__ = ["TICKS", "Adaptive", "Path", "Point", "Solved", "brownian_path"]
