"""Solvers in any language as schemes: a program reads steps on its stdin and writes new states on its stdout.

Commands take a program with ``--wire COMMAND``, and a policy with the table ``[tool.sdaeverify.wire]``. A plugin file
of two lines registers programs, too::

    from sdaeverify_wire import schemes

    sdaeverify_schemes = schemes("./my_solver")

The program sends a hello with its name, form, noise and claims. During a step it may request the coefficients of the
problem at any batch of states. Therefore every problem, the order conditions and the random members work without any
support in the program.
"""

from .scheme import Wired, scheme_of, schemes

__all__ = ["Wired", "scheme_of", "schemes"]
