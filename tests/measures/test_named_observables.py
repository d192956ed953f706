"""A weak claim that names its observables is judged by these, not by all test functions."""

import dataclasses

import numpy as np
import pytest

from facade import PlatenWeak2, gbm, judge_probe, probe_weak, quadratic_form
from facade import test_functions as phi
from probe.weak_cells import equation, euler, scheme
from sdaeverify import Claim, Settings, verify
from sdaeverify.measuring import Evidence, Tally, Verdict

A, B = -1.0, 0.8
SETTINGS = Settings()
OBSERVABLES = {
    "x": lambda t, parts: parts["x"][0],
    "x^2": lambda t, parts: parts["x"][0] ** 2,
    "cos x": lambda t, parts: np.cos(parts["x"][0]),
}


def growth(drift=lambda t, x: A * x):
    """Return growth with multiplicative noise."""
    return equation(drift, lambda t, x: B * x[:, None], [1.0], observables=OBSERVABLES)


def trapezoidal(p, x, t, h, n, *, variance=1.0, drift=1.0):
    """Make a step whose mean has order 2, whatever the order of the rest."""
    return x * (1.0 + 0.5 * drift * A * h + np.sqrt(variance) * B * n.dW) / (1.0 - 0.5 * drift * A * h)


def opinion(formula, claim, observable, problem=None, **parameters):
    """Return what is said without sampling of a scheme's claim about an observable, and whether T2 confirms T1."""
    problem, made = problem or growth(), scheme(formula, **parameters)
    tally = probe_weak(made, problem, SETTINGS)
    return judge_probe(Evidence(made, problem, problem, SETTINGS, tally, Tally()), claim, observable)


def naming(*quantities, value=2.0):
    """Return a claim of weak order 2."""
    return Claim(measure="weak", value=value, quantities=quantities, source="test")


def test_the_exact_order_of_a_mean_decides_a_claim_about_it():
    """E x_n = ((1 + ah/2)/(1 - ah/2))^n x_0 has order 2, though E x^3 has order 1, so that all functions have not."""
    found, _ = opinion(trapezoidal, naming("x"), "x")

    assert found.verdict is Verdict.VERIFIED
    assert found.tier == 2
    assert "of E[x] at T by moment equations" in str(found.reason)
    assert opinion(trapezoidal, naming(), "x")[0].verdict is Verdict.REFUTED


@pytest.mark.parametrize(
    ("formula", "parameters", "quantity", "value"),
    [
        (trapezoidal, {}, "x^2", 2.0),
        (trapezoidal, {"drift": 1.01}, "x", 2.0),
        (trapezoidal, {"drift": 1.01}, "x", 1.0),
        (trapezoidal, {"variance": 1.01}, "x^2", 1.0),
        (euler, {}, "x", 2.0),
    ],
)
def test_a_wrong_order_of_the_named_observable_is_refuted(formula, parameters, quantity, value):
    """Moments at T refute what is claimed of the observable that they know."""
    found, _ = opinion(formula, naming(quantity, value=value), quantity, **parameters)

    assert found.verdict is Verdict.REFUTED
    assert found.tier == 2


def test_a_wrong_variance_is_no_error_of_a_mean():
    """A mean that is right is verified where second moments are wrong."""
    assert opinion(trapezoidal, naming("x"), "x", variance=1.1)[0].verdict is Verdict.VERIFIED


def test_other_functions_do_not_refute_where_moments_are_not_known():
    """Of cos x one step says nothing by E x^3: whether it has order 2 is left to paths, and why is told."""
    found, confirmed = opinion(trapezoidal, naming("cos x"), "cos x")

    assert found.verdict is Verdict.INCONCLUSIVE
    assert not confirmed
    assert "for other functions; " in str(found.reason)


def test_the_observable_itself_refutes_where_moments_do_not_close():
    """With a drift that is not linear, T2 knows nothing: the local order of E x by itself refutes."""
    bent = growth(lambda t, x: np.sin(x))
    found, _ = opinion(euler, naming("x"), "x", bent)

    assert found.verdict is Verdict.REFUTED
    assert found.tier == 1
    assert "of E[x]" in str(found.reason)
    assert opinion(euler, naming("x", value=1.0), "x", bent)[0].verdict is Verdict.VERIFIED


def test_forms_are_those_of_quadratic_observables_alone():
    """Coefficients are found exactly; a jump, a kink or a cosine has none."""
    rough = {
        "jump": lambda t, parts: 1.0 * (parts["x"][0] > 1.0),
        "kink": lambda t, parts: np.abs(parts["x"][0]),
        "mixed": lambda t, parts: 3.0 + parts["x"][0] - 2.0 * parts["x"][0] * parts["x"][1],
    }
    two = equation(lambda t, x: -x, lambda t, x: np.eye(2)[..., None], [1.0, 0.5], noise_dim=2, observables=rough)
    found = quadratic_form(two, "mixed")

    assert (found.constant, found.linear.tolist()) == (3.0, [1.0, 0.0])
    assert found.square.tolist() == [[0.0, -1.0], [-1.0, 0.0]]
    assert quadratic_form(two, "jump") is None
    assert quadratic_form(two, "kink") is None
    assert quadratic_form(growth(), "cos x") is None


def test_test_functions_make_up_a_quadratic_form():
    """Their combination is the form, in whatever units its components are."""
    rng = np.random.default_rng(1)
    linear, square, units, x = rng.random(3), rng.random((3, 3)), np.array([0.5, 2.0, 8.0]), rng.random((3, 20))
    square = square + square.T
    made = phi.coefficients(linear, square, units) @ phi.values(x / units[:, None])

    assert made == pytest.approx(linear @ x + np.einsum("ip,ij,jp->p", x, square, x), rel=1e-14)


ROUGH = {
    "jump": lambda t, parts: 1.0 * (parts["x"][0] > 1.0),
    "kink": lambda t, parts: np.abs(parts["x"][0] - 1.0),
    "smooth": lambda t, parts: np.sin(parts["x"][0]),
}


@pytest.mark.sweep
@pytest.mark.parametrize("claim", [naming(), naming("jump", "kink", "smooth")])
def test_one_step_says_nothing_of_an_observable_that_is_not_smooth(claim):
    """A bounded scheme has order 1/2 for a jump, and its law on a lattice tells it; at a kink more is left open."""
    rough = dataclasses.replace(gbm(), observables=ROUGH, truths=())
    tally = probe_weak(PlatenWeak2(), rough, SETTINGS)
    evidence = Evidence(PlatenWeak2(), rough, rough, SETTINGS, tally, Tally())
    verdicts = {name: judge_probe(evidence, claim, name)[0] for name in ROUGH}

    assert verdicts["smooth"].verdict is Verdict.VERIFIED
    assert (verdicts["jump"].verdict, verdicts["jump"].tier) == (Verdict.REFUTED, 2)
    assert verdicts["kink"].verdict is Verdict.INCONCLUSIVE
    assert verdicts["kink"].speaks_against


@pytest.mark.long
@pytest.mark.parametrize("paths", [256, 4096])
def test_a_jump_is_not_verified_by_the_order_of_smooth_functions(paths):
    """Weak 2.0 of 1(x > 1) by a scheme with three-point noise, whose order is 1/2, is never verified."""

    def digital():
        """Growth, of which it is asked whether it is above 1."""
        return dataclasses.replace(gbm(), observables=ROUGH, truths=())

    found = verify([PlatenWeak2()], digital, "weak", paths=paths).verdicts
    verdicts = dict(zip(found["quantity"], found["verdict"], strict=True))

    assert verdicts["jump"] != "verified"
    assert verdicts["smooth"] == "verified"
