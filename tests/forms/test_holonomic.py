"""The constrained form: what it refuses, its derivatives, mass matrix and residuals."""

import dataclasses
import pickle

import numpy as np
import pytest

from forms.refusing import refusal
from sdaeverify import SDE, DenseJacobian, HolonomicSDAE, ProblemError

EPS = np.finfo(float).eps
MASS = np.array([[2.0, 0.5, 0.0], [0.5, 1.0, 0.2], [0.0, 0.2, 3.0]])


def force(t, r, v):
    """Return gravity and friction."""
    return np.array([[0.0], [0.0], [-1.0]]) - 0.1 * v


def diffusion(t, r, v):
    """Return isotropic noise."""
    return np.eye(3)[..., None]


def constraint(r):
    """Return g = (r_0^2 + r_1^2 + exp(r_2) - 2, sin(r_0) - r_1)."""
    return np.stack([r[0] ** 2 + r[1] ** 2 + np.exp(r[2]) - 2.0, np.sin(r[0]) - r[1]])


def jacobian(r):
    """Return Dg, shape (2, 3, P)."""
    one = np.ones_like(r[0])
    return np.stack([np.stack([2.0 * r[0], 2.0 * r[1], np.exp(r[2])]), np.stack([np.cos(r[0]), -one, 0.0 * one])])


X0 = 0.4
POSITION = np.array([X0, np.sin(X0), np.log(2.0 - X0**2 - np.sin(X0) ** 2)])
# Tangent: v_1 = cos(r_0) v_0 from the second constraint, v_2 from the first.
VELOCITY = np.array([1.0, np.cos(X0), -2.0 * (POSITION[0] + POSITION[1] * np.cos(X0)) / np.exp(POSITION[2])])
R = np.array([[0.3, -0.5, 1.2, 0.0], [0.1, 0.8, -0.4, 0.0], [0.6, -1.0, 0.2, 0.0]])
Y = np.array([[1.0, 0.2, -0.3, 1.0], [-0.5, 1.0, 0.1, 2.0], [0.4, 0.3, 2.0, -1.0]])
Z = np.array([[0.2, -1.0, 0.5, 0.0], [1.0, 0.4, 0.3, 1.0], [-0.7, 0.6, 0.1, 1.0]])


def make(**changes):
    """Return a valid problem with two constraints in R^3, with some of its arguments changed."""
    valid = {"force": force, "diffusion": diffusion, "constraint": constraint, "horizon": 1.0, "noise_dim": 3}
    data = {"position": POSITION, "velocity": VELOCITY, "source": "made up"}
    return HolonomicSDAE(**{**valid, **data, **changes})


def analytic(values):
    """Return a constraint with given values near the start and a Jacobian of full rank."""
    return lambda r: np.stack([r[0] - POSITION[0] + values, r[1] - POSITION[1]])


def real_buffer_jacobian(r):
    """Fill Dg into a buffer that cannot hold an imaginary part."""
    out = np.zeros((2, 3, r.shape[-1]))
    out[...] = jacobian(r)
    return out


