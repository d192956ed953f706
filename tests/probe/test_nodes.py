"""Cubature nodes: exactness, aggregation of half steps, and what becomes of rules that would be too large."""

from collections.abc import Callable
from itertools import combinations_with_replacement
from math import prod

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from facade import (
    LARGEST,
    MOST_NODES,
    POINTS,
    Rule,
    fifth_degree_rule,
    gauss_hermite,
    half_steps,
    join_areas,
    law_nodes,
    normal_rule,
    orthogonal_rule,
    outer,
    tensor_rule,
)
from joined_noise import aggregate
from sdaeverify import GAUSSIAN, THREE_POINT, TWO_POINT, Law
from sdaeverify.measuring import FEWEST
from sdaeverify.probing import Nodes, step_nodes
from sdaeverify.studying import LevelNoise

GAUSSIAN_MOMENTS = {0: 1.0, 1: 0.0, 2: 1.0, 3: 0.0, 4: 3.0, 5: 0.0, 6: 15.0, 7: 0.0, 8: 105.0, 9: 0.0, 10: 945.0}


@pytest.mark.parametrize("dimension", [3, 5])
def test_a_rule_of_the_fifth_degree_knows_all_moments_of_five_factors(dimension: int) -> None:
    """Of whichever variables, in 2^n + 2n nodes of positive weight."""
    rule = fifth_degree_rule(dimension)

    for factors in combinations_with_replacement(range(dimension), 5):
        for size in range(6):
            powers = np.bincount(factors[:size], minlength=dimension)
            moment = rule.weights @ np.prod(rule.x ** powers[:, None], axis=0)
            assert moment == pytest.approx(prod(GAUSSIAN_MOMENTS[p] for p in powers), abs=1e-12)
    assert len(rule.weights) == 2**dimension + 2 * dimension
    assert (rule.weights > 0.0).all()


def product_of(count: int) -> Callable[[int, int], Rule]:
    """Return what makes a product of so many nodes a variable, however many those are."""
    return lambda dimension, _: tensor_rule([gauss_hermite(count)] * dimension)


def means_of_squares(motions: int, areas: bool, rule: Callable[[int, int], Rule]) -> np.ndarray:
    """Return E d_i d_j for the defects d_i, one step against two halves, of all monomials of degree 1 to 3."""
    values = []
    for h, nodes in zip((1.0, 0.5, 0.5), half_steps(motions, FEWEST, areas=areas, rule=rule), strict=True):
        z = nodes.dW if nodes.H is None else np.concatenate([nodes.dW, nodes.H])
        chosen = (c for degree in (1, 2, 3) for c in combinations_with_replacement(range(len(z)), degree))
        values.append(np.array([np.prod(z[list(c)], axis=0) * h ** (0.5 * (3 - len(c))) for c in chosen]))
    whole, first, second = values
    defects = whole - first - second
    return (defects * nodes.weights) @ defects.T


@pytest.mark.parametrize(("motions", "areas"), [(2, True), (3, False), (4, False)])
def test_no_error_of_degree_three_hides_from_a_rule_of_the_fifth_degree(motions: int, areas: bool) -> None:
    """The rule is not exact for squares of degree 6, but 0 for no defect; two nodes a variable are, for some."""
    sizes, errors = np.linalg.eigh(means_of_squares(motions, areas, product_of(4)))
    # What adds up over two half steps, as dW does, has no defect.
    shown = sizes > 1e-10 * sizes.max()
    whitened = errors[:, shown] / np.sqrt(sizes[shown])

    def least_share(rule: Callable[[int, int], Rule]) -> float:
        return np.linalg.eigvalsh(whitened.T @ means_of_squares(motions, areas, rule) @ whitened).min()

    assert least_share(normal_rule) > 1e-10
    assert least_share(product_of(2)) < 1e-10


