"""Problems whose invariant law is known, and schemes with known stationary biases, for the tests of chains."""

from dataclasses import dataclass
from functools import cache
from typing import ClassVar

import numpy as np
from scipy.integrate import quad

from facade import MALA
from sdaeverify import SDE, Array, Chart, Claim, Increment, InvariantMean, Line, Scheme, Step
from sdaeverify.numerics import apply

SIGMA = 0.7
VARIANCE = SIGMA**2 / 2.0
POWERS = {"x": 1, "x^2": 2, "x^4": 4}


@dataclass(frozen=True)
class Euler(Scheme):
    """Euler-Maruyama with a claimed order, and with too much variance where asked for."""

    order: float = 1.0
    excess: float = 0.0

    name: ClassVar[str] = "claimed-euler"
    form: ClassVar[type[SDE]] = SDE

    @property
    def promises(self) -> tuple[Claim, ...]:
        return (Claim(measure="invariant", value=self.order, source="test"),)

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        dW = np.sqrt(1.0 + self.excess) * noise.dW
        return Step(state + h * problem.drift(t, state) + apply(problem.diffusion(t, state), dW))


class Heun(Euler):
    """Heun's scheme for additive noise, of weak order 2."""

    name: ClassVar[str] = "claimed-heun"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        f, BdW = problem.drift(t, state), apply(problem.diffusion(t, state), noise.dW)
        return Step(state + 0.5 * h * (f + problem.drift(t + h, state + h * f + BdW)) + BdW)


def euler_variance(h):
    """Return the stationary variance of Euler-Maruyama on `ou`, sigma^2/(2 - h)."""
    return SIGMA**2 / (2.0 - np.asarray(h))


def heun_variance(h):
    """Return the stationary variance of Heun's scheme on `ou`, sigma^2 (1 - h/2)/(2 - h + h^2/2)."""
    h = np.asarray(h)
    return SIGMA**2 * (1.0 - 0.5 * h) / (2.0 - h + 0.5 * h**2)


def problem_with(means, **data):
    """Return dx = f dt + sigma dW with the moments x, x^2 and x^4 as observables, and their invariant means."""
    settings = {"start": [1.0], "noise_dim": 1, "horizon": 1.0, "relaxation_time": 1.0, "source": "test", **data}
    sigma = settings.pop("sigma", SIGMA)
    return SDE(
        diffusion=lambda t, x: np.full((1, 1, 1), sigma),
        traits=frozenset({"additive-noise"}),
        observables={name: lambda t, parts, k=k: parts["x"][0] ** k for name, k in POWERS.items()},
        truths=tuple(InvariantMean(observable=name, value=value, source="test") for name, value in means.items()),
        **settings,
    )


def ou(**data):
    """Return dx = -x dt + sigma dW: a normal law of variance sigma^2/2."""
    means = {"x": 0.0, "x^2": VARIANCE, "x^4": 3.0 * VARIANCE**2}
    return problem_with(means, drift=lambda t, x: -x, **data)


def charted_ou():
    """Return `ou` with its chart, a line."""
    return ou(chart=Chart(axes=(Line(0.0, float(np.sqrt(VARIANCE))),), embed=lambda z: z, read=lambda x: x))


def double_well(**data):
    """Return dx = (x - x^3) dt + dW: a density proportional to exp(x^2 - x^4/2)."""
    return problem_with(_quartic_means(), drift=lambda t, x: x - x**3, sigma=1.0, relaxation_time=2.5, **data)


def rotation():
    """Return dx = dW on the circle: the same noise turns all chains alike, so that they never approach each other."""
    return SDE(
        drift=lambda t, x: np.zeros_like(x),
        diffusion=lambda t, x: np.ones((1, 1, 1)),
        start=[0.5],
        noise_dim=1,
        horizon=1.0,
        relaxation_time=2.0,
        source="test",
        observables={"cos": lambda t, parts: np.cos(parts["x"][0]), "sin": lambda t, parts: np.sin(parts["x"][0])},
        truths=tuple(InvariantMean(observable=name, value=0.0, source="test") for name in ("cos", "sin")),
    )


@cache
def _quartic_means():
    def integral(k):
        return quad(lambda x: x**k * np.exp(x**2 - 0.5 * x**4), -6.0, 6.0)[0]

    return {name: integral(k) / integral(0) for name, k in POWERS.items()}


class Shaken(MALA):
    """MALA, where a state that stays is moved by a ten-millionth: detailed balance is not seen from one step."""

    name: ClassVar[str] = "shaken"

    def step(self, problem, state, t, h, noise):
        end = super().step(problem, state, t, h, noise).state
        return Step(np.where(end == state, state + 1e-7 * noise.dW, end))
