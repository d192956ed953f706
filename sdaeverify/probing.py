"""The public names for authors of measures that probe: evaluation of one step of a scheme without sampling.

A measure that probes evaluates the scheme as a map and draws no paths, so its results have no sampling error. It is a
measure as described in `sdaeverify.measuring`, with a method ``probe(scheme, view, settings)`` whose result is
judged. Most probes have the same structure::

    step = OneStep(scheme, view)                                # x -> Phi(x, t, h, noise), states of shape (d, P)
    if step.why_not_probed():                                          # why the map cannot be evaluated anywhere
        return Tally()
    x = cloud(view, step.equation)                              # admissible states where solutions go, shape (d, S)
    nodes = step_nodes(view.noise_dim, 4, law=scheme.law)       # a rule for the noise of one step
    wide = np.repeat(x, len(nodes.weights), axis=1)             # every state with every node
    after = step(wide, step.time, h, nodes.increment(h, x.shape[1]))
    mean = nodes.mean(after.reshape(*x.shape, -1))              # E Phi(x, t, h, noise), shape (d, S)

States
    `cloud` returns 13 states, `extreme_states` adds distant ones; ``step.euler`` is a step of Euler's method for
    comparison; ``step.enter``, ``step.advance`` and ``step.read`` make several steps with the scheme's memory.
Orders
    `last_orders` estimates how fast defects vanish with h, above rounding and above the tolerance of a solver.
Linear steps
    `moment_errors` propagates first and second moments to the final time if problem and step are linear, and
    `mean_square_distance` the distance to the solution if the noise is additive.
Delays
    `LinearDelayRun` has the exact moments of a scheme that is linear on an equation with a delay; they determine
    the mean of each observable that ``is_quadratic``.
Stationary laws
    `invariant_errors` computes stationary means from the powers of a transition operator if the problem has a chart
    of one or two coordinates; its ``floors`` bound their numerical error.
Forms
    Query a problem for its capabilities, not for its class: ``view.capability(Multiplied)``.
Noise
    `sdaeverify.studying.Brownian` draws the noise of a probe's own runs, the same at all step sizes, from the address
    that a `Source` is.

Each function whose name begins with ``why_`` returns the reason why something does not apply, or an empty text. A
record of numbers that a probe returns becomes evidence by `sdaeverify.measuring.packed`. An opinion on it is made by
``sdaeverify.measuring.local_opinion`` if it decides, and by ``local_doubt`` if it does not.
"""

from .forms import Multiplied, StiffnessFamily
from .probe.linear.equation import linear_equation, why_not_linear_equation
from .probe.linear.moments import moment_errors, why_not_moments
from .probe.linear.pair import mean_square_distance, why_not_linear_pair
from .probe.local.orders import LocalOrders, last_orders
from .probe.operator.transition import why_not_operator
from .probe.operator.transition_errors import invariant_errors, invariant_observables
from .probe.stability.delay_run import LinearDelayRun
from .probe.step.nodes import Nodes, step_nodes
from .probe.step.one_step import OneStep, why_not_resolved
from .probe.step.states import cloud, extreme_states
from .probe.step.step_noise import StepNoise

__all__ = [
    "LinearDelayRun",
    "LocalOrders",
    "Multiplied",
    "Nodes",
    "OneStep",
    "StepNoise",
    "StiffnessFamily",
    "cloud",
    "extreme_states",
    "invariant_errors",
    "invariant_observables",
    "last_orders",
    "linear_equation",
    "mean_square_distance",
    "moment_errors",
    "step_nodes",
    "why_not_linear_equation",
    "why_not_linear_pair",
    "why_not_moments",
    "why_not_operator",
    "why_not_resolved",
]
