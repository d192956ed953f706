"""Nothing is verified on a problem that does not discriminate."""

from dataclasses import replace

import pytest

from facade import Cell, ControlPlan, ControlVerdicts, Objection, send
from sdaeverify import SDE, Claim, Control, ProblemError, Scheme, Settings
from sdaeverify.measuring import Evidence, Finding, Judgement, Measure, Reason, Verdict

CLAIM = Claim(measure="strong", value=1.0, source="a theorem")
VERIFIED = Finding(quantity="x", verdict=Verdict.VERIFIED, claim=CLAIM, reason=Reason("order 1.0"), p_verified=1e-9)
CONTROL = Control(measure="strong", order=1.0, positive="good", negative="bad")


class Judge(Measure):
    """A measure that knows the order of a scheme by its name."""

    name = "strong"

    def judge(self, evidence):
        """Compare the order with what is claimed."""
        (claim,) = evidence.promises
        verdict = Verdict.VERIFIED if evidence.scheme.order >= claim.value.least else Verdict.REFUTED
        return Judgement((Finding(quantity="x", verdict=verdict, claim=claim),), ())


class Known(Scheme):
    """A scheme of a known order."""

    form = SDE

    def __init__(self, name, order):
        object.__setattr__(self, "name", name)
        object.__setattr__(self, "order", order)

    __eq__, __hash__ = object.__eq__, object.__hash__


TESTED = Known("tested", 1.0)


def plans(positive=1.0, negative=0.5):
    """Return the plan of a control whose schemes have these orders."""
    cells = [Cell(Known(name, order), None, Judge()) for name, order in (("good", positive), ("bad", negative))]
    return (ControlPlan(CONTROL, *cells),)


def controls_of(made, lost="", objection=None):
    """Return the verdicts of controls on evidence in which the judge finds all it needs, but of a lost one."""
    found = {}
    for cell in (cell for plan in made for cell in (plan.positive, plan.negative) if cell is not None):
        evidence = Evidence(cell.scheme, None, None, Settings(), None, None)
        found[cell] = objection if cell.scheme.name == lost else evidence
    return ControlVerdicts(made, found)


def controlled(finding, scheme, controls):
    """Return a finding on a scheme as the controls leave it."""
    return send(finding, controls.case(finding, scheme))


REFUTED = replace(VERIFIED, verdict=Verdict.REFUTED)
EXACT = replace(VERIFIED, claim=Claim(measure="strong", value="round-off", source="exact"))
SUSPECT = plans(positive=0.5)


@pytest.mark.parametrize(
    ("finding", "scheme", "controls"),
    [
        (VERIFIED, TESTED, plans()),
        (VERIFIED, TESTED, ()),
        (EXACT, TESTED, plans(negative=1.0)),
        (REFUTED, TESTED, plans(negative=1.0)),
        (replace(REFUTED, tier=1), TESTED, SUSPECT),
        (replace(REFUTED, tier=3, quantity="y"), TESTED, SUSPECT),
        (replace(REFUTED, tier=3), SUSPECT[0].positive.scheme, SUSPECT),
    ],
    ids=["told apart", "no controls", "no order", "refuted", "one step", "another quantity", "control itself"],
)
def test_what_controls_have_nothing_against(finding, scheme, controls):
    """A problem that tells the orders apart leaves findings alone; a refutation needs no control."""
    assert controlled(finding, scheme, controls_of(controls)) == finding


@pytest.mark.parametrize(
    ("controls", "words"),
    [
        (plans(negative=1.0), "the negative control bad is not refuted"),
        (plans(positive=0.5), "the positive control good is not verified"),
        ((ControlPlan(CONTROL, missing="the control good is missing"),), "the control good is missing"),
        (
            (replace(plans()[0], control=replace(CONTROL, order=0.5)),),
            "the problem declares no control of strong order 1.0 or more, so that it can only verify lower orders",
        ),
    ],
)
def test_a_problem_that_does_not_discriminate_verifies_nothing(controls, words):
    """The finding becomes inconclusive, says why, and can no more be verified over the run."""
    found = controlled(VERIFIED, TESTED, controls_of(controls))

    assert found.verdict is Verdict.INCONCLUSIVE
    assert words in str(found.reason)
    assert found.p_verified == 1.0


class Nearly(Judge):
    """A measure that refutes nothing yet: the p-value against a claim is 1e-4 where the order is too low."""

    def judge(self, evidence):
        """Compare the order with what is claimed."""
        (claim,) = evidence.promises
        p = 1.0 if evidence.scheme.order >= claim.value.least else 1e-4
        return Judgement((Finding(quantity="x", verdict=Verdict.INCONCLUSIVE, claim=claim, p_refuted=p),), ())


