"""A trait that a problem has not is noticed, where it is made or by the evidence against the trait."""

import numpy as np
import pytest

from facade import EVIDENCE, ProblemSpec, ProblemSubject, load_plugins
from sdaeverify import SDE, DelaySDAE, Dissipation, ProblemError


def against(trait, build):
    """Return what speaks against a trait of a problem."""
    return EVIDENCE[trait](ProblemSubject(ProblemSpec("planted", build), load_plugins()))


def two_noises(diffusion, trait):
    on_circle = {"constraint": lambda x: ((x * x).sum(axis=0) - 5.0)[None]}
    circle = on_circle if trait in {"normal-milstein-term", "unconstrained"} else {}
    return SDE(
        drift=lambda t, x: -x,
        diffusion=diffusion,
        start=[1.0, 2.0],
        noise_dim=2,
        horizon=1.0,
        source="planted",
        traits=frozenset({trait}),
        **circle,
    )


STRETCH = np.array([[1.0], [2.0]])
FALSE = {
    "unconstrained, but on a circle": (lambda t, x: np.stack([x, x], axis=1), "unconstrained"),
    "constrained, but free": (lambda t, x: np.stack([x, x], axis=1), "constrained"),
    "scalar, but two": (lambda t, x: np.stack([x, x], axis=1), "scalar-noise"),
    "additive, moves with time": (lambda t, x: (1.0 + t) * np.eye(2)[..., None], "additive-noise"),
    "additive, moves with the state": (lambda t, x: x * np.eye(2)[..., None], "additive-noise"),
    "diagonal, but full": (lambda t, x: np.stack([x, x], axis=1), "diagonal-noise"),
    "diagonal, but crossed": (lambda t, x: x[::-1] * np.eye(2)[..., None], "diagonal-noise"),
    "normal, but faster on one side": (
        lambda t, x: np.stack([x[1] * x[0], -x[0] * x[0]])[:, None] * np.ones((1, 2, 1)),
        "normal-milstein-term",
    ),
    "commutative, but sheared": (lambda t, x: np.stack([x * STRETCH, x[::-1]], axis=1), "commutative-noise"),
    "commutative, but kinked": (lambda t, x: np.stack([x * STRETCH, np.abs(x[::-1])], axis=1), "commutative-noise"),
    "milstein, but diagonal": (lambda t, x: x * np.eye(2)[..., None], "vanishing-milstein-term"),
}


@pytest.mark.parametrize("name", FALSE)
def test_false_traits_are_noticed(name):
    """A problem that declares a trait it has not cannot be made, or there is evidence against this trait."""
    diffusion, trait = FALSE[name]
    try:
        text = against(trait, lambda: two_noises(diffusion, trait))
    except ProblemError as error:
        text = str(error)

    assert text


def overdamped(drift, diffusion):
    """Return an equation whose coefficients are changed after the form has looked at them."""
    problem = SDE(
        drift=lambda t, x: -x,
        diffusion=lambda t, x: np.eye(2)[..., None],
        start=[1.0, 2.0],
        noise_dim=2,
        horizon=1.0,
        source="planted",
        traits=frozenset({"overdamped-gradient"}),
    )
    object.__setattr__(problem, "drift", drift)
    object.__setattr__(problem, "diffusion", diffusion)
    return problem


NO_GRADIENTS = {
    "right": (lambda t, x: -x * (x * x).sum(axis=0), lambda t, x: 0.3 * np.eye(2)[..., None], ""),
    "turns": (lambda t, x: -x + 1e-3 * x[::-1] * [[1.0], [-1.0]], lambda t, x: np.eye(2)[..., None], "Df less"),
    "later": (lambda t, x: -x * (1.0 + 1e-9 * t), lambda t, x: np.eye(2)[..., None], "depends on time"),
    "uneven": (lambda t, x: -x, lambda t, x: np.diag([1.0, 1.001])[..., None], "not a multiple of Id"),
}


@pytest.mark.parametrize("name", NO_GRADIENTS)
def test_overdamped_dynamics_are_told_from_others(name):
    """The right one passes; a drift that turns or depends on time and uneven noise are noticed."""
    drift, diffusion, words = NO_GRADIENTS[name]
    text = against("overdamped-gradient", lambda: overdamped(drift, diffusion))

    assert words in text
    assert bool(text) == bool(words)


def delayed(**changes):
    """Return dx = -2 x dt + v dW with a delay, and without y, changed."""
    fields = {
        "drift": lambda t, x, v, y: -2.0 * x,
        "diffusion": lambda t, x, v, y: v[:, None],
        "delay": 0.5,
        "history": lambda t: [1.0],
        "noise_dim": 1,
        "horizon": 1.0,
        "source": "planted",
    }
    return DelaySDAE(**{**fields, **changes})


RIGHT = Dissipation(abar=2.0, al0=2.0, al1=0.0, al2=0.0, be0=0.0, be1=1.0, be2=0.0, L1=1.0, L2=0.0, L3=0.0)
FALSE_WITH_DELAY = {
    "noise of the state": ("delayed-noise", {"diffusion": lambda t, x, v, y: x[:, None] + v[:, None]}),
    "no y": ("algebraic", {}),
    "a delay": ("no-delay", {}),
    "less damping": ("dissipative", {"dissipation": RIGHT._replace(abar=2.5)}),
    "more drift": ("dissipative", {"dissipation": RIGHT._replace(al0=1.5)}),
    "more noise": ("dissipative", {"dissipation": RIGHT._replace(be1=0.5)}),
    "more noise without y": ("dissipative", {"dissipation_without_y": RIGHT._replace(be1=0.5)}),
}


@pytest.mark.parametrize("name", FALSE_WITH_DELAY)
def test_false_traits_of_delay_equations_are_noticed(name):
    """There is nothing against a trait where the problem has it, and something where one term is changed."""
    trait, change = FALSE_WITH_DELAY[name]

    assert against(trait, lambda: delayed(**change))


@pytest.mark.parametrize(("trait", "delay"), [("dissipative", 0.5), ("delayed-noise", 0.5), ("no-delay", 0.0)])
def test_true_traits_of_delay_equations_pass(trait, delay):
    """Delayed noise and the constants of dissipation are recognised, as is the absence of a delay."""
    problem = delayed(dissipation=RIGHT, traits=frozenset({"delayed-noise"}), delay=delay)

    assert against(trait, lambda: problem) == ""
