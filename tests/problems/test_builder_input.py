"""Whatever is given to a builder of problems, it is taken or refused in one line."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from sdaeverify import SdaeverifyError
from sdaeverify_problems import Bath, Fibre, clamped_chain, constrained_langevin, fibre_problem, free_chain, rotation

NUMBERS = [-1, -1.5, 0, float("nan"), float("inf"), float("-inf"), 1e300, 10**30, 2.5, True, 1e-320, 1j]
OTHERS = ["x", "", None, [1.0], {}, object(), b"1", int, np.zeros((2, 2)), np.array([np.nan]), lambda *given: None]
CHAIN = clamped_chain(3, 2)
CIRCLE: dict[str, Any] = {
    "constraint": lambda x: 0.5 * (1.0 - (x * x).sum(axis=0, keepdims=True)),
    "position": [1.0, 0.0],
    "velocity": [0.0, 1.0],
    "horizon": 1.0,
}
FURTHER = ("jacobian", "curvature", "mass", "observables", "constraint_bound")


def chain(build: Callable[..., object], **odd: Any) -> object:
    return build(**{"N": 3, "d": 2, **odd})


def fibre(**odd: Any) -> object:
    return fibre_problem(Fibre(**{"chain": CHAIN, **odd}), 0.01)


def problem(**odd: Any) -> object:
    return fibre_problem(**{"fibre": Fibre(chain=CHAIN), "horizon": 0.01, **odd})


def langevin(gradient: Any = lambda x: 0.0 * x, bath: Any = None, **odd: Any) -> object:
    return constrained_langevin(gradient, Bath(friction=1.0, kT=1.0) if bath is None else bath, **{**CIRCLE, **odd})


BUILDERS: dict[str, Callable[[Any], object]] = {
    **{
        f"{build.__name__} {name}": lambda odd, build=build, name=name: chain(build, **{name: odd})
        for build in (clamped_chain, free_chain)
        for name in ("N", "d")
    },
    **{
        f"Fibre {name}": lambda odd, name=name: fibre(**{name: odd})
        for name in ("chain", "alpha", "Fr", "Dr", "beta", "flow", "C", "D")
    },
    **{
        f"fibre_problem {name}": lambda odd, name=name: problem(**{name: odd})
        for name in ("fibre", "horizon", "position", "velocity")
    },
    **{
        f"Bath {name}": lambda odd, name=name: langevin(bath=Bath(**{"friction": 1.0, "kT": 1.0, name: odd}))
        for name in ("friction", "kT", "noise")
    },
    **{
        f"constrained_langevin {name}": lambda odd, name=name: langevin(**{name: odd})
        for name in ("gradient", "bath", *CIRCLE, *FURTHER)
    },
    "rotation": lambda odd: fibre(flow=rotation(odd)),
}


@pytest.mark.parametrize("builder", BUILDERS)
def test_what_is_no_argument_is_refused_in_one_line(builder):
    """Numbers out of range, texts, objects and functions of another shape are taken, or refused by a message."""
    said = []
    for odd in (*NUMBERS, *OTHERS):
        try:
            BUILDERS[builder](odd)
        except SdaeverifyError as error:
            said.append(str(error))

    assert said
    assert not [text for text in said if "\n" in text or not text]


def test_a_mistake_is_named():
    """The argument and what was given stand in the message, and a user's own error is its cause."""
    for call, message in (
        (lambda: fibre(alpha="x"), "alpha must be a number, got 'x'"),
        (lambda: fibre(flow=3), "flow must be a function, got 3"),
        (lambda: problem(fibre=None), "fibre must be a Fibre, got None"),
        (lambda: chain(free_chain, N=2.5), "N must be a whole number from 2 to 100000, got 2.5"),
    ):
        with pytest.raises(SdaeverifyError, match=message):
            call()
    with pytest.raises(SdaeverifyError, match="cannot be made with these arguments: ZeroDivisionError") as caught:
        langevin(gradient=lambda x: 1 / 0)
    assert isinstance(caught.value.__cause__, ZeroDivisionError)
