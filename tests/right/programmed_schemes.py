"""Right schemes with the habits of programs: branches, coins, coordinates and memory of their own."""

from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

import numpy as np

from right.case import EULER, ONE, Case, Twin, needs, order
from sdaeverify import SDE, Array, Claim, DelaySDAE, DelayState, Increment, IndexOneSDAE, Langevin, Law, Parts, Step
from sdaeverify.numerics import apply, norm


@dataclass(frozen=True)
class BranchInStep(Twin):
    """Euler's step for h <= 0.02, Heun's drift for longer ones; wrong with 0.9 of the drift in short steps."""

    name: ClassVar[str] = "right-branch-in-step"
    claims: ClassVar[tuple[Claim, ...]] = EULER

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        x, f, kick = state, problem.drift(t, state), problem.diffused(t, state, noise.dW)
        if h <= 0.02:
            return Step(x + self.weight(1.0, 0.9) * h * f + kick)
        return Step(x + 0.5 * h * (f + problem.drift(t + h, x + h * f + kick)) + kick)


@dataclass(frozen=True)
class Substeps(Twin):
    """The flow of f by as many Euler substeps as |f| says, then B dW; wrong with a substep too many."""

    name: ClassVar[str] = "right-substeps"
    claims: ClassVar[tuple[Claim, ...]] = EULER

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        x, kick = state, problem.diffused(t, state, noise.dW)
        count = 1.0 + np.floor(np.minimum(3.0, norm(np.broadcast_to(problem.drift(t, x), x.shape))))
        new = x
        for k in range(int(count.max()) + (not self.right)):
            active = (k < count) | (not self.right)
            new = np.where(active, new + h / count * problem.drift(t, new), new)
        return Step(new + kick)


@dataclass(frozen=True)
class CoinEuler(Twin):
    """Euler's explicit step or a split implicit one, as a coin says; wrong with half a drift on tails."""

    name: ClassVar[str] = "right-coin-euler"
    noise: ClassVar[frozenset[str]] = frozenset({"dW", "H"})
    discontinuous_in_noise: ClassVar[bool] = True
    claims: ClassVar[tuple[Claim, ...]] = EULER

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        assert noise.H is not None
        x, f = state, problem.drift(t, state)
        explicit = x + h * f
        corrected = x + self.weight(1.0, 0.5) * h * problem.drift(t + h, explicit)
        y = np.where(noise.H[0] > 0.0, explicit, corrected)
        return Step(y + problem.diffused(t, x, noise.dW))


SKEWED = Law(
    "skewed two-point",
    lambda x: np.where(x > 0.43072729929545744, np.sqrt(2.0), -np.sqrt(0.5)),
    (float(np.sqrt(2.0)), float(-np.sqrt(0.5))),
    (1.0 / 3.0, 2.0 / 3.0),
)


@dataclass(frozen=True)
class SkewedNoise(Twin):
    """Euler's step with skewed two-point variables: weak order 1/2 alone; wrong with 0.9 of them."""

    name: ClassVar[str] = "right-skewed-noise"
    law: ClassVar[Law] = SKEWED
    claims: ClassVar[tuple[Claim, ...]] = (order("weak", 0.5),)

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        kick = self.weight(1.0, 0.9) * problem.diffused(t, state, noise.dW)
        return Step(state + h * problem.drift(t, state) + kick)


@dataclass(frozen=True)
class FixedPoint(Twin):
    """Two iterations towards the implicit Euler step, B dW outside; wrong with h/2 in the second one."""

    name: ClassVar[str] = "right-fixed-point"
    claims: ClassVar[tuple[Claim, ...]] = EULER

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        x, kick = state, problem.diffused(t, state, noise.dW)
        y = x + h * problem.drift(t + h, x + kick) + kick
        return Step(x + self.weight(1.0, 0.5) * h * problem.drift(t + h, y) + kick)


class Coordinate(NamedTuple):
    """z = arsinh x."""

    z: Array


