"""Euler's step, which the schemes here make before or instead of what they do wrong."""

from typing import ClassVar

from sdaeverify import SDE, Array, Claim, Increment, Scheme, Step


class Euler(Scheme):
    """x+ = x + f h + B dW."""

    form: ClassVar[type[SDE]] = SDE
    claims: ClassVar[tuple[Claim, ...]] = (
        Claim(measure="strong", value=0.5, source="Kloeden & Platen 1992, Theorem 10.2.2"),
    )
    source: ClassVar[str] = "Kloeden & Platen 1992, section 10.2"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        return Step(state + h * problem.drift(t, state) + problem.diffused(t, state, noise.dW))
