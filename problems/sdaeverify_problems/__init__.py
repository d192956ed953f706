"""The problems shipped with sdaeverify: one folder for each family, one module (a plugin) for each problem.

The package also exports the builders of its problems, for user-defined problems::

    from sdaeverify_problems import Bath, Fibre, clamped_chain, constrained_langevin, fibre_problem

    fibre_problem(Fibre(chain=clamped_chain(7, 3), alpha=0.4, flow=my_flow, C=my_drag), horizon=0.25)
    constrained_langevin(my_gradient, Bath(friction=2.0, kT=0.5), constraint=my_g, position=[...], velocity=[...],
                         horizon=1.0)
"""

from .fibres._chain import Chain, clamped_chain, free_chain
from .fibres._fibre import Edges, Fibre, rotation
from .fibres._problem import fibre_problem
from .langevin._bath import Bath
from .langevin._constrained_langevin import constrained_langevin

__all__ = [
    "Bath",
    "Chain",
    "Edges",
    "Fibre",
    "clamped_chain",
    "constrained_langevin",
    "fibre_problem",
    "free_chain",
    "rotation",
]
