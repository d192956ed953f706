"""Blocks of a fibre's derivatives against dense ones, taken column by column with a complex step."""

from dataclasses import replace

import numpy as np
import pytest

from facade import Fibre, clamped_chain, fibre_problem
from problems.fibre_chains import CHAINS, curved, defects, derivative
from sdaeverify import Structure

EPS = np.finfo(float).eps
PATHS = 2
T = 0.3
NAMES = [name for name in CHAINS if "N=2" not in name]


def dense(structure, blocks, columns):
    """Return a block-banded matrix with one row for each slot of a node, shape (N q, n, P)."""
    unit = np.eye(columns * structure.nodes).reshape(structure.nodes, columns, -1)
    products = [blocks.times(np.repeat(unit[..., k : k + 1], PATHS, axis=-1)) for k in range(unit.shape[-1])]
    return np.stack(products, axis=2).reshape(-1, unit.shape[-1], PATHS)


def close(given, expected):
    np.testing.assert_allclose(given, expected, rtol=0.0, atol=256 * EPS * max(1.0, np.abs(expected).max()))


@pytest.mark.parametrize("chain", NAMES)
def test_constraint_blocks_are_the_derivatives_of_the_constraint(chain):
    """Dg, the rows v^T Hess g and H(c) agree with the definition of g; a point without constraint has a zero row."""
    chain = CHAINS[chain]
    problem = fibre_problem(Fibre(chain=chain), 0.01)
    structure, r, rng = problem.structure, curved(chain, PATHS), np.random.default_rng(3)
    v, c = rng.standard_normal(r.shape), rng.standard_normal((problem.constraints, PATHS))
    Dg = derivative(lambda x: defects(chain, x), r)
    # Dg is affine in r.
    rows = derivative(lambda x: defects(chain, x), r + v) - Dg
    hessian = np.stack(
        [
            np.einsum("mnp,mp->np", derivative(lambda x: defects(chain, x), r + unit[:, None]) - Dg, c)
            for unit in np.eye(len(r))
        ],
        axis=1,
    )

    for blocks, expected in (
        (structure.constraint_blocks(problem, r), Dg),
        (structure.curvature_rows(problem, r, v), rows),
    ):
        given = dense(structure, blocks, chain.d)
        close(given[structure.slots], expected)
        assert not np.delete(given, structure.slots, axis=0).any()
    close(dense(structure, structure.curvature_sum(problem, r, c), chain.d), hessian)


def test_blocks_are_those_that_complex_steps_find():
    """The closed forms and the general structure, which differentiates the force itself, agree."""
    problem = fibre_problem(Fibre(chain=clamped_chain(6, 2)), 0.01)
    own = problem.structure
    general = replace(problem, structure=Structure(nodes=6, owners=own.owners, width=2, reach=1))
    r = curved(clamped_chain(6, 2), PATHS)
    v = np.random.default_rng(4).standard_normal(r.shape)
    pairs = zip(own.force_blocks(problem, T, r, v), general.structure.force_blocks(general, T, r, v), strict=True)
    for ours, theirs in pairs:
        close(dense(own, ours, 2), dense(own, theirs, 2))
