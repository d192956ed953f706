"""A scheme on a class of SDEs: premises, conditions, and the orders that follow."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

from .. import Scheme, SdaeverifyError
from ..probing import Nodes, OneStep
from .asymptotic import SIZES, Rate, largest_change, order_left, rates, slowest
from .classes import EquationClass
from .conditions import STRONG, WEAK, Condition, Conditions, Weighed, belongs, breaking, order_of
from .equivariance import Related, related_equations
from .moments import ExactMoments
from .nodes import random_points, rule_nodes
from .record import Record
from .weights import OTHERS, H, NoStepError, Weighing

# Relative: updates of Newton's method are 1e-10 and less, what is no B-series 1e-4 and more.
SAME = 1e-8
# Rates are compared with orders, which are multiples of 1/2.
HALF = 0.25


@dataclass(frozen=True, eq=False)
class Examined:
    """A scheme and a class of equations.

    Attributes
    ----------
    scheme : Scheme
    kind : EquationClass
    motions : int
        Number of Brownian motions.
    top : int
        Largest weight of trees and forests.
    """

    scheme: Scheme
    kind: EquationClass
    motions: int
    top: int

    @cached_property
    def related(self) -> Related:
        """Equations of the class that an affine map relates."""
        return related_equations(self.kind, self.motions)

    @cached_property
    def points(self) -> Nodes:
        """Random noise."""
        return random_points(max(1, self.motions), self.scheme.law)

    @cached_property
    def not_applicable(self) -> str:
        """Why order conditions cannot be asked of the scheme on this class, or an empty text."""
        problem = self.related.below
        if self.scheme.view_of(problem) is not problem:
            forms = " or ".join(form.__name__ for form in self.scheme.forms)
            return f"solves the form {forms}"
        if self.scheme.jumps:
            return "a step jumps as a function of its noise: it has no expansion"
        return self.scheme.refuses(problem)

    @cached_property
    def unasked(self) -> str:
        """Why a step cannot be compared with trees though the scheme solves the class, or an empty text."""
        step = OneStep(self.scheme, self.related.below)
        if reason := step.why_not_comparable() or step.why_not_entered():
            return reason
        try:
            self.weighing.weights(self.points, H)
        except NoStepError as error:
            return str(error)
        except SdaeverifyError as error:
            return f"the step raises {type(error).__name__}: {error}"
        return ""

    @cached_property
    def conditions(self) -> Conditions:
        """The conditions of the class."""
        trees = self.kind.trees(self.motions, self.top)
        return Conditions(trees, self.kind.basis(trees, self.motions), ExactMoments())

    @cached_property
    def weighing(self) -> Weighing:
        """The scheme on the universal SDE."""
        solves = self.related.solves(self.scheme, self.points)
        return Weighing(self.scheme, self.conditions.trees, max(1, self.motions), self.kind.traits, solves)

    @cached_property
    def equivariance(self) -> float:
        """How far a step is from commuting with affine maps, relative to the states."""
        return self.related.defect(self.scheme, self.points)

    @cached_property
    def homogeneity(self) -> float:
        """How far weights in units of h^(w/2) differ between step sizes, relative to them."""
        first = self.weighing.weights(self.points, H)
        return max(largest_change(first, self.weighing.weights(self.points, h)) for h in OTHERS)

    @property
    def exact(self) -> bool:
        """Whether weights do not depend on the step size, so that each condition holds or does not."""
        return self.homogeneity <= SAME

    @property
    def why_not_every(self) -> str:
        """Why conditions do not say enough of every equation of the class, or an empty text."""
        reasons = []
        if self.equivariance > SAME:
            reasons.append(f"a step does not commute with affine maps ({self.equivariance:.2g})")
        if not self.exact:
            reasons.append(f"weights depend on h ({self.homogeneity:.2g})")
        return ", ".join(reasons)

    @property
    def premises(self) -> str:
        """The premises in words."""
        return self.why_not_every or (
            f"equivariant to {self.equivariance:.0e}, weights independent of h to {self.homogeneity:.0e}"
        )

    @cached_property
    def found(self) -> list[Condition]:
        """All conditions with what is found, at a step size at which weights of a B-series are best known."""
        return self.found_at(H)

    def found_at(self, h: float) -> list[Condition]:
        """Return all conditions with what is found in units of h^(w/2) with steps of size h."""
        rule = self._weighed(rule_nodes(max(1, self.motions), self.scheme.noise, self.scheme.law), h)
        means = self.conditions.of_means(rule, self.conditions.forests(self.top))
        if self.scheme.law.bounded:
            return means
        record = Record(self.scheme.noise, self.motions, self.conditions.moments)
        return [*self.conditions.on_paths(self._weighed(self.points, h), rule, record, self.top - 1), *means]

    def _weighed(self, nodes: Nodes, h: float) -> Weighed:
        return Weighed(self.weighing.weights(nodes, h), nodes)

    @cached_property
    def rates(self) -> list[Rate]:
        """How fast defects vanish, where weights depend on h."""
        return list(rates([self.found_at(h) for h in SIZES]))

    def order(self, measure: str) -> float:
        """Return the order that the conditions give; as information only where weights depend on h."""
        if self.exact:
            return order_of(self.found, self.top, measure)
        return order_left(self.rates, measure, self.top)

    def held_of(self, measure: str, p: float) -> tuple[int, int]:
        """Return how many of the conditions of an order hold, or have a rate that is enough for it, and how many are.

        Parameters
        ----------
        measure : str
        p : float
        """
        if self.exact:
            held = [each.held for each in self.found if belongs(each, measure, p)]
        else:
            concerned = (each for each in self.rates if belongs(each.condition, measure, p))
            held = [each.order(measure) > p - HALF for each in concerned]
        return sum(held), len(held)

    def breaking(self, measure: str) -> Sequence[Condition]:
        """Return the conditions that limit the order, the first one first."""
        if self.exact:
            return breaking(self.found, measure)
        slow = slowest(self.rates, measure)
        return [slow.condition] if slow.order(measure) < 0.5 * (self.top - 1) else []

    @property
    def measures(self) -> tuple[str, ...]:
        """The measures whose orders follow: a bounded law tells no paths."""
        return (WEAK,) if self.scheme.law.bounded else (STRONG, WEAK)
