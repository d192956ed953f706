"""Verdicts on the claims of a scheme, class by class, from order conditions."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from math import ceil, inf, nan

from sdaeverify import Claim, Scheme
from sdaeverify.measuring import Order, Verdict
from sdaeverify.studying import draws_own_numbers
from sdaeverify.trees import TreeClass

from ..class_row import ClassRow
from .classes import EquationClass
from .conditions import INVARIANT, STRONG, WEAK, Condition, belongs
from .examined import Examined
from .modified.equation import is_slow, modified_equation
from .modified.lines import cells_of_equation
from .modified.mistakes import mistake_of
from .posed.probe import probe_of
from .probes import Probe
from .weights import NoStepError

# Largest weight of trees without a claim; one more if there are at most about CHEAP trees, where each weight
# multiplies the number of trees by GROWTH.
LEAST, CHEAP, GROWTH = 3, 500, 4
# Weight up to which rules for expectations are exact, for any noise.
EXACT = 5
# Invariant measures of order 2 need the weight 5.
STATIONARY = 5
# Default numbers of motions: MANY up to a weight and a number of trees, FEW above.
FEW, MANY, QUICK, QUICK_TREES = 2, 3, 4, 200
# Weight of the term by which a tamed drift f/(1 + h |f|) deviates from the drift.
TAMED = 4
MEASURES = (STRONG, WEAK, INVARIANT)
ALONE = "the claim is about the mean of {} only; the order of all smooth functions is {:g}"


def rows_of(
    scheme: Scheme,
    kinds: Iterable[EquationClass | TreeClass],
    motions: int | None = 3,
    weight: int | None = None,
    *,
    modified: bool = False,
) -> Iterator[ClassRow]:
    """Yield the results for a scheme on some classes; see `orders` for the numbers.

    Parameters
    ----------
    scheme : Scheme
    kinds : iterable of EquationClass or TreeClass
        Classes of equations.
    motions : int or None
        None for a quick test: 3 motions for few trees of low weight, otherwise 2, and no weight beyond those of the
        claims.
    weight : int or None
    modified : bool
        Whether rows have the modified equation of the scheme; otherwise only those of refuted weak and invariant
        orders have it.
    """
    for kind in kinds:
        if motions is None:
            probe = _quick_probe(scheme, kind)
        else:
            first = probe_of(scheme, kind, _motions_of(kind, motions), LEAST)
            probe = probe_of(scheme, kind, first.motions, weight or _top(first))
        yield from _with_equation(probe, [*_rows(Examined(probe))], asked=modified)


def _with_equation(probe: Probe, rows: list[ClassRow], *, asked: bool) -> Iterator[ClassRow]:
    """Yield the rows of a class with the modified equation, if it is asked for or explains why one is refuted."""
    refuted = any(row.verdict is Verdict.REFUTED and row.measure != STRONG for row in rows)
    if not (asked or refuted) or is_slow(probe.kind):
        yield from rows
        return
    equation = modified_equation(probe.scheme, probe.kind, FEW)
    if equation.terms or (asked and equation.solves):
        lines, terms = cells_of_equation(equation)
        rows = [replace(row, modified=lines, modified_terms=terms) for row in rows]
    yield from rows


def _quick_probe(scheme: Scheme, kind: EquationClass | TreeClass) -> Probe:
    """Return a probe with many motions for few trees of low weight or an inapplicable class, else with few."""
    many = probe_of(scheme, kind, _motions_of(kind, MANY), LEAST)
    if Examined(many).why_not:
        return many
    # For diagonal noise, trees of weight 4 reveal a tamed step, which is not a sum over trees.
    is_diagonal = isinstance(kind, EquationClass) and kind.diagonal
    top = max(TAMED, _claimed_top(many)) if is_diagonal else _claimed_top(many)
    is_quick = top <= QUICK and len(many.trees(top)) <= QUICK_TREES
    return probe_of(scheme, kind, _motions_of(kind, MANY if is_quick else FEW), top)


def _motions_of(kind: EquationClass | TreeClass, motions: int) -> int:
    return motions if kind.motions is None else kind.motions


def _claimed_top(probe: Probe) -> int:
    """Return the largest weight that the claims need."""
    claimed = [needed(found[1]) for name in measures_of(probe.kind) if (found := claimed_order(probe, name))]
    least = STATIONARY if INVARIANT in measures_of(probe.kind) else LEAST
    return max([least, *claimed])


def _top(probe: Probe) -> int:
    """Return the largest weight of trees: one more than the claims need if that is cheap."""
    top = _claimed_top(probe)
    cheap = top < EXACT and GROWTH * len(probe.trees(top)) <= CHEAP
    return top + 1 if cheap else top


def measures_of(kind: EquationClass | TreeClass) -> tuple[str, ...]:
    """Return the measures with order conditions for a class.

    Parameters
    ----------
    kind : EquationClass or TreeClass
        Class of equations.
    """
    return (INVARIANT,) if isinstance(kind, EquationClass) and kind.overdamped else (STRONG, WEAK)


def claimed_order(probe: Probe, measure: str) -> tuple[Claim, Order] | None:
    """Return the claim of a scheme with the largest order for a class, and this order.

    A claim about the means of all functions takes precedence over one about named functions.

    Parameters
    ----------
    probe : Probe
        The scheme on the class.
    measure : str
    """
    orders = [(each, each.value) for each in _in_scope(probe, measure) if isinstance(each.value, Order)]
    covering = [found for found in orders if found[0].covers(measure, "x")]
    return max(covering, key=lambda found: (not named_means(found[0]), found[1].least), default=None)


def _in_scope(probe: Probe, measure: str) -> list[Claim]:
    traits = probe.problem.traits
    return [each for each in probe.scheme.promises if each.measure == measure and each.when <= traits]


def named_means(claim: Claim | None) -> str:
    """Return the functions to whose means a claim is restricted, in words; empty without a restriction."""
    return "" if claim is None or claim.measure == STRONG else " and ".join(claim.quantities)


def _of_others(probe: Probe, measure: str) -> str:
    """Return that an order is claimed only for means of functions without a condition, or an empty text."""
    names = [named for each in _in_scope(probe, measure) if (named := named_means(each))]
    return f"claimed only for {' and '.join(names)}, not for all smooth functions" if names else ""


def claimed_measures(scheme: Scheme, kind: EquationClass | TreeClass) -> list[str]:
    """Return the measures for which a scheme claims an order on a class, without running a step.

    Parameters
    ----------
    scheme : Scheme
    kind : EquationClass or TreeClass
        Class of equations.
    """
    probe = probe_of(scheme, kind, _motions_of(kind, FEW), LEAST)
    return [] if Examined(probe).why_not else [each for each in measures_of(kind) if claimed_order(probe, each)]


def _rows(of: Examined) -> Iterator[ClassRow]:
    probe = of.probe
    row = ClassRow(probe.scheme.label, probe.kind.name, probe.motions, "", Verdict.INCONCLUSIVE)
    if why := of.why_not or draws_own_numbers(probe.scheme, probe.problem):
        yield replace(row, verdict=Verdict.NOT_APPLICABLE, premise=why)
        return
    for measure in measures_of(probe.kind):
        promise, claim = claimed_order(probe, measure) or (None, None)
        if claim or measure in of.measures:
            told = _told(of, replace(row, measure=measure, promise=promise), claim)
            elsewhere = "" if claim else _of_others(probe, measure)
            yield replace(told, premise="; ".join(filter(None, (elsewhere, told.premise))))


def _told(of: Examined, row: ClassRow, claim: Order | None) -> ClassRow:
    least = claim.least if claim else nan
    unasked = "" if row.measure in of.measures else "a bounded law has no paths"
    if why := of.probe.fault or of.probe.why_not_weighed or unasked:
        verdict = Verdict.ERROR if of.probe.fault else _open(claim)
        return replace(row, claim=least, premise=why, verdict=verdict)
    try:
        return _compared(of, row, claim)
    except NoStepError as error:
        # A premise needs further steps, which may fail although the weights could be computed.
        return replace(row, claim=least, premise=str(error), verdict=_open(claim))


def _open(claim: Order | None) -> Verdict:
    return Verdict.INCONCLUSIVE if claim else Verdict.OUT_OF_SCOPE


def _compared(of: Examined, row: ClassRow, claim: Order | None) -> ClassRow:
    """Return the row with the verdict of the conditions on a claim.

    Raises
    ------
    NoStepError
        If a step that tests a premise cannot be computed.
    """
    least = claim.least if claim else nan
    order = of.order(row.measure)
    held, count = of.held_of(row.measure, least if claim else 0.5 * (of.probe.top - 1))
    falls_short = claim is not None and of.is_below(row.measure, least)
    inexact = of.why_not_exact(row.measure, least) if claim else ""
    inexact = inexact or (of.why_taken_back(row.measure) if falls_short else "")
    failing = _failing(of, row, claim)
    named = named_means(row.promise)
    inexact = inexact or (ALONE.format(named, order) if named and falls_short and not failing else "")
    beyond = _why_not_enough(of, claim) or _why_clipped(of, row, claim) or of.why_spoilt(row.measure, least)
    premise_fails = of.probe.why_not_every or inexact or beyond
    impossible = _impossible(of, row.measure, claim) if falls_short else ""
    verdict = _verdict(of, claim, refutes=falls_short and not inexact, premise_fails=bool(premise_fails))
    return replace(
        row,
        verdict=verdict,
        order=order,
        claim=least,
        held=held,
        of=count,
        first=next(iter(failing or of.breaking(row.measure)), None),
        premise=premise_fails or ", ".join(filter(None, (impossible, of.probe.covers, of.probe.premises))),
        mistake=mistake_of(of, row.measure, order) if verdict is Verdict.REFUTED and not impossible else "",
    )


def _failing(of: Examined, row: ClassRow, claim: Order | None) -> Sequence[Condition]:
    """Return the conditions that limit the claimed order, lowest order first.

    For a claim about the mean of x alone, these are the means of single trees: if one of them fails, E x has an error
    of that order after a short time. Products of trees concern other functions.
    """
    found = of.breaking(row.measure)
    if claim is None or not named_means(row.promise):
        return found
    return [
        each
        for each in found
        if row.measure == WEAK and belongs(each, WEAK, claim.least) and not each.on_paths and len(each.forest) == 1
    ]


def _impossible(of: Examined, measure: str, claim: Order | None) -> str:
    """Return that no scheme can reach an order with its record of the noise, or an empty text."""
    asked = (each for each in of.breaking(measure) if claim and belongs(each, measure, claim.least))
    beyond = next((each for each in asked if not each.known), None)
    if claim is None or beyond is None:
        return ""
    given = " and ".join(sorted(of.probe.noise))
    text = f"no scheme that uses only {given} can have {measure} order {claim.least:g}"
    return f"{text} ({beyond.name} requires more noise)"


def _verdict(of: Examined, claim: Order | None, *, refutes: bool, premise_fails: bool) -> Verdict:
    if claim is None:
        return Verdict.OUT_OF_SCOPE
    if refutes:
        return Verdict.REFUTED if of.probe.scheme.local_order_is_global else Verdict.INCONCLUSIVE
    return Verdict.INCONCLUSIVE if premise_fails else Verdict.VERIFIED


def needed(claim: Order) -> int:
    """Return the largest weight in the conditions of an order."""
    return ceil(2.0 * claim.least + 1.0)


def _why_clipped(of: Examined, row: ClassRow, claim: Order | None) -> str:
    """Return why clipped increments cannot have the claimed order, or an empty text."""
    most = of.probe.scheme.law.most(paths=row.measure == STRONG) if of.probe.motions else inf
    return f"clipped increments allow no order above {most:g}" if claim is not None and claim.least > most else ""


def _why_not_enough(of: Examined, claim: Order | None) -> str:
    """Return why the examined trees are too few for the claim, or an empty text."""
    if claim is None or of.probe.top >= needed(claim):
        return ""
    return f"the claimed order needs trees up to the weight {needed(claim)}"
