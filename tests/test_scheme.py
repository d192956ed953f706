"""The contract of a scheme: claims, states, and the defaults of the base class."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import pytest

from facade import flatten, same_kind
from sdaeverify import SDE, Array, Claim, Increment, Scheme, SchemeError, Step, UsageError


class TwoParts(NamedTuple):
    """A state of two arrays."""

    r: Array
    mu: Array


class OtherParts(NamedTuple):
    """The same arrays under other names."""

    q: Array
    p: Array


@dataclass(frozen=True)
class Damped(Scheme):
    """A scheme with parameters: x <- (1 - theta h) x + dW."""

    theta: float = 1.0
    kind: str = "plain"

    name = "damped"
    form = SDE

    def step(self, problem, state, t, h, noise):
        """Make one step."""
        return Step((1.0 - self.theta * h) * state + noise.dW)


def parts(paths=3, rows=2):
    """Return a state of two parts."""
    return TwoParts(np.ones((rows, paths)), np.full((1, paths), 2.0))


PROBLEM = SDE(
    drift=lambda t, x: -x,
    diffusion=lambda t, x: np.ones((1, 1, 1)),
    start=[2.0],
    horizon=1.0,
    noise_dim=1,
    source="made up",
)


def test_all_memory_of_a_state_is_one_array():
    """Parts are put below each other; a plain array is its own memory."""
    assert flatten(parts()).tolist() == [[1.0] * 3, [1.0] * 3, [2.0] * 3]
    x = np.ones((2, 3))
    assert flatten(x) is x


def test_a_state_of_the_same_kind_is_accepted():
    """Equal types and shapes pass without a word."""
    same_kind(parts(), Step(parts()))
    same_kind(np.ones((2, 3)), Step(np.zeros((2, 3))))


@pytest.mark.parametrize(
    ("before", "after", "given"),
    [
        (np.ones((2, 3)), np.ones((2, 1)), "ndarray of float64 (2, 1)"),
        (np.ones((2, 3)), np.ones((1, 3)), "ndarray of float64 (1, 3)"),
        (np.ones((2, 3)), parts(), "TwoParts of float64 (2, 3), float64 (1, 3)"),
        (parts(), np.ones((3, 3)), "ndarray of float64 (3, 3)"),
        (parts(), tuple(parts()), "tuple of float64 (2, 3), float64 (1, 3)"),
        (parts(), OtherParts(*parts()), "OtherParts of float64 (2, 3), float64 (1, 3)"),
        (parts(), parts(rows=1), "TwoParts of float64 (1, 3), float64 (1, 3)"),
        (np.ones((2, 3)), np.ones((2, 3)) + 0j, "ndarray of complex128 (2, 3)"),
        (np.ones((2, 3)), None, "NoneType of object ()"),
    ],
)
def test_a_state_of_another_kind_is_refused_in_one_line(before, after, given):
    """The message names what came back and what was expected."""
    with pytest.raises(SchemeError) as caught:
        same_kind(before, Step(after))
    text = str(caught.value)
    assert text.startswith(f"step returned {given}, expected a state like the one it was given, ")
    assert type(before).__name__ in text.rpartition("given, ")[2]
    assert "\n" not in text


def test_a_bare_state_is_no_step():
    """A step that forgets to wrap its state is told what to return."""
    with pytest.raises(SchemeError, match=r"step returned ndarray, expected Step\(state\)"):
        same_kind(np.ones((2, 3)), np.ones((2, 3)))


@pytest.mark.parametrize(
    ("quantities", "measure", "quantity", "covered"),
    [
        ((), "strong", "r", True),
        ((), "drift", "r", False),
        (("r", "v"), "strong", "v", True),
        (("r", "v"), "strong", "mu", False),
        (("r", "v"), "drift", "v", False),
        (("r",), "strong", "r@T", True),
        (("r@T",), "strong", "r@T", True),
        (("r@T",), "strong", "r", False),
    ],
)
def test_a_claim_covers_its_measure_and_its_quantities(quantities, measure, quantity, covered):
    """Without quantities it is about all of its measure, never about another one."""
    claim = Claim(measure="strong", value=1.0, source="Theorem 1", quantities=quantities)
    assert claim.covers(measure, quantity) is covered


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("measure", 3),
        ("measure", ""),
        ("value", [1]),
        ("value", None),
        ("value", True),
        ("margin", "wide"),
        ("source", ""),
        ("source", None),
        ("quantities", "x"),
        ("quantities", ("",)),
        ("when", "stiff"),
        ("bound", "small"),
    ],
)
def test_a_field_of_a_claim_that_is_of_another_type(field, value):
    """It is told in one line that names the field, in Python as elsewhere."""
    told = {"measure": "strong", "value": 1.0, "source": "Theorem 1", field: value}
    with pytest.raises(UsageError, match=f"^{field} of a claim expects .*, got ") as caught:
        Claim(**told)
    assert repr(value) in str(caught.value)


def test_a_claim_reads_as_words():
    """An order is a lower bound, anything else stands for itself."""
    assert str(Claim(measure="strong", value=0.5, source="x")) == "order >= 0.5"
    assert str(Claim(measure="drift", value="round-off", source="x")) == "round-off"


@pytest.mark.parametrize(
    ("scheme", "label"),
    [
        (Damped(), "damped"),
        (Damped(theta=0.5), "damped[theta=0.5]"),
        (Damped(kind="odd", theta=2.0), "damped[theta=2,kind=odd]"),
    ],
)
def test_a_label_shows_what_differs_from_the_defaults(scheme, label):
    """Parameters stand in the order of their declaration."""
    assert scheme.label == label


def test_a_prepared_stepper_makes_the_scheme_s_step():
    """`prepare` fixes problem and step size of `step`."""
    noise = Increment(np.full((1, 3), 0.5), np.zeros((1, 3)))
    stepper = Damped(theta=2.0).prepare(PROBLEM, 0.25)
    assert stepper(np.ones((1, 3)), 0.0, noise).state.tolist() == [[1.0] * 3]


def test_a_scheme_starts_where_the_problem_does_and_refuses_nothing():
    """The base class offers the problem's initial state and accepts every problem of its form."""
    assert Damped().start(PROBLEM, 3, 0.1).tolist() == [[2.0] * 3]
    assert Damped().refuses(PROBLEM) == ""


def test_a_scheme_has_to_write_its_step():
    """The base class has no step of its own."""
    with pytest.raises(NotImplementedError):
        Scheme.step(Damped(), PROBLEM, np.ones((1, 3)), 0.0, 0.1, Increment(np.ones((1, 3)), np.ones((1, 3))))


def test_a_step_reports_nothing_by_default():
    """Failures, truncations and further outputs are optional."""
    step = Step(np.ones((1, 3)))
    assert (step.failed, step.truncated, dict(step.outputs)) == (None, None, {})


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"value": ""}, "an order or words"),
        ({"value": -1.0}, "larger than its margin"),
        ({"margin": 0.0}, "larger than its margin"),
        ({"margin": 1.0}, "larger than its margin"),
        ({"value": float("inf")}, "finite"),
        ({"when": frozenset({"no-noise"})}, "unknown traits"),
    ],
)
def test_claims_that_say_nothing_are_refused(changes, words):
    """A claim needs a positive order or round-off, and a positive margin."""
    with pytest.raises(SchemeError, match=words):
        Claim(**{"measure": "strong", "value": 1.0, "source": "test", **changes})