@pytest.mark.parametrize(("dimension", "nodes"), [(2, 6**2), (4, 6**4), (6, 2**6 + 12), (8, 2**8 + 16)])
def test_a_rule_that_were_too_large_has_fewer_nodes_a_variable(dimension: int, nodes: int) -> None:
    """It stays a rule: exact up to degree 5, and at most as large as allowed."""
    rule = normal_rule(dimension, 6)

    assert rule.exact
    assert len(rule.weights) == nodes <= max(MOST_NODES, LARGEST)
    assert rule.weights.sum() == pytest.approx(1.0, abs=1e-12)
    assert rule.weights @ rule.x[0] ** 4 == pytest.approx(3.0, abs=1e-10)
    assert rule.weights @ (rule.x[0] ** 2 * rule.x[-1] ** 2) == pytest.approx(1.0, abs=1e-10)


def test_random_points_are_the_last_resort_and_say_so() -> None:
    """In many dimensions points are drawn, always the same, with mean squares right to some per cent."""
    rule, again = normal_rule(18, 6), normal_rule(18, 6)

    assert not rule.exact
    assert rule.x.shape == (18, POINTS)
    assert np.array_equal(rule.x, again.x)
    assert np.sqrt(rule.weights @ ((rule.x**2 - 1.0) ** 2).T / 2.0) == pytest.approx(1.0, abs=0.15)


@pytest.mark.parametrize("areas", [False, True])
@pytest.mark.parametrize("dimension", [1, 2])
def test_half_steps_make_up_the_whole(dimension: int, areas: bool) -> None:
    """The whole step's noise is what the harness makes of the two halves."""
    halves = half_steps(dimension, 3, areas=areas)

    pairs = zip(halves.first[:2], halves.second[:2], strict=True)
    fine = LevelNoise(*(None if a is None else np.stack([a, b]) for a, b in pairs))
    whole = aggregate(fine)

    assert np.allclose(halves.whole.dW, whole.dW[0], rtol=0.0, atol=1e-15)
    assert (halves.whole.H is None) is not areas
    if areas:
        assert np.allclose(halves.whole.H, whole.H[0], rtol=0.0, atol=1e-15)


def covariance(nodes: Nodes) -> np.ndarray:
    values = nodes.dW if nodes.H is None else np.concatenate([nodes.dW, nodes.H])
    return np.einsum("ik,jk,k->ij", values, values, nodes.weights)


@pytest.mark.parametrize("dimension", [1, 2])
def test_noise_has_its_covariance(dimension: int) -> None:
    """Increments have variance h and H has h/12, uncorrelated, over the whole step; each half has half of it."""
    halves, unit = half_steps(dimension, 3, areas=True), np.repeat([1.0, 1.0 / 12.0], dimension)

    assert np.allclose(covariance(halves.whole), np.diag(unit), atol=1e-13)
    assert np.allclose(covariance(halves.first), np.diag(unit / 2.0), atol=1e-13)
    assert np.allclose(covariance(halves.second), np.diag(unit / 2.0), atol=1e-13)
    assert np.allclose(covariance(step_nodes(dimension, 5, areas=True)), np.diag(unit), atol=1e-13)


@pytest.mark.parametrize("law", [TWO_POINT, THREE_POINT])
def test_a_bounded_law_has_its_atoms_as_nodes(law: Law) -> None:
    """The nodes of two bounded variables are all pairs of atoms; H is a sign of variance 1/12 for each of them."""
    nodes, signed = (step_nodes(2, 8, areas=areas, law=law) for areas in (False, True))

    assert sorted(set(np.round(nodes.dW.ravel(), 12))) == sorted(np.round(law.values, 12))
    assert len(nodes.weights) == len(law.values) ** 2
    assert nodes.H is None
    assert covariance(nodes) == pytest.approx(np.eye(2), abs=1e-14)
    assert len(signed.weights) == 4 * len(nodes.weights)
    assert covariance(signed) == pytest.approx(np.diag([1.0, 1.0, 1 / 12, 1 / 12]), abs=1e-14)


