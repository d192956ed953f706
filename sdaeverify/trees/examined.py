"""What the conditions of a class say of a scheme: orders, and which conditions limit them."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from math import nan

import numpy as np

from ..probe.step.memory import NEAR
from ..probe.step.two_rules import AGREEMENT, SHAPED
from .asymptotic import SIZES, Rate, order_left, rates, slowest
from .conditions import INVARIANT, STRONG, WEAK, Condition, Weighed, belongs, breaking, means_of_products, order_of
from .probes import Probe
from .record import Record
from .weights import H

# Rates are compared with orders, which are multiples of 1/2.
HALF = 0.25
# How far below a claim the order of what memory changes may be: as far as orders of single steps.
MARGINS = {STRONG: 0.1, WEAK: 0.25, INVARIANT: 0.25}
MEMORY = "memory changes runs by errors of order {:.2f}, which steps without a history do not show"


@dataclass(frozen=True, eq=False)
class Examined:
    """A scheme and a class of equations.

    Attributes
    ----------
    probe : Probe
        Where weights are found.
    """

    probe: Probe

    @property
    def why_not(self) -> str:
        """Why order conditions cannot be asked of the scheme on this class, or an empty text."""
        scheme, problem = self.probe.scheme, self.probe.problem
        if scheme.view_of(problem) is not problem:
            forms = " or ".join(form.__name__ for form in scheme.forms)
            return f"solves the form {forms}"
        if scheme.discontinuous_in_noise:
            return "a step jumps as a function of its noise: it has no expansion"
        return scheme.why_not(problem)

    @cached_property
    def found(self) -> list[Condition]:
        """All conditions with what is found, at a step size at which weights of a B-series are best known."""
        return self.found_at(H)

    def found_at(self, h: float) -> list[Condition]:
        """Return all conditions with what is found in units of h^(w/2) with steps of size h."""
        probe, conditions = self.probe, self.probe.conditions
        rule = probe.weighed(probe.rule, h)
        if probe.overdamped:
            return conditions.of_stationary(rule)
        means = conditions.of_means(rule, conditions.forests(probe.top))
        if probe.scheme.law.bounded:
            return means
        record = Record(probe.noise, probe.motions, conditions.moments)
        random = probe.at_points if h == H else probe.weighed(probe.points, h)
        return [*conditions.on_paths(random, rule, record, probe.top - 1), *means]

    @cached_property
    def rates(self) -> list[Rate]:
        """How fast defects vanish, where weights depend on h; none of diagonal noise, whose weights do not."""
        return [] if self.probe.all_sizes else list(rates([self.found_at(h) for h in SIZES]))

    def order(self, measure: str) -> float:
        """Return the order that the conditions give; as information only where weights depend on h."""
        if self.probe.fixed:
            return order_of(self.found, self.probe.top, measure)
        return order_left(self.rates, measure, self.probe.top) if self.rates else nan

    def is_below(self, measure: str, p: float) -> bool:
        """Return whether conditions that were looked at speak against an order.

        Conditions hold or do not at every step size: the margin of a claim, which is for coarse steps along paths,
        does not lower p. Orders by rates, where weights depend on h, are known to `HALF`.

        Parameters
        ----------
        measure : str
        p : float
        """
        least = p if self.probe.fixed else p - HALF
        return self.order(measure) < min(least, 0.5 * (self.probe.top - 1))

    def held_of(self, measure: str, p: float) -> tuple[int, int]:
        """Return how many of the conditions of an order hold, or have a rate that is enough for it, and how many are.

        A defect that vanishes too slowly counts whatever its weight: a coefficient at a wrong time spoils each order.

        Parameters
        ----------
        measure : str
        p : float
        """
        if self.probe.fixed:
            held = [each.held for each in self.found if belongs(each, measure, p)]
        else:
            told = [(rate, rate.order(measure) > p - HALF) for rate in self.rates]
            held = [enough for rate, enough in told if not enough or belongs(rate.condition, measure, p)]
        return sum(held), len(held)

    def breaking(self, measure: str) -> Sequence[Condition]:
        """Return the conditions that limit the order, the first one first."""
        if self.probe.fixed:
            return breaking(self.found, measure)
        if not self.rates:
            return []
        slow = slowest(self.rates, measure)
        return [slow.condition._replace(power=slow.power)] if slow.order(measure) < 0.5 * (self.probe.top - 1) else []

    def why_not_exact(self, measure: str, p: float) -> str:
        """Return why a mean is not known, or an empty text: two rules disagree on it.

        Rules are exact for polynomials of the noise. A step that is none, as one with the modulus of dW, has means
        that no rule gives exactly. Those of an order count, and where weights depend on h, the first that fails.

        Parameters
        ----------
        measure : str
        p : float
            The order.
        """
        probe, failing = self.probe, list(self.breaking(measure))
        if probe.scheme.law.bounded or (failing and failing[0].on_paths):
            return ""
        if probe.fixed:
            h, some = H, [] if probe.is_polynomial else self._means_of(measure, p)
        else:
            h, some = SIZES[0], failing[:1]
        if not some:
            return ""
        rules = probe.weighed(probe.rule, h), probe.weighed(probe.other_rule, h)
        for condition in some:
            found, other = (self._mean_at(condition, rule) for rule in rules)
            defect, rounding = abs(found - float(condition.wanted)), condition.tolerance * (1.0 + abs(found))
            if abs(found - other) > max(AGREEMENT * defect, rounding):
                return f"two rules give {found:.3g} and {other:.3g} for {condition.name}: {SHAPED}"
        return ""

    def _means_of(self, measure: str, p: float) -> list[Condition]:
        return [each for each in self.found if not each.on_paths and belongs(each, measure, p)]

    def why_spoilt(self, measure: str, claim: float) -> str:
        """Return that the memory of runs changes them by errors of a lower order than the claim, or an empty text.

        Parameters
        ----------
        measure : str
        claim : float
            The order; NaN without a claim.
        """
        most = self.probe.memory_order(measure)
        return MEMORY.format(most) if most < claim - MARGINS[measure] else ""

    def why_taken_back(self, measure: str) -> str:
        """Return that what the memory of runs changes may take back errors of single steps, or an empty text.

        Parameters
        ----------
        measure : str
        """
        most = self.probe.memory_order(measure)
        return MEMORY.format(most) if most < self.order(measure) + NEAR else ""

    def _mean_at(self, condition: Condition, rule: Weighed) -> float:
        forests = [condition.forest, *(forest for forest, _ in condition.others)]
        factors = np.array([1.0, *(float(c) for _, c in condition.others)])
        places = [tuple(map(self.probe.conditions.names.index, forest)) for forest in forests]
        return float(factors @ means_of_products(rule.psi, rule.nodes.weights, places))

    @property
    def measures(self) -> tuple[str, ...]:
        """The measures whose orders follow: a bounded law tells no paths."""
        if self.probe.overdamped:
            return (INVARIANT,)
        return (WEAK,) if self.probe.scheme.law.bounded else (STRONG, WEAK)
