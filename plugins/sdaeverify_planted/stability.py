"""Schemes that claim mean-square stability for every step size and lose it for long steps."""

from dataclasses import dataclass
from typing import ClassVar

from sdaeverify import SDE, Claim, Problem, Scheme, hookimpl
from sdaeverify_lab import Planted
from sdaeverify_schemes.delays.stochastic_theta import StochasticTheta
from sdaeverify_schemes.euler_maruyama import EulerMaruyama
from sdaeverify_schemes.milstein import Milstein

A_STABLE = Claim(measure="stability", value="A-stable", source="planted")


@dataclass(frozen=True)
class AlmostHalf(StochasticTheta):
    """The theta method with theta below 1/2: stable on dx = a x dt + b x dW up to -(2a + b^2)/(a^2 (1 - 2 theta))."""

    theta: float = 0.499

    name: ClassVar[str] = "planted-theta"
    form: ClassVar[tuple[type[Problem], ...]] = (SDE,)

    @property
    def promises(self) -> tuple[Claim, ...]:
        """What it would keep with theta = 1/2."""
        return (*self.claims, A_STABLE)


class AStableEuler(EulerMaruyama):
    """Euler-Maruyama, stable up to -(2a + b^2)/a^2."""

    name: ClassVar[str] = "planted-em-a-stable"
    claims: ClassVar[tuple[Claim, ...]] = (A_STABLE,)


class AStableMilstein(Milstein):
    """Milstein's scheme, stable up to -(2a + b^2)/(a^2 + b^4/2)."""

    name: ClassVar[str] = "planted-milstein-a-stable"
    claims: ClassVar[tuple[Claim, ...]] = (A_STABLE,)


@hookimpl
def sdaeverify_planted() -> list[Planted]:
    """Register the bugs."""
    bugs: dict[str, Scheme] = {
        "theta = .499": AlmostHalf(0.499),
        "theta = .49": AlmostHalf(0.49),
        "Euler-Maruyama": AStableEuler(),
        "Milstein": AStableMilstein(),
    }
    problem = "linear-test[a=-10,b=2]"
    return [Planted(bug=f"{b}: A-stability claimed", scheme=s, problem=problem) for b, s in bugs.items()]
