"""Terms of a modified equation, from the means of forests of one weight."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import nan

from sdaeverify import Scheme
from sdaeverify.probing import Nodes
from sdaeverify.trees import TreeClass

from ..classes import EquationClass
from ..conditions import WEAK, Condition, Conditions, Weighed
from ..examined import Examined
from ..grow import Forest
from ..posed.probe import probe_of
from ..probes import Probe
from ..stationary import forest_symmetry
from ..weights import NoStepError

# Largest number of trees, and weights: the 474 trees of general noise with two motions and weight 5 take 0.3 s.
MOST_TREES, DEFAULT_WEIGHT, MOST_WEIGHT = 500, 6, 8


@dataclass(frozen=True)
class GeneratorTerm:
    """A term c D^n u(F(tau_1), ..., F(tau_n)) of the generator of a modified equation.

    Attributes
    ----------
    forest : Forest
        Trees tau_1, ..., tau_n.
    value : float
        Coefficient c = (found - wanted)/sigma.
    error : float
        Bound on the error of c.
    """

    forest: Forest
    value: float
    error: float


@dataclass(frozen=True)
class ModifiedEquation:
    """The modified equation of a scheme for a class of equations.

    Attributes
    ----------
    scheme, kind : str
        Label of the scheme and name of the class.
    motions : int
        Number of Brownian motions.
    order : float
        Weak order p of single steps; NaN if unknown.
    terms : tuple of GeneratorTerm
        Terms of h^p L_p; empty if all conditions on means hold up to the largest weight.
    top : int
        Largest examined weight of forests.
    why_not : str
        Why the scheme has no modified equation from trees, or an empty text.
    solves : bool
        Whether the scheme solves equations of the class.
    """

    scheme: str
    kind: str
    motions: int
    order: float = nan
    terms: tuple[GeneratorTerm, ...] = ()
    top: int = 0
    why_not: str = ""
    solves: bool = True

    def of_degree(self, n: int) -> tuple[GeneratorTerm, ...]:
        """Return the terms with n-th derivatives of u."""
        return tuple(each for each in self.terms if len(each.forest) == n)

    @property
    def drift(self) -> tuple[GeneratorTerm, ...]:
        """Terms of f_p, each c F(tau)."""
        return self.of_degree(1)

    @property
    def covariance(self) -> tuple[GeneratorTerm, ...]:
        """Terms of Q_p, each c (F(tau_1) F(tau_2)^T + F(tau_2) F(tau_1)^T)."""
        return self.of_degree(2)

    @property
    def obstruction(self) -> tuple[GeneratorTerm, ...]:
        """Terms of third and higher order, with which no modified SDE exists."""
        return tuple(each for each in self.terms if len(each.forest) > 2)

    @property
    def exists(self) -> bool:
        """Whether the terms are those of an SDE."""
        return bool(self.terms) and not self.obstruction


def is_slow(kind: EquationClass | TreeClass) -> bool:
    """Return whether trees have algebraic nodes above others, so that a modified equation takes minutes."""
    return isinstance(kind, TreeClass) and any(not node.integral and node.least for node in kind.nodes)


def modified_equation(
    scheme: Scheme, kind: EquationClass | TreeClass, motions: int = 2, weight: int | None = None
) -> ModifiedEquation:
    """Compute the modified equation of a scheme for a class of equations.

    Parameters
    ----------
    scheme : Scheme
    kind : EquationClass or TreeClass
        Class of equations.
    motions : int
        Number of Brownian motions if the class does not fix it.
    weight : int, optional
        Largest weight of forests, at most 8; by default the largest with at most 500 trees.
    """
    own = motions if kind.motions is None else kind.motions
    first = probe_of(scheme, kind, own, 1)
    why_not = Examined(first).why_not
    empty = ModifiedEquation(scheme.label, kind.name, own, why_not=why_not, solves=not why_not)
    try:
        return empty if empty.why_not else _found(empty, first, weight)
    except NoStepError as error:
        return ModifiedEquation(scheme.label, kind.name, own, why_not=str(error))


def _found(empty: ModifiedEquation, probe: Probe, weight: int | None) -> ModifiedEquation:
    """Return the modified equation from the lowest weight at which conditions on means fail.

    Raises
    ------
    NoStepError
        If a step cannot be computed.
    """
    top = 0
    for w in range(2, (weight or DEFAULT_WEIGHT) + 1, 2):
        probe = probe_of(probe.scheme, probe.kind, probe.motions, w)
        if weight is None and len(probe.trees(w)) > MOST_TREES:
            break
        if why := probe.fault or probe.why_not_weighed:
            return _with(empty, top=top, why_not=why)
        top, failing = w, _failing_means(probe)
        if failing:
            why, order = _why_unknown(probe, failing), 0.5 * failing[0].weight - 1.0
            return _with(empty, order, top, () if why else tuple(map(_term, failing)), why)
    return _with(empty, top=top)


def _with(
    empty: ModifiedEquation,
    order: float = nan,
    top: int = 0,
    terms: tuple[GeneratorTerm, ...] = (),
    why_not: str = "",
) -> ModifiedEquation:
    return ModifiedEquation(empty.scheme, empty.kind, empty.motions, order, terms, top, why_not)


def _failing_means(probe: Probe) -> list[Condition]:
    """Return the failing conditions on means of the lowest weight."""
    failing = [each for each in means(probe.conditions, probe.weighed(probe.rule), probe.top) if not each.held]
    least = min((each.weight for each in failing), default=0)
    return [each for each in failing if each.weight == least]


def means(conditions: Conditions, rule: Weighed, top: int) -> list[Condition]:
    """Return the conditions on means of forests of the largest weight and the one below.

    Parameters
    ----------
    conditions : Conditions
        Conditions at least up to the weight.
    rule : Weighed
    top : int
        Largest weight.
    """
    forests = conditions.forests(top)
    return conditions.of_means(
        rule, [some for some in forests if sum(map(conditions.weights.__getitem__, some)) > top - 2]
    )


def _term(condition: Condition) -> GeneratorTerm:
    symmetry = forest_symmetry(condition.forest)
    error = condition.tolerance * (1.0 + abs(float(condition.wanted)))
    return GeneratorTerm(
        tuple(sorted(condition.forest)), (condition.found - float(condition.wanted)) / symmetry, error / symmetry
    )


def _why_unknown(probe: Probe, failing: Sequence[Condition]) -> str:
    """Return why the defects of means are not the terms of an equation, or an empty text."""
    if not probe.scheme.local_order_is_global:
        return "later steps cancel errors of single steps"
    if why := probe.why_not_every:
        return why
    weight = failing[0].weight
    if probe.memory_order(WEAK) < 0.5 * weight:
        return "a step depends on earlier steps by as much as the terms of the modified equation"
    return _why_inexact(probe, failing)


def _why_inexact(probe: Probe, failing: Sequence[Condition]) -> str:
    """Return that two rules for expectations disagree on the defects, or an empty text; see `Examined`."""
    if probe.all_sizes or probe.scheme.law.bounded:
        return ""
    other = probe.weighed(probe.other_rule)
    again = {each.forest: each.found for each in means(probe.conditions, other, probe.top)}
    for each in failing:
        if Nodes.why_inexact((each.found, again[each.forest]), abs(each.found - float(each.wanted))):
            return f"two quadrature rules give {each.found:.3g} and {again[each.forest]:.3g} for {each.name}"
    return ""
