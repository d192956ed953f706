"""Noise by address: what refinement keeps, what the covariances are, and which numbers share a stream."""

from itertools import pairwise

import hypothesis.extra.numpy as hnp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from facade import LONGEST, Brownian, fingerprint
from joined_noise import aggregate
from sdaeverify import Increment, SchemeError
from sdaeverify.studying import LevelNoise, Source

EPS = np.finfo(float).eps
SOURCE = Source(seed=7, problem="gbm[sigma=0.5]", block=3, paths=5)

numbers = st.floats(-1e3, 1e3, allow_subnormal=False)
steps = hnp.arrays(float, (2, 1, 3), elements=numbers)


def take(source, count, finest, dimension=2, h=0.25):
    """Draw the noise of the first coarsest steps."""
    stream = Brownian(source, dimension, h, finest).steps()
    return [next(stream) for _ in range(count)]


def unit_levels(h, finest):
    """Push the identity through the refinements: column k of every level is its response to the k-th normal."""
    count = 2 ** (finest + 1)
    normals = iter(np.eye(count).reshape(count, 1, count))
    levels = [LevelNoise(np.sqrt(h) * next(normals)[None], np.sqrt(h / 12) * next(normals)[None])]
    for level in range(finest):
        xi = np.stack([next(normals) for _ in range(2 * 2**level)]).reshape(2, 2**level, 1, count)
        levels.append(levels[-1].halved(h / 2**level, xi))
    return levels


def as_matrix(noise):
    """Return the rows dW_1, H_1, dW_2, H_2, ... of a level, shape (2 steps, normals)."""
    return np.stack([noise.dW, noise.H], axis=1).reshape(-1, noise.dW.shape[-1])


@given(dW=steps, H=steps, xi=hnp.arrays(float, (2, 2, 1, 3), elements=numbers), h=st.floats(1e-6, 10.0))
def test_aggregating_undoes_refining(dW, H, xi, h):
    """Joining the halves returns the step they came from, up to a few roundings of the terms that cancel."""
    joined = aggregate(LevelNoise(dW, H).halved(h, xi))
    size = np.abs(dW) + 6.0 * np.abs(H) + np.sqrt(h) * np.abs(xi).sum(axis=0)
    bound = 8.0 * EPS * size + np.finfo(float).tiny
    assert (np.abs(joined.dW - dW) <= bound).all()
    assert (np.abs(joined.H - H) <= bound).all()


@pytest.mark.parametrize("h", [0.3, 1.0, 2.0**-11])
@pytest.mark.parametrize("level", [0, 1, 2, 3])
def test_refined_increments_are_independent_with_the_right_variances(h, level):
    """As a linear map of unit normals every level has covariance diag(h_l, h_l/12, h_l, h_l/12, ...)."""
    A = as_matrix(unit_levels(h, 3)[level])
    step = h / 2**level
    variances = np.tile([step, step / 12], 2**level)
    scale = np.sqrt(np.outer(variances, variances))
    # Each of the 16 products is off by a few roundings for every level passed.
    assert (np.abs(A @ A.T - np.diag(variances)) <= 64 * EPS * scale).all()


def test_time_integrals_of_fine_steps_add_up_to_the_coarse_one():
    """Over a coarse step the integral is the sum over fine steps of h_f (W(t_k) - W(t)) + I_k (Chen)."""
    (levels,) = take(SOURCE, 1, 3, h=0.25)
    fine, h = levels[3], 0.25 / 8
    start = np.cumsum(fine.dW, axis=0) - fine.dW
    pieces = h * start + np.stack([fine.increment(k).time_integral(h) for k in range(8)])
    size = 0.25 * (np.abs(fine.dW).sum(axis=0) + np.abs(fine.H).sum(axis=0))
    difference = pieces.sum(axis=0) - levels[0].increment(0).time_integral(0.25)
    assert (np.abs(difference) <= 64 * EPS * size).all()


def test_a_finer_level_leaves_coarser_ones_bit_identical():
    """Levels 0 and 1 do not change when levels 2 and 3 are asked for."""
    for coarse, fine in zip(take(SOURCE, 3, 1), take(SOURCE, 3, 3), strict=True):
        for a, b in zip(coarse, fine, strict=False):
            assert np.array_equal(a.dW, b.dW)
            assert np.array_equal(a.H, b.H)


def test_the_same_address_gives_the_same_bits():
    """Noise is a function of its address and does not depend on what was drawn before or in between."""
    other = Brownian(SOURCE._replace(block=0), 2, 0.25, 2).steps()
    stream = Brownian(SOURCE, 2, 0.25, 2).steps()
    interleaved = [(next(other), next(stream))[1] for _ in range(3)]
    for a, b in zip(interleaved, take(SOURCE, 3, 2), strict=True):
        assert all(np.array_equal(x.dW, y.dW) and np.array_equal(x.H, y.H) for x, y in zip(a, b, strict=True))


@pytest.mark.parametrize("change", [{"block": 4}, {"seed": 8}, {"problem": "gbm"}])
def test_different_addresses_give_different_numbers(change):
    """Another block, seed or problem shares no number with this one."""
    (mine,), (other,) = take(SOURCE, 1, 1), take(SOURCE._replace(**change), 1, 1)
    for a, b in zip(mine, other, strict=True):
        assert not np.isin(a.dW, b.dW).any()
        assert not np.isin(a.H, b.H).any()


