"""Classes as quotients: as many conditions as random equations of the class have independent differentials."""

import numpy as np
import pytest

from facade import OF_SDES, EquationClass, RichEquation, Universal, grow, related_equations
from sdaeverify.probing import why_not_linear_equation
from trees.polynomials import directional, elementary, product

BY_NAME = {kind.name: kind for kind in OF_SDES}
# Powers of each of x_1, x_2, x_3 and t are lower.
SIZE = 5


@pytest.mark.parametrize(
    ("name", "motions", "top", "trees", "conditions"),
    [
        ("ode", 0, 4, 3, 3),
        ("scalar", 1, 5, 58, 58),
        ("additive", 2, 5, 20, 20),
        ("general", 2, 4, 108, 108),
        ("commutative", 2, 3, 27, 22),
        ("commutative", 2, 4, 108, 82),
        ("vanishing-milstein-term", 2, 4, 108, 26),
        ("diagonal", 2, 4, 42, 40),
        ("diagonal", 2, 5, 130, 112),
    ],
)
def test_a_class_has_as_many_conditions_as_are_known(name, motions, top, trees, conditions):
    """The dimension of the quotient, up to a weight."""
    kind = BY_NAME[name]
    grown = kind.trees(motions, top)

    assert (len(grown), len(kind.basis(grown, motions))) == (trees, conditions)


def test_forests_of_commuting_noise_are_as_many_as_are_known():
    """Strong order 2 and weak order 2 for two motions that commute are 766 conditions on 474 trees."""
    grown = BY_NAME["commutative"].trees(2, 5)
    assert len(grown) == 474
    assert len(BY_NAME["commutative"].basis(grown, 2)) < len(grown)


def random_polynomial(rng, variables, degree):
    """Return a random polynomial of some degree in some of x_1, x_2, x_3, t."""
    p = np.zeros((SIZE,) * 4)
    powers = np.indices(p.shape)
    fits = powers.sum(axis=0) <= degree
    for axis in set(range(4)) - set(variables):
        fits &= powers[axis] == 0
    p[fits] = rng.standard_normal(fits.sum())
    return p


# Powers of x and of t in a series, whose further terms no tree up to the weight 4 sees.
IN_X, IN_T = 3, 1


def cut(p):
    """Return a series without the terms that are not seen."""
    powers = np.indices(p.shape)
    return np.where((powers[:3].sum(axis=0) <= IN_X) & (powers[3] <= IN_T), p, 0.0)


def times(A, B):
    """Return the product of two matrices of series."""
    return [
        [cut(sum(product(p, q) for p, q in zip(row, column, strict=True))) for column in zip(*B, strict=True)]
        for row in A
    ]


def minus(A, B):
    """Return the difference of two matrices of series."""
    return [[p - q for p, q in zip(a, b, strict=True)] for a, b in zip(A, B, strict=True)]


def commuting_fields(rng):
    """Return a drift and two fields that commute at each time, as series about the origin.

    Constant fields c_j, moved by the inverse of a map phi_t(x) = x + ..., are D phi_t(x)^{-1} c_j. The map depends on
    time: fields of different times need not commute.
    """
    one = np.zeros((SIZE,) * 4)
    one[0, 0, 0, 0] = 1.0
    unit = [[one * (i == j) for j in range(3)] for i in range(3)]
    powers = np.indices(one.shape)
    bent = (powers[:3].sum(axis=0) > 0) & (powers.sum(axis=0) > 1) & (powers[3] <= IN_T)
    maps = [np.where(bent, random_polynomial(rng, (0, 1, 2, 3), IN_X + IN_T), 0.0) for _ in range(3)]
    rest = [[cut(directional(p, np.eye(4)[j])) for j in range(3)] for p in maps]
    inverse = minus(unit, rest)
    # (1 + N)^{-1} = 1 - N (1 + N)^{-1}: each round gives one degree more.
    for _ in range(IN_X + IN_T):
        inverse = minus(unit, times(rest, inverse))
    fields = [[np.tensordot(c, row, axes=1) for row in inverse] for c in rng.standard_normal((2, 3))]
    return [[random_polynomial(rng, (0, 1, 2, 3), 3) for _ in range(3)], *fields]


def differentials_of_commuting_noise(trees, systems):
    """Return elementary differentials of random systems at the origin, one row for each component of each."""
    rng = np.random.default_rng(5)
    return np.concatenate([elementary(commuting_fields(rng), trees, np.zeros(4)).T for _ in range(systems)])


