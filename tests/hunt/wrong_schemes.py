"""Wrong schemes that all shipped problems pass, and others whose error is in one place of a step."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from sdaeverify import SDE, THREE_POINT, Array, Claim, Increment, Law, Scheme, Step
from sdaeverify.numerics import apply
from sdaeverify_schemes.mala import MALA, density_ratio, log_ratio
from sdaeverify_schemes.platen_weak_2_general import PlatenWeak2General
from sdaeverify_schemes.sri1w1 import SRI1W1, own_noise


@dataclass
class Altered:
    """A problem some of whose coefficients are others."""

    problem: Any
    others: dict[str, Callable[..., Array]]

    def __getattr__(self, name: str) -> Any:
        return self.others.get(name) or getattr(self.problem, name)


class MalaOfAnotherProposal(MALA):
    """MALA whose acceptance has the densities of proposals of twice the variance."""

    name: ClassVar[str] = "mala-of-another-proposal"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        x = state
        y = x + h * problem.drift(t, x) + problem.diffused(t, x, noise.dW)
        density = density_ratio(problem, t, x, y)
        ratio = density + 0.5 * (log_ratio(problem, t, h, x, y) - density)
        return Step(np.where(np.log(noise.uniform(h)) < ratio, y, x))


class DriftStageAtOldTime(PlatenWeak2General):
    """Platen's scheme with f'(y) at t, not at t + h."""

    name: ClassVar[str] = "drift-stage-at-old-time"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        return super().step(Altered(problem, {"drift": lambda _, x: problem.drift(t, x)}), state, t, h, noise)


class NoiseStagesAtOldTime(PlatenWeak2General):
    """Platen's scheme with B'(y_j) at t, not at t + h: the time of a stage is that of the first one twice."""

    name: ClassVar[str] = "noise-stages-at-old-time"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        return super().step(Altered(problem, {"diffusion": lambda _, x: problem.diffusion(t, x)}), state, t, h, noise)


class SignsOfAdditiveNoise(Scheme):
    """x+ = x + (h/2) f + B dW + (h/4) D + (s/4) sum_j [f(c + s B_j) - f(c - s B_j)] dW_j with s = sqrt(h).

    c is x + h f, and D the sum of f over c +- the noise. Wrong is s (B_1 + ... + B_l) with one sign for all motions;
    right is a sign of its own for each, on average 2 f(c) + sum_j [f(c + s B_j) + f(c - s B_j) - 2 f(c)].
    """

    name: ClassVar[str] = "one-sign"
    form: ClassVar[type] = SDE
    law: ClassVar[Law] = THREE_POINT
    claims: ClassVar[tuple[Claim, ...]] = (
        Claim(measure="weak", value=2.0, when=frozenset({"additive-noise"}), source="what its author believes"),
    )
    source: ClassVar[str] = "made for this test"

    def refuses(self, problem: SDE) -> str:
        """Refuse noise that is not additive."""
        return "" if "additive-noise" in problem.traits else "noise is not additive"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        s, f, B = np.sqrt(h), problem.drift(t, state), problem.diffusion(t, state)
        c = state + h * f

        def later(move: Array) -> Array:
            return problem.drift(t + h, c + move)

        moves = [s * B[:, j] for j in range(problem.noise_dim)]
        slopes = sum((later(move) - later(-move)) * dW for move, dW in zip(moves, noise.dW, strict=True))
        both = self.both_sides(later, c, moves)
        return Step(state + 0.5 * h * f + apply(B, noise.dW) + 0.25 * h * both + 0.25 * s * slopes)

    def both_sides(self, later: Callable[[Array], Array], c: Array, moves: list[Array]) -> Array:
        """Return D."""
        return later(sum(moves)) + later(-sum(moves))


class OwnSigns(SignsOfAdditiveNoise):
    """The same scheme with a sign for each motion, which is right."""

    name: ClassVar[str] = "own-signs"

    def both_sides(self, later: Callable[[Array], Array], c: Array, moves: list[Array]) -> Array:
        """Return D."""
        centre = later(0.0 * c)
        return 2.0 * centre + sum(later(move) + later(-move) - 2.0 * centre for move in moves)


class LaterSecondStage(SRI1W1):
    """SRI1W1 with b_2 at t + 0.3 h, not at t + 0.25 h."""

    name: ClassVar[str] = "later-second-stage"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        step, s, f, b = super().step(problem, state, t, h, noise), np.sqrt(h), problem.drift(t, state), own_noise
        x = state + 0.25 * h * f + 0.5 * s * b(problem, t, state)
        dW, mean, shift = (
            noise.dW,
            noise.time_integral(h) / h,
            b(problem, t + 0.3 * h, x) - b(problem, t + 0.25 * h, x),
        )
        # What b_2 is multiplied with; b_4 has it, too, by which nothing changes up to the order that is claimed.
        weight = 4.0 / 3.0 * (dW - mean) + 2.0 / 3.0 * (dW**2 - h) / s + 5.0 / 18.0 * (dW**3 - 3.0 * h * dW) / h
        return Step(step.state + weight * shift)


WRONG = (DriftStageAtOldTime(), NoiseStagesAtOldTime(), SignsOfAdditiveNoise(), LaterSecondStage())
