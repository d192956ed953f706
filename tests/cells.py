"""A scheme that is one formula, for the tests of many rooms."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar

from sdaeverify import SDE, Claim, Increment, Problem, Scheme, Step

Rule = Callable[[Any, Any, float, Increment], Any]


@dataclass(frozen=True)
class Formula(Scheme):
    """A step (problem, state, h, noise) -> new state of one formula, for problems that do not depend on time."""

    rule: Rule
    promised: tuple[Claim, ...] = ()

    name: ClassVar[str] = "formula"
    form: ClassVar[type[Problem]] = SDE

    @property
    def label(self) -> str:
        return "formula"

    @property
    def promises(self) -> tuple[Claim, ...]:
        return self.promised

    def step(self, problem: Any, state: Any, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        new = self.rule(problem, state, h, noise)
        return new if isinstance(new, Step) else Step(new)


def claimant(*claims: Claim) -> Formula:
    """Return a scheme with claims that is never run."""
    return Formula(lambda *given: None, claims)
