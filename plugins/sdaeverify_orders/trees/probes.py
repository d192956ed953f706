"""Computation of the weights of a class: on the universal SDE, or on a rich equation with diagonal noise."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from math import inf

import numpy as np

from sdaeverify import SDE, Array, Problem, Scheme
from sdaeverify.errors import FAULTS, one_line
from sdaeverify.probing import Nodes, OneStep
from sdaeverify.trees import Relatives, TreeClass

from .asymptotic import largest_change
from .classes import EquationClass
from .conditions import STRONG, Conditions, Weighed
from .grow import Tree
from .moments import ExactMoments
from .nodes import COUNT, FEWEST, line_points, random_points, rule_nodes
from .relatives import distance, distance_alone, distance_far, within
from .sdes.equivariance import Family, related_equations
from .sdes.taylor import RichEquation, TaylorWeights, taylor_weights
from .weights import OTHERS, SHORT, H, NoStepError, Weighing, rounding_at

# Relative tolerance: updates of Newton's method are at most 1e-10, deviations from a B-series at least 1e-4.
SAME = 1e-8
# Largest tolerance of weights from a Taylor series, and tolerance of a series itself.
TAYLOR, SERIES = 1e-3, 1e-7
# Rounding: tolerance of a weight from a Taylor series, in standard deviations of its rounding error.
DEVIATIONS = 4.0
# Points on a line through the noise: one lies in each interval of a twentieth of a standard deviation.
ALONG = 128
# Random points for conditions on paths: all miss a share of 1/20 of the noise with probability 0.95^64 = 0.04.
MANY = 64
# Size of caches of conditions: the number of classes examined for one scheme.
SHARED = 16
# Standard deviation of random points for a series, relative to normal increments.
NEARER = 0.7


@dataclass(frozen=True, eq=False)
class Probe:
    """A scheme on equations of a class.

    Attributes
    ----------
    scheme : Scheme
    kind : EquationClass or TreeClass
    motions : int
        Number of Brownian motions.
    top : int
        Largest weight of trees and forests.
    """

    scheme: Scheme
    kind: EquationClass | TreeClass
    motions: int
    top: int

    @property
    def noises(self) -> int:
        """Number of Brownian motions passed to a step; without noise, one with zero coefficient."""
        return max(1, self.motions)

    @property
    def problem(self) -> Problem:
        """An equation of the class."""
        raise NotImplementedError

    def trees(self, top: int) -> list[Tree]:
        """Return the trees of the class up to a weight."""
        raise NotImplementedError

    @property
    def overdamped(self) -> bool:
        """Whether only the invariant measure of overdamped dynamics is examined."""
        return False

    @property
    def covers(self) -> str:
        """Further requirements on equations and scheme, in words."""
        return ""

    @property
    def noise(self) -> frozenset[str]:
        """Which of dW, H, K and A can enter a step."""
        return self.scheme.noise

    @property
    def count(self) -> int:
        """Largest number of nodes per variable of a rule."""
        return COUNT

    @property
    def rule(self) -> Nodes:
        """Quadrature rule for expectations."""
        return rule_nodes(self.noises, self.noise, self.scheme.law, self.count)

    @property
    def other_rule(self) -> Nodes:
        """Quadrature rule with other nodes, also exact for polynomials."""
        return rule_nodes(self.noises, self.noise, self.scheme.law, self.count, other=True)

    @cached_property
    def is_polynomial(self) -> bool:
        """Whether weights are polynomials of the noise of degree at most `top` along a line, so that rules are exact.

        Weights must be known at each step size; see `fixed`.
        """
        points = line_points(self.noises, self.noise, ALONG)
        psi = self.weighed(points).psi
        s = points.dW[0]
        fit = np.polynomial.Polynomial.fit
        rest = [float(np.abs(row - fit(s, row, self.top)(s)).max()) for row in psi]
        return max(rest, default=0.0) <= self.tolerance * (1.0 + float(np.abs(psi).max(initial=0.0)))

    @property
    def points(self) -> Nodes:
        """Random noise."""
        return random_points(self.noises, self.scheme.law)

    @property
    def conditions(self) -> Conditions:
        """Conditions of the class."""
        raise NotImplementedError

    @property
    def tolerance(self) -> float:
        """Rounding error of a condition."""
        raise NotImplementedError

    @cached_property
    def why_not_weighed(self) -> str:
        """Why a step has no weights although the scheme solves the class, or an empty text."""
        step = OneStep(self.scheme, self.problem)
        if (
            reason := step.why_not_comparable()
            or step.why_not_entered(run=False)
            or self.steps_of_runs.why_not_entered()
        ):
            return reason
        try:
            self.at_points  # noqa: B018 - it makes the first steps
        except NoStepError as error:
            return str(error)
        return ""

    @property
    def steps_of_runs(self) -> OneStep:
        """The scheme on an equation of the class, on which runs measure the effect of memory."""
        return OneStep(self.scheme, self.problem)

    def memory_order(self, measure: str) -> float:
        """Return the order of the effect of memory in a run on an equation of the class; infinite without memory.

        Parameters
        ----------
        measure : str
        """
        found = self.steps_of_runs.memory
        if found is None:
            return inf
        return float(found.strong.min() if measure == STRONG else found.weak)

    @cached_property
    def fault(self) -> str:
        """Error that the scheme raises in one line, or an empty text."""
        try:
            self.why_not_weighed  # noqa: B018 - it makes the first steps
        except FAULTS as error:
            return one_line(error)
        return ""

    def weighed(self, nodes: Nodes, h: float = H) -> Weighed:
        """Return the combinations of weights of the conditions, for noise of steps of size h."""
        raise NotImplementedError

    @property
    def at_points(self) -> Weighed:
        """Combinations of weights of the conditions at random points."""
        raise NotImplementedError

    @property
    def distant(self) -> Sequence[Relatives]:
        """Related equations of the class, one of them far from the origin and one at late times."""
        raise NotImplementedError

    @cached_property
    def unlike_far_out(self) -> float:
        """Distance of a step from commuting with the maps of `distant`, relative to its motion."""
        pairs = self.distant
        if not pairs:
            return 0.0
        return distance_far(self.scheme, pairs, random_points(pairs[0].above.noise_dim, self.scheme.law))

    @property
    def why_not_far_out(self) -> str:
        """Why the conditions do not cover equations far out, late or with more motions, or an empty text."""
        found = self.unlike_far_out
        return f"a step differs far out, at late times or with more motions ({found:.2g})" if found > SAME else ""

    @cached_property
    def unlike_alone(self) -> float:
        """Largest difference of a path in a batch of different states and noises from the path alone, relative."""
        return distance_alone(self.steps_of_runs)

    @property
    def why_not_elsewhere(self) -> str:
        """Why the conditions, found for few equal states near the origin, do not cover others, or an empty text."""
        if self.unlike_alone > SAME:
            return f"a step depends on the other paths of its batch (by {self.unlike_alone:.2g})"
        return self.why_not_far_out

    @property
    def far_premise(self) -> str:
        """Premise on equations far from the origin in words; empty if the class has none."""
        return f", unchanged at distant states and late times {within(self.unlike_far_out)}" if self.distant else ""

    @property
    def fixed(self) -> bool:
        """Whether weights are independent of the step size, so that each condition either holds or fails."""
        raise NotImplementedError

    @property
    def all_sizes(self) -> bool:
        """Whether weights come from a series for all step sizes, with its accuracy."""
        return False

    @property
    def why_not_every(self) -> str:
        """Why the conditions do not cover every equation of the class, or an empty text."""
        raise NotImplementedError

    @property
    def premises(self) -> str:
        """The premises in words, if they hold."""
        raise NotImplementedError


class AffineProbe(Probe):
    """A scheme on problems whose components are trees, and on equations related by affine maps."""

    def weights(self, nodes: Nodes, h: float) -> Array:
        """Return the weights of all trees for noise of steps of size h, in units of h^(w/2)."""
        raise NotImplementedError

    def combined(self, phi: Array) -> Array:
        """Return the combinations of weights of the conditions, shape (n, K)."""
        raise NotImplementedError

    def weighed(self, nodes: Nodes, h: float = H) -> Weighed:
        """Return the combinations of weights of the conditions, for noise of steps of size h."""
        return Weighed(self.combined(self.weights(nodes, h)), nodes)

    @cached_property
    def first_weights(self) -> Array:
        """Weights of all trees at random points."""
        return self.weights(self.points, H)

    @cached_property
    def at_points(self) -> Weighed:
        """Combinations of weights of the conditions at many random points."""
        return self.weighed(random_points(self.noises, self.scheme.law, MANY))

    @property
    def equivariance(self) -> float:
        """Distance of a step from commuting with affine maps, relative to the states."""
        raise NotImplementedError

    @property
    def homogeneity(self) -> float:
        """Largest relative difference between step sizes of weights in units of h^(w/2)."""
        raise NotImplementedError

    @property
    def fixed(self) -> bool:
        """Whether weights are independent of the step size."""
        return self.homogeneity <= SAME

    @property
    def why_not_every(self) -> str:
        """Why the conditions do not cover every equation of the class, or an empty text."""
        reasons = []
        if self.equivariance > SAME:
            reasons.append(
                f"a step does not commute with affine maps and shifts of time (by {self.equivariance:.2g})"
            )
        if not self.fixed:
            reasons.append(f"weights of a step depend on h (by {self.homogeneity:.2g})")
        # If a step is not a sum over trees near the origin, equations far out are not examined.
        return ", ".join(reasons) or self.why_not_elsewhere

    @property
    def premises(self) -> str:
        """The premises in words, if they hold."""
        maps, weights = within(self.equivariance), within(self.homogeneity)
        return f"commutes with affine maps {maps}, weights independent of h {weights}{self.far_premise}"


class SDEProbe(Probe):
    """A scheme on a class of SDEs."""

    kind: EquationClass

    @property
    def overdamped(self) -> bool:
        """Whether only the invariant measure of overdamped dynamics is examined."""
        return self.kind.overdamped

    @property
    def covers(self) -> str:
        """Further requirements on equations and scheme, in words."""
        return self.kind.covers

    def trees(self, top: int) -> list[Tree]:
        """Return the trees up to a weight, without those whose elementary differential vanishes identically."""
        return self.kind.trees(self.motions, top)

    @property
    def conditions(self) -> Conditions:
        """Conditions of the class."""
        return conditions_of(self.kind, self.motions, self.top, self.tolerance)


class UniversalProbe(AffineProbe, SDEProbe):
    """A scheme on the universal SDE of a class."""

    tolerance = SAME

    @property
    def related(self) -> Family:
        """Equations of the class that are related by affine maps."""
        return related_equations(self.kind, self.motions)

    @property
    def distant(self) -> Sequence[Relatives]:
        """Related equations of the class, one of them far from the origin and one at late times."""
        return self.related.distant

    @property
    def problem(self) -> SDE:
        """Random equation of the class in the plane."""
        found: SDE = self.related.near.below
        return found

    @cached_property
    def weighing(self) -> Weighing:
        """The scheme on the universal SDE."""
        solves = self.related.uses_drift_derivative(self.scheme, self.points)
        return Weighing(self.scheme, self.conditions.trees, self.noises, self.kind.traits, solves)

    def weights(self, nodes: Nodes, h: float) -> Array:
        """Return the weights of all trees for noise of steps of size h, in units of h^(w/2), shape (N, K)."""
        return self.weighing.weights(nodes, h)

    def combined(self, phi: Array) -> Array:
        """Return the combinations of weights of the conditions, shape (n, K)."""
        return self.conditions.combined(phi)

    @property
    def equivariance(self) -> float:
        """Distance of a step from commuting with affine maps, relative to the states."""
        return distance(self.scheme, self.related.near, self.points)

    @cached_property
    def homogeneity(self) -> float:
        """Largest relative difference between step sizes of weights in units of h^(w/2)."""
        far = max(largest_change(self.first_weights, self.weights(self.points, h)) for h in OTHERS)
        trees = self.conditions.trees
        short = (
            largest_change(self.first_weights, self.weights(self.points, h), rounding_at(trees, h)) for h in SHORT
        )
        return max(far, *short)


class DiagonalProbe(SDEProbe):
    """A scheme on a rich equation with diagonal noise."""

    tolerance, all_sizes = TAYLOR, True

    @cached_property
    def conditions(self) -> Conditions:
        """Conditions of the class, whose tolerances are the rounding errors of weights from a Taylor series."""
        found = conditions_of(self.kind, self.motions, self.top, self.tolerance)
        unknowns = rich_equation(self.motions, tuple(found.names)).unknowns
        # Solvers are exact to `SAME` alone.
        tolerances = {each.weight: float(np.clip(DEVIATIONS * each.rounding, SAME, TAYLOR)) for each in unknowns}
        return replace(found, tolerances=tolerances)

    @property
    def equation(self) -> RichEquation:
        """Rich equation that distinguishes the trees of the conditions."""
        return rich_equation(self.motions, tuple(self.conditions.names))

    @property
    def problem(self) -> SDE:
        """The rich equation as a problem."""
        return self.equation.sde

    @property
    def distant(self) -> Sequence[Relatives]:
        """The rich equation, far from the origin and at late times."""
        return self.equation.distant

    @property
    def noise(self) -> frozenset[str]:
        """Which of dW, H and K can enter a step; Lévy areas do not."""
        return self.scheme.noise - {"A"}

    @property
    def count(self) -> int:
        """Largest number of nodes per variable of a rule; fewer with many variables."""
        return FEWEST if "H" in self.noise else COUNT

    @property
    def points(self) -> Nodes:
        """Random noise of reduced size, so that the series converges fast."""
        found = super().points
        return found if self.scheme.law.bounded else found._replace(dW=NEARER * found.dW)

    def weighed(self, nodes: Nodes, h: float = H) -> Weighed:
        """Return the combinations of weights of the conditions, which hold for all step sizes."""
        return Weighed(self._at(nodes).psi, nodes)

    @property
    def at_points(self) -> Weighed:
        """Combinations of weights of the conditions at random points."""
        return Weighed(self.series.psi, self.points)

    def _at(self, nodes: Nodes) -> TaylorWeights:
        return taylor_weights(self.scheme, self.equation, nodes)

    @cached_property
    def series(self) -> TaylorWeights:
        """Weights at random points, with their distances from a series and from sums over trees."""
        return self._at(self.points)

    @property
    def fixed(self) -> bool:
        """Whether a step is a power series in sqrt(h) and a sum over trees, so that weights exist."""
        return self.series.no_series <= SERIES and not self._no_trees

    @property
    def _no_trees(self) -> float:
        """Largest distance of the series from a sum over trees that is above the tolerance; 0 if there is none."""
        tolerance_of = self.conditions.tolerance_of
        return max((off for weight, off in self.series.no_trees.items() if off > tolerance_of(weight)), default=0.0)

    @property
    def why_not_every(self) -> str:
        """Why a step has no weights, or an empty text."""
        if self.series.no_series > SERIES:
            return f"a step is not a power series in sqrt(h) (difference {self.series.no_series:.2g})"
        if self._no_trees:
            return f"a step is not a sum over trees (difference {self._no_trees:.2g})"
        return self.why_not_elsewhere

    @property
    def premises(self) -> str:
        """The premises in words, if they hold."""
        no_series, no_trees = self.series.no_series, max(self.series.no_trees.values())
        near = f"a power series in sqrt(h) to {no_series:.0e}, a sum over trees to {no_trees:.0e}"
        return near + self.far_premise


@lru_cache(maxsize=SHARED)
def rich_equation(motions: int, basis: tuple[Tree, ...]) -> RichEquation:
    """Return the equation with diagonal noise that distinguishes some trees, cached for all schemes."""
    return RichEquation(motions, basis)


@lru_cache(maxsize=SHARED)
def conditions_of(kind: EquationClass, motions: int, top: int, tolerance: float) -> Conditions:
    """Return the conditions of a class, cached because many schemes share them.

    Parameters
    ----------
    kind : EquationClass
        Class of equations.
    motions : int
    top : int
        Largest weight of trees and forests.
    tolerance : float
        Rounding error of a condition.
    """
    trees = kind.trees(motions, top)
    return Conditions(trees, kind.basis(trees, motions), ExactMoments(), tolerance)
