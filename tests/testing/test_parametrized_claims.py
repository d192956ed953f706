"""`parametrize_with_claims`: claimed cells as parameters of a test."""

from dataclasses import dataclass, replace
from typing import ClassVar

import pytest

from facade import Plan, Policy, load_plugins
from sdaeverify import SDE, Claim, Scheme, Step, UsageError
from sdaeverify.testing import parametrize_with_claims, parametrize_with_examinations
from sdaeverify.testing.claims import ClaimRun, claim_run


@dataclass(frozen=True)
class Mine(Scheme):
    """Euler-Maruyama, registered by nobody."""

    name: ClassVar[str] = "mine"
    form: ClassVar[type] = SDE
    claims: ClassVar = (
        Claim(measure="strong", value=0.5, source="test"),
        Claim(measure="weak", value=2.0, source="wrong on purpose"),
    )

    def step(self, problem, state, t, h, noise):
        return Step(state + h * problem.drift(t, state) + problem.diffused(t, state, noise.dW))


MILSTEIN = load_plugins().schemes["milstein"].thing


def parameters(mark):
    """Return id, subject and check of each test."""
    return {case.id: case.values for case in mark.args[1]}


def test_a_test_for_each_claimed_cell():
    """Named by problem, scheme and measure, with the scheme as subject."""
    two = {"problems": ["gbm"], "measures": ["strong", "weak"], "expected_failures": None}
    made = parameters(parametrize_with_claims([Mine(), "milstein"], **two))

    both = [f"gbm-{name}-{measure}" for name in ("milstein", "mine") for measure in ("strong", "weak")]
    assert [name for name in made if name.startswith("gbm")] == both
    assert made["gbm-mine-strong"][0] == Mine()
    assert repr(made["gbm-mine-strong"][1]) == "strong on gbm"


def test_a_test_for_each_claim_about_a_class():
    """A claim is put to the order conditions of each class, also where problems are named, and a tree refutes it."""
    made = parameters(parametrize_with_claims([Mine()], problems=["gbm"], measures=["weak"]))
    subject, check = made["every-equation[of=additive]-mine-weak"]

    assert "every-equation[of=scalar]-mine-weak" in made
    with pytest.raises(AssertionError, match=r"the condition f\(t\) fails, found 0, wanted 1/2"):
        check(subject)


def test_a_check_raises_what_became_of_its_claim():
    """Nothing if it holds, an AssertionError if not; there is no command for a scheme that nobody can name."""
    made = parameters(parametrize_with_claims([Mine()], problems=["gbm"]))
    subject, check = made["gbm-mine-strong"]

    check(subject)
    with pytest.raises(AssertionError, match="refuted: mine on gbm, weak x: claimed order >= 2") as failure:
        made["gbm-mine-weak"][1](subject)
    assert "reproduce" not in str(failure.value)


@dataclass(frozen=True)
class Forgetful(Mine):
    """Milstein's scheme without its correction term."""

    name: ClassVar[str] = "forgetful"
    claims: ClassVar = (Claim(measure="strong", value=1.0, source="Milstein 1975", when=frozenset({"scalar-noise"})),)


@dataclass(frozen=True)
class Correct(Forgetful):
    """Milstein's scheme."""

    name: ClassVar[str] = "correct"

    def step(self, problem, state, t, h, noise):
        return MILSTEIN.step(problem, state, t, h, noise)


@pytest.mark.parametrize("tier", ["smoke", None])
def test_a_weaker_scheme_is_refuted_where_problems_are_named(tier):
    """Euler-Maruyama has strong order 1 with additive noise: gbm is taken, and order conditions are asked, too."""
    options = {"problems": ["gbm", "ou"], **({} if tier is None else {"tier": tier})}
    made = parameters(parametrize_with_claims([Forgetful(), Correct()], **options))

    for name in ("gbm-forgetful-strong", "every-equation[of=scalar]-forgetful-strong"):
        subject, check = made[name]
        with pytest.raises(AssertionError, match="refuted: forgetful on"):
            check(subject)
    for name in ("gbm-correct-strong", "every-equation[of=scalar]-correct-strong"):
        subject, check = made[name]
        check(subject)


