"""What a step uses in place of the increments is named, if it explains the moves of the step for all noise."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
import pytest

from facade import FUNCTIONS, solved_instead
from sdaeverify import SDE, THREE_POINT, Array, Increment, Langevin, Law, Step
from sdaeverify.numerics import apply
from sdaeverify_schemes.milstein_areas import MilsteinAreas
from sdaeverify_schemes.quicsort import QUICSORT

from .test_solved_instead import Wrong, diffusion, drift, dynamics, generic

EVERY = frozenset({"dW", "H", "K"})
IN_PLACE = "is used in place of dW"
NONLINEAR = "a nonlinear function of the noise is used in place of dW"
MEAN = "the increments have a mean of size sqrt(h)"


def used(noise: Callable[[Array, float], Array], factor: float = 1.0) -> Wrong:
    """Return Euler-Maruyama with another noise in place of dW, and a factor of the drift."""
    return Wrong(lambda p, t, x, h, dW: factor * h * p.drift(t, x) + apply(p.diffusion(t, x), noise(dW, h)))


@dataclass(frozen=True)
class OtherParts(Wrong):
    """Euler-Maruyama with the other parts of the noise of a step, H and K."""

    name: ClassVar[str] = "other-parts"
    noise: ClassVar[frozenset[str]] = EVERY

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        moved = apply(problem.diffusion(t, state), self.line(noise, h))
        return Step(state + h * problem.drift(t, state) + moved)


def scalar() -> SDE:
    """Return a nonlinear equation with one component, whose diffusion is not constant."""
    return SDE(
        drift=lambda t, x: np.cos(x) + 0.3,
        diffusion=lambda t, x: (0.8 + 0.3 * np.sin(x))[None],
        start=[0.4],
        noise_dim=1,
        horizon=1.0,
        source="test",
        noise=EVERY,
    )


AVERAGE = np.array([[0.5, 0.5], [0.5, 0.5]])
NAMED = {
    "exchanged": (
        used(lambda dW, h: dW[::-1]),
        "the Brownian motions are exchanged: motion 2 in place of 1, motion 1 in place of 2",
    ),
    "mixed": (
        used(lambda dW, h: AVERAGE @ dW),
        "the increments are mixed: M dW is used in place of dW with M = [[0.5, 0.5], [0.5, 0.5]]",
    ),
    "of the other sign": (used(lambda dW, h: -dW), "the noise has the wrong sign: -dW is used in place of dW"),
    "shifted": (
        used(lambda dW, h: dW - 0.5 * np.sqrt(h)),
        f"{MEAN}: dW - 0.5 sqrt(h) is used in place of dW",
    ),
    "positive part": (used(lambda dW, h: np.maximum(dW, 0.0)), NONLINEAR),
    "clipped": (used(lambda dW, h: np.clip(dW, -np.sqrt(h), np.sqrt(h))), NONLINEAR),
    "root": (
        Wrong(lambda p, t, x, h, dW: np.sqrt(h) * p.drift(t, x) + apply(p.diffusion(t, x), dW)),
        "the drift is multiplied by sqrt(h) where h is meant",
    ),
    "half a root": (
        Wrong(lambda p, t, x, h, dW: (0.5 * np.sqrt(h) + h) * p.drift(t, x) + apply(p.diffusion(t, x), dW)),
        "the drift is multiplied by sqrt(h) where h is meant, and by 0.5",
    ),
    "without h": (
        Wrong(lambda p, t, x, h, dW: (1.0 + 0.5 * h) * p.drift(t, x) + apply(p.diffusion(t, x), dW)),
        "the drift is added without the step size: f + 0.5 h f in place of h f",
    ),
    "without h at all": (
        Wrong(lambda p, t, x, h, dW: p.drift(t, x) + apply(p.diffusion(t, x), dW)),
        "the drift is added without the step size: f in place of h f",
    ),
    "without x": (
        Wrong(lambda p, t, x, h, dW: h * p.drift(t, x) + apply(p.diffusion(t, x), dW) - x),
        "the state is left out: a step returns its move alone",
    ),
    "read in reverse": (
        Wrong(lambda p, t, x, h, dW: x[::-1] - x + h * p.drift(t, x[::-1]) + apply(p.diffusion(t, x[::-1]), dW)),
        "the components of the state are read in the order 2, 1",
    ),
    "returned in reverse": (
        Wrong(lambda p, t, x, h, dW: (x + h * p.drift(t, x) + apply(p.diffusion(t, x), dW))[::-1] - x),
        "the components of the state are returned in the order 2, 1",
    ),
}


@pytest.mark.sweep
@pytest.mark.parametrize(("scheme", "says"), NAMED.values(), ids=NAMED)
def test_wrong_moves_are_named(scheme, says):
    """A wrong noise, or a wrong power of the step size, is named."""
    assert solved_instead(scheme, generic(), paths=True) == says


@pytest.mark.sweep
@pytest.mark.parametrize("text", FUNCTIONS)
def test_functions_of_the_increments_are_named(text):
    """Each function of the dictionary is named with its factor, and its mean if it has one."""
    noise = used(lambda dW, h: 0.7 * np.sqrt(h) * FUNCTIONS[text].of(dW / np.sqrt(h)))
    said = solved_instead(noise, generic(), paths=True)

    assert said.endswith(f"0.7 {text} is used in place of dW")
    assert said.startswith(MEAN) == (text in {"|dW|", "dW^2/sqrt(h)"})


@pytest.mark.parametrize(
    ("line", "says"),
    [
        (lambda noise, h: noise.dW + 12.0 * noise.K, "dW + 12 K is used in place of dW"),
        (lambda noise, h: -noise.dW - 2.0 * noise.H, "-dW - 2 H is used in place of dW"),
        (lambda noise, h: np.sqrt(12.0) * noise.H, "3.464 H is used in place of dW"),
    ],
    ids=["K", "H", "H alone"],
)
def test_other_parts_of_the_noise_are_named(line, says):
    """A combination of dW, H and K is named with its numbers."""
    assert solved_instead(OtherParts(line), scalar(), paths=True) == says


def test_a_nonlinear_function_is_a_mistake_of_paths_alone():
    """Signs of H are right in law; of other functions the moments are not known, and nothing is said."""
    signs = OtherParts(lambda noise, h: np.sqrt(h) * np.sign(noise.H))

    assert [solved_instead(signs, scalar(), paths=paths) for paths in (True, False)] == [NONLINEAR, ""]
    assert solved_instead(NAMED["positive part"][0], generic()) == ""


@pytest.mark.parametrize("paths", [True, False])
def test_the_variance_of_a_nonlinear_function_is_told_before_that_it_is_one(paths):
    """With 2 dW - dW^3/(3 h) the noise has 5/3 of its variance, whatever is claimed."""
    cubic = used(lambda dW, h: 2.0 * dW - dW**3 / (3.0 * h))
    said = solved_instead(cubic, generic(), paths=paths)

    assert said == "the variance of the noise is multiplied by 1.667, the noise by 1.291"


@pytest.mark.parametrize("text", FUNCTIONS)
def test_moments_of_functions(text):
    """The mean and the mean square of a function are those of a sample, to six standard errors."""
    count = 200_000
    values = FUNCTIONS[text].of(np.random.Generator(np.random.Philox(key=54)).standard_normal(count))

    for sample, exact in ((values, FUNCTIONS[text].mean), (values**2, FUNCTIONS[text].square)):
        assert abs(sample.mean() - exact) <= 6.0 * sample.std() / np.sqrt(count) + 1e-12


@pytest.mark.parametrize("motions", [1, 2, 3])
def test_signs_are_right_in_law(motions):
    """For three motions some nodes are 0, and the rule has no exact covariance of signs; they are right in law."""
    problem = SDE(
        drift=lambda t, x: np.cos(x) + 0.3,
        diffusion=lambda t, x: np.eye(motions)[..., None] * (0.8 + 0.3 * np.sin(x))[:, None],
        start=np.full(motions, 0.4),
        noise_dim=motions,
        horizon=1.0,
        source="test",
    )
    signs = used(lambda dW, h: np.sqrt(h) * np.sign(dW))

    assert solved_instead(signs, problem) == ""
    assert solved_instead(signs, problem, paths=True) == f"sqrt(h) sign(dW) {IN_PLACE}"


@pytest.mark.parametrize("noise", ["exchanged", "of the other sign"])
def test_noise_with_the_law_of_the_increments_is_right_in_law(noise):
    """Where no paths are claimed, increments of the same law are no mistake."""
    assert solved_instead(NAMED[noise][0], generic()) == ""


class HalfForce(QUICSORT):
    """QUICSORT without half of the force on the momentum."""

    name: ClassVar[str] = "half-force"

    def step(self, problem: Langevin, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        after, n = super().step(problem, state, t, h, noise).state, problem.noise_dim
        return Step(np.concatenate([after[:n], after[n:] - 0.5 * h * problem.force(state[:n])]))


class Exchanged(MilsteinAreas):
    """Milstein's scheme with Levy areas whose increments are exchanged."""

    name: ClassVar[str] = "exchanged"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        moved = apply(problem.diffusion(t, state), noise.dW[::-1] - noise.dW)
        return Step(super().step(problem, state, t, h, noise).state + moved)


