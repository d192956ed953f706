"""The guide of each form has a scheme for it that passes the conformance kit and has the orders of Euler's."""

import doctest

import pytest

import sdaeverify
from facade import load_registry
from sdaeverify import Claim, Problem, verify
from sdaeverify.cli.commands.info import describe_concept
from sdaeverify.forms.guides import guide_of
from sdaeverify.testing import check_scheme

FORMS = {
    "SDE": "gbm",
    "Langevin": "angle-pendulum",
    "DelaySDAE": "gbm-algebraic",
    "IndexOneSDAE": "noisy-circuit",
    "HolonomicSDAE": "pendulum",
    "ConstrainedLangevin": "affine-constraint",
}
# What an example of eight lines leaves out: a docstring and a source.
PAPERS = {"docstring", "source", "claims", "declaration", "pickle", "frozen", "label"}


def example(form):
    """Return the class of the scheme in the guide of a form, whose example imports all that it uses."""
    names = {}
    for found in doctest.DocTestParser().get_examples(guide_of(getattr(sdaeverify, form))):
        exec(found.source, names)
    made = [each for name, each in names.items() if name.startswith("My")]
    assert len(made) == 1
    return made[0]


def test_every_form_has_an_example():
    """A form that is public and can be solved is in the table of this file."""
    public = {name for name in sdaeverify.__all__ if isinstance(getattr(sdaeverify, name), type)}
    assert {name for name in public if issubclass(getattr(sdaeverify, name), Problem)} - {"Problem"} == {*FORMS}


@pytest.mark.parametrize("form", FORMS)
def test_the_example_passes_the_kit(form):
    """Its step has all the behaviour of a step."""
    rows = check_scheme(example(form)(), problems=[FORMS[form]])
    assert len(rows) > 15
    assert [
        (row["check"], row["reason"]) for row in rows if row["status"] == "failed" and row["check"] not in PAPERS
    ] == []


@pytest.mark.long
@pytest.mark.parametrize("form", FORMS)
def test_the_example_has_the_orders_of_euler(form):
    """A claim of the strong order 1/2 is verified on a problem of the form."""
    kind = example(form)
    named = {"claims": (Claim(measure="strong", value=0.5, source="Euler"),), "__doc__": "Euler."}
    rows = verify(type("Example", (kind,), named)(), FORMS[form], "strong", paths=512).rows.verdicts
    assert {row.verdict for row in rows if row.claim} == {"verified"}


def test_info_has_the_guide():
    """A form is told with what its step is given; of a form that has no guide there is none."""
    told = describe_concept("DelaySDAE", load_registry(environ={}))
    assert "A scheme for it" in told
    assert any(">>> class MyDelayEuler(Scheme):" in line for line in told)
    assert guide_of(type("Other", (sdaeverify.SDE,), {})) == ""


def test_info_lists_the_methods_of_noise():
    """An author finds what an increment can do, and how to have two normals a step."""
    told = "\n".join(describe_concept("noise", load_registry(environ={})))
    assert "  time_integral(h): Return int_t^{t+h}" in told
    assert "``sqrt(12/h) H``" in told
