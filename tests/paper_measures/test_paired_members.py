"""Errors of the members of a family on the same noise: against exact moments, and where members are left out."""

from dataclasses import replace

import numpy as np
import pytest

from facade import ALL, FAILED, FINER, SHARE, STIFFEST, UniformlyAccurate, affine_constraint, paired_errors, run_of
from paper_measures.stiff_cells import Rootless
from sdaeverify import Settings
from sdaeverify.numerics import GROUPS
from sdaeverify.probing import moment_errors

PATHS = 1500
SETTINGS = Settings(paths=SHARE * PATHS, levels=3)
SCHEME, PROBLEM = UniformlyAccurate(), affine_constraint()
SMALL = replace(SETTINGS, paths=100, coarsest=2)


@pytest.fixture(scope="module")
def errors():
    """Return the evidence on the affine problem."""
    return paired_errors(SCHEME, PROBLEM, SETTINGS)


def exact(eps):
    """Return the exact errors of E x_1, E x_2, E x_1^2, E x_1 x_2 at all levels."""
    found = moment_errors(SCHEME, affine_constraint(eps), SETTINGS.steps)
    return np.stack([found.first[:, 0], found.first[:, 1], found.second[:, 0, 0], found.second[:, 0, 1]], axis=1)[:3]


@pytest.mark.long
def test_errors_agree_with_exact_moments(errors):
    """Means and changes of means are those of exact recursions, up to the error of sample and reference."""
    names = list(PROBLEM.observables)
    columns = [names.index(name) for name in ("x_1", "x_2", "x_1^2", "x_1 x_2")]
    groups = errors.weak[..., columns] / errors.counts[:, None, None]
    mean, se = groups.mean(axis=1), groups.std(axis=1, ddof=1) / np.sqrt(GROUPS)
    blur = np.abs(errors.blurred[..., columns].sum(axis=1)) / PATHS
    referenced = blur.max(axis=1) > 0.0
    known = np.stack([exact(eps) for eps in errors.eps])
    expected = np.where(referenced[:, None, None], known[:, :-1], known[:, :-1] - known[:, 1:])

    off = np.abs(mean - expected) - 2.0 * blur[:, None]
    assert (off <= 6.0 * se + 1e-12).all()
    # It is a small part of the largest errors that is left open.
    assert (6.0 * se).max() < np.abs(expected).max()


def test_euler_paths_serve_where_they_are_fine_enough(errors):
    """There is a reference where eps is at least 16 of its steps, and nowhere else."""
    step = errors.h[-1] / 2.0 / 2.0**FINER
    referenced = np.abs(errors.blurred).sum(axis=(1, 2)) > 0.0

    assert referenced.any()
    assert not referenced.all()
    assert np.array_equal(referenced, errors.eps >= STIFFEST * step)


def test_strong_errors_are_uniformly_of_order_one_half(errors):
    """The largest squared distance of all eps halves with the step."""
    largest = errors.strong.sum(axis=1).max(axis=0)

    assert largest[0] / largest[1] == pytest.approx(2.0, rel=0.1)


@pytest.mark.parametrize(("run", "used"), [(40, 40), (ALL, ALL), (2 * ALL, ALL), (8 * ALL, 2 * ALL)])
def test_a_share_of_the_paths_is_used(run, used):
    """All paths are used up to a number, and a share of larger runs: of the least one that has so many."""
    steps = Settings(paths=run, levels=3, coarsest=1)

    assert paired_errors(SCHEME, PROBLEM, steps).counts.sum() == used
    assert run_of(used) <= SHARE * used
    assert run_of(used) == run or used == ALL


def test_noise_depends_on_the_seed_alone():
    """The same seed gives the same evidence, another one does not."""
    one, again = (paired_errors(SCHEME, PROBLEM, SMALL) for _ in range(2))
    other = paired_errors(SCHEME, PROBLEM, replace(SMALL, seed=1))

    assert all(np.array_equal(a, b) for a, b in zip(one, again, strict=True))
    assert not np.allclose(one.weak, other.weak)


def test_paths_without_root_are_counted_for_each_eps():
    """Eps with too many of them are there, with the others; the coarsest step alone ends nothing."""
    ended = paired_errors(Rootless(beyond=0.5), PROBLEM, SMALL)
    coarse = paired_errors(Rootless(longer=0.2), PROBLEM, SMALL)
    many = (ended.failed.sum(axis=1) > FAILED * ended.counts.sum()).any(axis=1)

    assert ended.eps[0] < 2e-8
    assert ended.eps[-1] == 10.0
    assert np.array_equal(many, ended.eps > 0.5)
    assert not ended.failed[~many].any()
    assert coarse.failed[..., 0].all(axis=0).any()
    assert not coarse.failed[..., 2].any()
