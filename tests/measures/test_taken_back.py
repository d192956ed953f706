"""Errors of single steps that later steps take back: a low local weak order decides nothing, paths and moments do."""

from dataclasses import dataclass
from typing import ClassVar

import pytest

from sdaeverify import SDE, Array, Claim, Increment, Scheme, Step, verify
from sdaeverify.numerics import jacobian


@dataclass(frozen=True)
class InTurns(Scheme):
    """Explicit and implicit Euler in turns: two steps are one of the trapezoidal rule, of weak order 2."""

    noise_size: float = 1.0

    name: ClassVar[str] = "in-turns"
    form: ClassVar[type[SDE]] = SDE
    claims: ClassVar[tuple[Claim, ...]] = (
        Claim(measure="weak", value=2.0, when=frozenset({"additive-noise"}), source="made up"),
    )
    local_order_is_global: ClassVar[bool] = False

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step for one component and additive noise."""
        kicked = state + self.noise_size * problem.diffused(t, state, noise.dW)
        if round(t / h) % 2 == 0:
            return Step(kicked + h * problem.drift(t, state))
        y = kicked
        for _ in range(12):
            slope = jacobian(lambda x: problem.drift(t + h, x), y)[0, 0]
            y = y - (y - h * problem.drift(t + h, y) - kicked) / (1.0 - h * slope)
        return Step(y)


class Undeclared(InTurns):
    """The same without saying that errors are taken back."""

    name: ClassVar[str] = "undeclared"
    local_order_is_global: ClassVar[bool] = True


class OneKind(InTurns):
    """Explicit Euler in every step, which says that errors are taken back: it is of weak order 1."""

    name: ClassVar[str] = "one-kind"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        return Step(state + h * problem.drift(t, state) + problem.diffused(t, state, noise.dW))


def found(scheme, problem):
    """Return verdicts and reasons of a scheme on a problem."""
    table = verify(scheme, problem, "weak", paths=4096).verdicts
    return set(table.verdict), " ".join(table.reason)


@pytest.mark.long
@pytest.mark.parametrize("problem", ["ou", "double-well"])
def test_the_weak_measure_hears_that_errors_are_taken_back(problem):
    """A right scheme is not refuted by one step, which says why it is silent; undeclared, it is refuted."""
    verdicts, reasons = found(InTurns(), problem)
    assert "refuted" not in verdicts
    assert "the scheme declares that later steps cancel errors of single steps" in reasons

    assert found(Undeclared(), problem)[0] == {"refuted"}


@pytest.mark.long
def test_wrong_schemes_are_refuted_whatever_they_say():
    """A wrong variance is found by the law of short steps, a wrong order by moments and by paths."""
    for wrong in (InTurns(noise_size=1.1), OneKind()):
        assert "refuted" in found(wrong, "ou")[0]
        assert "verified" not in found(wrong, "ou")[0]