@pytest.mark.parametrize(("order", "p_refuted", "left"), [(0.5, 1e-4, 1.0), (1.0, 1e-4, 1e-4), (0.5, 0.1, 0.1)])
def test_nothing_is_refuted_over_all_tests_where_the_control_may_be(order, p_refuted, left):
    """Holm's procedure cannot refute what the positive control misses, too: p is 1 then. No verdict changes by it."""
    cells = (Cell(Known(name, known), None, Nearly()) for name, known in (("good", order), ("bad", 0.5)))
    open_ = replace(VERIFIED, verdict=Verdict.INCONCLUSIVE, tier=3, p_refuted=p_refuted)

    found = controlled(open_, TESTED, controls_of((ControlPlan(CONTROL, *cells),)))

    assert (found.verdict, found.p_refuted) == (Verdict.INCONCLUSIVE, left)


def sides(upper, lower):
    """Return the plans of controls of orders 1 and 1/2, whose two schemes have these orders."""
    return tuple(
        ControlPlan(
            Control(measure="strong", order=order, positive=f"good {order}", negative=f"bad {order}"),
            *(
                Cell(Known(f"{name} {order}", known), None, Judge())
                for name, known in zip(("good", "bad"), pair, strict=True)
            ),
        )
        for order, pair in ((1.0, upper), (0.5, lower))
    )


@pytest.mark.parametrize(
    ("controls", "words"),
    [
        (sides((1.0, 0.5), (0.5, 0.0)), ""),
        (sides((1.0, 0.8), (0.5, 0.0)), ""),
        (sides((1.0, 0.8), (0.8, 0.0)), "none of the controls of lower order is refuted: bad 1.0, good 0.5"),
        (sides((0.5, 0.0), (0.5, 0.0)), "the positive control good 1.0 is not verified"),
        (sides((1.0, 0.5), (0.5, 0.0))[:1], ""),
        (sides((1.0, 0.5), (0.5, 0.0))[1:], "the problem declares no control of strong order 0.75 or more"),
    ],
)
def test_orders_between_declared_ones_are_decided_by_the_controls_on_both_sides(controls, words):
    """A claim of 0.75 is put to what has order 1, and to what is known to have less: one of those must miss it."""
    between = replace(VERIFIED, claim=replace(CLAIM, value=0.75))

    found = controlled(between, TESTED, controls_of(controls))

    assert found.verdict is (Verdict.INCONCLUSIVE if words else Verdict.VERIFIED)
    assert words in str(found.reason)


def test_paths_refute_nothing_where_a_control_is_refuted():
    """Where what is right is refuted in the same quantity, too, the problem is in error and not the scheme."""
    found = controlled(replace(REFUTED, tier=3, p_refuted=1e-9), TESTED, controls_of(SUSPECT))

    assert (found.verdict, found.p_refuted) == (Verdict.ERROR, 1.0)
    assert "exact solution of the problem is in doubt: good, known to have order 1.0, is refuted here as well" in str(
        found.reason
    )


@pytest.mark.parametrize("lost", ["good", "bad"])
@pytest.mark.parametrize("verdict", [Verdict.ERROR, Verdict.NOT_RUN, Verdict.INCONCLUSIVE])
def test_controls_without_evidence_confirm_nothing(lost, verdict):
    """What was not measured is not what was not refuted: the claim is in error or not run, and says why."""
    partly = controls_of(plans(), lost, Objection("was not measured: it died", verdict))

    found = controlled(VERIFIED, TESTED, partly)

    assert found.verdict is verdict
    assert f"the control {lost} was not measured: it died" in str(found.reason)
    assert "is not refuted" not in str(found.reason)
    assert found.p_verified == 1.0
    assert controlled(REFUTED, TESTED, partly).p_refuted != 1.0


def test_a_control_of_which_nobody_knows_whether_it_can_be_run():
    """Where asking whether a control can be run has failed, the claim is in error."""
    failed = ControlPlan(CONTROL, missing="the control good cannot be run: it died", failed=True)

    found = controlled(VERIFIED, TESTED, controls_of((failed,)))

    assert found.verdict is Verdict.ERROR
    assert "the control good cannot be run: it died" in str(found.reason)


@pytest.mark.parametrize("wrong", [{"order": 0.0}, {"negative": "good"}])
def test_controls_that_make_no_sense_are_refused(wrong):
    """An order is positive, and a scheme cannot be its own opposite."""
    with pytest.raises(ProblemError):
        replace(CONTROL, **wrong)
