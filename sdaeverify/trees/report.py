"""Verdicts on the claims of a scheme, class by class, from order conditions."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from math import ceil, inf, nan
from pathlib import Path

import pandas as pd

from ..contracts.claimed import Order
from ..contracts.scheme import Claim, Scheme
from ..contracts.settings import whole
from ..contracts.spelling import did_you_mean
from ..errors import UsageError
from ..forms import SDE
from ..registry.load import load_registry
from ..registry.selection import select_schemes
from . import TreeClass
from .classes import CLASSES, OF_SDES, EquationClass
from .conditions import INVARIANT, STRONG, WEAK, Condition, belongs
from .examined import Examined
from .posed.probe import PosedProbe
from .probes import DiagonalProbe, Probe, UniversalProbe
from .problem_file import problem_file
from .sdes.universal import Universal
from .weights import NoStepError


class ClassVerdict(StrEnum):
    """What order conditions say of a claim for a class of equations."""

    VERIFIED = "verified"
    REFUTED = "refuted"
    PREMISE = "premise fails"
    NOT_CLAIMED = "not claimed"
    ERROR = "error"
    NOT_APPLICABLE = "not applicable"


# Without a claim, trees up to this weight are looked at. One more where there are about so many trees at most: each
# weight brings a multiple of those before.
LEAST, CHEAP, GROWTH = 3, 500, 4
# Rules for expectations are exact up to this weight, whatever noise a step uses.
EXACT = 5
# Invariant measures of order 2 need the weight 5.
STATIONARY = 5
# Motions where nobody says how many: many up to a weight and a number of trees, few above.
FEW, MANY, QUICK, QUICK_TREES = 2, 3, 4, 200
# A tamed drift f/(1 + h |f|) leaves the drift by a term of the weight 4.
TAMED = 4
MEASURES = (STRONG, WEAK, INVARIANT)
MOST_MOTIONS, MOST_WEIGHT = 4, 8


@dataclass(frozen=True)
class ClassRow:
    """What is found of one claim for one class.

    Attributes
    ----------
    scheme, kind, measure : str
        Label of the scheme, name of the class, ``strong``, ``weak`` or ``invariant``.
    motions : int
        Number of Brownian motions.
    verdict : ClassVerdict
    order : float
        That conditions give, as far as they were looked at; NaN where none were.
    claim : float
        The order claimed; NaN without a claim.
    held, of : int
        How many of the conditions of the claimed order, without a claim of all that are looked at, hold, of how many.
    first : Condition or None
        The first one that does not hold.
    premise : str
        The premises, or why one fails, or why nothing applies.
    promise : Claim or None
        What is claimed.
    """

    scheme: str
    kind: str
    motions: int
    measure: str
    verdict: ClassVerdict
    order: float = nan
    claim: float = nan
    held: int = 0
    of: int = 0
    first: Condition | None = None
    premise: str = ""
    promise: Claim | None = None

    @property
    def why(self) -> str:
        """Why the verdict is what it is, in a sentence."""
        if self.verdict is ClassVerdict.REFUTED and self.first:
            found, wanted = self.first.texts
            return f"order {self.order:g}: the condition {self.first.name} fails, found {found}, wanted {wanted}"
        if self.verdict is ClassVerdict.VERIFIED:
            return f"{self.held} of {self.of} conditions hold for up to {self.motions} motions; {self.premise}"
        return self.premise

    @property
    def cells(self) -> dict[str, object]:
        """The row of a table."""
        found, wanted = self.first.texts if self.first else ("", "")
        return {
            "scheme": self.scheme,
            "class": self.kind,
            "motions": self.motions,
            "measure": self.measure,
            "order": self.order,
            "claim": self.claim,
            "verdict": self.verdict.value,
            "held": self.held,
            "of": self.of,
            "first": self.first.name if self.first else "",
            "found": found,
            "wanted": wanted,
            "premise": self.premise,
        }


@dataclass(frozen=True)
class OrderReport:
    """What order conditions say of a scheme, class by class.

    Attributes
    ----------
    scheme : Scheme
    rows : tuple of ClassRow
        One for each class and measure.
    """

    scheme: Scheme
    rows: tuple[ClassRow, ...]

    @classmethod
    def of(
        cls, scheme: Scheme, classes: str | Sequence[str] | None = None, motions: int = 3, weight: int | None = None
    ) -> "OrderReport":
        """Return the report on a scheme.

        Parameters
        ----------
        scheme : Scheme
        classes : str or sequence of str, optional
        motions : int
        weight : int, optional
            As `orders` takes them, which raises what this does.
        """
        check_numbers(motions, weight)
        return cls(scheme, tuple(rows_of(scheme, classes_named(scheme, classes), motions, weight)))

    @property
    def table(self) -> pd.DataFrame:
        """One row for each claim and class: orders, conditions held of all, the first that fails, premises."""
        return pd.DataFrame([row.cells for row in self.rows])

    @property
    def failing(self) -> tuple[Condition, ...]:
        """The first failing condition of each claim that is refuted."""
        refuted = (row.first for row in self.rows if row.verdict is ClassVerdict.REFUTED)
        return tuple(dict.fromkeys(first for first in refuted if first))

    @property
    def premises(self) -> dict[str, str]:
        """The premises of each class, or why it does not apply."""
        return {row.kind: row.premise for row in self.rows}

    def to_problem(self, condition: Condition) -> str:
        """Return a plugin file with the problem of a condition, on which `matrix` refutes the scheme.

        Parameters
        ----------
        condition : Condition
            One of `failing`, or the first one of another row.

        Raises
        ------
        UsageError
            If it is none of these, or if no single tree shows it.
        """
        row = next((row for row in self.rows if row.first == condition), None)
        if row is None:
            raise UsageError(f"condition {condition.name!r:.200} is none of this report")
        if row.measure == INVARIANT:
            raise UsageError(
                "no single equation isolates a condition of the invariant measure: ask matrix on double-well"
            )
        return problem_file(condition, self.scheme, classes_of(self.scheme)[row.kind], max(1, row.motions))

    def __repr__(self) -> str:
        return self.table.to_string(index=False)


def orders(
    scheme: str | Scheme,
    classes: str | Sequence[str] | None = None,
    motions: int = 3,
    weight: int | None = None,
    *,
    plugins: Sequence[str | Path] = (),
) -> OrderReport:
    """Ask a scheme for the order conditions of classes of equations, which hold for every smooth one of a class.

    One step on an equation whose components are rooted trees tells every elementary weight to rounding.

    Parameters
    ----------
    scheme : str or Scheme
        A name with parameters, or a scheme itself, as `verify` takes it.
    classes : str or sequence of str, optional
        Out of ode, scalar, additive, diagonal, commutative, vanishing-milstein-term, general,
        overdamped-gradient for SDEs, langevin and langevin-gradient, index-1 and index-1-additive, and what another
        form brings; all if left out.
    motions : int
        Number of Brownian motions where a class has no number of its own: what holds holds for as many.
    weight : int, optional
        Largest weight of trees and forests, noise nodes counting 1 and others 2; 2 p + 1 for a claimed order p, and
        one more where that costs nothing.
    plugins : sequence of str or Path, optional
        Plugin files, beside the installed plugins.

    Returns
    -------
    OrderReport

    Raises
    ------
    UsageError
        If a name is unknown, means several schemes, or a number is out of its range.
    """
    found = select_schemes(load_registry(plugins), scheme)
    if len(found) != 1:
        raise UsageError(f"orders expects one scheme, got {scheme!r:.200}, which means {len(found)}")
    return OrderReport.of(found[0], classes, motions, weight)


def check_numbers(motions: int, weight: int | None) -> None:
    """Check the numbers that a user gives.

    Raises
    ------
    UsageError
        If one is out of its range.
    """
    if not 1 <= whole("motions", motions) <= MOST_MOTIONS:
        raise UsageError(f"motions must be from 1 to {MOST_MOTIONS}, got {motions!r}")
    if weight is not None and not 1 <= whole("weight", weight) <= MOST_WEIGHT:
        raise UsageError(f"weight must be from 1 to {MOST_WEIGHT}, got {weight!r}")


def classes_of(scheme: Scheme) -> dict[str, EquationClass | TreeClass]:
    """Return by name the classes that a scheme can be asked about: those of the framework, and of its own forms."""
    own = (kind for form in scheme.forms for kind in form.tree_classes())
    return {kind.name: kind for kind in (*own, *CLASSES)}


def classes_named(scheme: Scheme, names: str | Sequence[str] | None) -> list[EquationClass | TreeClass]:
    """Return the classes of some names, separated by commas if they are one text; all if there is none.

    Raises
    ------
    UsageError
        If a name is unknown.
    """
    known = classes_of(scheme)
    wanted = known if names is None else names.split(",") if isinstance(names, str) else names
    for name in wanted:
        if name not in known:
            raise UsageError(f"unknown class {name!r:.200}; known are {', '.join(known)}{did_you_mean(name, known)}")
    return [known[name] for name in wanted]


def every_equation(of: str = "general") -> SDE:
    """Return the universal SDE of a class with two motions, which stands for all smooth SDEs of it.

    Parameters
    ----------
    of : str
        Name of the class.

    Raises
    ------
    UsageError
        If it is no class of SDEs: a form poses its problems itself.
    """
    kind = next((each for each in OF_SDES if each.name == of), None)
    if kind is None:
        raise UsageError(f"{of!r:.200} is no class of SDEs; known are {', '.join(each.name for each in OF_SDES)}")
    motions = _motions_of(kind, FEW)
    return Universal(kind.trees(motions, LEAST), max(1, motions), kind.traits).sde


def rows_of(
    scheme: Scheme, kinds: Iterable[EquationClass | TreeClass], motions: int | None = 3, weight: int | None = None
) -> Iterator[ClassRow]:
    """Yield what is found of a scheme for some classes; see `orders` for the numbers.

    Parameters
    ----------
    scheme : Scheme
    kinds : iterable of EquationClass or TreeClass
        The classes.
    motions : int or None
        None for what takes little time: 3 where few trees of low weights are asked for, else 2, and no weight beyond
        what claims need.
    weight : int or None
    """
    for kind in kinds:
        if motions is None:
            probe = _quick_probe(scheme, kind)
        else:
            first = probe_of(scheme, kind, _motions_of(kind, motions), LEAST)
            probe = probe_of(scheme, kind, first.motions, weight or _top(first))
        yield from _rows(Examined(probe))


def _quick_probe(scheme: Scheme, kind: EquationClass | TreeClass) -> Probe:
    """Return a probe of many motions where few trees of low weights, or none at all, are asked for, else of few."""
    many = probe_of(scheme, kind, _motions_of(kind, MANY), LEAST)
    if Examined(many).why_not:
        return many
    # Diagonal noise: trees of the weight 4 tell a tamed step, which is no sum over trees.
    is_diagonal = isinstance(kind, EquationClass) and kind.diagonal
    top = max(TAMED, _claimed_top(many)) if is_diagonal else _claimed_top(many)
    is_quick = top <= QUICK and len(many.trees(top)) <= QUICK_TREES
    return probe_of(scheme, kind, _motions_of(kind, MANY if is_quick else FEW), top)


def _motions_of(kind: EquationClass | TreeClass, motions: int) -> int:
    return motions if kind.motions is None else kind.motions


def probe_of(scheme: Scheme, kind: EquationClass | TreeClass, motions: int, top: int) -> Probe:
    """Return where the weights of a class are found.

    Parameters
    ----------
    scheme : Scheme
    kind : EquationClass or TreeClass
        The class.
    motions : int
    top : int
    """
    if isinstance(kind, TreeClass):
        return PosedProbe(scheme, kind, motions, top)
    return (DiagonalProbe if kind.diagonal else UniversalProbe)(scheme, kind, motions, top)


def _claimed_top(probe: Probe) -> int:
    """Return the largest weight that claims need."""
    claimed = [needed(found[1]) for name in measures_of(probe.kind) if (found := claimed_order(probe, name))]
    least = STATIONARY if INVARIANT in measures_of(probe.kind) else LEAST
    return max([least, *claimed])


def _top(probe: Probe) -> int:
    """Return up to which weight trees are looked at: one more than claims need where that costs little."""
    top = _claimed_top(probe)
    cheap = top < EXACT and GROWTH * len(probe.trees(top)) <= CHEAP
    return top + 1 if cheap else top


def measures_of(kind: EquationClass | TreeClass) -> tuple[str, ...]:
    """Return what is asked of a class.

    Parameters
    ----------
    kind : EquationClass or TreeClass
        The class.
    """
    return (INVARIANT,) if isinstance(kind, EquationClass) and kind.overdamped else (STRONG, WEAK)


def claimed_order(probe: Probe, measure: str) -> tuple[Claim, Order] | None:
    """Return the claim of the largest order of a scheme for a class, and this order.

    Parameters
    ----------
    probe : Probe
        The scheme on the class.
    measure : str
    """
    traits = probe.problem.traits
    claims = (each for each in probe.scheme.promises if each.when <= traits and each.covers(measure, "x"))
    orders = [(each, each.value) for each in claims if isinstance(each.value, Order)]
    return max(orders, key=lambda found: found[1].least, default=None)


def claimed_measures(scheme: Scheme, kind: EquationClass | TreeClass) -> list[str]:
    """Return of which measures a scheme claims an order for a class; nothing is run.

    Parameters
    ----------
    scheme : Scheme
    kind : EquationClass or TreeClass
        The class.
    """
    probe = probe_of(scheme, kind, _motions_of(kind, FEW), LEAST)
    return [] if Examined(probe).why_not else [each for each in measures_of(kind) if claimed_order(probe, each)]


def _rows(of: Examined) -> Iterator[ClassRow]:
    probe = of.probe
    row = ClassRow(probe.scheme.label, probe.kind.name, probe.motions, "", ClassVerdict.PREMISE)
    if of.why_not:
        yield replace(row, verdict=ClassVerdict.NOT_APPLICABLE, premise=of.why_not)
        return
    for measure in measures_of(probe.kind):
        promise, claim = claimed_order(probe, measure) or (None, None)
        if claim or measure in of.measures:
            yield _told(of, replace(row, measure=measure, promise=promise), claim)


def _told(of: Examined, row: ClassRow, claim: Order | None) -> ClassRow:
    least = claim.least if claim else nan
    unasked = "" if row.measure in of.measures else "a bounded law tells no paths"
    if why := of.probe.fault or of.probe.why_not_weighed or unasked:
        verdict = ClassVerdict.ERROR if of.probe.fault else _open(claim)
        return replace(row, claim=least, premise=why, verdict=verdict)
    try:
        return _compared(of, row, claim)
    except NoStepError as error:
        # Steps that test a premise are other ones than those that have given the weights.
        return replace(row, claim=least, premise=str(error), verdict=_open(claim))


def _open(claim: Order | None) -> ClassVerdict:
    return ClassVerdict.PREMISE if claim else ClassVerdict.NOT_CLAIMED


def _compared(of: Examined, row: ClassRow, claim: Order | None) -> ClassRow:
    """Return what the conditions say of a claim.

    Raises
    ------
    NoStepError
        If a step that tests a premise cannot be made.
    """
    least = claim.least if claim else nan
    order = of.order(row.measure)
    held, count = of.held_of(row.measure, least if claim else 0.5 * (of.probe.top - 1))
    falls_short = claim is not None and order < claim.floor and bool(of.breaking(row.measure))
    inexact = of.why_not_exact(row.measure) or of.why_taken_back(row.measure) if falls_short else ""
    beyond = _why_not_enough(of, claim) or _why_clipped(of, row, claim) or of.why_spoilt(row.measure, least)
    premise_fails = of.probe.why_not_every or inexact or beyond
    premises = (_impossible(of, row.measure, claim) if falls_short else "", of.probe.covers, of.probe.premises)
    return replace(
        row,
        verdict=_verdict(of, claim, refutes=falls_short and not inexact, premise_fails=bool(premise_fails)),
        order=order,
        claim=least,
        held=held,
        of=count,
        first=next(iter(of.breaking(row.measure)), None),
        premise=premise_fails or ", ".join(filter(None, premises)),
    )


def _impossible(of: Examined, measure: str, claim: Order | None) -> str:
    """Return that the record of the noise cannot give an order, whatever a scheme makes of it, or an empty text."""
    asked = (each for each in of.breaking(measure) if claim and belongs(each, measure, claim.least))
    beyond = next((each for each in asked if not each.known), None)
    if claim is None or beyond is None:
        return ""
    given = " and ".join(sorted(of.probe.noise))
    text = f"no scheme that is given {given} alone can have {measure} order {claim.least:g}"
    return f"{text} ({beyond.name} is beyond it)"


def _verdict(of: Examined, claim: Order | None, *, refutes: bool, premise_fails: bool) -> ClassVerdict:
    if claim is None:
        return ClassVerdict.NOT_CLAIMED
    if refutes:
        return ClassVerdict.REFUTED if of.probe.scheme.local_order_is_global else ClassVerdict.PREMISE
    return ClassVerdict.PREMISE if premise_fails else ClassVerdict.VERIFIED


def needed(claim: Order) -> int:
    """Return the largest weight of the conditions of an order."""
    return ceil(2.0 * claim.least + 1.0)


def _why_clipped(of: Examined, row: ClassRow, claim: Order | None) -> str:
    """Return why increments that are clipped have no such order, or an empty text."""
    most = of.probe.scheme.law.most(paths=row.measure == STRONG) if of.probe.motions else inf
    return f"clipped increments allow no order above {most:g}" if claim is not None and claim.least > most else ""


def _why_not_enough(of: Examined, claim: Order | None) -> str:
    """Return why the trees that were looked at are too few for the claim, or an empty text."""
    if claim is None or of.probe.top >= needed(claim):
        return ""
    return f"the order claimed needs trees up to the weight {needed(claim)}"
