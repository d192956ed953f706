"""Mistakes in stages are named from the terms of the modified equation, each by its own sentence."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
import pytest

from facade import (
    STAGE_MEANS,
    STAGE_MISTAKES,
    classes_of,
    modified_equation,
    rows_of_classes,
    stage_means,
    stage_mistake,
)
from sdaeverify import SDE, Array, Claim, Increment, Scheme, Step
from sdaeverify.numerics import apply
from sdaeverify_schemes.delays.stochastic_theta import StochasticTheta
from sdaeverify_schemes.euler_maruyama import EulerMaruyama
from sdaeverify_schemes.heun import HeunAdditive
from sdaeverify_schemes.milstein import Milstein
from sdaeverify_schemes.milstein_areas import MilsteinAreas
from sdaeverify_schemes.platen_weak_2 import PlatenWeak2
from sdaeverify_schemes.platen_weak_2_general import PlatenWeak2General
from sdaeverify_schemes.sra1 import SRA1
from sdaeverify_schemes.sri1w1 import SRI1W1

from .wrong import noisy, scaled, timed

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
    "the stages of the drift have the mean time t + h": (shifted(PLATEN, "drift", 1.0), "general"),
    "the diffusion is evaluated only at t": (shifted(PLATEN, "diffusion", 0.0), "general"),
    "the stages of the diffusion have the mean time t + h": (shifted(PLATEN, "diffusion", 1.0), "general"),
    "all stages are evaluated at t": (shifted(shifted(PLATEN, "drift", 0.0), "diffusion", 0.0), "general"),
    "all stages have the mean time t + h": (shifted(shifted(PLATEN, "drift", 1.0), "diffusion", 1.0), "general"),
    "no stage of the drift uses the drift": (Stage(a=0.0), "additive"),
    "no stage of the drift uses the noise": (Stage(d=0.0), "additive"),
    "at the midpoint": (Stage(w=1.0, c=0.5, a=0.5, d=0.5), "additive"),
}


def told(scheme, kind):
    """Return what is said of a scheme on a class."""
    return stage_mistake(modified_equation(scheme, classes_of(scheme)[kind], 2, 4))


@pytest.mark.sweep
@pytest.mark.parametrize("says", PLANTED)
def test_mistakes_of_stages_are_named(says):
    """Each entry is found on the scheme that makes it."""
    assert says in told(*PLANTED[says])


def test_a_mean_time_is_not_taken_for_the_time_of_all_stages():
    """A second stage at t + 2 h has the same terms as two stages at t + h: what is said holds for both."""
    late, both = told(Stage(c=2.0), "additive"), told(shifted(Stage(), "drift", 1.0), "additive")

    assert late == both == "the stages of the drift have the mean time t + h; the mean time of stages must be t + h/2"


def test_every_entry_is_planted():
    """No mistake is in the dictionary without a scheme that makes it."""
    assert not [each for each in STAGE_MISTAKES.values() if not any(says in each for says in PLANTED)]


@pytest.mark.sweep
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


MEANS = {
    "of the time (in h) 9/20, of the drift (in h f) 9/20, of the noise (in B dW) 9/20, of its variance (in h) 9/20": (
        Stage(w=0.45)
    ),
    "of the time (in h) 1/3": Stage(c=2.0 / 3.0),
    "of the drift (in h f) 1/4": Stage(a=0.5),
    "of the noise (in B dW) 1/4, of its variance (in h) 1/8": Stage(d=0.5),
}


@pytest.mark.parametrize("says", MEANS)
def test_wrong_means_over_stages_are_named(says):
    """The means over the stages of the drift that are not 1/2 are named with their values."""
    equation = modified_equation(MEANS[says], classes_of(MEANS[says])["additive"], 2, 4)

    assert stage_means(equation) == f"the weighted means over the stages of the drift must be 1/2, they are: {says}"
    assert all(any(name in each for each in MEANS) for name, _ in STAGE_MEANS.values())


@pytest.mark.parametrize(
    ("scheme", "kind"),
    [
        (PLATEN, "general"),
        (EulerMaruyama(), "general"),
        (Milstein(), "scalar"),
        (StochasticTheta(theta=1.0), "scalar"),
    ],
    ids=str,
)
def test_other_terms_are_no_means_over_stages(scheme, kind):
    """A right scheme has no wrong mean, and of one with further terms none is said."""
    assert stage_means(modified_equation(scheme, classes_of(scheme)[kind], 2, 4)) == ""


def diagonal(integrals: Array) -> Array:
    """Return the integrals with equal indices, others 0."""
    return integrals * np.eye(len(integrals))[..., None]


def first(integrals: Array) -> Array:
    """Return the first integral, others 0."""
    return integrals * np.outer(*np.eye(len(integrals))[[0, 0]])[..., None]


CHANGES: dict[str, Callable[[Array], Array]] = {
    "half": lambda integrals: 0.5 * integrals,
    "twice": lambda integrals: 2.0 * integrals,
    "transposed": lambda integrals: integrals.swapaxes(0, 1),
    "diagonal": diagonal,
    "first-twice": lambda integrals: integrals + first(integrals),
    "two-factors": lambda integrals: 1.1 * integrals + 0.1 * diagonal(integrals),
}


@dataclass(frozen=True)
class Doubles(MilsteinAreas):
    """Milstein's scheme with other double integrals.

    Attributes
    ----------
    change : str
    drift : float
        Factor of the drift.
    """

    change: str = "twice"
    drift: float = 1.0

    name: ClassVar[str] = "doubles"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        x, B, integrals = state, problem.diffusion(t, state), CHANGES[self.change](noise.double_integrals(h))
        moved = x + self.drift * h * problem.drift(t, x) + problem.diffused(t, x, noise.dW)
        for j in range(problem.noise_dim):
            column = np.broadcast_to(B[:, j], x.shape)
            moved = moved + np.einsum("dkp,kp->dp", problem.derivative_of_diffusion(t, x, column), integrals[j])
        return Step(moved)


@dataclass(frozen=True)
class WithFactor(EulerMaruyama):
    """Milstein's scheme for scalar noise with a factor of its correction.

    Attributes
    ----------
    factor : float
    """

    factor: float = 1.0

    name: ClassVar[str] = "with-factor"
    claims: ClassVar[tuple[Claim, ...]] = (Claim(measure="strong", value=1.0, source="as Milstein's"),)

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        B = problem.diffusion(t, state)
        along = problem.derivative_of_diffusion(t, state, B[:, 0])[:, 0]
        euler = super().step(problem, state, t, h, noise).state
        return Step(euler + 0.5 * self.factor * along * (noise.dW**2 - h))


INTEGRALS = {
    "Milstein's correction, the sum of DB_k B_j I_jk, is doubled": (WithFactor(factor=2.0), "scalar"),
    "Milstein's correction, the sum of DB_k B_j I_jk, has the wrong sign": (WithFactor(factor=-1.0), "scalar"),
    "Milstein's correction, the sum of DB_k B_j I_jk, is left out": (WithFactor(factor=0.0), "scalar"),
    "Milstein's correction, the sum of DB_k B_j I_jk, is multiplied by 0.9": (WithFactor(factor=0.9), "scalar"),
    "Milstein's correction, the sum of DB_k B_j I_jk, is halved": (Doubles("half"), "general"),
    "the double integrals are transposed: I_kj is used in place of I_jk": (
        Doubles("transposed"),
        "general",
    ),
    "the double integrals I_jk with different j and k are left out": (Doubles("diagonal"), "general"),
    "the part of the Levy areas in the double integrals is multiplied by 0.99": (
        noisy(MilsteinAreas(), "less", scaled("A", 0.99)),
        "general",
    ),
}


def of_strong_order(scheme, kind):
    """Return what is said of a scheme whose strong order is refuted for a class, and that it is."""
    (row,) = [each for each in rows_of_classes(scheme, [classes_of(scheme)[kind]], 2) if each.measure == "strong"]
    return row.verdict.value, row.mistake


@pytest.mark.sweep
@pytest.mark.parametrize("says", INTEGRALS)
def test_wrong_double_integrals_are_named(says):
    """A wrong factor, and integrals with other indices, are named from the weights of the trees b_k(b_j)."""
    assert of_strong_order(*INTEGRALS[says]) == ("refuted", says)


@pytest.mark.sweep
@pytest.mark.parametrize(
    "scheme",
    [
        Doubles("first-twice"),
        Doubles("twice", drift=0.5),
        Doubles("two-factors"),
    ],
    ids=["one of them", "and the drift", "two factors"],
)
def test_of_double_integrals_with_other_errors_nothing_is_said(scheme):
    """Where a wrong integral is not the whole defect, there is no sentence about it."""
    verdict, said = of_strong_order(scheme, "general")

    assert verdict == "refuted"
    assert "Milstein" not in said
    assert "integrals" not in said


def test_a_right_correction_has_no_sentence():
    """Milstein's scheme is verified, and has no sentence."""
    assert of_strong_order(Milstein(), "scalar") == ("verified", "")


@dataclass(frozen=True)
class Mixed(SRI1W1):
    """SRI1W1 with the drift of the second stage at t + h and, if asked, a defect of paths that no mean shows."""

    further: float = 0.0

    name: ClassVar[str] = "mixed"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        f = problem.drift
        late = replace(problem, drift=lambda s, x: f(t + (s - t) / 0.75, x))
        moved = problem.diffused(t + h, state, noise.H) - problem.diffused(t, state, noise.H)
        return Step(super().step(late, state, t, h, noise).state + self.further * moved)


@pytest.mark.sweep
@pytest.mark.parametrize("further", [0.0, 1.0])
def test_stages_are_named_for_paths_only_if_they_explain_these(further):
    """A wrong stage is the mistake of a strong order only if no other condition on paths fails."""
    scheme = Mixed(further=further)
    rows = [*rows_of_classes(scheme, [classes_of(scheme)["scalar"]], 1)]
    said = {row.measure: (row.verdict.value, row.mistake) for row in rows}
    stages = "the weighted means over the stages of the drift must be 1/2, they are: of the time (in h) 2/3"

    assert said == {"strong": ("refuted", "" if further else stages), "weak": ("refuted", stages)}
