"""Exact moments of iterated integrals, against values by hand and against Gaussian quadrature."""

from fractions import Fraction
from itertools import product

import numpy as np
import pytest

from facade import TIME_LEAF, ExactMoments, Record, grow, tree
from sdaeverify.probing import Nodes

B, C, F, T = tree(1), tree(2), tree(0), TIME_LEAF
FB, BF, BB, BC, CB = tree(0, (B,)), tree(1, (F,)), tree(1, (B,)), tree(1, (C,)), tree(2, (B,))


@pytest.mark.parametrize(
    ("forest", "value"),
    [
        ((), "1"),
        ((B,), "0"),
        ((F,), "1"),
        ((B, B), "1"),
        ((B, C), "0"),
        ((B, B, B, B), "3"),
        ((B, B, C, C), "1"),
        ((FB, FB), "1/3"),  # E (int W ds)^2
        ((B, FB), "1/2"),  # E W int W ds
        ((BF, BF), "1/3"),  # E (int s dW)^2
        ((B, BF), "1/2"),
        ((FB, BF), "1/6"),
        ((BB, BB), "1/2"),  # E (int W dW)^2
        ((BC, BC), "1/2"),
        ((BC, CB), "0"),
        ((BB, B, B), "1"),  # (W^2 - 1)/2 W^2
        ((BC, B, C), "1/2"),
        ((BB,), "0"),
        ((tree(0, (B, B)),), "1/2"),  # E int W^2 ds
        ((tree(0, (B, C)),), "0"),
        ((tree(0, (F,)),), "1/2"),
        ((tree(0, (T,)),), "1/2"),
        ((tree(0, (T, T)),), "1/3"),
        ((tree(0, (F, T)),), "1/3"),
        ((tree(1, (T,)), B), "1/2"),
        ((tree(1, (B, B)), B), "1/2"),  # E W int W^2 dW = int s ds
        ((tree(1, (B, B)), tree(1, (B, B))), "1"),  # int 3 s^2 ds
        ((tree(1, (BB,)), tree(1, (BB,))), "1/6"),
        ((tree(1, (BB,)), B, B, B), "1"),  # H_3/6, E H_3 W^3 = 6
        ((tree(0, (BB,)),), "0"),
        ((tree(0, (BB,)), BB), "1/6"),
        ((F, F, F), "1"),
        ((tree(0, (FB,)), B), "1/6"),
        ((tree(0, (BF,)), FB), "1/12"),  # int int min(s, u)^2 / 2 ds du
        ((tree(0, (B,)), tree(1, (T,)), C, C), "1/6"),
    ],
)
def test_moments_by_hand(forest, value):
    """E prod I(tau) over a step of length 1."""
    assert ExactMoments().mean(forest) == Fraction(value)


def test_the_area_of_two_motions_has_the_variance_of_levy():
    """A = (I(b2(b1)) - I(b1(b2)))/2 has E A^2 = 1/4, and E A dW1 dW2 = 0."""
    area = {CB: Fraction(1, 2), BC: Fraction(-1, 2)}
    moments = ExactMoments()

    assert moments.mean_of_product((area, area)) == Fraction(1, 4)
    assert moments.mean_of_product((area, {B: Fraction(1)}, {C: Fraction(1)})) == 0


def test_products_of_the_record_have_the_moments_of_normal_variables():
    """All forests of b, f(b) and f(b,t) up to six factors, against Gauss-Hermite quadrature in dW, H and K."""
    x, w = np.polynomial.hermite_e.hermegauss(4)
    dW, H, K = (part.ravel()[None] for part in np.meshgrid(x, x / 12**0.5, x / 720**0.5, indexing="ij"))
    weights = np.multiply.outer(np.multiply.outer(w, w), w).ravel() / w.sum() ** 3
    moments = ExactMoments()
    record = Record(frozenset({"dW", "H", "K"}), 1, moments)
    values = {each: entry.value(Nodes(dW, H, weights, K=K)) for each, entry in record.entries.items()}

    for powers in product(range(3), repeat=3):
        forest = [each for each, power in zip(values, powers, strict=True) for _ in range(power)]
        found = float(np.prod([np.ones(64), *(values[each] for each in forest)], axis=0) @ weights)
        assert float(moments.mean(forest)) == pytest.approx(found, abs=1e-13)


def test_products_of_iterated_integrals_follow_itos_formula():
    """I(a) I(b) is the sum over roots that are removed last; so are its moments with any third tree."""
    trees, moments = grow(2, 2), ExactMoments()
    for a, b, c in product(trees, trees, grow(2, 3)):
        parts = [(tree(a.colour, (*a.kids, b)),), (tree(b.colour, (*b.kids, a)),)]
        if a.colour == b.colour and a.colour > 0:
            parts.append((tree(0, (*a.kids, *b.kids)),))
        assert moments.mean((a, b, c)) == sum(moments.mean((*part, c)) for part in parts)