def test_schemes_that_use_second_areas_or_levy_areas_have_sentences():
    """The steps that are compared are given K and A."""
    langevin = replace(dynamics(), noise=EVERY)
    sde = replace(generic(), noise=frozenset({"dW", "H", "A"}))

    assert solved_instead(HalfForce(), langevin) == "the force is halved"
    assert solved_instead(Exchanged(), sde, paths=True) == NAMED["exchanged"][1]


ALIKE = {
    "two mistakes": used(lambda dW, h: np.abs(dW), factor=2.0),
    "at some states": Wrong(
        lambda p, t, x, h, dW: h * p.drift(t, x) + apply(p.diffusion(t, x), np.where(x[:1] > 0.3, np.abs(dW), dW))
    ),
    "root of another drift": Wrong(
        lambda p, t, x, h, dW: np.sqrt(h) * (p.drift(t, x) + 0.1) + apply(p.diffusion(t, x), dW)
    ),
    "root and a further drift": Wrong(
        lambda p, t, x, h, dW: np.sqrt(h) * p.drift(t, x) + h * x + apply(p.diffusion(t, x), dW)
    ),
    "jump and a further drift": Wrong(lambda p, t, x, h, dW: p.drift(t, x) + h * x + apply(p.diffusion(t, x), dW)),
    "jump by another drift": Wrong(lambda p, t, x, h, dW: p.drift(t, x) + 0.1 + apply(p.diffusion(t, x), dW)),
    "jump with another noise": Wrong(lambda p, t, x, h, dW: p.drift(t, x) + 2.0 * apply(p.diffusion(t, x), dW)),
    "without x, with another drift": Wrong(
        lambda p, t, x, h, dW: 2.0 * h * p.drift(t, x) + apply(p.diffusion(t, x), dW) - x
    ),
    "without x for half of the noise": Wrong(
        lambda p, t, x, h, dW: h * p.drift(t, x) + apply(p.diffusion(t, x), dW) - x * (dW[:1] < 0.0)
    ),
    "a random jump": Wrong(lambda p, t, x, h, dW: x * dW[:1] / np.sqrt(h) + apply(p.diffusion(t, x), dW)),
}


