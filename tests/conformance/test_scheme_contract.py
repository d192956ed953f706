"""Every registered scheme keeps the contract of a step, on every problem it can be put to."""

import dataclasses
import pickle

import numpy as np
import pytest

from conformance.cells import Cell, copied, driving, fields, prepared, spread, step, take
from sdaeverify.forms import NOISE, TRAITS
from sdaeverify.noise import Increment
from sdaeverify.registry import Registry
from sdaeverify.scheme import Scheme, State, Step, flatten, same_kind

PATHS = 64
# Each path among five, and every fourth alone.
BATCHES = [slice(n, n + size) for size, every in ((5, 5), (1, 4)) for n in range(0, PATHS, every)]
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


@pytest.fixture(scope="module")
def made(cell: Cell, state: State, h: float, noise: Increment) -> Step:
    """Return the step of all paths, with which others are compared."""
    return step(cell, state, h, noise)


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


def test_a_step_is_a_function(cell: Cell, state: State, h: float, noise: Increment, made: Step) -> None:
    """The same input gives the same bits."""
    again = step(cell, state, h, noise)

    assert equal(made.state, again.state)
    assert made.outputs.keys() == again.outputs.keys()
    assert all(np.array_equal(made.outputs[name], again.outputs[name]) for name in made.outputs)


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


def test_a_new_state_is_no_view_of_the_noise(noise: Increment, made: Step) -> None:
    """The new state does not share memory with the noise, which is drawn afresh."""
    assert not any(np.may_share_memory(a, b) for a in fields(made.state) for b in noise[:2])


def test_paths_do_not_see_their_neighbours(cell: Cell, state: State, h: float, noise: Increment, made: Step) -> None:
    """A path in a small batch, or alone, goes where it goes in a large one."""
    stepper = prepared(cell, h)
    for some in BATCHES:
        assert_close(stepper(take(state, some), take(noise, some)).state, take(made.state, some))


def test_paths_can_be_reordered(cell: Cell, state: State, h: float, noise: Increment, made: Step) -> None:
    """Permuting the paths permutes the results."""
    order = np.random.default_rng(3).permutation(PATHS)

    permuted = step(cell, take(state, order), h, take(noise, order)).state

    assert_close(permuted, take(made.state, order))


def test_a_step_returns_a_state_like_the_one_given(cell: Cell, h: float) -> None:
    """State, flags and outputs have the number of paths that was given."""
    for paths in (1, 3):
        given = cell.scheme.start(cell.problem, paths, cell.problem.horizon / PATHS)

        result = step(cell, given, h, driving(cell.problem, paths, h))

        same_kind(given, result)
        assert all(array.shape[-1] == paths for array in (*fields(result.state), *result.outputs.values()))
        masks = [mask for mask in (result.failed, result.truncated) if mask is not None]
        assert all(mask.shape == (paths,) and mask.dtype == np.bool_ for mask in masks)


def test_a_step_uses_the_increment_of_the_brownian_motion(cell: Cell, state: State, h: float) -> None:
    """Noise of the other sign or of half the size gives another state, on every path where a step is made at all.

    A linear step may by chance be even in dW, or constant on one side of 0, at one step size.
    """
    noise = driving(cell.problem, PATHS, h, block=1)
    steps = [step(cell, state, h, noise._replace(dW=s * noise.dW, H=s * noise.H)) for s in (1.0, -1.0, 0.5)]
    new, opposite, half = (flatten(made.state) for made in steps)
    changed = np.any((new != opposite) | (new != half), axis=0)
    # A step that fails may stay where it was, whatever the noise.
    failed = np.all([np.zeros(PATHS, dtype=bool) if made.failed is None else made.failed for made in steps], axis=0)

    assert changed.any()
    assert np.all(changed | failed)


def test_a_scheme_uses_the_noise_it_declares_and_no_other(
    cell: Cell, state: State, h: float, noise: Increment, made: Step
) -> None:
    """Noise that a scheme does not declare may be anything, even no number, and changes nothing."""
    nothing = np.full_like(noise.dW, np.nan)
    others = dict.fromkeys((NOISE | {"xi"}) - cell.scheme.noise, nothing)

    result = step(cell, state, h, noise._replace(**others))

    assert equal(result.state, made.state)


def test_a_scheme_says_where_it_is_from(scheme: Scheme) -> None:
    """Class and step are described, and the scheme has a source."""
    assert (type(scheme).__doc__ or "").strip()
    assert (type(scheme).step.__doc__ or "").strip()
    assert scheme.source.strip()


@pytest.fixture(scope="session")
def negative(registry: Registry) -> set[str]:
    """Return the schemes that are there to be refuted."""
    problems = [entry.make().build() for entry in registry.problems.values()]
    return {control.negative for problem in problems for control in problem.controls}


def test_claims_can_be_verified(scheme: Scheme, registry: Registry, negative: set[str]) -> None:
    """Each claim has a source, names a registered measure, and asks for traits that exist."""
    assert scheme.claims or scheme.name in negative
    for claim in scheme.claims:
        assert claim.source.strip()
        assert claim.measure in registry.measures
        assert claim.when <= TRAITS


def test_a_scheme_is_a_value(scheme: Scheme) -> None:
    """A scheme survives pickling, equals its copy, and cannot be changed."""
    copy = pickle.loads(pickle.dumps(scheme))

    assert copy == scheme
    assert hash(copy) == hash(scheme)
    assert copy.label == scheme.label
    with pytest.raises(dataclasses.FrozenInstanceError):
        scheme.name = "other"  # type: ignore[misc]
