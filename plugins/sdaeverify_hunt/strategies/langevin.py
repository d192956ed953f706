"""Strategies for Langevin dynamics without constraints."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any, ClassVar

from hypothesis import strategies as st

from .draws import DISSIPATIVE, GROWING, LIPSCHITZ, LONG, choices, fields, horizon_of, of_group, starts
from .example import Example, vector_text
from .terms import Field, indexed, scaled

KINDS = ("additive",)
SUITABLE = (LIPSCHITZ, DISSIPATIVE, GROWING, LONG)


@dataclass(frozen=True)
class LangevinExample(Example):
    """Langevin dynamics dq = p dt, dp = (F(q) - gamma p) dt + sigma dW.

    Attributes
    ----------
    force : tuple of Field
        F, of q.
    friction, strength : float
    momentum : tuple of float
        p at time 0.
    """

    form: ClassVar[str] = "Langevin"
    state: ClassVar[str] = "q"
    sums: ClassVar[tuple[str, ...]] = ("force",)
    begun_by: ClassVar[Mapping[str, str]] = MappingProxyType({"q": "start", "p": "momentum"})

    force: tuple[Field, ...]
    friction: float
    strength: float
    momentum: tuple[float, ...]

    @property
    def fields(self) -> tuple[Field, ...]:
        """Force F."""
        return self.force

    def definitions(self) -> Iterator[str]:
        """Yield the definition of F."""
        yield vector_text("force", "q", self.force, indexed("q", self.dimension))

    def arguments(self) -> Iterator[str]:
        """Yield force, friction, strength and start."""
        yield from ("force=force", f"friction={self.friction}", f"strength={self.strength}")
        yield from (f"position={list(self.start)}", f"momentum={list(self.momentum)}")
        yield 'noise=frozenset({"dW", "H", "K", "A"})'

    def doubled(self) -> "LangevinExample":
        """Return the example with 2 F and 2 sigma."""
        return replace(self, force=scaled(self.force, 2.0), strength=2.0 * self.strength)


@st.composite
def langevins(
    draw: Any, kinds: tuple[str, ...] = KINDS, groups: tuple[str, ...] = SUITABLE, largest: int = 3
) -> LangevinExample:
    """Draw Langevin dynamics.

    Parameters
    ----------
    draw : callable
        Draw function of hypothesis.
    kinds, groups : tuple of str
        Kinds and classes to draw from.
    largest : int
        Largest number of components of the state.
    """
    kind, group, n = draw(choices(kinds, groups, largest))
    force = of_group(draw(fields(n, n, timed=False)), group)
    friction, strength = draw(st.sampled_from((1.0, 0.5, 2.0, 0.0))), draw(st.sampled_from((0.5, 1.0, 0.25)))
    start = draw(starts(n))
    return LangevinExample(kind, group, horizon_of(group), start, force, friction, strength, draw(starts(n)))
