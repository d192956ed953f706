"""What makes no sense is refused in one line that names it: by shipped problems, and by builders of problems."""

from collections.abc import Callable
from math import inf, nan
from typing import Any

import numpy as np
import pytest

from facade import Fibre, clamped_chain, fibre_problem, free_chain, load_registry
from sdaeverify import ParameterError, ProblemError, SdaeverifyError
from sdaeverify_problems import Bath, constrained_langevin, rotation

REGISTRY = load_registry([])
NOT_NEGATIVE = "eps must be finite and not negative, got"
PARAMETERS: list[tuple[str, dict[str, Any], str]] = [
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
    (
        "penalised-sphere",
        {"pull": 1.0, "spin": 1.0},
        "no closed form is known for pull combined with damping or spin",
    ),
    ("rigid-trimer", {"sigma": 0.0}, "sigma must be positive and finite, got 0.0"),
    ("sphere-langevin", {"m_2": -1.0}, "m_2 must be positive and finite, got -1.0"),
    ("sphere-product", {"spheres": 1}, "spheres must be at least 2, got 1"),
    ("sphere-product", {"mixing": nan}, "A must be regular"),
    ("stiefel", {"p": 4}, "p must be between 1 and d"),
    ("torus", {"stiffness": 1.0}, "stiffness"),
    ("tube-torus", {"eps": -1.0}, "eps"),
]


@pytest.mark.parametrize(("problem", "parameters", "message"), PARAMETERS)
def test_bad_parameters_are_named(problem: str, parameters: dict[str, Any], message: str) -> None:
    """One line says which parameter it is."""
    with pytest.raises(ParameterError, match=message) as caught:
        REGISTRY.problems[problem].thing(**parameters)

    assert "\n" not in str(caught.value)


CHAIN = clamped_chain(3, 2)
CIRCLE: dict[str, Any] = {
    "constraint": lambda x: 0.5 * (1.0 - (x * x).sum(axis=0, keepdims=True)),
    "position": [1.0, 0.0],
    "velocity": [0.0, 1.0],
    "horizon": 1.0,
}
MATRIX = np.array([[1.0, 0.3], [0.3, 0.8]])


def chain(build: Callable[..., object], **odd: Any) -> object:
    return build(**{"N": 3, "d": 2, **odd})


def fibre(**odd: Any) -> Any:
    return fibre_problem(Fibre(**{"chain": CHAIN, **odd}), 0.01)


def problem(**odd: Any) -> object:
    return fibre_problem(**{"fibre": Fibre(chain=CHAIN), "horizon": 0.01, **odd})


def bath(**odd: Any) -> Bath:
    return Bath(**{"friction": 1.0, "kT": 1.0, **odd})


BATH = bath()


def langevin(gradient: Any = lambda x: 0.0 * x, bath: Any = BATH, **odd: Any) -> object:
    return constrained_langevin(gradient, bath, **{**CIRCLE, **odd})


def stretched(chain: Any, row: int) -> object:
    """Return a fibre whose points from a row on are too far away."""
    position = chain.straight().reshape(chain.N, chain.d)
    position[row:] *= 1.0 + 0.05 / np.linalg.norm(position[row])
    return fibre_problem(Fibre(chain=chain), 0.01, position=position)


