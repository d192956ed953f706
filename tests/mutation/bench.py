"""A seeded choice of mutants and rewritings of every shipped scheme, and what the verifier says of them."""

import random
import warnings
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from sdaeverify import Scheme, verify
from sdaeverify.registry.load import load_registry
from sdaeverify.registry.selection import select_problems, select_schemes

from .difference import Orders, orders
from .perturbed import WHEN, perturbed
from .sources import SAME, WRONG, Place, distinct, places, variant

# By form: problems that are cheap and on which the claims of its schemes are verified.
PROBLEMS = {
    "SDE": ("gbm", "forced-ou", "noncommuting", "circle", "hyperbolic"),
    "Langevin": ("angle-pendulum",),
    "HolonomicSDAE": ("pendulum[horizon=1]",),
    "ConstrainedLangevin": ("affine-constraint", "affine-constraint[eps=0]"),
    "DelaySDAE": ("delay-ou", "delay-test[set=II,horizon=4]"),
}
# A mutant's claim is wrong if its difference leaves at least this much less than the order that is claimed.
SHORT = 0.35
# What a rewriting may change by rounding, it changes at many places.
REWRITTEN = 6
SETTINGS: dict[str, Any] = {"paths": 1024, "block": 256}


class Case(NamedTuple):
    """A variant, where it runs, and the orders that are left to it.

    Attributes
    ----------
    scheme : Scheme
    problem : str
    told : str
        What was changed.
    left : Orders
    """

    scheme: Scheme
    problem: str
    told: str
    left: Orders


class Bent(NamedTuple):
    """A bug that `perturbed` makes, and when."""

    bug: str
    when: str


def grounds() -> Iterator[tuple[Scheme, str, Any]]:
    """Yield each shipped scheme with the problems it is tried on, and the problem as the scheme sees it."""
    registry = load_registry([])
    for scheme in select_schemes(registry):
        for form in scheme.forms:
            for label in PROBLEMS[form.__name__]:
                view = scheme.view_of(select_problems(registry, label)[0].build())
                if view is not None and not scheme.refuses(view) and scheme.noise <= view.noise:
                    yield scheme, label, view


def mutants(seed: int, each: int) -> Iterator[Case]:
    """Yield mutants that differ by more than rounding, at most so many of one scheme on one problem."""
    for scheme, label, view in grounds():
        rng = random.Random(f"{seed}|{scheme.label}|{label}")
        for number, case in enumerate(_mutants(scheme, label, view, rng)):
            if number >= each:
                break
            yield case


def _mutants(scheme: Scheme, label: str, view: Any, rng: random.Random) -> Iterator[Case]:
    found: list[Place | Bent] = list(places(scheme, WRONG))
    rng.shuffle(found)
    bent: list[Place | Bent] = [Bent(bug, when) for bug in _bugs(view) for when in WHEN]
    rng.shuffle(bent)
    # Bugs of both kinds take turns.
    turns = [thing for pair in zip(bent, found, strict=False) for thing in pair] + found[len(bent) :]
    for number, thing in enumerate(turns):
        case = _case(scheme, label, view, thing, number)
        if case is not None and not case.left.same:
            yield case


def _bugs(view: Any) -> list[str]:
    return ["no step", "weaker noise", "component 0", *(["lag lost"] if getattr(view, "delay", 0.0) else [])]


def _case(scheme: Scheme, label: str, view: Any, thing: Place | Bent, number: int) -> Case | None:
    name = f"mutant-{number}-{scheme.name}"
    try:
        if isinstance(thing, Bent):
            left = orders(scheme, perturbed(scheme, thing.bug, "always", name), view)
            return Case(perturbed(scheme, *thing, name), label, f"{scheme.label}: {thing.bug} {thing.when}", left)
        made = variant(scheme, [thing], WRONG, name)
        return Case(made.scheme, label, made.name, orders(scheme, made.scheme, view))
    except (NameError, TypeError, ValueError, IndexError, AttributeError):
        # The changed text is no scheme.
        return None


def rewritings(seed: int, each: int) -> Iterator[Case]:
    """Yield rewritings, which differ from their originals by rounding alone."""
    for scheme, label, view in grounds():
        rng = random.Random(f"{seed}|{scheme.label}|{label}|same")
        found = list(places(scheme, SAME))
        for number in range(each):
            chosen = distinct(rng.sample(found, min(len(found), REWRITTEN)))
            try:
                made = variant(scheme, chosen, SAME, f"rewriting-{number}-{scheme.name}")
                left = orders(scheme, made.scheme, view)
            except (TypeError, ValueError, np.exceptions.AxisError):
                continue
            yield Case(made.scheme, label, made.name, left)


def judged(cases: list[Case], measures: tuple[str, ...] = ("strong", "weak")) -> pd.DataFrame:
    """Return the verdicts on cases of one problem, with what was changed and the order that is left."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)
        table = verify([case.scheme for case in cases], cases[0].problem, measures, **SETTINGS).verdicts
    by = {case.scheme.label: case for case in cases}
    table = table[table.scheme.isin(by) & table.claim.astype(bool)].copy()
    table["told"] = [by[label].told for label in table.scheme]
    table["left"] = [_left(by[row.scheme].left, row.measure, row.quantity) for row in table.itertuples()]
    return table


def _left(left: Orders, measure: str, quantity: str) -> float:
    if measure == "weak":
        return left.weak.get(quantity, float("nan"))
    component = quantity.removesuffix("@T")
    return min(left.strong.values()) if component == "state" else left.strong.get(component, float("nan"))


def wrongly_verified(table: pd.DataFrame) -> pd.DataFrame:
    """Return the rows that are verified although less than what they claim is left."""
    order = table.claim.str.extract(r">= ([\d.]+)", expand=False).astype(float)
    return table[(table.verdict == "verified") & (table.left < order - SHORT)]
