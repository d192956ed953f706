"""JUnit files."""

from pathlib import Path
from xml.etree.ElementTree import fromstring

import pytest
import xmlschema

from sdaeverify.contracts.finding import Method, Verdict
from sdaeverify.gate.lock import Lock
from sdaeverify.gate.policy import ExpectedFailure, Policy
from sdaeverify.gate.writers.machine import junit_xml

from .conftest import NASTY, gated, result


@pytest.fixture(scope="module")
def schema():
    """Return the schema of the parts that are used."""
    return xmlschema.XMLSchema(Path(__file__).with_name("xunit2.xsd"))


def test_every_outcome_is_valid(everything, schema):
    """The file fits the schema whatever became of the cells and whatever they are called."""
    text = junit_xml(gated(*everything, lock=Lock((f"gone {NASTY}",))))

    schema.validate(text)
    assert "\x1b" not in text
    assert "\x00" not in text


def test_no_cells(schema):
    """A gate without cells has no suite."""
    schema.validate(junit_xml(gated()))


def test_counts(everything):
    """Failures and skips are counted in each suite and in all."""
    expected = ExpectedFailure(reason="known", quantity="y")
    policy = Policy(expected_failures=(expected,))
    root = fromstring(junit_xml(gated(*everything, result(Verdict.REFUTED, quantity="y"), policy=policy)))
    (suite,) = root

    cases = suite.findall("testcase")
    failures, skips = suite.findall("testcase/failure"), suite.findall("testcase/skipped")
    assert [failure.get("type") for failure in failures] == ["failed"] + 3 * ["unmeasured"]
    assert [skip.get("type") for skip in skips] == ["undecided", "xfailed"]
    assert (suite.get("tests"), suite.get("failures"), suite.get("skipped")) == ("7", "4", "2")
    assert (root.get("tests"), root.get("failures"), root.get("errors")) == ("7", "4", "0")
    assert len(cases) == 7


def test_what_a_case_says():
    """A case names scheme, measure and quantity, and its output has claim, interval and command."""
    finding = result(Verdict.REFUTED, estimate=0.5, low=0.4, high=0.6, method=Method("paths"))
    (case,) = fromstring(junit_xml(gated(finding))).iter("testcase")

    assert (case.get("classname"), case.get("name")) == ("plain", "sharp x")
    text = case.find("system-out").text
    assert "claimed order >= 1.0 up to a margin of 0.2" in text
    assert "0.5, between 0.4 and 0.6 (99 % interval)" in text
    assert "python -m sdaeverify matrix -s plain -p line -m sharp" in text
    assert case.find("failure").get("message").startswith("refuted: plain on line, sharp x")


def test_undecided_fails_where_it_must_not_be():
    """An undecided claim is skipped, or a failure where the policy says so."""
    undecided = result(Verdict.INCONCLUSIVE)
    (suite,) = fromstring(junit_xml(gated(undecided, policy=Policy(inconclusive="fail"))))

    assert (suite.get("failures"), suite.get("skipped")) == ("1", "0")


def test_times_add_up():
    """The time of a scheme on a problem is shared among its cases."""
    (suite,) = fromstring(junit_xml(gated(result(Verdict.VERIFIED), result(Verdict.VERIFIED, quantity="y"))))

    assert suite.get("time") == "0.500"
    assert [case.get("time") for case in suite.iter("testcase")] == ["0.250", "0.250"]
