"""Results of the conditions of a class for a scheme: orders, and the conditions that limit them."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from math import nan

import numpy as np

from sdaeverify.probing import Nodes

from .asymptotic import SIZES, Rate, order_left, rates, slowest
from .conditions import INVARIANT, STRONG, WEAK, Condition, Weighed, belongs, breaking, means_of_products, order_of
from .probes import Probe
from .record import Record
from .weights import H

# Tolerance for rates and for the effect of memory, because orders are multiples of 1/2.
HALF = 0.25
# Tolerance below a claim for the order of the effect of memory, the same as for orders of single steps.
MARGINS = {STRONG: 0.1, WEAK: 0.25, INVARIANT: 0.25}
MEMORY = "memory adds errors of order {:.2f} to a run, which steps without a history do not show"


@dataclass(frozen=True, eq=False)
class Examined:
    """A scheme and a class of equations, with the results of the conditions.

    Attributes
    ----------
    probe : Probe
        Computes the weights.
    """

    probe: Probe

    @property
    def why_not(self) -> str:
        """Why the class has no order conditions for the scheme, or an empty text."""
        scheme, problem = self.probe.scheme, self.probe.problem
        if scheme.view_of(problem) is not problem:
            forms = " or ".join(form.__name__ for form in scheme.forms)
            return f"solves the form {forms}"
        if scheme.discontinuous_in_noise:
            return "a step is discontinuous in its noise, so that it has no expansion"
        return scheme.why_not(problem)

    @cached_property
    def found(self) -> list[Condition]:
        """All conditions with their defects, at a step size that determines the weights of a B-series best."""
        return self.found_at(H)

    def found_at(self, h: float) -> list[Condition]:
        """Return all conditions with their defects for steps of size h, in units of h^(w/2)."""
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
        """Rates of the defects if weights depend on h; empty for diagonal noise, whose weights hold for all h."""
        return [] if self.probe.all_sizes else list(rates([self.found_at(h) for h in SIZES]))

    def order(self, measure: str) -> float:
        """Return the order from the conditions; only informative if weights depend on h."""
        if self.probe.fixed:
            return order_of(self.found, self.probe.top, measure)
        return order_left(self.rates, measure, self.probe.top) if self.rates else nan

    def is_below(self, measure: str, p: float) -> bool:
        """Return whether the examined conditions contradict an order.

        Conditions hold or fail at every step size. Therefore the margin of a claim, which allows for coarse steps
        along paths, does not lower p. Orders from rates, if weights depend on h, are accurate to `HALF`.

        Parameters
        ----------
        measure : str
        p : float
        """
        least = p if self.probe.fixed else p - HALF
        return self.order(measure) < min(least, 0.5 * (self.probe.top - 1))

    def held_of(self, measure: str, p: float) -> tuple[int, int]:
        """Return the number of conditions of an order that hold, or have a sufficient rate, and their total number.

        A defect that vanishes too slowly counts regardless of its weight, because a coefficient taken at a wrong time
        spoils every order.

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
        """Return the conditions that limit the order, lowest order first."""
        if self.probe.fixed:
            return breaking(self.found, measure)
        if not self.rates:
            return []
        slow = slowest(self.rates, measure)
        return [slow.condition._replace(power=slow.power)] if slow.order(measure) < 0.5 * (self.probe.top - 1) else []

    def why_not_exact(self, measure: str, p: float) -> str:
        """Return why a mean is not known exactly because two rules disagree on it, or an empty text.

        Rules are exact for polynomials of the noise. If a step is not a polynomial, such as one with the modulus of
        dW, no rule gives its means exactly. The means of the conditions of an order are compared or, if weights
        depend on h, that of the first failing condition.

        Parameters
        ----------
        measure : str
        p : float
            Order of the conditions.
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
            if abs(found - other) > rounding and (why := Nodes.why_inexact((found, other), defect)):
                return f"two quadrature rules give {found:.3g} and {other:.3g} for {condition.name}: {why}"
        return ""

    def _means_of(self, measure: str, p: float) -> list[Condition]:
        return [each for each in self.found if not each.on_paths and belongs(each, measure, p)]

    def why_spoilt(self, measure: str, claim: float) -> str:
        """Return that memory changes runs by errors of a lower order than the claim, or an empty text.

        Parameters
        ----------
        measure : str
        claim : float
            Claimed order; NaN without a claim.
        """
        most = self.probe.memory_order(measure)
        return MEMORY.format(most) if most < claim - MARGINS[measure] else ""

    def why_taken_back(self, measure: str) -> str:
        """Return that the effect of memory may cancel errors of single steps, or an empty text.

        Parameters
        ----------
        measure : str
        """
        most = self.probe.memory_order(measure)
        return MEMORY.format(most) if most < self.order(measure) + HALF else ""

    def _mean_at(self, condition: Condition, rule: Weighed) -> float:
        forests = [condition.forest, *(forest for forest, _ in condition.others)]
        factors = np.array([1.0, *(float(c) for _, c in condition.others)])
        places = [tuple(map(self.probe.conditions.names.index, forest)) for forest in forests]
        return float(factors @ means_of_products(rule.psi, rule.nodes.weights, places))

    @property
    def measures(self) -> tuple[str, ...]:
        """Measures with an order from the conditions; a bounded law determines no paths."""
        if self.probe.overdamped:
            return (INVARIANT,)
        return (WEAK,) if self.probe.scheme.law.bounded else (STRONG, WEAK)