def test_purposes_and_levels_have_different_streams():
    """Within one block another level or purpose gives other numbers."""
    addresses = [("brownian", 0), ("brownian", 1), ("truth", 0)]
    first = {float(SOURCE.stream(purpose, level).standard_normal()) for purpose, level in addresses}
    assert len(first) == len(addresses)


@pytest.mark.parametrize(("level", "block"), [(0, 0), (1, 0), (5, 123456)])
def test_drawing_moves_the_low_words_of_the_counter_only(level, block):
    """Level and block are the high words of the counter, so that streams of one key can never overlap."""
    stream = SOURCE._replace(block=block).stream("brownian", level)
    stream.standard_normal(10_000)
    counter = stream.bit_generator.state["state"]["counter"].tolist()
    assert counter[1:] == [0, level, block]
    # Four words a count, a normal takes one or (seldom) a few.
    assert 10_000 / 4 <= counter[0] <= 10_000


def test_drawn_noise_is_read_only():
    """Neither a level nor the increment of one step can be written into."""
    (levels,) = take(SOURCE, 1, 2)
    increments = [noise.increment(0) for noise in levels]
    arrays = [array for noise in (*levels, *increments) for array in (noise.dW, noise.H)]
    assert not any(array.flags.writeable for array in arrays)


def test_the_fingerprint_tells_seeds_apart():
    """The fingerprint is a short text, the same for the same seed."""
    assert fingerprint(1) == fingerprint(1)
    assert fingerprint(1) != fingerprint(2)
    assert len(fingerprint(1)) == 16


def sample(h=0.25):
    """Return (dW_1, H_1, dW_2, H_2) of two motions over their standard deviations, shape (8, 65536)."""
    drawn = take(SOURCE._replace(paths=4096), 16, 1, h=h)
    rows = [[n.dW[0], n.H[0], n.dW[1], n.H[1]] for _, n in drawn]
    z = np.array(rows) / np.sqrt(np.array([h / 2, h / 24] * 2))[:, None, None]
    return z.transpose(1, 2, 0, 3).reshape(8, -1)


def smallest_p_value(z):
    """Test that the rows are independent unit normals: sums of squares of z_i and (z_i +- z_j)/sqrt 2 are chi^2."""
    i, j = np.triu_indices(len(z), 1)
    rows = np.concatenate([z, (z[i] + z[j]) / np.sqrt(2), (z[i] - z[j]) / np.sqrt(2)])
    law, squares = stats.chi2(z.shape[1]), (rows**2).sum(axis=1)
    p = 2 * np.minimum(law.cdf(squares), law.sf(squares))
    return len(rows) * p.min()


def test_drawn_noise_has_the_stated_covariance():
    """On 65536 samples no variance and no covariance is off at the level 1e-6 (Bonferroni)."""
    assert smallest_p_value(sample()) > 1e-6


def test_pieces_are_short_and_come_in_time_order():
    """No piece is longer than the limit, however fine the level, and those of a level join without a gap."""
    finest = 9
    pieces = list(next(Brownian(SOURCE, 1, 0.25, finest).pieces()))

    assert max(len(noise.dW) for _, noise in pieces) == LONGEST
    for level in range(finest + 1):
        joined = np.concatenate([noise.dW for at, noise in pieces if at == level])
        assert len(joined) == 2**level
        assert joined.sum(axis=0) == pytest.approx(pieces[0][1].dW[0], abs=2**finest * EPS)


def test_a_piece_comes_before_the_finer_ones_inside_it():
    """Depth first: when a level has come to some time, no finer level is behind by more than a piece."""
    done = [0.0] * 8
    for level, noise in next(Brownian(SOURCE, 1, 1.0, 7).pieces()):
        done[level] += len(noise.dW) / 2**level
        assert all(coarse >= fine for coarse, fine in pairwise(done))
    assert done == [1.0] * 8


def test_using_fewer_paths_leaves_them_as_they_are():
    """A block of which only some paths are used gives these the same numbers."""
    few = next(Brownian(SOURCE._replace(used=2), 2, 0.25, 3).pieces())
    every = next(Brownian(SOURCE, 2, 0.25, 3).pieces())

    for (_, one), (_, other) in zip(few, every, strict=True):
        assert np.array_equal(one.dW, other.dW[..., :2])
        assert np.array_equal(one.H, other.H[..., :2])


def test_without_areas_increments_are_independent_with_the_right_variances():
    """Halving dW alone gives two independent increments: (W + D)/2 and (W - D)/2 with D of variance h."""
    h, normals = 0.3, np.eye(2)
    fine = LevelNoise(np.sqrt(h) * normals[0].reshape(1, 1, 2), None).halved(h, normals[1].reshape(1, 1, 1, 2))

    A = fine.dW[:, 0]
    assert pytest.approx(np.diag([h / 2, h / 2]), abs=8 * EPS) == A @ A.T
    assert fine.H is None
    assert aggregate(fine).dW == pytest.approx(np.sqrt(h) * normals[0].reshape(1, 1, 2), abs=8 * EPS)


def test_areas_that_are_not_drawn_are_asked_for_in_vain():
    """The time integral needs H, and says so in one line."""
    with pytest.raises(SchemeError, match="H is not drawn for this problem"):
        Increment(np.ones((1, 1)), None).time_integral(0.1)
