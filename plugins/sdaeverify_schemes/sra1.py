"""Roessler's stochastic Runge-Kutta scheme SRA1 for additive noise, of strong order 3/2."""

from typing import ClassVar

from sdaeverify import SDE, Array, Claim, Increment, Scheme, Step, hookimpl

from ._additive import not_additive
from ._senses import LINEAR_GROWTH, by_growth
from ._small_steps import STABLE


class SRA1(Scheme):
    """Two stages and the time integral Z = int_t^{t+h} (W(s) - W(t)) ds.

    y  = x + (3/4) h f(t, x) + (3/2) B(t + h) Z/h,
    x+ = x + (h/3) [f(t, x) + 2 f(t + 3h/4, y)] + B(t + h) (dW - Z/h) + B(t) Z/h.
    """

    name: ClassVar[str] = "sra1"
    form: ClassVar[type[SDE]] = SDE
    noise: ClassVar[frozenset[str]] = frozenset({"dW", "H"})
    claims: ClassVar[tuple[Claim, ...]] = (
        *by_growth(
            Claim(measure="strong", value=1.5, source="Roessler 2010, section 6"),
            Claim(measure="weak", value=2.0, source="measured"),
        ),
        Claim(measure="invariant", value=2.0, when=LINEAR_GROWTH, source="measured; the weak order"),
        STABLE,
    )
    source: ClassVar[str] = "Roessler 2010, section 6, SRA1"

    def refuses(self, problem: SDE) -> str:
        """Refuse noise that is not declared additive."""
        return not_additive(problem)

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the state x has shape (d, P)."""
        x = state
        f, mean = problem.drift(t, x), noise.time_integral(h) / h
        later = problem.diffused(t + h, x, mean)
        y = x + 0.75 * h * f + 1.5 * later
        kick = problem.diffused(t + h, x, noise.dW) - later + problem.diffused(t, x, mean)
        return Step(x + h / 3.0 * (f + 2.0 * problem.drift(t + 0.75 * h, y)) + kick)


@hookimpl
def sdaeverify_schemes() -> list[Scheme]:
    """Register the scheme."""
    return [SRA1()]
