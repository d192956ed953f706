"""A scheme as a black-box one-step map between states of the equation."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ...arrays import Array, Mask
from ...contracts.scheme import Scheme, State, Step, flatten
from ...errors import SchemeError
from ...forms import Equation, Problem, components, outside
from ...forms.names import article
from ...noise.brownian import Increment
from .memory import MemoryOrders, memory_orders
from .nodes import SEED, Nodes, law_nodes, step_nodes
from .states import WHEN, cloud, follows_coefficients, states_near_start, time_unit
from .together import PathBatch, together

# A fast component is resolved by steps that are shorter than its time scale by this factor.
# Theorem: elementary, an error h^p (1 + h/tau) has the local order p + log2((1 + 1/64)/(1 + 1/128)) = p + 0.011.
RESOLVED = 64.0
# Steps after which the memory of a scheme is compared with that of `enter`, their size in units of time, and a bound
# of round-off.
# Size: of a run.
# Rounding: 8 steps of 64 operations err by at most 512 eps = 1.1e-13.
FEW_STEPS, SHORT_STEP, SAME = 8, 2.0**-8, 1e-12
# Bound of the nodes of a step in standard deviations: those of Gauss-Hermite rules of up to 9 points are within 4.52.
# Theorem: the largest root of the Hermite polynomial He_9 is 4.513.
OUTERMOST = 4.52
TRUNCATED = "steps of every size are truncated at every state, so that no order can be observed"
STILL = "a step returns its state unchanged"
FAILED = "steps of every size fail at every state, so that no order can be observed"


def why_not_resolved(view: Problem, shortest: float) -> str:
    """Return why steps do not show the order of a problem as h tends to 0, or an empty string.

    The steps are longer than the fastest time scale, or the coefficients oscillate within a step. With steps longer
    than its stiffness parameter, a uniformly accurate scheme does not follow the equation step by step. Its errors
    then change from one asymptotic law to another, however accurate the scheme is.
    """
    if view.fastest_time < RESOLVED * shortest:
        return (
            f"the shortest step probed, h = {shortest:.2g}, does not resolve the fastest time {view.fastest_time:.2g}"
        )
    if not follows_coefficients(view, shortest):
        return f"the shortest step probed, h = {shortest:.2g}, does not resolve how the coefficients vary in time"
    return ""


@dataclass(frozen=True)
class OneStep:
    """Map x -> Phi(x, t, h, noise) between states of shape (d, P), whose rows are the components of `equation`.

    Attributes
    ----------
    scheme : Scheme
    view : Problem
        Problem in the scheme's form.
    """

    scheme: Scheme
    view: Problem

    @cached_property
    def equation(self) -> Equation:
        """Equation of the comparable components."""
        equation = self.view.equation()
        if equation is None:
            raise SchemeError(f"{article(type(self.view).__name__)} offers no Ito equation to compare one step with")
        return equation

    @property
    def time(self) -> float:
        """Time of probed steps: a fifth of the horizon, since derivatives of the coefficients may vanish at 0."""
        return WHEN * self.view.horizon

    @property
    def time_unit(self) -> float:
        """Unit of the step sizes of probes; see `states.time_unit`."""
        return time_unit(self.view)

    @property
    def names(self) -> dict[str, slice]:
        """Rows of each component in the state."""
        return dict(self.equation.names or {"x": slice(None)})

    @property
    def admissible_corners(self) -> Array:
        """Admissible states near 0 and the unit vectors, shape (d, 1 + d), for a problem with constraints.

        If one of these has no nearest admissible state, as for the centre of a circle, the unprojected points are
        returned.
        """
        points = np.eye(self.equation.dimension, 1 + self.equation.dimension, k=1)
        with np.errstate(all="ignore"):
            admissible = self.view.admissible(points)
        return admissible if np.isfinite(admissible).all() else points

    def why_not_probed(self, *, beside: bool = False, run: bool = True, levy: bool = False) -> str:
        """Return why the map cannot be probed at any state, or an empty string.

        Parameters
        ----------
        beside : bool
            Whether the probe has nodes for noise other than Brownian motions.
        run : bool
            Whether to make a run, the only slow part, to determine whether memory has an effect.
        levy : bool
            Whether the probe has nodes for Levy areas.
        """
        if self.scheme.discontinuous_in_noise:
            return "a step is discontinuous in its noise: quadrature does not give expectations"
        if self.view.records and not beside:
            return "no quadrature is known for noise other than Brownian motion"
        return self.why_not_at_nodes(levy=levy) or self.why_not_comparable() or self.why_not_entered(run=run)

    def why_not_at_nodes(self, *, levy: bool = False) -> str:
        """Return that a step uses Brownian noise for which there are no nodes, or an empty string.

        Parameters
        ----------
        levy : bool
            As for `why_not_probed`.
        """
        beyond = self.scheme.noise & {"K", "A"} - ({"A"} if levy or self.view.noise_dim == 1 else set())
        return f"a step uses noise {', '.join(sorted(beyond))}; quadrature supports only dW and H" if beyond else ""

    def why_not_comparable(self) -> str:
        """Return why states cannot be compared with those of an Ito equation, or an empty string."""
        if self.view.equation() is None:
            return f"{article(type(self.view).__name__)} offers no Ito equation to compare one step with"
        rows = [row for part in self.names.values() for row in range(self.equation.dimension)[part]]
        if sorted(rows) != list(range(self.equation.dimension)):
            return "the named components omit rows of the state, or contain some twice"
        return ""

    def why_not_entered(self, *, run: bool = True) -> str:
        """Return that `enter` does not set all memory, or the state lacks compared components, or an empty string.

        Parameters
        ----------
        run : bool
            As for `why_not_probed`.
        """
        h = self.view.horizon / 64.0
        start, entered = self.scheme.start(self.view, 2, h), self.enter(self.equation.initial(2), 0.0, h)
        if type(start) is not type(entered) or flatten(start).shape != flatten(entered).shape:
            return "the scheme has memory that enter(problem, state, t, h) does not set"
        if reason := self.untold(entered):
            return reason
        memory = memory_orders(self) if run and self.remembers(entered) else None
        if memory is not None and not memory.vanish:
            return "steps of a run differ from those that begin with enter(problem, state, t, h)"
        return ""

    def why_not_memoryless(self) -> str:
        """Return that steps near the start depend on more than the problem's components, or an empty string."""
        memory = len(flatten(self.scheme.start(self.view, 1, self.view.horizon))) - components(self.view)
        if memory <= 0:
            return ""
        if reason := self.why_not_entered(run=False):
            return reason
        with np.errstate(all="ignore"):
            return "" if self._keeps_entered() else "steps depend on memory, and a random member has no history"

    def _keeps_entered(self) -> bool:
        """Return whether after each of a few steps the memory equals that set by `enter` at the same state."""
        t, h = self.time, SHORT_STEP * self.time_unit
        x, rng = states_near_start(self.view, self.equation), np.random.Generator(np.random.Philox(key=SEED + 9))
        state = self.enter(x, t, h)
        for _ in range(FEW_STEPS):
            noise = self.scheme.law.increment(self.view.drawn(rng, h, x.shape[1]), h)
            state, t = self.advance(state, t, h, noise), t + h
            if not np.allclose(flatten(state), flatten(self.enter(self.read(state), t, h)), rtol=SAME, atol=SAME):
                return False
        return True

    def remembers(self, state: State) -> bool:
        """Return whether a state of the scheme has more rows than the equation."""
        return len(flatten(state)) > self.equation.dimension

    @property
    def memory(self) -> MemoryOrders | None:
        """Orders of the effect of memory in a run, for a map that can be probed; None without further memory."""
        return memory_orders(self) if self.remembers(self.scheme.start(self.view, 1, self.view.horizon)) else None

    @property
    def memory_vanishes(self) -> bool:
        """Whether the memory of a run has no effect beyond rounding, for a map that can be probed."""
        return self.memory is None or bool(np.isinf(self.memory.weak))

    def untold(self, state: State) -> str:
        """Return that a state of the scheme lacks compared components, or an empty string."""
        lacking = [name for name in self.names if name not in self.scheme.parts(self.view, state)]
        if not lacking:
            return ""
        given = tuple(name for name in self.names if name not in lacking)
        hint = f"; if that is intended, declare gives = {given}" if self.view.giving(given) is not self.view else ""
        return f"the state of the scheme has no {', '.join(lacking)}{hint}"

    def enter(self, x: Array, t: float, h: float) -> State:
        """Return the scheme's state at x, for steps of size h from time t.

        Parameters
        ----------
        x : ndarray, shape (d, P)
        t : float
            Time of the state.
        h : float
            Step size, on which the memory of a scheme may depend.
        """
        return self.scheme.enter(self.view, self.view.state(x, t), t, h)

    def advance(self, state: State, t: float, h: float, noise: Increment) -> State:
        """Return the scheme's state after a step, including all memory.

        Parameters
        ----------
        state : State
            State of the scheme, on P paths.
        t : float
            Start of the step.
        h : float
            Size of the step.
        noise : Increment
            Noise on the same paths.
        """
        return self.scheme.prepare(self.view, h)(state, t, noise).state

    def truncated(self, x: Array, h: Array, times: Sequence[float]) -> Mask:
        """Return from which states a step of each size is truncated at some node of the noise, shape (S, H).

        A truncated step differs from the asymptotic form of the step, so that it shows no order there. A step of
        Euler's method that leaves the domain of the problem also counts as truncated, because schemes that stay in
        the domain modify it.

        Parameters
        ----------
        x : ndarray, shape (d, S)
        h : ndarray, shape (H,)
        times : sequence of H floats
            Start of the step of each size.
        """
        nodes = self.few_nodes()
        wide = np.repeat(x, len(nodes.weights), axis=1)
        found = np.zeros((x.shape[1], len(h)), dtype=bool)
        if self.view.records:
            return found
        batches = [
            PathBatch(wide, t, size, nodes.increment(size, x.shape[1]))
            for size, t in zip(h.tolist(), times, strict=True)
        ]
        if batches and self.make(*batches[0]).truncated is not None:
            for place, made in enumerate(self.together(batches)):
                if made.truncated is not None:
                    found[:, place] = made.truncated.reshape(x.shape[1], -1).any(axis=1)
        for place, (_, t, size, noise) in enumerate(batches if self.view.domain is not None else ()):
            left = self.leaves_domain(wide, t, size, noise._replace(dW=OUTERMOST * noise.dW))
            found[:, place] |= left.reshape(x.shape[1], -1).any(axis=1)
        return found

    def leaves_domain(self, x: Array, t: float, h: float, noise: Increment) -> Mask:
        """Return the paths on which a step of Euler's method leaves the domain of the problem, shape (P,).

        Parameters
        ----------
        x : ndarray, shape (d, P)
        t : float
            Start of the step.
        h : float
            Size of the step.
        noise : Increment
            Noise on the same paths.
        """
        if self.view.domain is None:
            return np.zeros(x.shape[1], dtype=bool)
        return outside(self.view, self.euler(x, t, h, noise))

    def few_nodes(self) -> Nodes:
        """Return two nodes per variable of the noise, or a few nodes of another rule if these would be too many."""
        l, noise, law = self.view.noise_dim, self.scheme.noise, self.scheme.law
        nodes = step_nodes(l, 2, areas="H" in noise, law=law)
        return law_nodes(l, noise, law)[0] if noise & {"K", "A"} or not nodes.exact else nodes

    def usable_states(self, h: float, x: Array | None = None) -> Array:
        """Return the states from which steps of this size are not truncated; by default of those of `cloud`."""
        x = cloud(self.view, self.equation) if x is None else x
        with np.errstate(all="ignore"):
            truncated = self.truncated(x, np.array([h]), [self.time])[:, 0]
        return x[:, ~truncated] if truncated.any() else x

    def why_not_sound(self, h: float, x: Array | None = None) -> str:
        """Return that no step of this size shows an order, or an empty string.

        Either steps are truncated at every state, or each step fails.

        Parameters
        ----------
        h : float
        x : ndarray, shape (d, S), optional
            Probe states; by default those of `cloud`.
        """
        x = cloud(self.view, self.equation) if x is None else x
        if not self.usable_states(h, x).size:
            return TRUNCATED
        if self.view.records:
            return ""
        _, made = self._at_few_nodes(x, h)
        return FAILED if made.failed is not None and made.failed.all() else ""

    def is_still(self, h: float) -> bool:
        """Return whether a step of this size returns each state of `cloud` unchanged, including all memory."""
        if self.view.records:
            return False
        state, made = self._at_few_nodes(cloud(self.view, self.equation), h)
        return np.array_equal(state, flatten(made.state))

    def _at_few_nodes(self, x: Array, h: float) -> tuple[Array, Step]:
        """Return the flat states at the start of steps of this size, and the results of the steps.

        The states are copied, because a step may write into its argument.
        """
        nodes = self.few_nodes()
        with np.errstate(all="ignore"):
            state = self.enter(np.repeat(x, len(nodes.weights), axis=1), self.time, h)
            before = flatten(state).copy()
            return before, self.scheme.prepare(self.view, h)(state, self.time, nodes.increment(h, x.shape[1]))

    def read(self, state: State) -> Array:
        """Return the comparable components of a state, shape (d, P)."""
        parts = self.scheme.parts(self.view, state)
        x = np.empty((self.equation.dimension, flatten(state).shape[-1]))
        for name, rows in self.names.items():
            x[rows] = parts[name]
        return x

    def make(self, x: Array, t: float, h: float, noise: Increment) -> Step:
        """Return the result of a step from given states, with all memory, flags and outputs.

        Parameters
        ----------
        x : ndarray, shape (d, P)
        t, h : float
            Start and size of the step.
        noise : Increment
        """
        return self.scheme.prepare(self.view, h)(self.enter(x, t, h), t, noise)

    def together(self, batches: Iterable[PathBatch]) -> Iterator[Step]:
        """Yield the steps of batches that differ in time and size, in few calls if this does not change a bit.

        Parameters
        ----------
        batches : iterable of PathBatch
            Their x has shape (d, P).
        """
        return together(self.make, batches)

    def __call__(self, x: Array, t: float, h: float, noise: Increment) -> Array:
        """Return Phi(x, t, h, noise), the components after a step from state x, shape (d, P)."""
        return self.read(self.advance(self.enter(x, t, h), t, h, noise))

    def euler(self, x: Array, t: float, h: float, noise: Increment) -> Array:
        """Return a step of Euler's method for the equation, shape (d, P).

        Parameters
        ----------
        x : ndarray, shape (d, P)
        t : float
            Start of the step.
        h : float
            Size of the step.
        noise : Increment
            Noise on the same paths.
        """
        return self.equation.euler(t, x, h, noise)