@dataclass(frozen=True)
class OtherCoordinates(Twin):
    """Euler's step for z = arsinh x by Ito's formula, one component; wrong without the second derivative."""

    name: ClassVar[str] = "right-other-coordinates"
    claims: ClassVar[tuple[Claim, ...]] = EULER

    def refuses(self, problem: SDE) -> str:
        """Refuse several components."""
        return needs(problem, components=1)

    def enter(self, problem: SDE, state: Array, t: float, h: float) -> Coordinate:
        """Return the coordinate of a state."""
        return Coordinate(np.arcsinh(state))

    def parts(self, problem: SDE, state: Coordinate) -> Parts:
        """Return x."""
        return problem.parts(np.sinh(state.z))

    def step(self, problem: SDE, state: Coordinate, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        x = np.sinh(state.z)
        B, r = problem.diffusion(t, x), np.sqrt(1.0 + x * x)
        second = self.weight(0.5, 0.0) * x / r**3 * (B**2).sum(axis=1)
        change = h * (problem.drift(t, x) / r - second) + apply(B, noise.dW) / r
        return Step(Coordinate(state.z + change))


class Compensated(NamedTuple):
    """A sum and what rounding has taken from it."""

    x: Array
    lost: Array


@dataclass(frozen=True)
class CompensatedSum(Twin):
    """Euler's step with Kahan's summation; wrong with what is lost added at every step times 1e3."""

    name: ClassVar[str] = "right-compensated-sum"
    claims: ClassVar[tuple[Claim, ...]] = EULER

    def enter(self, problem: SDE, state: Array, t: float, h: float) -> Compensated:
        """Return a state of which nothing is lost."""
        return Compensated(state, 0.0 * state)

    def parts(self, problem: SDE, state: Compensated) -> Parts:
        """Return x."""
        return problem.parts(state.x)

    def step(self, problem: SDE, state: Compensated, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        x, lost = state
        change = h * problem.drift(t, self.weight(1.0, 0.9) * x) + problem.diffused(t, x, noise.dW) + lost
        new = x + change
        return Step(Compensated(new, change - (new - x)))


class Ring(NamedTuple):
    """The state and what it was at the mesh points before, the latest first."""

    x: Array
    y: Array
    old: Array


@dataclass(frozen=True)
class OwnHistory(Twin):
    """Euler's step for delays with interpolation in a history of its own; wrong with half of the lagged value."""

    name: ClassVar[str] = "right-own-history"
    form: ClassVar[type] = DelaySDAE
    claims: ClassVar[tuple[Claim, ...]] = EULER

    def refuses(self, problem: DelaySDAE) -> str:
        """Refuse algebraic components, and equations without a delay."""
        return "" if problem.delay and problem.constraint is None else "it takes a delay and no constraint"

    def start(self, problem: DelaySDAE, paths: int, h: float) -> Ring:
        """Return the initial state and the history before it; no state of a later time can be entered."""
        x, y = problem.initial(paths)
        length = int(np.ceil(problem.delay / h - 1e-9)) + 1
        old = [np.broadcast_to(problem.past(-k * h), x.shape) for k in range(1, length + 1)]
        return Ring(x, y, np.concatenate(old))

    def parts(self, problem: DelaySDAE, state: Ring) -> Parts:
        """Return x."""
        return problem.parts(DelayState(state.x, state.y))

    def step(self, problem: DelaySDAE, state: Ring, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        x, y, old = state
        values = np.concatenate([x, old]).reshape(-1, *x.shape)
        place = problem.delay / h
        low = int(np.floor(place + 1e-9))
        share = max(0.0, place - low)
        v = (1.0 - share) * values[low] + share * values[min(low + 1, len(values) - 1)]
        v = self.weight(1.0, 0.5) * v
        new = x + h * problem.drift(t, x, v, y) + problem.diffused(t, x, v, y, noise.dW)
        return Step(Ring(new, y, values[:-1].reshape(old.shape)))


@dataclass(frozen=True)
class OneNewtonStep(Twin):
    """Euler's step for equations of index 1 with one Newton step for y; wrong with half a step."""

    name: ClassVar[str] = "right-one-newton-step"
    form: ClassVar[type] = IndexOneSDAE
    claims: ClassVar[tuple[Claim, ...]] = EULER

    def step(self, problem: IndexOneSDAE, state: DelayState, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        x, y = state
        new = x + h * problem.drift(t, x, x, y) + problem.diffused(t, x, x, y, noise.dW)
        if problem.constraint is None:
            return Step(DelayState(new, y))
        u = problem.constraint(t + h, new, new, y)
        slope = np.broadcast_to(problem.linearised_constraint(t + h, new, new, y).y, (len(y), *y.shape))
        change = np.linalg.solve(np.moveaxis(slope, -1, 0), np.moveaxis(u, -1, 0)[..., None])[..., 0].T
        return Step(DelayState(new, y - self.weight(1.0, 0.1) * change))


@dataclass(frozen=True)
class Normalised(Twin):
    """Euler's step divided by its length, for equations on the unit sphere; wrong with 0.9 of the noise."""

    name: ClassVar[str] = "right-normalised"
    claims: ClassVar[tuple[Claim, ...]] = (
        *EULER,
        Claim(measure="drift", value="round-off", source="tests/right"),
    )

    def refuses(self, problem: SDE) -> str:
        """Refuse what does not stay on the unit sphere."""
        if not problem.has_constraints:
            return "there is no constraint"
        x = np.random.default_rng(1).standard_normal((problem.dimension, 5))
        same = problem.constraint(x / norm(x))
        return "" if np.abs(same).max() < 1e-12 else "the constraint is not the unit sphere"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        kick = self.weight(1.0, 0.9) * problem.diffused(t, state, noise.dW)
        y = state + h * problem.drift(t, state) + kick
        return Step(y / norm(y))


@dataclass(frozen=True)
class Middle(Twin):
    """B, half of A, O, half of A: weak order 1, invariant order 2 of positions; wrong with 0.9 of B."""

    name: ClassVar[str] = "right-middle"
    form: ClassVar[type] = Langevin
    claims: ClassVar[tuple[Claim, ...]] = (
        *ONE,
        order("invariant", 1.0),
        Claim(measure="invariant", value=2.0, quantities=("cos q", "cos^2 q"), source="Zhang et al. 2019"),
    )

    def step(self, problem: Langevin, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        n, gamma = problem.noise_dim, problem.friction
        q, p = state[:n], state[n:]
        p = p + self.weight(1.0, 0.9) * h * problem.force(q)
        q = q + 0.5 * h * p
        variance = -np.expm1(-2.0 * gamma * h) / (2.0 * gamma) if gamma else h
        p = np.exp(-gamma * h) * p + problem.strength * np.sqrt(variance / h) * noise.dW
        return Step(np.concatenate([q + 0.5 * h * p, p]))


class Pair(NamedTuple):
    """A state and whether the next step is implicit."""

    x: Array
    odd: Array


@dataclass(frozen=True)
class InTurns(Twin):
    """Heun's drift and Euler's in turns; wrong with 0.9 of the drift in every second step."""

    name: ClassVar[str] = "right-in-turns"
    claims: ClassVar[tuple[Claim, ...]] = EULER

    def enter(self, problem: SDE, state: Array, t: float, h: float) -> Pair:
        """Return a state before an even step."""
        return Pair(state, np.zeros((1, state.shape[1])))

    def parts(self, problem: SDE, state: Pair) -> Parts:
        """Return x."""
        return problem.parts(state.x)

    def step(self, problem: SDE, state: Pair, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        x, odd = state
        f, kick = problem.drift(t, x), problem.diffused(t, x, noise.dW)
        late = problem.drift(t + h, x + h * f + kick)
        even_drift = 0.5 * (f + late)
        drift = np.where(odd > 0.0, self.weight(1.0, 0.9) * f, even_drift)
        return Step(Pair(x + h * drift + kick, 1.0 - odd))


class Drifts(NamedTuple):
    """A state and two drifts before it."""

    x: Array
    f: Array
    g: Array


@dataclass(frozen=True)
class ThreeStepAdams(Twin):
    """x+ = x + h (23 f_n - 16 f_{n-1} + 5 f_{n-2})/12 + B dW; wrong with 4 for 5."""

    name: ClassVar[str] = "right-three-step-adams"
    claims: ClassVar[tuple[Claim, ...]] = EULER

    def enter(self, problem: SDE, state: Array, t: float, h: float) -> Drifts:
        """Return a state before which the drift was the same."""
        f = np.broadcast_to(problem.drift(t, state), state.shape)
        return Drifts(state, f, f)

    def parts(self, problem: SDE, state: Any) -> Parts:
        """Return x."""
        return problem.parts(state.x)

    def step(self, problem: SDE, state: Drifts, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        x, old, older = state
        f = np.broadcast_to(problem.drift(t, x), x.shape)
        change = (23.0 * f - 16.0 * old + self.weight(5.0, 4.0) * older) / 12.0
        return Step(Drifts(x + h * change + problem.diffused(t, x, noise.dW), f, old))


CASES = (
    Case(BranchInStep, "gbm,noncommuting"),
    Case(Substeps, "gbm,noncommuting"),
    Case(CoinEuler, "hyperbolic,noncommuting"),
    Case(SkewedNoise, "gbm,ou"),
    Case(FixedPoint, "gbm,noncommuting"),
    Case(OtherCoordinates, "gbm,ou"),
    Case(CompensatedSum, "gbm,noncommuting"),
    Case(OwnHistory, "delay-ou,delay-linear"),
    Case(OneNewtonStep, "noisy-circuit,gbm-algebraic"),
    Case(Normalised, "sphere,circle"),
    Case(Middle, "angle-pendulum"),
    Case(InTurns, "gbm,noncommuting"),
    Case(ThreeStepAdams, "gbm,noncommuting"),
)
