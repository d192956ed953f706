"""Wrong schemes: six errors that vanish on linear and autonomous problems, and many plain ones."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np

from sdaeverify import SDE, THREE_POINT, Array, Claim, Increment, Law, Scheme, Step
from sdaeverify.numerics import apply
from sdaeverify_lab.planted.higher_orders import FewSigns, NewNoise, OldDrift, OldNoise
from sdaeverify_schemes.delays.stochastic_theta import StochasticTheta
from sdaeverify_schemes.euler_maruyama import EulerMaruyama
from sdaeverify_schemes.heun import Heun, HeunAdditive
from sdaeverify_schemes.milstein import Milstein
from sdaeverify_schemes.milstein_areas import MilsteinAreas
from sdaeverify_schemes.platen_weak_2 import PlatenWeak2
from sdaeverify_schemes.platen_weak_2_general import PlatenWeak2General
from sdaeverify_schemes.sra1 import SRA1
from sdaeverify_schemes.sri1w1 import SRI1W1


@dataclass(frozen=True)
class SignedHeun(Scheme):
    """x+ = x + h [f/4 + 3/4 f(t + 2h/3, y)] + B dW with y = x + 2/3 (h f + B dW) + sqrt(2h)/3 B zeta, zeta signs.

    Attributes
    ----------
    own : bool
        Whether each motion has a sign of its own, as it must.
    """

    own: bool = True

    name: ClassVar[str] = "signed-heun"
    form: ClassVar[type] = SDE
    noise: ClassVar[frozenset[str]] = frozenset({"dW", "H"})
    law: ClassVar[Law] = THREE_POINT
    claims: ClassVar[tuple[Claim, ...]] = (Claim(measure="weak", value=2.0, source="by its conditions"),)

    def refuses(self, problem: SDE) -> str:
        """Refuse noise that is not additive."""
        return "" if "additive-noise" in problem.traits else "the noise is not declared additive"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        zeta = np.sqrt(12.0 / h) * noise.H
        f, B = problem.drift(t, state), problem.diffusion(t, state)
        sign = zeta if self.own else np.broadcast_to(zeta[:1], zeta.shape)
        y = state + (h * f + apply(B, noise.dW)) / 1.5 + np.sqrt(2.0 * h) / 3.0 * apply(B, sign)
        return Step(state + h * (0.25 * f + 0.75 * problem.drift(t + h / 1.5, y)) + apply(B, noise.dW))


class AromaticEuler(EulerMaruyama):
    """Euler-Maruyama with h (tr DB_1) B_1: equivariant under invertible maps alone."""

    name: ClassVar[str] = "wrong-aromatic"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        (d, P), B = state.shape, problem.diffusion(t, state)
        units = (np.repeat(np.eye(d)[:, [i]], P, axis=1) for i in range(d))
        trace = sum(problem.derivative_of_diffusion(t, state, unit)[i, 0] for i, unit in enumerate(units))
        return Step(super().step(problem, state, t, h, noise).state + h * trace * B[:, 0])


Change = Callable[[Increment, float], Increment]


def noisy(base: Scheme, name: str, change: Change) -> Scheme:
    """Return a scheme that is given other noise."""

    def step(self: Any, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        return super(kind, self).step(problem, state, t, h, change(noise, h))

    kind = type(
        f"Noisy{type(base).__name__}", (type(base),), {"name": f"wrong-{base.name}-{name}".lower(), "step": step}
    )
    return kind()


def timed(base: Scheme, name: str, part: str, shift: float = 0.0, scale: float = 1.0) -> Scheme:
    """Return a scheme that sees drift or diffusion at other times, from the begin of its step on."""

    def step(self: Any, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        given = getattr(problem, part)
        moved = {part: lambda s, x: given(t + scale * (s - t) + shift * h, x)}
        if part == "diffusion":
            derivative = problem.derivative_of_diffusion
            moved["diffusion_derivative"] = lambda s, x, y: derivative(t + scale * (s - t) + shift * h, x, y)
        return super(kind, self).step(replace(problem, **moved), state, t, h, noise)

    kind = type(
        f"Timed{type(base).__name__}", (type(base),), {"name": f"wrong-{base.name}-{name}".lower(), "step": step}
    )
    return kind()


def scaled(part: str, factor: float) -> Change:
    """Return a change of the size of dW, H or A."""
    return lambda noise, h: noise._replace(**{part: factor * getattr(noise, part)})


def first_for_all(part: str) -> Change:
    """Return that all motions have the dW or H of the first."""

    def change(noise: Increment, h: float) -> Increment:
        given = getattr(noise, part)
        return noise._replace(**{part: np.broadcast_to(given[:1], given.shape)})

    return change


def reversed_order(part: str) -> Change:
    """Return that motions, or pairs, are taken in the other order."""
    return lambda noise, h: noise._replace(**{part: getattr(noise, part)[::-1]})


def mixed(share: float) -> Change:
    """Return that H is correlated with dW."""
    return lambda noise, h: noise._replace(H=noise.H + share * noise.dW)


SIX = [
    OldDrift(),
    OldNoise(),
    NewNoise(),
    SignedHeun(own=False),
    noisy(
        MilsteinAreas(),
        "pairs",
        lambda noise, h: noise._replace(A=noise.A[[0, 2, 1]] if len(noise.A) == 3 else noise.A),
    ),
    FewSigns(),
]
# Class in which each is wrong, by scheme.
FORTY = [
    *(
        (noisy(base, f"dW-{factor}", scaled("dW", factor)), kind)
        for base, kind, factor in [
            (EulerMaruyama(), "scalar", 0.99),
            (EulerMaruyama(), "general", 1.01),
            (Heun(), "scalar", 0.98),
            (Milstein(), "scalar", 1.02),
            (SRI1W1(), "scalar", 1.01),
            (SRA1(), "additive", 0.99),
            (HeunAdditive(), "additive", 1.01),
            (MilsteinAreas(), "general", 0.99),
            (StochasticTheta(), "additive", 1.01),
            (PlatenWeak2(), "scalar", 1.01),
            (PlatenWeak2(), "additive", 0.99),
            (PlatenWeak2General(), "general", 1.01),
        ]
    ),
    *(
        (noisy(base, f"H-{factor}", scaled("H", factor)), kind)
        for base, kind, factor in [
            (SRA1(), "additive", 1.01),
            (SRA1(), "additive", -1.0),
            (SRI1W1(), "scalar", 0.99),
            (SRI1W1(), "scalar", -1.0),
            (PlatenWeak2General(), "general", 0.98),
        ]
    ),
    *(
        (noisy(base, f"mixed-{share}", mixed(share)), kind)
        for base, kind, share in [
            (SRA1(), "additive", 0.02),
            (SRI1W1(), "scalar", 0.02),
        ]
    ),
    *((noisy(MilsteinAreas(), f"A-{factor}", scaled("A", factor)), "general") for factor in (0.99, -1.0, 0.0)),
    *(
        (noisy(base, f"first-{part}", first_for_all(part)), kind)
        for base, kind, part in [
            (EulerMaruyama(), "general", "dW"),
            (HeunAdditive(), "additive", "dW"),
            (SRA1(), "additive", "H"),
            (SRI1W1(), "diagonal", "H"),
            (PlatenWeak2(), "diagonal", "dW"),
            (PlatenWeak2General(), "general", "H"),
        ]
    ),
    *(
        (noisy(base, f"reversed-{part}", reversed_order(part)), kind)
        for base, kind, part in [
            (EulerMaruyama(), "additive", "dW"),
            (SRA1(), "additive", "H"),
            (MilsteinAreas(), "general", "dW"),
            (SRI1W1(), "diagonal", "H"),
        ]
    ),
    *(
        (timed(base, f"{part}-{shift}-{scale}", part, shift, scale), kind)
        for base, kind, part, shift, scale in [
            (HeunAdditive(), "additive", "drift", 0.0, 0.0),
            (HeunAdditive(), "additive", "drift", 0.02, 1.0),
            (SRA1(), "additive", "drift", 0.0, 0.0),
            (SRA1(), "additive", "drift", 0.0, 1.02),
            (SRI1W1(), "scalar", "drift", 0.0, 0.0),
            (SRI1W1(), "scalar", "diffusion", 0.0, 0.0),
            (SRI1W1(), "scalar", "diffusion", 0.05, 1.0),
            (PlatenWeak2(), "scalar", "drift", 0.0, 0.0),
            (PlatenWeak2(), "scalar", "diffusion", 0.0, 0.0),
            (PlatenWeak2General(), "general", "diffusion", 0.0, 1.05),
            (PlatenWeak2General(), "general", "drift", -0.02, 1.0),
        ]
    ),
]
