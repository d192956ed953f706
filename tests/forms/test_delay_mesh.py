"""Meshes against a delay, and the lagged values of a run against a list of all its states."""

from math import floor

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from facade import Mesh
from sdaeverify import Array, Increment
from sdaeverify.forms.delay.mesh import Recall

EPS = np.finfo(float).eps
NONE = Increment(np.zeros((1, 2)), None)


def history(t: float) -> Array:
    """Return a history that no interpolation reproduces."""
    return np.array([[np.cos(3.0 * t)], [t * t]])


def walk(steps: int) -> Array:
    """Return x_0, x_1, ... of two components on two paths, x_0 being the history's."""
    states = np.random.default_rng(4).standard_normal((steps + 1, 2, 2))
    states[0] = history(0.0)
    return states


def lagged(states: Array, n: int, h: float, delay: float) -> Array:
    """Return the value at n h - delay of the states' linear interpolation, and of the history left of 0."""
    place = n - delay / h
    # A whole number of steps is one to rounding.
    if abs(place - round(place)) < 1e-9:
        place = float(round(place))
    if place <= 0.0:
        return np.broadcast_to(history(place * h), states.shape[1:])
    left = floor(place)
    share = place - left
    return states[left] if not share else (1.0 - share) * states[left] + share * states[left + 1]


@pytest.mark.parametrize(
    ("delay", "h", "m", "delta"),
    [
        (1.0, 0.125, 8, 0.0),
        (1.0, 1.0, 1, 0.0),
        (1.0, 0.3, 4, 2.0 / 3.0),
        (1.0, 4.0, 1, 0.75),
        (0.0, 0.1, 0, 0.0),
        # Neither of these is a whole number in floating point.
        (0.3, 0.1, 3, 0.0),
        (1.0, 0.9 / 9.0 / 10.0, 100, 0.0),
        (0.7, 0.7 / 49.0, 49, 0.0),
    ],
)
def test_a_delay_is_so_many_steps_less_a_part_of_one(delay: float, h: float, m: int, delta: float) -> None:
    """Tau = (m - delta) h with 0 <= delta < 1, a whole number being one in spite of rounding."""
    mesh = Mesh.of(delay, h)

    assert mesh.m == m
    assert mesh.delta == pytest.approx(delta, abs=8 * EPS)


@given(delay=st.floats(1e-3, 10.0), h=st.floats(1e-3, 10.0))
def test_any_delay_has_its_mesh(delay: float, h: float) -> None:
    """The decomposition holds to rounding for every delay and step size, and m is the least that is possible."""
    m, delta = Mesh.of(delay, h)

    assert m >= 1
    assert 0.0 <= delta < 1.0
    assert (m - delta) * h == pytest.approx(delay, rel=2e-11)


@pytest.mark.parametrize(("mesh", "weight"), [(Mesh(0, 0.0), 1.0), (Mesh(1, 0.3), 0.3), (Mesh(1, 0.0), 0.0)])
def test_the_unknown_has_a_weight_where_it_is_its_own_past(mesh: Mesh, weight: float) -> None:
    """It is 1 without delay, delta where the delay is shorter than a step, and 0 for two steps or more."""
    assert mesh.weight == weight
    assert Mesh(2, 0.3).weight == 0.0


@settings(max_examples=60)
@given(ratio=st.one_of(st.integers(1, 9).map(float), st.floats(0.05, 9.0)), steps=st.integers(1, 30))
def test_recalled_values_are_those_of_all_states(ratio: float, steps: int) -> None:
    """At every step of every mesh, what is recalled is what a list of all states gives."""
    h, states = 0.25, walk(steps)
    delay = ratio * h
    mesh = Mesh.of(delay, h)
    recall = Recall(mesh, h, delay, history, states[0])
    for n in range(steps):
        noise = recall.add_past(NONE)
        assert noise.lagged is not None
        assert noise.ahead is not None
        # Next to a whole number the two readings differ by a part 1e-9 of a step.
        np.testing.assert_allclose(noise.lagged, lagged(states, n, h, delay), atol=1e-7)
        complete = noise.ahead + (mesh.weight * states[n + 1] if n + 1 > mesh.m - mesh.delta else 0.0)
        np.testing.assert_allclose(complete, lagged(states, n + 1, h, delay), atol=1e-7)
        assert np.array_equal(recall.lagged(), noise.lagged)
        recall.push(states[n + 1])


@pytest.mark.parametrize("ratio", [0.4, 1.0, 2.5, 7.0])
def test_memory_does_not_grow_with_the_run(ratio: float) -> None:
    """At most m + 2 states are kept, however many steps are made."""
    states = walk(200)
    mesh = Mesh.of(ratio, 1.0)
    recall = Recall(mesh, 1.0, ratio, history, states[0])
    before = recall.ring.nbytes
    for state in states[1:]:
        recall.push(state)

    assert recall.ring.nbytes == before
    assert len(recall.ring) <= mesh.m + 2


def test_what_is_recalled_cannot_change_later() -> None:
    """A lagged value stays what it was when newer states take its place, and cannot be written into."""
    states = walk(8)
    recall = Recall(Mesh.of(1.0, 1.0), 1.0, 1.0, history, states[0])
    for n in range(3):
        recall.push(states[n + 1])
    found = recall.lagged()
    kept = found.copy()
    for n in range(3, 8):
        recall.push(states[n + 1])

    assert np.array_equal(found, kept)
    with pytest.raises(ValueError, match="read-only"):
        found += 1.0