REFUSED = [
    ({"position": [0.0, np.inf, 0.0]}, "position must be a vector of finite numbers, got [0.0, inf, 0.0]"),
    ({"velocity": [1.0, 0.0]}, "velocity has 2 components, position has 3"),
    ({"constraint": lambda r: 1.0 * r}, "constraint(r) has 3 components, expected between 1 and 2"),
    ({"constraint": lambda r: r[:0]}, "constraint(r) has 0 components, expected between 1 and 2"),
    (
        {"constraint": lambda r: r[0] - POSITION[0]},
        "constraint(r) returned shape (3,), expected (1, 3) for 3 paths (paths last)",
    ),
    ({"constraint": analytic(np.nan)}, "constraint(r) is not finite at the initial state: [nan, 0.0]"),
    ({"force": lambda t, r, v: v[:2]}, "force(t, r, v) returned shape (2, 3), expected (3, 3)"),
    ({"force": lambda t, r, v: np.nan * v}, "force(t, r, v) is not finite at the initial state"),
    ({"force": lambda t, r, v: 0.0}, "force(t, r, v) returned float, expected an array of real numbers"),
    ({"diffusion": lambda t, r, v: np.eye(3)}, "diffusion(t, r, v) returned shape (3, 3), expected (3, 3, 3)"),
    ({"noise_dim": 2}, "diffusion(t, r, v) returned shape (3, 3, 1), expected (3, 2, 3)"),
    ({"jacobian": lambda r: jacobian(r)[0]}, "jacobian(r) returned shape (3, 3), expected (2, 3, 3)"),
    (
        {"curvature": lambda r, y, z: y[0]},
        "curvature(r, y, z) returned shape (3,), expected (2, 3)",
    ),
    (
        {"constraint": lambda r: np.stack([np.abs(r[0]) - POSITION[0], r[1] - POSITION[1]])},
        "constraint is not analytic (abs or a real array?), so that Dg cannot be taken by complex step; give",
    ),
    (
        {"jacobian": real_buffer_jacobian},
        "jacobian is not analytic (abs or a real array?), so that D^2 g cannot be taken by complex step; give curv",
    ),
    (
        {"constraint": lambda r: np.stack([constraint(r)[0], 3.0 * constraint(r)[0]])},
        "Dg does not have full rank at the initial position [0.4,",
    ),
    ({"position": POSITION + np.array([0.0, 0.0, 1e-6])}, "initial data violate g = 0: g is"),
    ({"velocity": VELOCITY + np.array([0.0, 1e-6, 0.0])}, "initial data violate Dg v = 0: Dg v is"),
    ({"mass": np.eye(2)}, "mass must be a finite matrix of shape (3, 3), got array([[1., 0.]"),
    ({"mass": np.diag([1.0, np.nan, 1.0])}, "mass must be a finite matrix of shape (3, 3), got"),
    ({"mass": [["a"] * 3] * 3}, "mass must be a finite matrix of shape (3, 3), got [['a', 'a', 'a'],"),
    ({"mass": np.triu(np.ones((3, 3)))}, "mass must be symmetric, got [[1.0, 1.0, 1.0], [0.0, 1.0, 1.0],"),
    (
        {"mass": np.diag([1.0, -1.0, 1.0])},
        "mass must be positive definite beyond rounding, its eigenvalues are [-1.0",
    ),
    ({"mass": np.ones((3, 3))}, "mass must be positive definite beyond rounding, its eigenvalues are"),
    ({"constraint_bound": 0.5}, "constraint_bound C_g must be finite and at least 1, got 0.5"),
    ({"constraint_bound": np.inf}, "constraint_bound C_g must be finite and at least 1, got inf"),
    ({"diffusion_product": lambda t, r, v, w: 1.1 * w}, "diffusion_product disagrees"),
    ({"diffusion_product": lambda t, r, v, w: w[:1]}, "diffusion_product returned shape"),
    ({"linearisation": lambda r: DenseJacobian(1.1 * jacobian(r))}, "disagrees with the derivative"),
    ({"linearisation": lambda r: DenseJacobian(jacobian(r)), "mass": MASS}, "with a mass matrix"),
]


@pytest.mark.parametrize(("changes", "message"), REFUSED, ids=[text for _, text in REFUSED])
def test_contradictory_problems_are_refused_in_one_line(changes, message):
    """The message says what was expected and what was given."""
    assert message in refusal(make, **changes)


def test_inconsistent_initial_data_are_shown():
    """The message about the start names the residual, its size and its component, and no whole vector."""
    v = np.array([2.0, 0.0, 0.0])
    values = make().dg(make().initial(1).r)[..., 0] @ v
    worst = np.abs(values).argmax()
    where = f"{values[worst]:.3g} in component {worst + 1} of {len(values)}"
    with pytest.raises(ProblemError, match=rf"violate Dg v = 0: Dg v is {where}$"):
        make(velocity=v)


