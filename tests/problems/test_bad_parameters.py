"""Parameters that make no sense are refused in one line that names the parameter."""

from math import inf, nan
from typing import Any

import pytest

from facade import load_registry
from sdaeverify import ParameterError
from sdaeverify_problems import Fibre, clamped_chain

NOT_NEGATIVE = "eps must be finite and not negative, got"
REFUSED: list[tuple[str, dict[str, Any], str]] = [
    ("affine-constraint", {"eps": -1.0}, f"{NOT_NEGATIVE} -1.0"),
    ("affine-constraint", {"d": 2, "q": 2}, "q must be between 1 and d - 1, got q = 2 and d = 2"),
    ("affine-constraint", {"coupling": -5.0}, "the symmetric part of K is not positive definite for coupling = -5.0"),
    ("constrained-curve", {"shape": "knot"}, "shape must be one of ellipse, space, got 'knot'"),
    ("constrained-curve", {"eps": nan}, f"{NOT_NEGATIVE} nan"),
    ("constrained-curve", {"sigma": -1.0}, "sigma must be positive and finite, got -1.0"),
    ("damped-pendulum", {"mass": 0.0}, "mass must be positive and finite, got"),
    ("damped-pendulum", {"mass": inf}, "mass must be positive and finite, got"),
    ("delay-linear", {"A": 1e300}, "must be finite and grow by no more than"),
    ("delay-linear", {"c": -1e11}, "must be finite and grow by no more than"),
    ("delay-linear", {"d": nan}, "d of problem 'delay-linear'|must be finite and grow by no more than"),
    ("exponential-strip", {"eps": nan}, f"{NOT_NEGATIVE} nan"),
    ("exponential-strip", {"q": 0}, "q must be at least 1, got 0"),
    ("exponential-strip", {"alpha": 0.0}, "alpha must be positive and finite, got 0.0"),
    ("fibre-clamped", {"N": 1}, "N must be a whole number from 2 to 100000, got 1"),
    ("fibre-clamped", {"d": 4}, "d must be a whole number from 2 to 3, got 4"),
    ("fibre-free", {"alpha": nan}, "alpha must be positive"),
    ("fibre-free", {"beta": -0.1}, "beta must be finite and not negative"),
    ("fibre-linear", {"Dr": 0.0}, "Dr must be positive"),
    ("forced-ou", {"a": 0.0}, "a must be positive"),
    (
        "hyperbolic-pair",
        {"c": 3.15, "b_1": 2.76, "b_2": 0.124, "x_1": 0.793, "horizon": 2.84},
        "standard deviation of 3 at the end, got 24:",
    ),
    ("orthogonal-group", {"m": 1}, "m must be at least 2"),
    ("orthogonal-group", {"stiffness": 1e9}, "stiffness must be at most 1e4"),
    ("penalised-sphere", {"eps": -0.1}, f"{NOT_NEGATIVE} -0.1"),
    ("penalised-sphere", {"damping": -1.0}, "damping must be finite and not negative, got -1.0"),
    ("penalised-sphere", {"pull": 1.0, "spin": 1.0}, "no closed form is known with pull and damping or spin"),
    ("rigid-trimer", {"sigma": 0.0}, "sigma must be positive and finite, got 0.0"),
    ("sphere-langevin", {"m_2": -1.0}, "masses must be positive and finite, got"),
    ("sphere-product", {"spheres": 1}, "d and spheres must be at least 2, got 2 and 1"),
    ("sphere-product", {"mixing": nan}, "A must be regular"),
    ("stiefel", {"p": 4}, "p must be between 1 and d"),
    ("torus", {"stiffness": 1.0}, "stiffness"),
    ("tube-torus", {"eps": -1.0}, "eps"),
]


@pytest.mark.parametrize(("problem", "parameters", "message"), REFUSED)
def test_bad_parameters_are_named(problem: str, parameters: dict[str, Any], message: str) -> None:
    """One line says which parameter it is."""
    with pytest.raises(ParameterError, match=message) as caught:
        load_registry([]).problems[problem].thing(**parameters)

    assert "\n" not in str(caught.value)


def test_gravity_must_be_given_by_a_positive_number() -> None:
    """The Froude number of a fibre of one's own is checked, too."""
    with pytest.raises(ParameterError, match=r"Fr must be positive, got -1\.0"):
        Fibre(chain=clamped_chain(3, 2), Fr=-1.0)
