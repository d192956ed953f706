"""Chains: the inextensibility constraint against its definition, blocks of derivatives, where a reference is."""

from dataclasses import replace

import numpy as np
import pytest

from facade import Fibre, clamped_chain, fibre_clamped, fibre_problem, free_chain, hanging_fibre, is_resolved
from problems.fibre_chains import CHAINS, curved, defects, derivative
from sdaeverify import Structure
from sdaeverify_problems.fibres import _inextensible as inextensible

EPS = np.finfo(float).eps
PATHS, T = 4, 0.3


def close(given, expected, terms=256):
    np.testing.assert_allclose(given, expected, rtol=0.0, atol=terms * EPS * max(1.0, np.abs(expected).max()))


@pytest.mark.parametrize("name", CHAINS)
def test_constraint_is_its_definition(name):
    """It is the one of the paper on chains off the manifold, too, and vanishes on it."""
    chain = CHAINS[name]
    r = curved(chain, PATHS)
    off = r + 0.1 * np.random.default_rng(3).standard_normal(r.shape)

    close(inextensible.constraint(chain, off), defects(chain, off), 64)
    assert np.abs(inextensible.constraint(chain, r)).max() < 64 * EPS / chain.ds


@pytest.mark.parametrize("make", [clamped_chain, free_chain])
@pytest.mark.parametrize("N", [2, 3, 7, 20])
def test_bound_holds_near_the_manifold_and_is_reached(make, N):
    """No norm of (2.7) exceeds C_g within EPS ds of curved chains; the straight one needs 97 per cent of it."""
    chain = make(N, 2)
    C_g = inextensible.bound(chain)
    off = np.random.default_rng(8).standard_normal((2 * N, 200))
    off *= inextensible.EPS * chain.ds / np.linalg.norm(off, axis=0)
    straight = np.repeat(chain.straight()[:, None], 100, axis=1)
    needed = largest_norms(chain, np.concatenate([curved(chain, 100), straight], axis=1) + off)

    assert needed.max() <= C_g
    assert largest_norms(chain, straight).max() > C_g / (1 + 3 * inextensible.EPS)


def largest_norms(chain, r):
    """Return the largest of the norms in (2.7) on each path; of D^2 g a lower bound by its own largest entry."""
    Dg = np.moveaxis(derivative(lambda x: defects(chain, x), r), -1, 0)
    eigenvalues = np.linalg.eigvalsh(Dg @ np.swapaxes(Dg, 1, 2))
    return np.maximum(eigenvalues[:, -1], np.maximum(1 / eigenvalues[:, 0], np.full(r.shape[-1], 2 / chain.ds**2)))


def dense(structure, blocks, columns):
    """Return a block-banded matrix with one row for each slot of a node, shape (N q, n, P)."""
    unit = np.eye(columns * structure.nodes).reshape(structure.nodes, columns, -1)
    products = [blocks.times(np.repeat(unit[..., k : k + 1], PATHS, axis=-1)) for k in range(unit.shape[-1])]
    return np.stack(products, axis=2).reshape(-1, unit.shape[-1], PATHS)


@pytest.mark.parametrize("name", [name for name in CHAINS if "N=2" not in name])
def test_blocks_are_those_that_complex_steps_find(name):
    """The closed forms and the general structure, which differentiates force and constraint themselves, agree."""
    chain, rng = CHAINS[name], np.random.default_rng(4)
    problem = fibre_problem(Fibre(chain=chain), 0.01)
    own, r = problem.structure, curved(chain, PATHS)
    general = replace(problem, structure=Structure(nodes=chain.N, owners=own.owners, width=chain.d, reach=1))
    v, c = rng.standard_normal(r.shape), rng.standard_normal((problem.constraints, PATHS))
    found = [
        [
            *each.structure.force_blocks(each, T, r, v),
            each.structure.constraint_blocks(each, r),
            each.structure.curvature_rows(each, r, v),
            each.structure.curvature_sum(each, r, c),
        ]
        for each in (problem, general)
    ]

    for ours, theirs in zip(*found, strict=True):
        close(dense(own, ours, chain.d), dense(own, theirs, chain.d))


def test_reference_is_attached_where_it_is_stable():
    """With alpha = 0.4 it is up to time 0.25; 512 Heun steps multiply no mode of the hanging fibre by e till then."""
    fibre = Fibre(chain=clamped_chain(7, 2), alpha=0.4)
    rates = np.linalg.eigvals(hanging_fibre(fibre, 1.0).generator)

    def growth(horizon):
        z = horizon / 512 * rates
        return (np.abs(1 + z + z * z / 2) ** 512).max()

    assert fibre_clamped(alpha=0.4, horizon=0.25).pathwise is not None
    assert fibre_clamped(alpha=0.4, horizon=2.0).pathwise is None
    assert max(growth(each) for each in np.geomspace(0.05, 5.0, 41) if is_resolved(fibre, each)) < np.e
    assert growth(2.0) > 1e3
