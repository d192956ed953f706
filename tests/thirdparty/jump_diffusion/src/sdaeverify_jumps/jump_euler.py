"""Euler's scheme for jump-diffusions, and two that are wrong."""

from typing import ClassVar

from sdaeverify import Array, Claim, Increment, Scheme, Step, hookimpl

from ._compound_poisson import JUMPS
from ._jump_diffusion import JumpDiffusion

BOOK = "Platen & Bruti-Liberati 2010, section 6.1 and chapter 12"


class JumpEuler(Scheme):
    """x+ = x + f h + g dW + c dJ with all coefficients at the step's begin."""

    name: ClassVar[str] = "jump-euler"
    form: ClassVar[type[JumpDiffusion]] = JumpDiffusion
    noise: ClassVar[frozenset[str]] = frozenset({"dW", JUMPS})
    claims: ClassVar[tuple[Claim, ...]] = (
        Claim(measure="strong", value=0.5, source=BOOK),
        Claim(measure="weak", value=1.0, source=BOOK),
    )
    source: ClassVar[str] = BOOK

    def step(self, problem: JumpDiffusion, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        return Step(problem.euler(t, state, h, noise))


class CompensatedJumpEuler(JumpEuler):
    """x+ = x + f h + g dW + c (dJ - E dJ): right for the martingale part of J, wrong for J."""

    name: ClassVar[str] = "compensated-jump-euler"

    def step(self, problem: JumpDiffusion, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        J = problem.jumps
        return Step(problem.euler(t, state, h, noise) - h * J.rate * J.mean * problem.jump(t, state))


class MarcusJumpEuler(JumpEuler):
    """c is taken half way through a jump, as in Marcus' canonical equation: right where c is constant, and wrong."""

    name: ClassVar[str] = "marcus-jump-euler"

    def step(self, problem: JumpDiffusion, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        dJ, c = noise.records[JUMPS].total, problem.jump(t, state)
        return Step(problem.euler(t, state, h, noise) + (problem.jump(t, state + 0.5 * c * dJ) - c) * dJ)


@hookimpl
def sdaeverify_schemes() -> list[Scheme]:
    """Register the schemes."""
    return [JumpEuler(), CompensatedJumpEuler(), MarcusJumpEuler()]