def test_expected_failures():
    """A claim that is expected to fail is an xfail with its reason; an expectation that is not met fails."""
    expected = [{"measure": "weak", "reason": "order 1"}, {"measure": "strong", "reason": "it holds"}]
    made = parameters(parametrize_with_claims([Mine()], problems=["gbm"], expected_failures=expected))
    subject, check = made["gbm-mine-weak"]

    with pytest.raises(pytest.xfail.Exception, match="order 1"):
        check(subject)
    with pytest.raises(AssertionError, match="unexpectedly verified"):
        made["gbm-mine-strong"][1](subject)


def test_in_a_test_file(pytester):
    """The decorator makes ordinary tests whose failures show the claim and no inside of this package."""
    pytester.makepyfile(
        """
        from sdaeverify.testing import parametrize_with_claims, parametrize_with_examinations

        @parametrize_with_claims(["euler-maruyama"], problems=["gbm"], measures=["strong"],
                                 expected_failures=[{"problem": "gbm", "reason": "not so"}])
        def test_claims(subject, check):
            check(subject)
        """
    )
    result = pytester.runpytest_inprocess("-p", "no:hypothesispytest", "-p", "no:benchmark")

    result.assert_outcomes(failed=1, passed=7)
    result.stdout.fnmatch_lines(["E *unexpectedly verified: euler-maruyama on gbm, strong x: *"])
    assert "claims.py" not in result.stdout.str().replace("test_in_a_test_file", "")


@pytest.mark.parametrize(
    ("schemes", "options", "words"),
    [
        ([], {}, "schemes is empty"),
        (["milstien"], {}, "unknown scheme 'milstien'; did you mean milstein?"),
        ([Mine], {}, "expected a scheme, got the class Mine; write Mine"),
        (["milstein"], {"tier": "smok"}, "did you mean smoke?"),
        (["milstein"], {"measures": ["limits"]}, "no claims about the measures"),
        (
            ["milstein"],
            {"expected_failures": [{"problem": "x*", "reason": "r"}]},
            "problem=x\\* matches no claimed cell",
        ),
        (["milstein"], {"expected_failures": [{"problem": "*"}]}, "missing required field `reason`"),
        (["milstein"], {"expected_failures": [{"reason": 5}]}, "reason: Expected `str`, got `int`"),
        (["milstein"], {"seed": "x"}, "seed must be a whole number, got 'x'"),
    ],
)
def test_what_an_author_gets_wrong(schemes, options, words):
    """It is said where the tests are made, before any is run."""
    with pytest.raises(UsageError, match=words):
        parametrize_with_claims(schemes, **options)


@pytest.mark.long
def test_a_cell_does_not_depend_on_the_others():
    """Run alone or with all others of its problem, a cell has the same outcomes, to the last bit."""
    policy = Policy(schemes=(Mine(), "milstein", "heun"), problems=("gbm",), tier="smoke")
    together = claim_run(load_plugins(), policy)
    (problem,) = together.plan.problems
    for cell in problem.cells:
        alone = ClaimRun(Plan((replace(problem, cells=(cell,)),)), policy, together.registry)
        one, other = alone.outcomes(cell), together.outcomes(cell)
        assert repr([outcome.finding for outcome in one]) == repr([outcome.finding for outcome in other])


def test_the_level_is_shared_among_all_cells():
    """With many cells, one test gets a smaller part of the error probability, whatever is run of them."""
    few = claim_run(load_plugins(), Policy(schemes=("milstein",), problems=("gbm",), tier="ci"))
    many = ClaimRun(Plan(200 * few.plan.problems), few.policy, few.registry)

    assert few.settings.tests_reserved == 1000
    assert many.settings.tests_reserved == 10 * len(many.plan.cells) > 1000


SOLVERS = {
    "adaptive": {"solvers": ["heun-pi"], "problems": ["ou"], "paths": 100, "tolerances": [0.03, 0.01, 0.003]},
    "sealed": {"solvers": ["own-euler"], "problems": ["ou"], "paths": 8192, "looks": 1},
}


def test_shipped_examinations_are_found():
    """They belong to plugins that only some commands load; the kit loads them as a gate does."""
    assert [*parameters(parametrize_with_examinations(SOLVERS))] == [*SOLVERS]


@pytest.mark.long
def test_a_shipped_examination_is_a_test():
    """Its solver is measured once, and the check passes if no claim is refuted or undecided."""
    ((subject, check),) = parameters(parametrize_with_examinations({"sealed": SOLVERS["sealed"]})).values()
    check(subject)
    assert subject == "sealed"
