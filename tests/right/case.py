"""An unusual scheme that is right, beside its wrong twin."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar, NamedTuple

import numpy as np

from sdaeverify import SDE, Array, Claim, Scheme

SOURCE = "tests/right"
ADDITIVE = frozenset({"additive-noise"})


class Case(NamedTuple):
    """A scheme and the problems it is tried on, as `sdaeverify.verify` takes them."""

    scheme: type[Scheme]
    problems: str


@dataclass(frozen=True)
class Twin(Scheme):
    """A scheme that is right by default, and wrong in one place with ``right=False``."""

    right: bool = True

    form: ClassVar[type] = SDE

    def weight(self, right: float, wrong: float) -> float:
        """Return a coefficient of the step."""
        return right if self.right else wrong


def order(measure: str, value: float, *when: str, sense: str = "in mean square") -> Claim:
    """Return a claim of an order."""
    return Claim(measure=measure, value=value, when=frozenset(when), sense=sense, source=SOURCE)


EULER = order("strong", 0.5), order("weak", 1.0)
ONE = order("strong", 1.0), order("weak", 1.0)
COMMUTATIVE = *EULER, order("strong", 1.0, "commutative-noise")
SECOND = order("strong", 1.0), order("weak", 2.0)


def needs(problem: SDE, *traits: str, components: int = 0) -> str:
    """Return why a problem has none of the traits, or another number of components."""
    if components and problem.dimension != components:
        return f"it takes {components} components"
    return "" if not traits or problem.traits & set(traits) else f"the noise is none of {', '.join(traits)}"


def turned(problem: SDE, t: float, x: Array) -> list[Array]:
    """Return DB B_j for each j, shape (d, l, P): its column k is DB_k B_j."""
    B, l = problem.diffusion(t, x), problem.noise_dim
    columns = (problem.derivative_of_diffusion(t, x, np.broadcast_to(B[:, j], x.shape)) for j in range(l))
    return [np.broadcast_to(column, (len(x), l, x.shape[-1])) for column in columns]


def stratonovich(problem: SDE, t: float, x: Array) -> Array:
    """Return the drift F = f - (1/2) sum_j DB_j B_j, shape (d, P)."""
    correction = sum(column[:, j] for j, column in enumerate(turned(problem, t, x)))
    return np.asarray(problem.drift(t, x) - 0.5 * correction)


def ito_drift(problem: SDE, t: float, x: Array) -> Array:
    """Return f, shape (d, P)."""
    return problem.drift(t, x)


def runge_kutta(field: Callable[[Array], Array], x: Array) -> Array:
    """Return the classical Runge-Kutta step of size 1 along a field."""
    a = field(x)
    b = field(x + 0.5 * a)
    c = field(x + 0.5 * b)
    return x + (a + 2.0 * b + 2.0 * c + field(x + c)) / 6.0
