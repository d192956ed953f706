"""Findings of one run are held against each other: a wrong limit in one of them is one in others."""

from dataclasses import replace

import pytest

from contradictions import TooMuchNoise
from facade import (
    Cell,
    CellResult,
    EulerMaruyama,
    Milstein,
    Strong,
    Study,
    Weak,
    family_wise,
    forbid,
    gbm,
    harmonic_langevin,
    plan,
    problem_spec,
)
from sdaeverify import Claim, Settings
from sdaeverify.measuring import Finding, Kind, Measure, Reason, Verdict
from sdaeverify.study.agreement import agreeing, components_of

PROBLEM = replace(
    harmonic_langevin(),
    observables={
        "q^2": lambda t, parts: parts["q"][0] ** 2,
        "p^2": lambda t, parts: parts["p"][0] ** 2,
        "energy": lambda t, parts: parts["q"][0] ** 2 + parts["p"][0] ** 2,
    },
    truths=(),
)
CLAIM = Claim(measure="any", value=1.0, source="test")
EULER = EulerMaruyama()


class Named(Measure):
    """A measure of a name that follows something, and is never run."""

    def __init__(self, name, follows):
        self.name, self.follows = name, follows


CELL = Cell(EULER, problem_spec(harmonic_langevin), Measure(), seen=EULER.view_of(PROBLEM))
PATHS, LAW, SIZES = Named("of paths", "paths"), Named("of law", "law"), Named("of sizes", "")


def verified(*quantities):
    """Return findings that verify claims by paths."""
    return [
        Finding(quantity=name, verdict=Verdict.VERIFIED, claim=CLAIM, p_verified=1e-12, p_refuted=1.0)
        for name in quantities
    ]


def wrong(quantity, kind=Kind.WRONG_LIMIT):
    """Return a finding that refutes a claim."""
    return Finding(quantity=quantity, verdict=Verdict.REFUTED, claim=CLAIM, reason=Reason("off", kind), tier=1)


def result(measure, *findings, scheme=EULER):
    """Return the result of a cell."""
    return CellResult(replace(CELL, scheme=scheme, measure=measure), tuple(findings))


def left(results):
    """Return measure and quantity of what stays verified."""
    return {
        (each.cell.measure.name, finding.quantity)
        for each in results
        for finding in each.findings
        if finding.verdict is Verdict.VERIFIED
    }


def doubted(quantity):
    """Return a finding that one step leaves open, since it does not follow the equation at some states."""
    reason = Reason("off at 8 % of the states", Kind.INCONSISTENT)
    found = Finding(quantity=quantity, verdict=Verdict.INCONCLUSIVE, claim=CLAIM, reason=reason, tier=1)
    return forbid(found, Verdict.VERIFIED)


def test_a_step_that_departs_at_some_states_speaks_against_all_claims_of_its_scheme():
    """What one step has seen at few states holds against paths and laws, stationary ones too, of its scheme alone."""
    stationary, other = Named("stationary", "stationary law"), Milstein()
    results = [
        result(PATHS, doubted("state")),
        result(LAW, *verified("q^2")),
        result(stationary, *verified("energy")),
        result(SIZES, *verified("cost")),
        result(stationary, *verified("energy"), scheme=other),
    ]
    found = agreeing(PROBLEM, results)

    assert left(found) == {("of sizes", "cost"), ("stationary", "energy")}
    assert {each.cell.scheme for each in found if left([each]) == {("stationary", "energy")}} == {other}
    assert "one step does not follow the equation in state (of paths)" in str(found[1].findings[0].reason)


def test_a_wrong_law_says_nothing_of_the_stationary_one():
    """The limits of long runs and of short steps do not commute."""
    results = [result(LAW, wrong("q^2")), result(Named("stationary", "stationary law"), *verified("energy"))]

    assert left(agreeing(PROBLEM, results)) == {("stationary", "energy")}


QUANTITIES = ("q", "q@T", "p", "p@T", "state", "state@T")