FRICTION = "friction must be a positive number"
MESSAGES: list[tuple[Callable[[], object], str]] = [
    (lambda: fibre(Fr=-1.0), r"Fr must be positive, got -1\.0"),
    (lambda: fibre(alpha="x"), "alpha must be a number, got 'x'"),
    (lambda: fibre(flow=3), "flow must be a function, got 3"),
    (lambda: fibre(flow=lambda r, t: r[0]), r"flow u\(r, t\) returned \(4, 3\), expected \(2, 4, 3\)"),
    (lambda: fibre(flow=lambda r, t: np.zeros(2)), r"flow u\(r, t\) returned \(2,\)"),
    (lambda: fibre(flow=lambda r, t: 0.0), r"flow u\(r, t\) returned float"),
    (lambda: fibre(flow=lambda r, t: np.zeros((2, 3, 3))), r"flow u\(r, t\) returned \(2, 3, 3\)"),
    (lambda: fibre(C=lambda r, tau, t: r), r"C\(r, tau, t\) returned \(2, 4, 3\), expected \(2, 2, 4, 3\)"),
    (
        lambda: fibre(D=lambda r, v, tau, t: np.eye(2)),
        r"D\(r, v, tau, t\) returned \(2, 2\), expected \(2, 2, 4, 3\)",
    ),
    (lambda: problem(fibre=None), "fibre must be a Fibre, got None"),
    (lambda: problem(position=np.zeros(6)), r"position has shape \(6,\), expected \(3, 2\): points, components"),
    (lambda: problem(velocity=[[0.0, 0.0], [0.0, 0.0], [0.0, -1.0]]), "violate Dg v = 0"),
    (lambda: chain(free_chain, N=2.5), "N must be a whole number from 2 to 100000, got 2.5"),
    (lambda: stretched(CHAIN, 0), r"0\.3 from the clamp r_0 to point 1, expected ds = 0\.25"),
    (lambda: stretched(CHAIN, 2), r"0\.3 from point 2 to point 3, expected ds = 0\.25"),
    (lambda: stretched(free_chain(4, 2), 3), r"0\.3 from point 3 to point 4, expected ds = 0\.25"),
    *[(lambda odd=odd: langevin(bath=bath(friction=odd)), FRICTION) for odd in (0.0, -1.0, nan, lambda r: r[1])],
    *[
        (lambda odd=odd: langevin(bath=bath(friction=odd)), "symmetric positive definite")
        for odd in (MATRIX + np.eye(2, k=1), np.diag([1.0, -0.1]))
    ],
    (lambda: langevin(bath=bath(friction=np.eye(3))), r"of shape \(2, 2\)"),
    *[(lambda odd=odd: langevin(bath=bath(kT=odd)), "temperature kT must be positive") for odd in (0.0, inf)],
    (lambda: langevin(bath=bath(noise=lambda r: np.eye(2)[..., None])), "must be 2 kT gamma"),
    (
        lambda: langevin(mass=np.diag([1.0, 0.0])),
        "mass must be positive definite beyond rounding, its eigenvalues are",
    ),
    (
        lambda: constrained_langevin(lambda r: r, bath()),
        "^constrained Langevin dynamics need an initial position",
    ),
    (
        lambda: constrained_langevin(lambda r: r[0], bath(), position=[1.0, 0.0, 0.0]),
        r"^grad V returned shape \(1,\) for positions of shape \(3, 1\)$",
    ),
]


@pytest.mark.parametrize(("call", "message"), MESSAGES)
def test_a_mistake_is_named(call: Callable[[], object], message: str) -> None:
    """The argument and what was given, or what a function returned, stand in one line."""
    with pytest.raises((ParameterError, ProblemError), match=message) as caught:
        call()
    assert "\n" not in str(caught.value)


def test_a_users_own_error_is_the_cause() -> None:
    """What a user's function raises is told."""
    with pytest.raises(SdaeverifyError, match="cannot be made with these arguments: ZeroDivisionError") as caught:
        langevin(gradient=lambda x: 1 / 0)
    assert isinstance(caught.value.__cause__, ZeroDivisionError)


NUMBERS = [-1, -1.5, 0, nan, inf, -inf, 1e300, 10**30, 2.5, True, 1e-320, 1j]
OTHERS = ["x", "", None, [1.0], {}, object(), b"1", int, np.zeros((2, 2)), np.array([nan]), lambda *given: None]
ARGUMENTS: dict[Callable[..., object], tuple[str, ...]] = {
    lambda **odd: chain(clamped_chain, **odd): ("N", "d"),
    lambda **odd: chain(free_chain, **odd): ("N", "d"),
    lambda flow: fibre(flow=rotation(flow)): ("flow",),
    fibre: ("chain", "alpha", "Fr", "Dr", "beta", "flow", "C", "D"),
    problem: ("fibre", "horizon", "position", "velocity"),
    lambda **odd: langevin(bath=bath(**odd)): ("friction", "kT", "noise"),
    langevin: (
        "gradient",
        "bath",
        *CIRCLE,
        "jacobian",
        "curvature",
        "mass",
        "observables",
        "constraint_bound",
    ),
}


@pytest.mark.parametrize(("build", "name"), [(build, name) for build, names in ARGUMENTS.items() for name in names])
def test_what_is_no_argument_is_refused_in_one_line(build: Callable[..., object], name: str) -> None:
    """Numbers out of range, texts, objects and functions of another shape are taken, or refused by a message."""
    said = []
    for odd in (*NUMBERS, *OTHERS):
        try:
            build(**{name: odd})
        except SdaeverifyError as error:
            said.append(str(error))

    assert said
    assert not [text for text in said if "\n" in text or not text]


def test_functions_of_fibres_may_be_the_same_on_all_edges_and_paths() -> None:
    """Shapes of length 1 along the last two axes are the right ones, too."""
    one = np.eye(2)[..., None, None]
    same = fibre(flow=lambda r, t: one[0], C=lambda r, tau, t: 2.0 * one, D=lambda r, v, tau, t: 3.0 * one)
    r, v, _ = same.initial(4)

    np.testing.assert_allclose(same.diffusion(0.0, r, v), 6.0 * fibre().diffusion(0.0, r, v), rtol=1e-14)
