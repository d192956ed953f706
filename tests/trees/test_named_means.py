"""Claims about the means of named functions are not put to classes as if they were about all functions."""

from typing import Any, ClassVar

import pytest

from sdaeverify import SDE, Claim, Scheme, Step
from sdaeverify_orders import orders


class MeanTrapezoidal(Scheme):
    """Heun's drift with Euler's noise: the mean of x after one step is right to h^2, that of x^2 to h."""

    name: ClassVar[str] = "mean-trapezoidal"
    form: ClassVar[type[SDE]] = SDE
    source: ClassVar[str] = "test"

    def step(self, problem: SDE, state: Any, t: float, h: float, noise: Any) -> Step:
        """Make one step."""
        f, moved = problem.drift(t, state), problem.diffused(t, state, noise.dW)
        return Step(state + 0.5 * h * (f + problem.drift(t + h, state + h * f + moved)) + moved)


class Euler(MeanTrapezoidal):
    """Euler-Maruyama: the mean of x after one step is right to h."""

    name: ClassVar[str] = "mean-euler"

    def step(self, problem: SDE, state: Any, t: float, h: float, noise: Any) -> Step:
        """Make one step."""
        return Step(state + h * problem.drift(t, state) + problem.diffused(t, state, noise.dW))


def weak_row(kind, *about, least=2.0):
    """Return the row on general noise of a scheme that claims a weak order of the means of some functions."""

    class Claiming(kind):
        claims = (Claim(measure="weak", value=least, quantities=about, source="test"),)

    return next(row for row in orders(Claiming(), "general", 2).rows if row.measure == "weak")


def test_products_of_trees_do_not_refute_a_claim_about_the_mean_of_x():
    """It was refuted by b1 . b1(t); the reason names what the claim is about and the order of other functions."""
    row = weak_row(MeanTrapezoidal, "x")

    assert row.verdict == "inconclusive"
    assert "the claim is about the mean of x only; the order of all smooth functions is 1" in row.why


def test_a_tree_by_itself_refutes_a_claim_about_the_mean_of_x():
    """Euler's mean of x misses f(t), so that order 2 is refuted; order 1 holds, since it does for all functions."""
    row = weak_row(Euler, "x")

    assert (row.verdict, row.first.name) == ("refuted", "f(t)")
    assert weak_row(Euler, "x", least=1.0).verdict == "verified"


@pytest.mark.parametrize("kind", [MeanTrapezoidal, Euler])
def test_a_claim_about_all_functions_is_refuted_as_before(kind):
    """Without names a claim is about all functions."""
    assert weak_row(kind).verdict == "refuted"


def test_a_claim_about_another_function_is_not_asked_and_the_row_says_so():
    """No condition is about the mean of x^2 alone."""
    row = weak_row(MeanTrapezoidal, "x^2", "cos x")

    assert row.verdict == "out_of_scope"
    assert row.premise.startswith("claimed only for x^2 and cos x, not for all smooth functions")
