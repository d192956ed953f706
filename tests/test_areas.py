"""Levy areas and second space-time areas: Chen's relation, variances, and what they leave as it was."""

from dataclasses import replace

import numpy as np
import pytest

from facade import Brownian, known_part, noncommuting, outer, pairs
from joined_noise import aggregate
from sdaeverify import Increment, ProblemError, SchemeError
from sdaeverify.numerics import antisymmetric
from sdaeverify.studying import Source

SOURCE = Source(20261122, "areas", 0, 40000)
ALL, AREAS, USUAL = frozenset({"dW", "H", "K", "A"}), frozenset({"dW", "H", "A"}), frozenset({"dW", "H"})
H = 0.5
# A mean of n numbers is off by more than this many standard errors once in two million times.
SIGMAS = 5.0


@pytest.fixture(scope="module")
def levels():
    """Return four levels of a coarsest step of three Brownian motions with all there is."""
    return next(Brownian(SOURCE, 3, H, 3, ALL).steps())


def standardised(values, expected):
    """Return how many standard errors a mean is off, for each row."""
    error = values.std(axis=-1, ddof=1) / np.sqrt(values.shape[-1])
    return np.abs(values.mean(axis=-1) - expected) / error


@pytest.mark.parametrize("level", range(3))
def test_neighbours_make_the_longer_step(level, levels):
    """Every field of every level is what two steps of the next one make: Chen's relation, to rounding."""
    made = aggregate(levels[level + 1])
    for name in ("dW", "H", "K", "A"):
        np.testing.assert_allclose(getattr(levels[level], name), getattr(made, name), rtol=0.0, atol=1e-14)


def test_areas_change_nothing_else():
    """The same stream without areas has the same dW and H, to the last bit."""
    few = SOURCE._replace(paths=7)
    with_areas, without = (next(Brownian(few, 3, H, 3, fields).steps()) for fields in (AREAS, USUAL))

    for one, other in zip(with_areas, without, strict=True):
        np.testing.assert_array_equal(one.dW, other.dW)
        np.testing.assert_array_equal(one.H, other.H)


def test_pieces_have_the_areas_of_their_steps():
    """Pieces of a level, one after the other, are its steps, and come in the same order as without areas."""
    few = SOURCE._replace(paths=3)
    pieces = list(next(Brownian(few, 2, H, 6, AREAS).pieces()))
    plain = [(level, len(noise.dW)) for level, noise in next(Brownian(few, 2, H, 6).pieces())]
    whole = next(Brownian(few, 2, H, 6, AREAS).steps())

    assert [(level, len(noise.dW)) for level, noise in pieces] == plain
    for level, expected in enumerate(whole):
        found = np.concatenate([noise.A for at, noise in pieces if at == level])
        np.testing.assert_array_equal(found, expected.A)


@pytest.mark.parametrize("level", range(4))
def test_areas_have_the_moments_of_the_theory(level, levels):
    """E A = 0, E A_ij^2 = h^2/4, E A_ij A_ik = 0, and E A_ij H_i dW_j = h^2/12."""
    noise, h = levels[level], H / 2**level
    A, i, j = noise.A[0], *pairs(3)

    assert (standardised(A, 0.0) < SIGMAS).all()
    assert (standardised(A**2, h**2 / 4.0) < SIGMAS).all()
    assert (standardised(A[[0, 0, 1]] * A[[1, 2, 2]], 0.0) < SIGMAS).all()
    assert (standardised(A * noise.H[0][i] * noise.dW[0][j], h**2 / 12.0) < SIGMAS).all()


def test_dw_and_its_integrals_explain_the_areas_of_finer_paths(levels):
    """What they leave of the area of eight finest steps has mean 0 given each of them, and variance h^2/20."""
    coarse = levels[0]
    rest = (coarse.A - known_part(coarse.dW, coarse.H, coarse.K))[0]

    for a, b in ((coarse.H, coarse.dW), (coarse.K, coarse.H), (coarse.K, coarse.dW)):
        assert (standardised(rest * outer(a, b)[0], 0.0) < SIGMAS).all()
    assert (standardised(rest**2, H**2 / 20.0) < SIGMAS).all()


@pytest.mark.parametrize("level", [0, 2])
def test_second_areas_are_independent_with_their_variance(level, levels):
    """E K^2 = h/720, and K is independent of dW and H."""
    noise, h = levels[level], H / 2**level

    assert (standardised(noise.K[0] ** 2, h / 720.0) < SIGMAS).all()
    assert (standardised(noise.K[0] * noise.dW[0], 0.0) < SIGMAS).all()
    assert (standardised(noise.K[0] * noise.H[0], 0.0) < SIGMAS).all()


def test_second_area_is_the_time_integral():
    """K of a step is the integral of (W(s) - s dW/h) (h/2 - s)/h^2, here by midpoints of 2048 short ones."""
    *_, fine = levels = next(Brownian(SOURCE._replace(paths=5), 1, H, 11, ALL).steps())
    n = len(fine.dW)
    before = np.concatenate([np.zeros((1, 5)), np.cumsum(fine.dW[:, 0], axis=0)[:-1]])
    means = before + 0.5 * fine.dW[:, 0] + fine.H[:, 0]
    s = (np.arange(n)[:, None] + 0.5) * H / n

    integral = ((means - s * levels[0].dW[0] / H) * (0.5 * H - s)).sum(axis=0) / (n * H)
    np.testing.assert_allclose(levels[0].K[0, 0], integral, atol=1e-3 * np.sqrt(H / 720.0))


def test_double_integrals_are_those_of_ito():
    """I_ij + I_ji = dW_i dW_j, I_ii = (dW_i^2 - h)/2 and I_ij - I_ji = 2 A_ij."""
    noise = Increment(np.array([[0.3], [-0.5]]), None, A=np.array([[0.1]]))

    found = noise.double_integrals(0.25)[..., 0]
    np.testing.assert_allclose(found, [[-0.08, 0.025], [-0.175, 0.0]], atol=1e-16)


def test_one_brownian_motion_has_no_area():
    """Its double integral needs none; of two it does, and who does not draw it is told how."""
    one, two = (Increment(np.ones((l, 1)), None) for l in (1, 2))

    np.testing.assert_allclose(one.double_integrals(0.5)[0, 0], 0.25)
    words = r"A is not drawn for this problem, which needs noise=frozenset\({'dW', 'H', 'A'}\) for it; a scheme"
    with pytest.raises(SchemeError, match=words):
        two.double_integrals(0.5)


def test_matrix_of_areas_is_antisymmetric():
    """A_ij = -A_ji."""
    A = antisymmetric(np.arange(1.0, 4.0)[:, None], 3)[..., 0]

    np.testing.assert_array_equal(A, [[0, 1, 2], [-1, 0, 3], [-2, -3, 0]])


def test_problem_with_areas_has_time_integrals():
    """Areas are drawn around what dW and H tell of them."""
    with pytest.raises(ProblemError, match="noise must be dW, or dW and H with K or A or both"):
        replace(noncommuting(), noise=frozenset({"dW", "A"}))
