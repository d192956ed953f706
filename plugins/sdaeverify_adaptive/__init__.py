"""Solvers that choose their steps: does the tolerance keep its promise? The command `adaptive`, and its contract.

A plugin registers solvers by the hook ``sdaeverify_adaptive``, a function without arguments that returns a list of
them, marked `hookimpl`. A solver is an `Adaptive`: it solves a problem along a `Path` with a tolerance and returns a
`Solved`. It is a scheme in all but its step, so that its name, form, claims and parameters are those of a scheme. A
gate counts its claims where the policy has a table ``[tool.sdaeverify.examinations.adaptive]``.
"""

from .contract import Adaptive, Solved
from .path import TICKS, Path, Point, brownian_path

__all__ = ["TICKS", "Adaptive", "Path", "Point", "Solved", "brownian_path"]
