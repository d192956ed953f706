"""Strategies for overdamped Langevin dynamics on a surface and near it."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any, ClassVar

from hypothesis import strategies as st

from .draws import DISSIPATIVE, LIPSCHITZ, choices, fields, of_group
from .example import Example, vector_text
from .holonomic import on_surface, surface_text, surfaces
from .terms import Field, indexed, scaled

CONSTRAINED, PENALISED = KINDS = ("on the surface", "near the surface")
SUITABLE = (LIPSCHITZ, DISSIPATIVE)
# Stiffness parameters; no step size of a run resolves the last one.
EPS = (0.5, 0.1, 0.02)


@dataclass(frozen=True)
class OverdampedExample(Example):
    """Overdamped dynamics with the drift f, scalar noise strength and the constraint zeta, for one eps.

    Attributes
    ----------
    drift : tuple of Field
        f, of x.
    surface : tuple of Field
        zeta, up to a constant.
    strength, eps : float
    """

    form: ClassVar[str] = "ConstrainedLangevin"
    sums: ClassVar[tuple[str, ...]] = ("drift",)

    drift: tuple[Field, ...]
    surface: tuple[Field, ...]
    strength: float
    eps: float

    @property
    def fields(self) -> tuple[Field, ...]:
        """Drift f."""
        return self.drift

    def definitions(self) -> Iterator[str]:
        """Yield the definitions of f, zeta and the start."""
        yield vector_text("drift", "x", self.drift, indexed("x", self.dimension))
        yield surface_text("x", self.start, self.surface)

    def arguments(self) -> Iterator[str]:
        """Yield coefficients, constraint and start."""
        yield from ("drift=drift", "constraint=constraint", "start=start")
        yield from (f"strength={self.strength}", "eps=eps", "family=lambda other: counterexample(horizon, other)")

    def numbers(self) -> Mapping[str, tuple[float, str]]:
        """Return eps as a parameter, because claims uniform in eps need the problem for other values of eps."""
        return {"eps": (self.eps, "Stiffness parameter, 0 on the surface.")}

    def doubled(self) -> "OverdampedExample":
        """Return the example with 2 f and 2 sigma."""
        return replace(self, drift=scaled(self.drift, 2.0), strength=2.0 * self.strength)


@st.composite
def overdamped(
    draw: Any, kinds: tuple[str, ...] = KINDS, groups: tuple[str, ...] = SUITABLE, largest: int = 3
) -> OverdampedExample:
    """Draw overdamped dynamics.

    Parameters
    ----------
    draw : callable
        Draw function of hypothesis.
    kinds, groups : tuple of str
        Kinds and classes to draw from.
    largest : int
        Largest number of components of the state; the number is at least 2.
    """
    kind, group, d = draw(choices(kinds, groups, largest, least=2))
    drift = of_group(draw(fields(d, d, timed=False)), group)
    eps = 0.0 if kind == CONSTRAINED else draw(st.sampled_from(EPS))
    surface, strength = draw(surfaces(d, planes=False)), draw(st.sampled_from((0.5, 1.0, 0.25)))
    return OverdampedExample(kind, group, 0.5, draw(on_surface(d)), drift, surface, strength, eps)
