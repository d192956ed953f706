"""The multipliers measure: claims that are kept, broken and not decided."""

from typing import ClassVar

import pytest

from facade import EulerMaruyama, HalfExplicitEuler, MultiplierExponents, ou, pendulum
from sdaeverify import Claim, Problem, Scheme, Settings
from sdaeverify.measuring import Evidence, Finding, Tally, Verdict

SETTINGS = Settings(paths=40, levels=3)


def judged(scheme: Scheme, problem: Problem) -> dict[str, Finding]:
    """Probe and judge a cell."""
    measure = MultiplierExponents()
    assert measure.refuses(scheme, problem) == ""
    tally = measure.probe(scheme, problem.view(scheme.form), SETTINGS)
    found = measure.judge(Evidence(scheme, problem, problem, SETTINGS, tally, Tally()))
    assert {row.quantity for row in found.levels} == {finding.quantity for finding in found.findings}
    return {finding.quantity: finding for finding in found.findings}


class Immodest(HalfExplicitEuler):
    """The scheme that claims more than it keeps, and something in words."""

    name: ClassVar[str] = "immodest"
    claims: ClassVar[tuple[Claim, ...]] = (
        Claim(measure="multipliers", quantities=("kappa",), value=3.0, source="test"),
        Claim(measure="multipliers", quantities=("lambda remainder",), value="small", source="test"),
    )


def test_exponents_of_the_theory_are_verified() -> None:
    """Kappa, lambda^re and Lambda^re of the half-explicit scheme keep (3.17), found without sampling."""
    found = judged(HalfExplicitEuler(), pendulum())

    assert {name: finding.verdict for name, finding in found.items()} == dict.fromkeys(
        ("kappa", "lambda remainder", "Lambda remainder"), Verdict.VERIFIED
    )
    assert found["kappa"].estimate == pytest.approx(2.0, abs=1e-3)
    assert {finding.tier for finding in found.values()} == {1}


def test_claims_that_are_too_high_unknown_or_not_made() -> None:
    """An order above the true one is refuted, words decide nothing, and without a claim the order is shown."""
    found = judged(Immodest(), pendulum())

    assert found["kappa"].verdict is Verdict.REFUTED
    assert found["lambda remainder"].verdict is Verdict.INCONCLUSIVE
    assert found["Lambda remainder"].verdict is Verdict.OUT_OF_SCOPE
    assert found["Lambda remainder"].estimate == pytest.approx(1.0, abs=1e-3)


def test_cells_without_multipliers_do_not_apply() -> None:
    """Equations have no multipliers."""
    assert "no multiplier" in MultiplierExponents().refuses(EulerMaruyama(), ou())
    assert "no multiplier" in MultiplierExponents().refuses(EulerMaruyama(), pendulum())


def test_missing_evidence_decides_nothing() -> None:
    """A cell whose first block is missing is not probed."""
    problem = pendulum()
    evidence = Evidence(HalfExplicitEuler(), problem, problem, SETTINGS, Tally(), Tally())
    (finding,) = MultiplierExponents().judge(evidence).findings

    assert finding.verdict is Verdict.INCONCLUSIVE
