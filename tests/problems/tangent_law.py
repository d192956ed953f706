"""Laws on the tangent bundle of the unit sphere in R^3, and the generator of constrained mechanics on monomials."""

from collections.abc import Callable
from itertools import product
from typing import NamedTuple

import numpy as np

from sdaeverify import Array, HolonomicSDAE


class Law(NamedTuple):
    """Nodes (r, v), shape (6, P), and weights, shape (P,), of a probability measure."""

    x: Array
    weights: Array


def canonical_nodes(mass: Array, kT: float, potential: Callable[[Array], Array], count: int = 40) -> Law:
    """Return nodes of exp(-V/kT) sqrt(r^T M^{-1} r) on the sphere, velocities being normal.

    In a basis T of the tangent plane, v = T s and s ~ N(0, kT (T^T M T)^{-1}). Gauss' rules have `count` nodes in r_3
    and 5 in each component of s, the trapezoidal rule 2 `count` in the longitude.
    """
    z, weights = np.polynomial.legendre.leggauss(count)
    phi = 2 * np.pi * np.arange(2 * count) / (2 * count)
    rho = np.sqrt(1.0 - z**2)
    r = np.stack([np.outer(rho, np.cos(phi)), np.outer(rho, np.sin(phi)), np.outer(z, np.ones(2 * count))]).reshape(
        3, -1
    )
    first = np.cross(r, np.where(np.abs(r[2]) < 0.9, [[0.0], [0.0], [1.0]], [[1.0], [0.0], [0.0]]), axis=0)
    first = first / np.linalg.norm(first, axis=0)
    T = np.stack([first, np.cross(r, first, axis=0)], axis=1)
    K = np.einsum("iap,ij,jbp->pab", T, mass, T)
    root = np.linalg.cholesky(kT * np.linalg.inv(K))
    nodes, normal = np.polynomial.hermite_e.hermegauss(5)
    s = np.stack(np.meshgrid(nodes, nodes)).reshape(2, -1)
    v = np.einsum("iap,pab,bq->ipq", T, root, s)
    pushed = np.linalg.solve(mass, r)
    density = np.repeat(weights, 2 * count) * np.sqrt((r * pushed).sum(axis=0)) * np.exp(-potential(r) / kT)
    full = np.outer(density, np.outer(normal, normal)).ravel()
    x = np.concatenate([np.broadcast_to(r[..., None], v.shape), v]).reshape(6, -1)
    return Law(x, full / full.sum())


def monomials(positions: int, velocities: int) -> list[tuple[int, ...]]:
    """Return the exponents of monomials in (r, v), up to a degree in r and one in v."""
    degrees = product(range(max(positions, velocities) + 1), repeat=6)
    return [e for e in degrees if sum(e[:3]) <= positions and sum(e[3:]) <= velocities]


def value(exponents: tuple[int, ...], x: Array) -> Array:
    """Return a monomial, shape (P,)."""
    result = np.ones(x.shape[1])
    for i, k in enumerate(exponents):
        for _ in range(k):
            result = result * x[i]
    return result


def lowered(exponents: tuple[int, ...], i: int) -> tuple[int, tuple[int, ...]]:
    """Return factor and exponents of a derivative; the factor is 0 where there is nothing to differentiate."""
    k = exponents[i]
    return k, tuple(e - (j == i and k > 0) for j, e in enumerate(exponents))


class Image(NamedTuple):
    """L q of each monomial and the size of the terms that were added up, shapes (k, P)."""

    values: Array
    sizes: Array


def images(problem: HolonomicSDAE, x: Array, exponents: list[tuple[int, ...]]) -> Image:
    """Return L q = Dq f + (1/2) tr(D^2 q B B^T) of the inherent SDE, derivatives being those of monomials."""
    equation = problem.view(type(problem.ito()))
    f = equation.drift(0.0, x)
    B = np.broadcast_to(equation.diffusion(0.0, x), (6, problem.noise_dim, x.shape[1]))
    D = 0.5 * np.einsum("ilp,jlp->ijp", B, B)
    found = [_terms(e, x, f, D) for e in exponents]
    return Image(np.stack([sum(t) for t in found]), np.stack([sum(map(np.abs, t)) for t in found]))


def _terms(exponents: tuple[int, ...], x: Array, f: Array, D: Array) -> list[Array]:
    terms = [np.zeros(x.shape[1])]
    for i in range(6):
        a, first = lowered(exponents, i)
        terms += [a * value(first, x) * f[i]] if a else []
        for j in range(3, 6) if a and i >= 3 else ():
            b, second = lowered(first, j)
            terms += [a * b * value(second, x) * D[i, j]] if b else []
    return terms
