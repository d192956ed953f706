"""A delay equation as an ordinary one of the solution now and at earlier times."""

import numpy as np
import pytest

from facade import (
    SETS,
    KeptAlgebraic,
    LaggedAlgebraicTheta,
    OldLagAlgebraic,
    StochasticTheta,
    WrongLag,
    delay_linear,
    delay_martingale,
    delay_ou,
    delay_test,
    gbm,
    gbm_algebraic,
    judge_strong,
    keeps_constraint,
    local_strong,
    remove_delay,
    strong_orders,
)
from probe.strong_cells import probed
from sdaeverify import SDE, Array, Increment, Scheme
from sdaeverify.forms.delay.linked import linked_equation

S, H, PATHS = 0.3, 1.0 / 16.0, 5


def pairs() -> Array:
    """Return x(s + tau) and x(s) on a few paths."""
    return np.random.default_rng(3).uniform(0.5, 1.5, (2, PATHS))


@pytest.mark.parametrize("problem", [gbm(), gbm_algebraic()])
def test_without_delay_nothing_is_linked(problem: SDE) -> None:
    """Scheme and problem come back as they are."""
    scheme = StochasticTheta()

    assert remove_delay(scheme, problem) == (scheme, problem)


def test_spans_with_one_end_are_one_problem() -> None:
    """Up to two delays and up to the horizon are the same where that is two delays, and are found once."""
    scheme, problem, longer = StochasticTheta(), delay_ou(horizon=2.0), delay_test("II", horizon=4.0)

    assert remove_delay(scheme, problem, until=2.0) == remove_delay(scheme, problem)
    assert remove_delay(scheme, longer, until=2.0) != remove_delay(scheme, longer)


@pytest.mark.parametrize("name", ["II", "IV"])
def test_the_equation_of_the_pair(name: str) -> None:
    """Each solution has the other, or the history, for its past, and a Brownian motion of its own."""
    a, b, c, d, l, q = SETS[name]
    equation, (x, v) = linked_equation(delay_test(name), 2), pairs()
    w = np.full(PATHS, S - 1.0 + 1.0)

    def f(now: Array, past: Array) -> Array:
        return (a + q) * now + b * past + l * np.sin(past)

    np.testing.assert_allclose(equation.drift(S, pairs()), np.stack([f(x, v), f(v, w)]), rtol=1e-14)
    B = equation.diffusion(S, pairs())
    np.testing.assert_allclose([B[0, 0], B[1, 1]], [c * x + d * v, c * v + d * w], rtol=1e-14)
    assert not B[0, 1].any()
    assert not B[1, 0].any()
    assert equation.noise_dim == 2


@pytest.mark.parametrize("theta", [0.0, 0.5, 1.0])
def test_a_linked_step_makes_the_older_step_first(theta: float) -> None:
    """The younger step's lagged values are the older step's begin and end."""
    a, b, c, d, l, q = SETS["IV"]
    scheme, equation = remove_delay(StochasticTheta(theta), delay_test("IV"))
    x, v = pairs()
    dW = np.sqrt(H) * np.random.default_rng(4).standard_normal((2, PATHS))

    def made(now: Array, past: Array, ahead: Array, kick: Array) -> Array:
        f = a * now + b * past + l * np.sin(past) + q * now
        known = now + H * (1.0 - theta) * f + (c * now + d * past) * kick
        return (known + H * theta * (b * ahead + l * np.sin(ahead))) / (1.0 - H * theta * (a + q))

    older = made(v, np.full(PATHS, S), np.full(PATHS, S + H), dW[1])
    younger = made(x, v, older, dW[0])

    got = scheme.step(equation, pairs(), S, H, Increment(dW, None))
    np.testing.assert_allclose(got.state, np.stack([younger, older]), rtol=1e-13)


@pytest.mark.sweep
@pytest.mark.parametrize(
    ("problem", "links", "order"),
    [
        (delay_test("II"), 2, 0.5),
        (delay_test("IV"), 2, 0.5),
        (delay_test("IV"), 1, 1.0),
        (delay_martingale(), 2, 0.5),
        (delay_ou(), 2, 1.0),
        (delay_ou(), 1, 1.0),
    ],
    ids=lambda thing: getattr(thing, "source", str(thing)),
)
def test_orders_before_and_after_the_first_delay(problem: SDE, links: int, order: float) -> None:
    """Delayed noise is additive up to the first delay and not after it; noise of the state is of order 1/2."""
    found = strong_orders(local_strong(*remove_delay(StochasticTheta(0.0), problem, links)))[0]

    assert found.order == pytest.approx(order, abs=0.05)


def test_a_step_that_forgets_the_delay_is_refuted() -> None:
    """With x itself for its past, one step does not follow the equation."""
    order, *_ = probed(WrongLag(0.5, "present"), delay_linear())

    assert judge_strong(order, 0.5, sharp=True).verdict == "refuted"


@pytest.mark.parametrize(
    ("scheme", "keeps"),
    [
        (StochasticTheta(0.0), True),
        (StochasticTheta(1.0), True),
        (LaggedAlgebraicTheta(), True),
        (KeptAlgebraic(), False),
        (OldLagAlgebraic(), False),
    ],
)
def test_whether_y_solves_the_constraint_is_seen_in_one_step(scheme: Scheme, keeps: bool) -> None:
    """A y that is kept, or solved for with the old lag, does not; nor does one that is not there."""
    assert keeps_constraint(scheme, delay_test("IV")) is keeps
    assert not keeps_constraint(scheme, delay_ou())
