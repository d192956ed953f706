"""Guides for authors of schemes: the arguments of a step for each form, and a scheme of eight lines.

The command ``info`` and the documentation page of the form show them. The docstring of a form describes its arguments
only, so that it fits a screen.
"""

from .delay.delay_sdae import DelaySDAE
from .delay.index_one import IndexOneSDAE
from .langevin.langevin import Langevin
from .mechanics.holonomic import HolonomicSDAE
from .overdamped.constrained_langevin import ConstrainedLangevin
from .problem import Problem
from .sde.sde import SDE

GUIDES: dict[type[Problem], str] = {
    SDE: """\
A step is given x, an array of shape (d, P), and returns ``Step`` of such an array. It calls
``problem.drift(t, x)``, ``problem.diffusion(t, x)``, ``problem.diffused(t, x, w)`` for B w with w of shape (l,
P), ``problem.derivative_of_drift(t, x)`` and ``problem.derivative_of_diffusion(t, x, y)``.

>>> from sdaeverify import SDE, Scheme, Step
>>> class MyEuler(Scheme):
...     name, form = "my-euler", SDE
...     def step(self, problem, state, t, h, noise):
...         f = problem.drift(t, state)
...         return Step(state + h * f + problem.diffused(t, state, noise.dW))
""",
    Langevin: """\
A step is given (q, p) as one array of shape (2 n, P), and returns ``Step`` of such an array. It calls
``problem.force(q)`` and reads ``problem.friction`` and ``problem.strength``.

>>> import numpy as np
>>> from sdaeverify import Langevin, Scheme, Step
>>> class MySymplecticEuler(Scheme):
...     name, form = "my-symplectic-euler", Langevin
...     def step(self, problem, state, t, h, noise):
...         q, p = np.split(state, 2)
...         p = p + h * (problem.force(q) - problem.friction * p) + problem.strength * noise.dW
...         return Step(np.concatenate([q + h * p, p]))
""",
    DelaySDAE: """\
A step is given ``DelayState(x, y)``, arrays of shapes (d, P) and (q, P), and returns ``Step`` of such a state.
The lagged values are ``lag.now`` and, where x is at the end of the step, ``lag.ahead(x)``, of
``lag = problem.lag(state.x, h, noise)``. It calls ``problem.drift(t, x, v, y)``,
``problem.diffused(t, x, v, y, w)`` for g w with w of shape (l, P), ``problem.eliminated(t, x, v)`` for y, and
``problem.consistent(t, x, v)`` for the state with this y.

>>> from sdaeverify import DelaySDAE, Scheme, Step
>>> class MyDelayEuler(Scheme):
...     name, form = "my-delay-euler", DelaySDAE
...     def step(self, problem, state, t, h, noise):
...         (x, y), lag = state, problem.lag(state.x, h, noise)
...         x = x + h * problem.drift(t, x, lag.now, y) + problem.diffused(t, x, lag.now, y, noise.dW)
...         return Step(problem.consistent(t + h, x, lag.ahead(x)))
""",
    IndexOneSDAE: """\
The functions of the problem take (t, x, y), without the lagged value that those of a `DelaySDAE` take.

>>> from sdaeverify import DelayState, IndexOneSDAE, Scheme, Step
>>> class MyCircuitEuler(Scheme):
...     name, form = "my-circuit-euler", IndexOneSDAE
...     def step(self, problem, state, t, h, noise):
...         x, y = state
...         x = x + h * problem.drift(t, x, y) + problem.diffused(t, x, y, noise.dW)
...         return Step(DelayState(x, problem.eliminated(t + h, x)))
""",
    HolonomicSDAE: """\
A step is given ``HolonomicState(r, v, mu)``, arrays of shapes (n, P), (n, P) and (m, P), and returns ``Step``
of such a state. It calls ``problem.force(t, r, v)``, ``problem.diffused(t, r, v, w)`` for B w with w of shape
(l, P), ``problem.inverse_mass(y)`` for M^-1 y, ``problem.constraint(r)``, and with
``J = problem.linearised(r)``, which is Dg(r), ``problem.push(J, c)`` for M^-1 grad g(r) c and
``problem.tangent(J, v)`` for the tangential part of v and its multiplier.

>>> from sdaeverify import HolonomicSDAE, HolonomicState, Scheme, Step
>>> class MyMechanicsEuler(Scheme):
...     name, form = "my-mechanics-euler", HolonomicSDAE
...     def step(self, problem, state, t, h, noise):
...         r, v, mu = state
...         kick = h * problem.force(t, r, v) + problem.diffused(t, r, v, noise.dW)
...         r = r + h * v
...         v, c = problem.tangent(problem.linearised(r), v + problem.inverse_mass(kick))
...         return Step(HolonomicState(r, v, mu + c))
""",
    ConstrainedLangevin: """\
A step is given x, an array of shape (d, P), and returns ``Step`` of such an array. It calls
``problem.drift(x)`` and ``problem.constraint(x)``, reads ``problem.strength`` and ``problem.eps``, and has the
geometry of the constraint near x from ``problem.near(x)``, see `ConstraintGeometry`; ``problem.ito()`` is (1.4)
or (1.2) as an `SDE`.

>>> from sdaeverify import ConstrainedLangevin, Scheme, Step
>>> class MyPenalisedEuler(Scheme):
...     name, form = "my-penalised-euler", ConstrainedLangevin
...     def step(self, problem, state, t, h, noise):
...         equation = problem.ito()
...         f = equation.drift(t, state)
...         return Step(state + h * f + equation.diffused(t, state, noise.dW))
""",
}


def guide_of(form: type[Problem]) -> str:
    """Return the guide for authors of schemes for a form; empty for a form without one."""
    return GUIDES.get(form, "")