def test_too_many_atoms_are_sampled():
    """Sixteen three-point variables have 43 million atoms: random ones take their place and say so."""
    nodes = step_nodes(16, 3, law=THREE_POINT)
    assert nodes.dW.shape == (16, POINTS)
    assert not nodes.exact
    assert set(np.unique(nodes.dW)) == set(THREE_POINT.values)
    assert step_nodes(8, 3, law=THREE_POINT).exact


def standardised(nodes: Nodes) -> np.ndarray:
    """Return all noise of a step of length 1 as variables of variance 1, areas less what H tells of them."""
    A = nodes.A
    if A is not None and nodes.H is not None:
        A = np.sqrt(12.0) * (A - outer(nodes.H, nodes.dW))
    elif A is not None:
        A = 2.0 * A
    scales = ((nodes.dW, 1.0), (nodes.H, 12.0), (nodes.K, 720.0), (A, 1.0))
    return np.concatenate([np.sqrt(scale) * part for part, scale in scales if part is not None])


def assert_exact_to_degree_three(x: np.ndarray, weights: np.ndarray) -> None:
    """Expect mean 0, covariance Id and third moments 0, to rounding."""
    n = len(x)
    assert weights.sum() == pytest.approx(1.0, abs=1e-12)
    assert (weights > 0.0).all()
    assert np.abs(x @ weights).max() < 1e-12
    assert np.abs((x * weights) @ x.T - np.eye(n)).max() < 1e-12
    assert np.abs(np.einsum("ik,jk,lk,k->ijl", x, x, x, weights, optimize=True)).max() < 1e-11


@settings(max_examples=25, deadline=None)
@given(n=st.integers(3, 48))
def test_an_orthogonal_rule_is_exact_to_degree_three(n: int) -> None:
    """For any number of variables, in few nodes; squares multiply rightly as well."""
    rule = orthogonal_rule(n)
    assert_exact_to_degree_three(rule.x, rule.weights)
    assert len(rule.weights) <= 6 * n
    assert rule.weights @ (rule.x**2).sum(axis=0) ** 2 == pytest.approx(n * (n + 2.0), rel=1e-12)


@settings(max_examples=40, deadline=None)
@given(
    l=st.integers(1, 9),
    beside=st.sets(st.sampled_from(["H", "K", "A"])),
    law=st.sampled_from([GAUSSIAN, TWO_POINT, THREE_POINT]),
)
def test_nodes_of_a_law_resolve_mean_and_covariance(l: int, beside: set[str], law: Law) -> None:
    """Of every kind of noise, two sets of nodes are exact to degree 3, and they are few."""
    noise = frozenset({"dW", *(beside if not law.bounded else beside & {"H"})})
    for nodes in law_nodes(l, noise, law):
        assert nodes.exact
        x = standardised(nodes)
        assert len(x) == l * (1 + ("H" in noise) + ("K" in noise)) + ("A" in noise) * (l * (l - 1) // 2)
        assert_exact_to_degree_three(x, nodes.weights)
        assert len(nodes.weights) <= max(36, 12 * len(x))


@pytest.mark.parametrize("areas", [False, True])
@pytest.mark.parametrize("dimension", [2, 3, 6])
def test_levy_areas_of_half_steps_make_up_the_whole(dimension: int, areas: bool) -> None:
    """Chen's relation holds at every node, areas have mean 0 and, where the rule is of degree 5, their variance."""
    halves = half_steps(dimension, 3, areas=areas, levy=True)
    for nodes in halves:
        assert nodes.A is not None
        assert np.abs(nodes.A @ nodes.weights).max() < 1e-12
    A, dW = (np.stack([first, second]) for first, second in zip(*((n.A, n.dW) for n in halves[1:]), strict=True))
    assert np.allclose(halves.whole.A, join_areas(A, dW)[0], rtol=0.0, atol=1e-14)
    if halves.whole.degree == 5:
        for nodes, h in zip(halves, (1.0, 0.5, 0.5), strict=True):
            assert (nodes.A * nodes.weights) @ nodes.A.T == pytest.approx(0.25 * h**2, abs=1e-12)
