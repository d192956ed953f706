"""The inextensibility constraint at O(N) against its definition, differentiated column by column."""

import numpy as np
import pytest

from facade import clamped_chain, free_chain
from problems.fibre_chains import CHAINS, curved, defects, derivative
from sdaeverify_problems.fibres import _inextensible as inextensible

EPS = np.finfo(float).eps
PATHS = 4


@pytest.fixture(params=CHAINS, name="chain")
def given_chain(request):
    return CHAINS[request.param]


def dense(chain, r):
    return derivative(lambda x: defects(chain, x), r)


def close(given, expected, terms=64):
    np.testing.assert_allclose(given, expected, rtol=0.0, atol=terms * EPS * np.abs(expected).max())


def test_constraint_is_its_definition(chain):
    """It is the one of the paper on chains off the manifold, too, and vanishes on it."""
    r = curved(chain, PATHS)
    off = r + 0.1 * np.random.default_rng(3).standard_normal(r.shape)

    close(inextensible.constraint(chain, off), defects(chain, off))
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
    Dg = np.moveaxis(dense(chain, r), -1, 0)
    gram = Dg @ np.swapaxes(Dg, 1, 2)
    eigenvalues = np.linalg.eigvalsh(gram)
    return np.maximum(eigenvalues[:, -1], np.maximum(1 / eigenvalues[:, 0], np.full(r.shape[-1], 2 / chain.ds**2)))
