"""Mistakes in stages are named from the terms of the modified equation, each by its own sentence."""

from dataclasses import dataclass
from typing import ClassVar

import pytest

from facade import STAGE_MISTAKES, classes_of, modified_equation, stage_mistake
from sdaeverify import SDE, Array, Increment, Scheme, Step
from sdaeverify.numerics import apply
from sdaeverify_schemes.delays.stochastic_theta import StochasticTheta
from sdaeverify_schemes.euler_maruyama import EulerMaruyama
from sdaeverify_schemes.heun import HeunAdditive
from sdaeverify_schemes.milstein import Milstein
from sdaeverify_schemes.platen_weak_2 import PlatenWeak2
from sdaeverify_schemes.platen_weak_2_general import PlatenWeak2General
from sdaeverify_schemes.sra1 import SRA1

from .wrong import timed

PLATEN = PlatenWeak2General()


@dataclass(frozen=True)
class Stage(Scheme):
    """x+ = x + h [(1 - w) f(t, x) + w f(t + c h, x + a h f + d B dW)] + B dW.

    Attributes
    ----------
    w, c, a, d : float
    """

    w: float = 0.5
    c: float = 1.0
    a: float = 1.0
    d: float = 1.0

    name: ClassVar[str] = "stage"
    form: ClassVar[type] = SDE

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        f, moved = problem.drift(t, state), apply(problem.diffusion(t, state), noise.dW)
        later = problem.drift(t + self.c * h, state + self.a * h * f + self.d * moved)
        return Step(state + h * ((1.0 - self.w) * f + self.w * later) + moved)


def shifted(scheme: Scheme, part: str, shift: float) -> Scheme:
    """Return a scheme whose drift or diffusion is at the time t + shift h alone."""
    return timed(scheme, f"{part}-{shift}", part, shift=shift, scale=0.0)


PLANTED = {
    "the drift is evaluated only at t": (shifted(PLATEN, "drift", 0.0), "general"),
    "the drift is evaluated only at t + h": (shifted(PLATEN, "drift", 1.0), "general"),
    "the diffusion is evaluated only at t": (shifted(PLATEN, "diffusion", 0.0), "general"),
    "the diffusion is evaluated only at t + h": (shifted(PLATEN, "diffusion", 1.0), "general"),
    "all stages are evaluated at t": (shifted(shifted(PLATEN, "drift", 0.0), "diffusion", 0.0), "general"),
    "all stages are evaluated at t + h": (shifted(shifted(PLATEN, "drift", 1.0), "diffusion", 1.0), "general"),
    "no stage of the drift uses the drift": (Stage(a=0.0), "additive"),
    "no stage of the drift uses the noise": (Stage(d=0.0), "additive"),
    "at the midpoint": (Stage(w=1.0, c=0.5, a=0.5, d=0.5), "additive"),
}


def told(scheme, kind):
    """Return what is said of a scheme on a class."""
    return stage_mistake(modified_equation(scheme, classes_of(scheme)[kind], 2, 4))


@pytest.mark.parametrize("says", PLANTED)
def test_mistakes_of_stages_are_named(says):
    """Each entry is found on the scheme that makes it."""
    assert says in told(*PLANTED[says])


def test_every_entry_is_planted():
    """No mistake is in the dictionary without a scheme that makes it."""
    assert not [each for each in STAGE_MISTAKES.values() if not any(says in each for says in PLANTED)]


@pytest.mark.parametrize(
    ("scheme", "kind"),
    [
        (EulerMaruyama(), "additive"),
        (EulerMaruyama(), "general"),
        (HeunAdditive(), "additive"),
        (Milstein(), "scalar"),
        (PlatenWeak2(), "scalar"),
        (PLATEN, "general"),
        (SRA1(), "additive"),
        (StochasticTheta(), "additive"),
        (StochasticTheta(theta=1.0), "general"),
        (Stage(w=0.45), "additive"),
    ],
    ids=str,
)
def test_other_schemes_have_no_sentence(scheme, kind):
    """A right scheme has none, and neither has one whose terms are those of no entry."""
    assert told(scheme, kind) == ""
