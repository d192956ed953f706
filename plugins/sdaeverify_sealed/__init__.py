"""Solvers that draw their own random numbers and make whole runs, judged in law: the command `sealed`, its contract.

A sealed solver maps ``(problem, h, T, paths, seed)`` to final states, or to means of observables. No noise is shared
with it, so that its errors along paths are unknown; the law of its final states is compared with what is known of the
problem. A function is made a solver by `sealed`, a program by `program`, and a plugin registers both by the hook
``sdaeverify_sealed``, a function without arguments that returns a list of them, marked `hookimpl`. A gate counts
their claims where the policy has a table ``[tool.sdaeverify.examinations.sealed]``.
"""

from .contract import Ends, Means, Sealed, sealed
from .programs import program

__all__ = ["Ends", "Means", "Sealed", "program", "sealed"]