def test_a_mass_matrix_symmetric_up_to_rounding_is_accepted():
    """Q D Q^T is symmetric up to eps of its largest entry, also where its entries cancel."""
    Q, _ = np.linalg.qr(np.array([[1.0, 2.0, 0.5], [-1.0, 1.0, 3.0], [0.3, 0.1, 1.0]]))
    M = Q @ np.diag([1.0, 1.0, 1.0 + 1e-13]) @ Q.T
    assert make(mass=M).dimension == 3


def test_inverse_mass_undoes_the_mass():
    """M M^{-1} y = y for vectors (n, P) and matrices (n, l, P)."""
    problem, matrices = make(mass=MASS), np.stack([Y, Z], axis=1)
    bound = 16 * EPS * np.linalg.cond(MASS)
    assert np.abs(MASS @ problem.inverse_mass(Y) - Y).max() <= bound * np.abs(Y).max()
    assert np.abs(np.einsum("ij,jlp->ilp", MASS, problem.inverse_mass(matrices)) - matrices).max() <= 2 * bound


def test_gram_matrices_are_those_of_each_path():
    """G_M = Dg M^{-1} Dg^T, also for Jacobians at two different positions."""
    problem, left, right = make(mass=MASS), jacobian(R), jacobian(R + 0.1)
    gram = problem.linearised(R).gram(problem.linearised(R + 0.1)).matrix
    for p in range(R.shape[1]):
        expected = left[..., p] @ np.linalg.solve(MASS, right[..., p].T)
        assert np.abs(gram[..., p] - expected).max() <= 64 * EPS * np.linalg.cond(MASS) * 10


def test_a_constant_jacobian_may_have_one_column_of_paths():
    """For a linear constraint Dg may be (m, n, 1), and all that is made of it fits any number of paths."""
    line = {"constraint": lambda r: (r[0] + r[1] - 1.0)[None], "position": [0.5, 0.5, 0.0]}
    data = {"velocity": [1.0, -1.0, 0.0], "mass": MASS, "jacobian": lambda r: np.array([[[1.0], [1.0], [0.0]]])}
    narrow, wide = make(**line, **data), make(**{**line, **data, "jacobian": None})
    x = np.concatenate([R, Y])
    for name in ("drift", "diffusion"):
        a, b = getattr(narrow.view(SDE), name)(0.0, x), getattr(wide.view(SDE), name)(0.0, x)
        assert np.abs(a - b).max() <= 1e-11


def test_residuals_are_the_constraint_and_its_hidden_companion():
    """g(r) and Dg(r) v come with the size |Dg| |r| and |Dg| |v| of the terms that cancel in them."""
    problem = make(jacobian=jacobian)
    residuals = problem.residuals({"r": R, "v": Y})
    size = np.sqrt((jacobian(R) ** 2).sum(axis=(0, 1)))
    assert np.array_equal(residuals["g"].value, constraint(R))
    assert np.allclose(residuals["Dg v"].value, np.einsum("mnp,np->mp", jacobian(R), Y), rtol=0, atol=64 * EPS)
    assert np.allclose(residuals["g"].scale, size * np.linalg.norm(R, axis=0), rtol=16 * EPS)
    assert np.allclose(residuals["Dg v"].scale, size * np.linalg.norm(Y, axis=0), rtol=16 * EPS)


def test_a_changed_copy_is_checked_again():
    """Replacing a field of a problem makes a new, checked one."""
    assert dataclasses.replace(make(mass=MASS), horizon=2.0).horizon == 2.0
    with pytest.raises(ProblemError, match="initial data violate"):
        dataclasses.replace(make(), velocity=[1.0, 1.0, 1.0])


def test_a_problem_made_of_module_functions_can_be_pickled():
    """A pickled problem keeps its mass matrix."""
    copy = pickle.loads(pickle.dumps(make(mass=MASS)))
    assert np.array_equal(copy.inverse_mass(Y), make(mass=MASS).inverse_mass(Y))