@pytest.mark.long
@pytest.mark.parametrize(("top", "systems", "rank"), [(3, 10, 22), (4, 33, 82)])
def test_commuting_systems_have_the_rank_of_their_conditions(top, systems, rank):
    """Fields that commute have 22 independent differentials up to weight 3, 82 up to 4; the relations vanish."""
    trees = grow(2, top)
    rows = differentials_of_commuting_noise(trees, systems)

    assert np.linalg.matrix_rank(rows / np.abs(rows).max(axis=1, keepdims=True), tol=1e-9) == rank
    assert conditions_carry(BY_NAME["commutative"], trees, rows)


def conditions_carry(kind, trees, rows):
    """Tell whether a series is zero on equations of a class as soon as its conditions hold.

    For any weights Delta, sum Delta/sigma F = sum over conditions of (combination of Delta)/sigma F of the tree that
    names it.
    """
    delta = np.random.default_rng(7).standard_normal(len(trees))
    places = {each: place for place, each in enumerate(trees)}
    whole = rows @ (delta / [each.symmetry for each in trees])
    carried = np.zeros_like(whole)
    for condition in kind.basis(trees, 2):
        name = next(iter(condition))
        combined = sum(float(c) * delta[places[part]] for part, c in condition.items())
        carried += combined / name.symmetry * rows[:, places[name]]
    scale = np.abs(rows) @ np.ones(len(trees))
    return bool(np.all(np.abs(whole - carried) <= 1e-8 * scale))


@pytest.mark.parametrize(("top", "rank"), [(4, 40), (5, 112)])
def test_diagonal_noise_has_the_rank_of_its_conditions(top, rank):
    """A rich equation with diagonal noise has as many independent differentials, and trees that coincide do so."""
    kind = BY_NAME["diagonal"]
    trees = kind.trees(2, top)
    rows = RichEquation(2, tuple(trees)).elementary(trees).reshape(len(trees), -1).T

    by_weight = [rows[:, [each.weight == weight for each in trees]] for weight in range(1, top + 1)]
    scaled = [part / np.linalg.norm(part, axis=0) for part in by_weight]
    assert sum(np.linalg.matrix_rank(part, tol=1e-6) for part in scaled) == rank
    assert conditions_carry(kind, trees, rows)


def test_differentials_of_the_rich_equation_are_derivatives():
    """F of f(b1), b1(t) and f(b1,b2) are differences of the coefficients."""
    trees = {str(each): each for each in BY_NAME["diagonal"].trees(2, 4)}
    equation, e = RichEquation(2, tuple(trees.values())), 1e-4
    wanted = [trees["b1"], trees["b2"], trees["f(b1)"], trees["b1(t)"], trees["f(b1,b2)"]]
    b1, b2, fb, bt, fbb = equation.elementary(wanted)
    x, t, still = equation.x, 0.34375, np.zeros((2, equation.states))

    def f(a, c):
        return equation.drift(t, x + np.concatenate([a * b1 + c * b2, still]))[:2]

    np.testing.assert_allclose((f(e, 0) - f(-e, 0)) / (2 * e), fb, atol=1e-6)
    np.testing.assert_allclose((f(e, e) - f(e, -e) - f(-e, e) + f(-e, -e)) / (4 * e * e), fbb, atol=1e-5)
    later, sooner = (equation.diffusion(t + s, x)[0, 0] for s in (e, -e))
    np.testing.assert_allclose((later - sooner) / (2 * e), bt[0], atol=1e-6)


def test_linear_equations_have_words_for_conditions():
    """Coefficients A x + a are differentiated once: as many trees as words, each letter 0 counting 2."""
    linear = EquationClass("scalar, linear", motions=1, linear=True)
    assert [len(linear.trees(1, top)) for top in (1, 2, 3, 4, 5)] == [1, 3, 6, 11, 19]


def test_equations_of_a_linear_class_are_linear():
    """Those that an affine map relates, and the universal one, are A x + a with constants: QuTiP takes them."""
    linear = EquationClass("scalar, linear", motions=1, linear=True)
    related = related_equations(linear, 1)
    some = (related.near.below, related.near.above, Universal(linear.trees(1, 4), 1).sde)
    assert {why_not_linear_equation(each) for each in some} == {""}
    assert why_not_linear_equation(related_equations(BY_NAME["scalar"], 1).near.below)
