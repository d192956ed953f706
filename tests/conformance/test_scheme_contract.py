"""Every registered scheme keeps the contract of a step, on every problem it can be put to."""

import dataclasses
import pickle

import numpy as np
import pytest

from conformance.cells import Cell, copied, driving, fields, spread, step, take
from sdaeverify.forms import NOISE, TRAITS
from sdaeverify.noise import Increment
from sdaeverify.registry import load_registry
from sdaeverify.scheme import Scheme, State, flatten, same_kind

PATHS = 64
EPS = np.finfo(float).eps


@pytest.fixture(params=[64, 2], ids=["fine", "coarse"], scope="module")
def h(request: pytest.FixtureRequest, cell: Cell) -> float:
    """Return a step size at which nothing special happens, and one at which truncation does."""
    return cell.problem.horizon / request.param


@pytest.fixture(scope="module")
def state(cell: Cell) -> State:
    return spread(cell.scheme, cell.problem, PATHS)


@pytest.fixture(scope="module")
def noise(cell: Cell, h: float) -> Increment:
    return driving(cell.problem, PATHS, h, block=PATHS)


def equal(left: State, right: State) -> bool:
    pairs = zip(fields(left), fields(right), strict=True)
    return all(np.array_equal(a, b, equal_nan=True) for a, b in pairs)


def assert_close(left: State, right: State) -> None:
    """Assert that two states agree within 32 eps of the largest component of each path.

    Sums may be taken in another order, and iterations for a root end within some 9 eps of it on either side.
    """
    a, b = flatten(left), flatten(right)
    scale = np.maximum(1.0, np.abs(b).max(axis=0))

    assert np.isfinite(b).all()
    assert np.all(np.abs(a - b) <= 32 * EPS * scale)


def test_a_step_is_a_function(cell: Cell, state: State, h: float, noise: Increment) -> None:
    """The same input gives the same bits."""
    once, again = (step(cell, state, h, noise) for _ in range(2))

    assert equal(once.state, again.state)
    assert once.outputs.keys() == again.outputs.keys()
    assert all(np.array_equal(once.outputs[name], again.outputs[name]) for name in once.outputs)


def test_a_step_leaves_its_inputs_alone(cell: Cell, state: State, h: float, noise: Increment) -> None:
    """Nothing is written into the state or the noise."""
    mine, its = copied(state), copied(noise)

    step(cell, mine, h, its)

    assert equal(mine, state)
    assert equal(its[:2], noise[:2])


def test_a_step_accepts_read_only_inputs(cell: Cell, state: State, h: float, noise: Increment) -> None:
    """A step works on arrays that cannot be written into."""
    assert not any(array.flags.writeable for array in (*fields(state), *noise[:2]))

    step(cell, state, h, noise)


def test_a_new_state_is_no_view_of_the_noise(cell: Cell, state: State, h: float, noise: Increment) -> None:
    """The new state does not share memory with the noise, which is drawn afresh."""
    new = step(cell, state, h, noise).state

    assert not any(np.may_share_memory(a, b) for a in fields(new) for b in noise[:2])


@pytest.mark.parametrize("size", [1, 5])
def test_paths_do_not_see_their_neighbours(cell: Cell, state: State, h: float, noise: Increment, size: int) -> None:
    """A path in a small batch goes where it goes in a large one."""
    together = step(cell, state, h, noise).state
    for first in range(0, PATHS, size):
        some = slice(first, first + size)
        assert_close(step(cell, take(state, some), h, take(noise, some)).state, take(together, some))


def test_paths_can_be_reordered(cell: Cell, state: State, h: float, noise: Increment) -> None:
    """Permuting the paths permutes the results."""
    order = np.random.default_rng(3).permutation(PATHS)

    permuted = step(cell, take(state, order), h, take(noise, order)).state

    assert_close(permuted, take(step(cell, state, h, noise).state, order))


@pytest.mark.parametrize("paths", [1, 3])
def test_a_step_returns_a_state_like_the_one_given(cell: Cell, h: float, paths: int) -> None:
    """State, flags and outputs have the number of paths that was given."""
    given = cell.scheme.start(cell.problem, paths, cell.problem.horizon / PATHS)

    result = step(cell, given, h, driving(cell.problem, paths, h))

    same_kind(given, result)
    assert all(array.shape[-1] == paths for array in (*fields(result.state), *result.outputs.values()))
    masks = [mask for mask in (result.failed, result.truncated) if mask is not None]
    assert all(mask.shape == (paths,) and mask.dtype == np.bool_ for mask in masks)


def test_a_step_uses_the_increment_of_the_brownian_motion(cell: Cell, state: State, h: float) -> None:
    """Noise of the other sign or of half the size gives another state, on every path.

    A linear step may by chance be even in dW, or constant on one side of 0, at one step size.
    """
    noise = driving(cell.problem, PATHS, h, block=1)
    new, opposite, half = (
        flatten(step(cell, state, h, noise._replace(dW=s * noise.dW, H=s * noise.H)).state) for s in (1.0, -1.0, 0.5)
    )

    assert np.all(np.any((new != opposite) | (new != half), axis=0))


def test_a_scheme_uses_the_noise_it_declares_and_no_other(
    cell: Cell, state: State, h: float, noise: Increment
) -> None:
    """Noise that a scheme does not declare may be anything, even no number, and changes nothing."""
    nothing = np.full_like(noise.dW, np.nan)
    others = dict.fromkeys((NOISE | {"xi"}) - cell.scheme.noise, nothing)

    result = step(cell, state, h, noise._replace(**others))

    assert equal(result.state, step(cell, state, h, noise).state)


def test_a_scheme_says_where_it_is_from(scheme: Scheme) -> None:
    """Class and step are described, and the scheme has a source."""
    assert (type(scheme).__doc__ or "").strip()
    assert (type(scheme).step.__doc__ or "").strip()
    assert scheme.source.strip()


def test_claims_can_be_verified(scheme: Scheme) -> None:
    """Each claim has a source, names a registered measure, and asks for traits that exist."""
    registry = load_registry(environ={})
    measures, problems = registry.measures, [entry.make().build() for entry in registry.problems.values()]
    negative = {control.negative for problem in problems for control in problem.controls}

    # Who claims nothing is there to be refuted.
    assert scheme.claims or scheme.name in negative
    for claim in scheme.claims:
        assert claim.source.strip()
        assert claim.measure in measures
        assert claim.when <= TRAITS


def test_a_scheme_is_a_value(scheme: Scheme) -> None:
    """A scheme survives pickling, equals its copy, and cannot be changed."""
    copy = pickle.loads(pickle.dumps(scheme))

    assert copy == scheme
    assert hash(copy) == hash(scheme)
    assert copy.label == scheme.label
    with pytest.raises(dataclasses.FrozenInstanceError):
        scheme.name = "other"  # type: ignore[misc]
