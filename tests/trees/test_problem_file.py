"""The problem of a failing condition, as a plugin file that the engine refutes the scheme on."""

import pytest

from sdaeverify import UsageError, orders, verify
from sdaeverify_schemes.milstein_areas import MilsteinAreas
from sdaeverify_schemes.platen_weak_2_general import PlatenWeak2General
from trees.wrong import SIX, SignedHeun

RIGHT = [PlatenWeak2General(), PlatenWeak2General(), PlatenWeak2General(), SignedHeun(), MilsteinAreas()]


def judged(scheme, file, measure):
    """Return the verdicts of the engine on the problem of a file."""
    return set(verify(scheme, "counterexample", measure, plugins=[file]).verdicts.verdict)


@pytest.mark.slow
@pytest.mark.parametrize(("wrong", "right"), [*zip(SIX[:5], RIGHT, strict=True)])
def test_the_engine_refutes_the_wrong_scheme_there_and_verifies_the_right_one(wrong, right, tmp_path):
    """One step on a few trees shows what all shipped problems hide."""
    report = orders(wrong, "additive" if isinstance(wrong, SignedHeun) else "general", 3)
    measure = "strong" if isinstance(wrong, MilsteinAreas) else "weak"
    file = tmp_path / "problem.py"
    file.write_text(report.to_problem(report.failing[0]))

    assert judged(wrong, file, measure) == {"refuted"}
    assert judged(right, file, measure) == {"verified"}


def test_the_file_says_what_it_is_about(tmp_path):
    """Scheme, condition, what is found and wanted, and the trees of the components."""
    report = orders(SIX[1], "general", 2)
    text = report.to_problem(report.failing[0])

    assert "an order condition of planted-platen-general-old-noise fails" in text
    assert "The condition b1 . b1(t): found 0, wanted 1/2, in units of h^(4/2)." in text
    assert "    x[0]  b1\n    x[1]  b1(t)\n" in text


def test_a_condition_of_another_report_has_no_problem():
    """A condition belongs to the report that found it."""
    with pytest.raises(UsageError, match="is none of this report"):
        orders("milstein", "scalar").to_problem(orders(SIX[1], "general", 2).failing[0])
