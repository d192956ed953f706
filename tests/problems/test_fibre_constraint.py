"""The inextensibility constraint at O(N) against its definition, differentiated column by column."""

import numpy as np
import pytest

from problems.fibre_chains import CHAINS, curved, defects, derivative
from sdaeverify_problems import _inextensible as inextensible
from sdaeverify_problems._chain import clamped_chain, free_chain
from sdaeverify_problems._inextensible import ChainJacobian

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


def test_products_with_the_jacobian_are_those_of_the_matrix(chain):
    """Dg y, Dg Y, grad g c and grad g C agree with the dense derivative, and so does the matrix made of them."""
    r, rng = curved(chain, PATHS), np.random.default_rng(4)
    Dg, J = dense(chain, r), ChainJacobian(chain, chain.edges(r))
    m, n, _ = Dg.shape
    y, Y = rng.standard_normal((n, PATHS)), rng.standard_normal((n, 3, PATHS))
    c, C = rng.standard_normal((m, PATHS)), rng.standard_normal((m, 3, PATHS))

    close(inextensible.dense(chain, r), Dg)
    close(J.times(y), np.einsum("mnp,np->mp", Dg, y))
    close(J.times(Y), np.einsum("mnp,nkp->mkp", Dg, Y))
    close(J.transposed(c), np.einsum("mnp,mp->np", Dg, c))
    close(J.transposed(C), np.einsum("mnp,mkp->nkp", Dg, C))
    close(J.size(), np.sqrt((Dg**2).sum(axis=(0, 1))))


def test_directions_may_be_the_same_on_all_paths(chain):
    """A direction or multiplier of one column serves every path."""
    r = curved(chain, PATHS)
    J = ChainJacobian(chain, chain.edges(r))
    Dg = dense(chain, r)
    one = np.ones((len(Dg), 2, 1))

    close(J.times(np.eye(len(r))[..., None]), Dg)
    close(J.transposed(one), np.repeat(Dg.sum(axis=0)[:, None], 2, axis=1))


def test_gram_systems_are_solved_by_elimination_along_the_chain(chain):
    """Dg grad g of the same and of another position, times its solution, gives the right side."""
    r = curved(chain, PATHS)
    s = r + 0.02 * chain.ds * np.random.default_rng(5).standard_normal(r.shape)
    J, other = (ChainJacobian(chain, chain.edges(x)) for x in (r, s))
    b = np.random.default_rng(6).standard_normal((len(J.e), PATHS))
    for left, right in ((r, r), (r, s), (s, r)):
        matrix = np.einsum("inp,jnp->ijp", dense(chain, left), dense(chain, right))
        gram = (J if left is r else other).gram(J if right is r else other)
        condition = np.linalg.cond(np.moveaxis(matrix, -1, 0)).max()

        np.testing.assert_allclose(
            np.einsum("ijp,jp->ip", matrix, gram.solve(b)), b, rtol=0.0, atol=64 * EPS * condition
        )
        assert (gram.positive() == (np.linalg.det(np.moveaxis(matrix, -1, 0)) > 0)).all()


def test_curvature_is_the_second_derivative(chain):
    """D^2 g(y, z) is the derivative of Dg z along y."""
    r, rng = curved(chain, PATHS), np.random.default_rng(7)
    y, z = rng.standard_normal((2, *r.shape))
    shifted = [dense(chain, r + step * y) for step in (1.0, -1.0)]

    # Dg is affine in r, so that a central difference is exact.
    change = 0.5 * np.einsum("mnp,np->mp", shifted[0] - shifted[1], z)
    close(inextensible.curvature(chain, r, y, z), change, 256)


@pytest.mark.parametrize("N", [2, 7, 20])
def test_gram_matrix_of_the_straight_clamped_fibre_has_known_eigenvalues(N):
    """They are (2 - 2 cos((2 k - 1) pi/(2 N + 1)))/ds^2, from near (pi/(2 N + 1))^2/ds^2 to less than 4/ds^2."""
    chain = clamped_chain(N, 2)
    r = chain.straight()[:, None]
    Dg = inextensible.dense(chain, r)[..., 0]
    angles = (2 * np.arange(1, N + 1) - 1) * np.pi / (2 * N + 1)

    np.testing.assert_allclose(np.linalg.eigvalsh(Dg @ Dg.T), (2 - 2 * np.cos(angles)) / chain.ds**2, rtol=1e-9)


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