@pytest.mark.sweep
@pytest.mark.parametrize("scheme", ALIKE.values(), ids=ALIKE)
def test_of_moves_that_nothing_explains_nothing_is_said(scheme):
    """Nothing is said where one wrong part of a step is explained, but not all of them."""
    assert solved_instead(scheme, generic(), paths=True) == ""


def test_an_increment_that_is_used_twice_is_no_exchange():
    """Motion 2 in place of 3 leaves out motion 3: the matrix is told."""
    problem = SDE(
        drift=drift,
        diffusion=lambda t, x: np.concatenate([diffusion(t, x), diffusion(t + 1.0, x[::-1])[:, :1]], axis=1),
        start=[0.3, -0.2],
        noise_dim=3,
        horizon=1.0,
        source="test",
    )
    said = [
        solved_instead(used(lambda dW, h, o=order: dW[o]), problem, paths=True) for order in ([0, 1, 1], [1, 2, 0])
    ]

    assert said == [
        f"the increments are mixed: M dW {IN_PLACE} with M = [[1, 0, 0], [0, 1, 0], [0, 1, 0]]",
        "the Brownian motions are exchanged: motion 2 in place of 1, motion 3 in place of 2, motion 1 in place of 3",
    ]


def test_functions_that_a_law_does_not_tell_apart_are_not_named():
    """With three values of dW its modulus and its square are multiples of each other."""

    @dataclass(frozen=True)
    class Modulus(Wrong):
        law: ClassVar[Law] = THREE_POINT

    modulus = Modulus(lambda p, t, x, h, dW: h * p.drift(t, x) + apply(p.diffusion(t, x), np.abs(dW)))

    assert solved_instead(modulus, generic(), paths=True) == NONLINEAR


def test_a_function_that_is_a_multiple_for_the_law_of_the_scheme_is_told_as_one():
    """With the three values of dW its cube is 3 dW: a factor of the noise."""

    @dataclass(frozen=True)
    class Bounded(Wrong):
        law: ClassVar[Law] = THREE_POINT

    cubed = Bounded(lambda p, t, x, h, dW: h * p.drift(t, x) + apply(p.diffusion(t, x), dW**3 / h))

    assert solved_instead(cubed, generic()) == "the variance of the noise is multiplied by 9, the noise by 3"
