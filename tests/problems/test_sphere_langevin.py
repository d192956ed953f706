"""The heavy point on the sphere: its expectations, its relaxation time, and that a scheme finds its law."""

import numpy as np
import pytest

from facade import sphere_langevin
from problems.tangent_law import canonical_nodes, images, monomials, value
from sdaeverify import Array, HolonomicSDAE


def gap(problem: HolonomicSDAE, mass: Array, kT: float, c_g: float) -> float:
    """Return the least positive eigenvalue of -L among polynomials of degrees up to 3, by Galerkin's method."""
    law, exponents = canonical_nodes(mass, kT, lambda r: c_g * r[2], count=12), monomials(3, 3)
    basis = np.stack([value(e, law.x) for e in exponents])
    basis_norm = np.sqrt((basis**2) @ law.weights)[:, None]
    weighted = basis / basis_norm * law.weights
    gram, L = weighted @ (basis / basis_norm).T, weighted @ (images(problem, law.x, exponents).values / basis_norm).T
    # On the sphere and on its tangent planes the monomials are not independent.
    sizes, directions = np.linalg.eigh(gram)
    kept = sizes > 1e-9 * sizes[-1]
    reduced = directions[:, kept] / np.sqrt(sizes[kept])
    rates = np.sort(-np.linalg.eigvals(reduced.T @ L @ reduced).real)
    return float(rates[rates > 1e-5][0])


@pytest.mark.slow
@pytest.mark.parametrize("masses", [(1.0, 1.0, 1.0), (1.0, 2.0, 4.0), (1.0, 8.0, 1.0)])
@pytest.mark.parametrize(("c_g", "kT"), [(1.0, 0.1), (1.0, 0.5), (0.0, 0.5)])
@pytest.mark.parametrize("gamma", [0.3, 1.0, 3.0])
def test_relaxation_is_estimated_to_its_size(
    masses: tuple[float, float, float], c_g: float, kT: float, gamma: float
) -> None:
    """The estimate is between 1 and 5 times the reciprocal of the generator's gap."""
    problem = sphere_langevin(c_g, gamma, kT, *masses)

    assert 1.0 <= problem.relaxation * gap(problem, np.diag(masses), kT, c_g) <= 5.0