@pytest.mark.parametrize(
    ("measure", "quantity", "paths", "laws"),
    [
        (LAW, "p^2", {"q", "q@T"}, set()),
        (LAW, "energy", set(), set()),
        (PATHS, "p@T", {"q", "q@T"}, {"q^2", "energy"}),
        (PATHS, "state", {"q", "q@T", "p", "p@T"}, {"q^2", "energy"}),
        (SIZES, "q", set(QUANTITIES), {"q^2", "energy"}),
    ],
)
@pytest.mark.parametrize("kind", [Kind.WRONG_LIMIT, Kind.INCONSISTENT])
def test_a_wrong_limit_holds_against_all_that_it_concerns(measure, quantity, paths, laws, kind):
    """A wrong law is one of the state and of what an observable reads; wrong paths are none of the law.

    A step that departs from the equation has no law of it.
    """
    seen = [
        result(measure, wrong(quantity, kind)),
        result(PATHS, *verified(*QUANTITIES)),
        result(LAW, *verified("q^2", "energy")),
    ]

    found = left(agreeing(PROBLEM, seen))
    if kind is Kind.INCONSISTENT and measure is not SIZES:
        laws = set()

    assert found == {("of paths", name) for name in paths} | {("of law", name) for name in laws}
    assert left(agreeing(PROBLEM, seen[::-1])) == found


@pytest.mark.parametrize(
    "other",
    [
        result(LAW, wrong("energy"), scheme=Milstein()),
        result(LAW, wrong("energy", Kind.ORDER)),
        result(LAW, replace(wrong("energy"), verdict=Verdict.INCONCLUSIVE)),
    ],
    ids=["another scheme", "a low order", "nothing decided"],
)
def test_nothing_else_is_held_against_a_finding(other):
    """Other schemes, orders that are too low and what is open leave verdicts as they are, to the bit."""
    sure = result(PATHS, *verified(*QUANTITIES))

    # Texts: a number that is NaN is not equal to itself.
    assert repr(agreeing(PROBLEM, [other, sure])) == repr((other, sure))


def test_what_is_withheld_says_why_and_does_not_come_back():
    """The reason names measure and quantity; no correction over all tests verifies it again."""
    seen = agreeing(PROBLEM, [result(LAW, wrong("p^2")), result(PATHS, *verified("state"))])

    (found,) = family_wise(seen, 0.01)[1].findings

    assert found.verdict is Verdict.INCONCLUSIVE
    assert str(found.reason).startswith("not confirmed: wrong limit in p^2 (of law)")


def test_what_is_open_elsewhere_cannot_be_verified_over_all_tests():
    """An inconclusive finding with a small p-value is not taken for verified where the limit is known to be wrong."""
    (sure,) = verified("state")
    open_ = replace(sure, verdict=Verdict.INCONCLUSIVE)
    alone = family_wise([result(PATHS, open_)], 0.01)
    beside = family_wise(agreeing(PROBLEM, [result(LAW, wrong("p^2")), result(PATHS, open_)]), 0.01)

    assert alone[0].findings[0].verdict is Verdict.VERIFIED
    assert beside[1].findings[0].verdict is Verdict.INCONCLUSIVE


def test_components_are_those_that_an_observable_reads():
    """Kinetic energies read velocities, energies all; what is no observable reads nothing."""
    assert components_of(PROBLEM, CELL, "p^2") == {"p"}
    assert components_of(PROBLEM, CELL, "energy") == {"q", "p"}
    assert components_of(PROBLEM, CELL, "state") == frozenset()


@pytest.mark.parametrize("excess", [1e-6, 3e-5])
def test_paths_are_not_verified_where_the_law_is_wrong(excess):
    """A millionth of too much noise is seen in moments at T, 30 in means of one step, neither along paths."""
    uncontrolled = lambda: replace(gbm(), controls=())  # noqa: E731
    uncontrolled.__name__ = "uncontrolled"
    study = Study(plan([TooMuchNoise(excess)], [problem_spec(uncontrolled)], [Strong(), Weak()]), Settings(paths=256))
    for _ in study.run():
        pass

    strong, weak = study.results()

    assert {finding.verdict for finding in weak.findings} == {Verdict.REFUTED}
    assert {finding.verdict for finding in strong.findings} == {Verdict.INCONCLUSIVE}
    assert all("not confirmed" in str(finding.reason) for finding in strong.findings)
