"""Computation of the weights of a class that a form defines."""

from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property, lru_cache

import numpy as np

from sdaeverify import Array, Problem, Scheme
from sdaeverify.probing import Nodes, OneStep
from sdaeverify.trees import Relatives, TreeClass

from ..asymptotic import largest_change
from ..classes import EquationClass
from ..conditions import Conditions
from ..grow import Tree
from ..moments import Combination, ExactMoments
from ..nodes import random_points
from ..probes import SAME, SHARED, AffineProbe, DiagonalProbe, Probe, UniversalProbe
from ..relatives import distance
from ..weights import OTHERS, SHORT, H, rounding_at
from .grammar import grow_nodes, sum_of_integrals, told_apart
from .weighing import PosedWeighing

# Horizon of runs as part of that of the problem; in longer runs a random algebraic equation may change its root.
RUN = 0.0625


@lru_cache(maxsize=SHARED)
def relatives_of(kind: TreeClass, motions: int) -> Relatives:
    """Return related equations of a class, cached because most schemes only need their form."""
    return kind.relatives(motions)


@lru_cache(maxsize=SHARED)
def distant_of(kind: TreeClass, motions: int) -> tuple[Relatives, ...]:
    """Return related equations of a class far from the origin and at late times, cached for all schemes."""
    return tuple(kind.distant(motions))


class PosedProbe(AffineProbe):
    """A scheme on the problems that a form defines."""

    kind: TreeClass

    @property
    def tolerance(self) -> float:
        """Rounding error of a condition, from those of weights and of the interpolation of a coefficient."""
        if not self.fixed:
            return SAME
        weighing, count = self.weighing, 1 + max(k for _, k in self._told_apart)
        rounding = float(np.abs(weighing.powers(count)).sum(axis=1).max()) * max(self.homogeneity, self.remainder)
        return max(SAME, rounding, float(weighing.growth(count).max()) * self.remainder)

    @cached_property
    def steps_of_runs(self) -> OneStep:
        """The scheme on a random equation of the class, on which runs measure the effect of memory."""
        return OneStep(self.scheme, replace(self.problem, horizon=RUN * self.problem.horizon))

    @property
    def relatives(self) -> Relatives:
        """Equations of the class that are related by an affine map."""
        return relatives_of(self.kind, self.motions)

    @property
    def distant(self) -> Sequence[Relatives]:
        """Related equations of the class, one of them far from the origin and one at late times."""
        return distant_of(self.kind, self.motions)

    @property
    def problem(self) -> Problem:
        """Random equation of the class."""
        found: Problem = self.relatives.below
        return found

    def trees(self, top: int) -> list[Tree]:
        """Return the trees up to a weight."""
        return grow_nodes(self.kind.nodes, self.motions, top)

    @property
    def _scaled(self) -> frozenset[str]:
        return frozenset(node.name for node in self.kind.nodes if node.scaled)

    @property
    def conditions(self) -> Conditions:
        """Conditions of the class."""
        trees, basis = self.trees(self.top), list(self._told_apart.values())
        return Conditions(trees, basis, ExactMoments(), self.tolerance, [*map(sum_of_integrals, basis)])

    @cached_property
    def weighing(self) -> PosedWeighing:
        """The scheme on the problems whose components are the trees."""
        plain = [each for each in self.trees(self.top) if self._scaled.isdisjoint(_names(each))]
        return PosedWeighing(self.scheme, self.kind, self.motions, plain)

    def weights(self, nodes: Nodes, h: float) -> Array:
        """Return the weights of all trees at all scaling values, in units of h^(w/2), shape (G, N, K)."""
        return self.weighing.at_values(nodes, h, self.weighing.values)

    def combined(self, phi: Array) -> Array:
        """Return the combinations of weights of the conditions, shape (n, K)."""
        weighing, keys = self.weighing, list(self._told_apart)
        places = {each: place for place, each in enumerate(weighing.trees)}
        found = np.tensordot(weighing.powers(1 + max(k for _, k in keys)), phi, axes=1)
        return np.asarray(found[[k for _, k in keys], [places[each] for each, _ in keys]])

    @cached_property
    def _told_apart(self) -> dict[tuple[Tree, int], Combination]:
        return told_apart(self.trees(self.top), self._scaled, self.top)

    @cached_property
    def equivariance(self) -> float:
        """Distance of a step from commuting with affine maps, relative to the states."""
        above = self.relatives.above
        return distance(self.scheme, self.relatives, random_points(above.noise_dim, self.scheme.law))

    @cached_property
    def homogeneity(self) -> float:
        """Largest relative difference between step sizes of weights in units of h^(w/2)."""
        weighing, few = self.weighing, self.weighing.few
        first = self.first_weights[few]
        others = (weighing.at_values(self.points, h, weighing.values[few]) for h in (*OTHERS, *SHORT))
        roundings: tuple[Array | float, ...] = (
            *(0.0 for _ in OTHERS),
            *(rounding_at(weighing.trees, h) for h in SHORT),
        )
        return max(largest_change(first, *each) for each in zip(others, roundings, strict=True))

    @property
    def remainder(self) -> float:
        """Relative distance of weights from a power series in the number of scaled nodes; 0 without scaled nodes."""
        weighing = self.weighing
        if not self._scaled:
            return 0.0
        value, expected = weighing.interpolated(self.first_weights)
        return largest_change(expected, weighing.at_values(self.points, H, np.array([value]))[0])

    @property
    def why_not_every(self) -> str:
        """Why the conditions do not cover every equation of the class, or an empty text."""
        series = "" if self.remainder <= SAME else f"weights are not a power series ({self.remainder:.2g})"
        return ", ".join(filter(None, (super().why_not_every, series)))

    @property
    def premises(self) -> str:
        """The premises in words, if they hold."""
        series = (f"a power series in {name} to {self.remainder:.0e}" for name in sorted(self._scaled))
        return ", ".join((super().premises, *series))


def _names(each: Tree) -> frozenset[str]:
    return frozenset({each.name}).union(*map(_names, each.kids))


def probe_of(scheme: Scheme, kind: EquationClass | TreeClass, motions: int, top: int) -> Probe:
    """Return the probe that computes the weights of a class.

    Parameters
    ----------
    scheme : Scheme
    kind : EquationClass or TreeClass
        Class of equations.
    motions : int
    top : int
    """
    if isinstance(kind, TreeClass):
        return PosedProbe(scheme, kind, motions, top)
    return (DiagonalProbe if kind.diagonal else UniversalProbe)(scheme, kind, motions, top)
