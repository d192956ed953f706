"""The contract of a scheme: claims, states, and the defaults of the base class."""

from typing import NamedTuple

import numpy as np
import pytest

from facade import flatten, same_kind
from sdaeverify import Array, Claim, SchemeError, Step, UsageError
from sdaeverify.arrays import each


class TwoParts(NamedTuple):
    """A state of two arrays."""

    r: Array
    mu: Array


class OtherParts(NamedTuple):
    """The same arrays under other names."""

    q: Array
    p: Array


def parts(paths=3, rows=2):
    """Return a state of two parts."""
    return TwoParts(np.ones((rows, paths)), np.full((1, paths), 2.0))


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


@pytest.mark.parametrize(
    ("mu", "given"),
    [
        (False, "bool of shape ()"),
        (None, "NoneType of shape ()"),
        (np.zeros(3), "ndarray of shape (3,)"),
        (np.zeros((1, 1)), "ndarray of shape (1, 1)"),
    ],
)
def test_a_field_that_is_no_array_of_rows_and_paths_is_named(mu, given):
    """A flag, or an array without rows, in the memory of a scheme is named with the shape that is expected."""
    with pytest.raises(SchemeError) as caught:
        flatten(parts()._replace(mu=mu))
    expected = "expected an array of shape (k, 3)"
    assert str(caught.value) == f"field mu of the state is {given}, {expected}"


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
    ("changes", "words"),
    [
        ({"value": ""}, "an order or words"),
        ({"value": -1.0}, "larger than its margin"),
        ({"margin": 0.0}, "larger than its margin"),
        ({"margin": 1.0}, "larger than its margin"),
        ({"margin": 0.5}, "less than 1/2"),
        ({"value": 2.0, "margin": 0.6}, "less than 1/2"),
        ({"value": float("inf")}, "finite"),
        ({"when": frozenset({"no-noise"})}, "unknown traits"),
    ],
)
def test_claims_that_say_nothing_are_refused(changes, words):
    """A claim needs a positive order or round-off, and a positive margin."""
    with pytest.raises(SchemeError, match=words):
        Claim(**{"measure": "strong", "value": 1.0, "source": "test", **changes})


def test_a_plain_tuple_as_a_state_is_named():
    """It was made by `tuple(x, y)`, whose error says nothing of states."""
    x = np.zeros((1, 3))
    with pytest.raises(
        TypeError, match="is a NamedTuple, such as the one that the step was given; got a plain tuple of 2"
    ):
        each(np.copy, (x, x))
    assert each(np.copy, TwoParts(x, x)).__class__ is TwoParts
