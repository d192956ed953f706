"""Rooted trees: how many there are, their symmetries, how they are written and drawn."""

import pytest

from facade import TIME_LEAF, closed_sets, closure, formula, grow, picture, tree

B1, B2, F = tree(1), tree(2), tree(0)


@pytest.mark.parametrize(
    ("motions", "counts"), [(0, [1, 1, 3, 3]), (1, [3, 8, 21, 58]), (2, [7, 27, 108, 474]), (3, [13, 67, 375, 2323])]
)
def test_there_are_as_many_trees_as_are_known(motions, counts):
    """The numbers of trees up to the weights 2, 3, 4 and 5, leaves of time among them."""
    assert [len(grow(motions, top)) for top in (2, 3, 4, 5)] == counts


def test_additive_noise_has_leaves_alone():
    """A constant diffusion has no derivatives, neither by x nor by time."""
    assert len(grow(2, 5, additive=True)) == 20
    assert {each for each in grow(2, 5, additive=True) if each.colour > 0} == {B1, B2}


def test_each_tree_is_grown_once_behind_its_subtrees():
    """The list is closed and in an order in which components can be computed."""
    grown = grow(2, 4)

    assert len(set(grown)) == len(grown)
    assert closure(grown) == sorted(closure(grown), key=closure(grown).index)
    assert all(grown.index(part) <= grown.index(each) for each in grown for part in each.subtrees)


@pytest.mark.parametrize(
    ("each", "symmetry", "weight"),
    [
        (F, 1, 2),
        (tree(0, (B1, B1)), 2, 4),
        (tree(0, (B1, B2)), 1, 4),
        (tree(1, (TIME_LEAF, TIME_LEAF, TIME_LEAF)), 6, 7),
        (tree(0, (tree(1, (B1, B1)), tree(1, (B1, B1)))), 8, 8),
    ],
)
def test_symmetry_and_weight(each, symmetry, weight):
    """Sigma counts permutations of equal subtrees, at all nodes; noise weighs 1, drift and time 2."""
    assert (each.symmetry, each.weight) == (symmetry, weight)


def test_trees_are_written_and_drawn():
    """A forest is a product of formulas; the picture has the root on top."""
    each = tree(0, (B1, tree(2, (TIME_LEAF, B1))))

    assert formula((B1, each)) == "b1 . f(b1,b2(t,b1))"
    assert picture(each) == ["f", "├─ b1", "└─ b2", "   ├─ t", "   └─ b1"]


def test_closed_sets_hold_all_trees():
    """Each set has the subtrees of its trees, is small, and together they have all."""
    grown = grow(2, 4)
    sets = closed_sets(grown, 30)

    assert {each for some in sets for each in some} == set(grown)
    assert all(set(closure(some)) == set(some) and len(some) <= 30 for some in sets)
    assert all(closure(some) == some for some in sets)
