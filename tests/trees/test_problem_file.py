"""The problem of a failing condition, as a plugin file that the engine refutes the scheme on."""

import pytest

from sdaeverify import UsageError, verify
from sdaeverify_orders import orders
from sdaeverify_schemes.milstein_areas import MilsteinAreas
from sdaeverify_schemes.platen_weak_2_general import PlatenWeak2General
from trees.wrong import SIX, FewSigns, SignedHeun

GENERAL = PlatenWeak2General()
RIGHT = [GENERAL, GENERAL, GENERAL, SignedHeun(), MilsteinAreas(), GENERAL]
# The shipped problem that shows each of the errors.
SEEING = [*["turning-frame"] * 3, "product-force", "three-motions", "four-motions"]


def judged(scheme, file, measure):
    """Return the verdicts of the engine on the problem of a file."""
    return set(verify(scheme, "counterexample", measure, plugins=[file]).verdicts.verdict)


@pytest.mark.slow
@pytest.mark.parametrize(("wrong", "right"), [*zip(SIX, RIGHT, strict=True)])
def test_the_engine_refutes_the_wrong_scheme_there_and_verifies_the_right_one(wrong, right, tmp_path):
    """One step on a few trees shows what all shipped problems hide."""
    numbers = (4, 4) if isinstance(wrong, FewSigns) else (3, None)
    report = orders(wrong, "additive" if isinstance(wrong, SignedHeun) else "general", *numbers)
    measure = "strong" if isinstance(wrong, MilsteinAreas) else "weak"
    file = tmp_path / "problem.py"
    file.write_text(report.to_problem(report.failing[0]))

    assert judged(wrong, file, measure) == {"refuted"}
    assert judged(right, file, measure) == {"verified"}


@pytest.mark.slow
@pytest.mark.parametrize(("wrong", "right", "problem"), [*zip(SIX, RIGHT, SEEING, strict=True)])
def test_shipped_problems_refute_the_wrong_scheme_and_verify_the_right_one(wrong, right, problem):
    """Each of the six errors shows on one of the problems that were made to see it."""
    measure = "strong" if isinstance(wrong, MilsteinAreas) else "weak"

    assert set(verify(wrong, problem, measure).verdicts.verdict) == {"refuted"}
    assert set(verify(right, problem, measure).verdicts.verdict) == {"verified"}


def test_the_file_says_what_it_is_about(tmp_path):
    """Scheme, condition, what is found and wanted, and the trees of the components."""
    report = orders(SIX[1], "general", 2)
    text = report.to_problem(report.failing[0])

    assert "an order condition of planted-platen-general-old-noise fails" in text
    assert "The condition b1 . b1(t): found 0, wanted 1/2, in units of h^(4/2)." in text
    assert "    x[0]  b1\n    x[1]  b1(t)\n" in text


def test_a_condition_of_another_report_has_no_problem():
    """A condition belongs to the report that found it."""
    with pytest.raises(UsageError, match="is not in this report"):
        orders("milstein", "scalar").to_problem(orders(SIX[1], "general", 2).failing[0])
