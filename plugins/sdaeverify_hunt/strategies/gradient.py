"""Strategy for gradient dynamics of one component, whose invariant law is known. Requires hypothesis."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from math import cos, sin
from typing import Any, ClassVar

import numpy as np
from hypothesis import strategies as st

from .draws import DISSIPATIVE, of_group, starts, terms
from .example import Example, vector_text
from .terms import COS, Field, scaled

GRADIENT, GROUPS = "gradient", (DISSIPATIVE,)
TRAITS = {GRADIENT: ("additive-noise", "overdamped-gradient")}
# Strengths of the noise, simpler ones first, and terms besides -x: no barrier takes more than some hundred times of
# relaxation to cross.
STRENGTHS, WAVES = (1.0, 0.75, 1.25), 2
# Points at which the density is summed, as many as resolve each wave, up to where it is below 1e-100 for any drift.
FAR, POINTS = 24.0, 9601
OBSERVABLES = {"x": "x", "x^2": "x**2", "cos x": "np.cos(x)"}


@dataclass(frozen=True)
class GradientExample(Example):
    """dx = f dt + sigma dW with f = -x + sum a cos(k x + p), whose invariant density is exp((2/sigma^2) int f).

    Attributes
    ----------
    drift : tuple of Field
        f, one row.
    strength : float
        sigma.
    """

    form: ClassVar[str] = "SDE"
    traits_of_kinds: ClassVar[Mapping[str, tuple[str, ...]]] = TRAITS
    sums: ClassVar[tuple[str, ...]] = ("drift",)

    drift: tuple[Field, ...]
    strength: float

    @property
    def fields(self) -> tuple[Field, ...]:
        """Drift f."""
        return self.drift

    @property
    def rate(self) -> float:
        """Rate c of the linear part -c x of the drift."""
        return -sum(term.size for term in self.drift[0] if term.shape != COS)

    def definitions(self) -> Iterator[str]:
        """Yield the definitions of f and B."""
        yield "from sdaeverify import InvariantMean\n"
        yield vector_text("drift", "t, x", self.drift, ["x[0]"])
        yield f"def diffusion(t, x):\n    return np.full((1, 1, 1), {self.strength})\n"

    def arguments(self) -> Iterator[str]:
        """Yield coefficients, start, noise, and what is known of the invariant law."""
        yield from ("drift=drift", "diffusion=diffusion", f"start={[*self.start]}")
        yield from ("noise_dim=1", 'noise=frozenset({"dW", "H"})', f"relaxation_time={1.0 / self.rate}")
        means = (
            f'InvariantMean(observable="{name}", value={v}, source="quadrature")' for name, v in self.means.items()
        )
        yield f"truths=({', '.join(means)},)"

    def observables(self) -> Iterator[str]:
        """Yield the entries of the observables, those with known invariant means."""
        for name, text in OBSERVABLES.items():
            yield f'"{name}": lambda t, s: {text.replace("x", "s[" + repr("x") + "][0]")}'

    @property
    def means(self) -> dict[str, float]:
        """Means of the observables under the invariant law; sums over equidistant points are exact to rounding."""
        x = np.linspace(-FAR, FAR, POINTS)
        exponent = (2.0 / self.strength**2) * sum(_integral(term, x) for term in self.drift[0])
        weights = np.exp(exponent - np.max(exponent))
        weights /= weights.sum()
        return {"x": float(weights @ x), "x^2": float(weights @ x**2), "cos x": float(weights @ np.cos(x))}

    def doubled(self) -> "GradientExample":
        """Return the example with 2 f and 2 sigma."""
        return replace(self, drift=scaled(self.drift, 2.0), strength=2.0 * self.strength)


def _integral(term: Any, x: Any) -> Any:
    """Return the integral of a term from 0 to each point."""
    k = term.wave[0] if term.wave else 0.0
    if term.shape != COS:
        return 0.5 * term.size * k * x**2
    if not k:
        return term.size * cos(term.phase) * x
    return term.size * (np.sin(k * x + term.phase) - sin(term.phase)) / k


@st.composite
def gradients(
    draw: Any,
    kinds: tuple[str, ...] = (GRADIENT,),
    groups: tuple[str, ...] = GROUPS,
    largest: int = 1,
) -> GradientExample:
    """Draw gradient dynamics of one component.

    Parameters
    ----------
    draw : callable
        Draw function of hypothesis.
    kinds, groups : tuple of str
        Kinds and classes to draw from.
    largest : int
        Largest number of components, for strategies of other forms.
    """
    kind, group = draw(st.sampled_from(kinds)), draw(st.sampled_from(groups))
    waves = draw(st.lists(terms(1, timed=False), max_size=WAVES).map(tuple))
    strength = draw(st.sampled_from(STRENGTHS))
    return GradientExample(kind, group, 1.0, draw(starts(1)), of_group((waves,), group), strength)
