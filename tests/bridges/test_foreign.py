"""Formulas written with NumPy on arrays of another library: here NumPy's own, in disguise."""

import numpy as np
import pytest

from sdaeverify_bridges.kit import Foreign

X = np.array([[1.0, 2.0, 3.0], [0.5, -1.0, 4.0]])
A = np.array([[0.0, 1.0], [-1.0, 0.0]])

FORMULAS = {
    "operators": lambda x: 2.0 * x[0] - x[1] ** 2 / 3.0,
    "ufuncs": lambda x: np.sin(x) + np.maximum(x, 0.0) * np.exp(-x),
    "matrix from the left": lambda x: A @ x,
    "stacked": lambda x: np.stack([x[1], -x[0]]),
    "joined": lambda x: np.concatenate([x[:1], 0.0 * x[1:]]),
    "new axis": lambda x: x[:, None] * np.ones((1, 2, 1)),
    "einsum": lambda x: np.einsum("ij,jp->ip", A, x),
    "chosen": lambda x: np.where(x > 0.0, x, -x),
    "summed": lambda x: np.sum(x**2, axis=0),
    "method": lambda x: x.sum(axis=0),
    "complex step": lambda x: np.imag((x + 1e-100j) ** 3) / 1e-100,
    "linear algebra": lambda x: np.linalg.solve(A, x),
    "alike": lambda x: np.zeros_like(x) + np.full_like(x, 2.0),
    "rows": sum,
}


@pytest.mark.parametrize("name", FORMULAS)
def test_formula_runs_as_it_is(name):
    """A formula gives the numbers that it gives on NumPy's arrays."""
    found = FORMULAS[name](Foreign(X, np))

    np.testing.assert_array_equal(found.array, FORMULAS[name](X))


def add_in_place(x):
    """Write into a state."""
    x += 1.0


@pytest.mark.parametrize(
    "formula",
    [lambda x: float(x[0, 0]), lambda x: 1.0 if x[0, 0] > 0.0 else 0.0, np.asarray, add_in_place, np.add.reduce],
    ids=["a number", "a branch", "an array", "in place", "a reduction"],
)
def test_what_leaves_the_functions_of_numpy_is_refused(formula):
    """A formula that another library could not follow raises, and changes nothing."""
    state = X.copy()

    with pytest.raises(TypeError):
        formula(Foreign(state, np))
    np.testing.assert_array_equal(state, X)


def test_function_that_the_library_has_not_is_named():
    """The error says what is missing."""
    with pytest.raises(TypeError, match="uses sin, which the library does not provide"):
        np.sin(Foreign(X, object()))
