"""Schemes for Ito's equation: Milstein's term in several ways, implicit, tamed, exponential and stabilised ones."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import scipy

from right.case import COMMUTATIVE, EULER, ONE, Case, Twin, needs, order, turned
from sdaeverify import SDE, Array, Claim, Increment, Step
from sdaeverify.numerics import largest, newton, norm, update_tolerance


@dataclass(frozen=True)
class DerivativeFreeMilstein(Twin):
    """Milstein's term by differences over sqrt(h), diagonal noise; wrong with dW^2 in the place of dW^2 - h."""

    name: ClassVar[str] = "right-derivative-free-milstein"
    claims: ClassVar[tuple[Claim, ...]] = ONE

    def refuses(self, problem: SDE) -> str:
        """Refuse noise that is not diagonal."""
        return needs(problem, "scalar-noise", "diagonal-noise")

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        x, s, f = state, np.sqrt(h), problem.drift(t, state)
        double = noise.dW**2 - self.weight(h, 0.0)
        up = x + h * f + s * problem.diffused(t, x, np.ones_like(noise.dW))
        change = problem.diffused(t, up, double) - problem.diffused(t, x, double)
        return Step(x + h * f + problem.diffused(t, x, noise.dW) + change / (2.0 * s))


@dataclass(frozen=True)
class SymmetricMilstein(Twin):
    """x+ = x + h f + B dW + (1/2) sum_jk DB_k B_j (dW_j dW_k - h delta_jk); wrong with j > k left out."""

    name: ClassVar[str] = "right-symmetric-milstein"
    claims: ClassVar[tuple[Claim, ...]] = COMMUTATIVE

    def refuses(self, problem: SDE) -> str:
        """Refuse diffusions whose derivative cannot be had."""
        return problem.why_not_derivative_of_diffusion()

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        x, dW = state, noise.dW
        products = 0.5 * (dW[:, None] * dW - h * np.eye(len(dW))[..., None])
        if not self.right:
            products = products * np.triu(np.ones((len(dW), len(dW))))[..., None]
        new = x + h * problem.drift(t, x) + problem.diffused(t, x, dW)
        for j, column in enumerate(turned(problem, t, x)):
            new = new + np.einsum("dkp,kp->dp", column, products[j])
        return Step(new)


@dataclass(frozen=True)
class WagnerPlaten(Twin):
    """The strong Ito-Taylor step of order 3/2 in one component with one noise; wrong with a sign turned.

    With Z = int W ds, L f = f_t + f f' + g^2 f''/2 and g_t by differences in time,

        x+ = x + h f + g dW + g g' (dW^2 - h)/2 + g f' Z + L f h^2/2 + L g (h dW - Z) + g (g g')' (dW^2/3 - h) dW/2.
    """

    name: ClassVar[str] = "right-wagner-platen"
    noise: ClassVar[frozenset[str]] = frozenset({"dW", "H"})
    claims: ClassVar[tuple[Claim, ...]] = (order("strong", 1.5), order("weak", 1.5))

    def refuses(self, problem: SDE) -> str:
        """Refuse several components or noises."""
        return needs(problem, "scalar-noise", components=1) or problem.why_not_derivative_of_diffusion()

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        x, one, dW, Z, e = state, np.ones_like(state), noise.dW, noise.time_integral(h), 1e-4
        f, f_x, f_xx = self._taylor(lambda y: problem.drift(t, y), x, one)
        g, g_x, g_xx = self._taylor(lambda y: problem.diffusion(t, y)[:, 0], x, one)
        f_t = (problem.drift(t + e, x) - problem.drift(t - e, x)) / (2.0 * e)
        g_t = (problem.diffusion(t + e, x) - problem.diffusion(t - e, x))[:, 0] / (2.0 * e)
        Lf, Lg = f_t + f * f_x + 0.5 * g * g * f_xx, g_t + f * g_x + 0.5 * g * g * g_xx
        new = x + h * f + g * dW + 0.5 * g * g_x * (dW * dW - h) + g * f_x * Z + 0.5 * h * h * Lf
        third = 0.5 * g * (g_x * g_x + g * g_xx) * (dW * dW / 3.0 - h) * dW
        return Step(new + self.weight(1.0, -1.0) * Lg * (h * dW - Z) + third)

    def _taylor(self, f, x: Array, one: Array) -> tuple[Array, Array, Array]:
        # By complex steps and their differences.
        e = 1e-4
        slope = [np.imag(f(x + shift + 1e-30j * one)) / 1e-30 for shift in (-e, 0.0, e)]
        return f(x), slope[1], (slope[2] - slope[0]) / (2.0 * e)


@dataclass(frozen=True)
class SplitStepBackward(Twin):
    """y = x + h f(y), x+ = y + B(y) dW; wrong with y = x + (h/2) f(y)."""

    name: ClassVar[str] = "right-split-step-backward"
    claims: ClassVar[tuple[Claim, ...]] = EULER

    def refuses(self, problem: SDE) -> str:
        """Refuse drifts that cannot be differentiated."""
        return problem.why_not_derivative_of_drift()

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        x, s, unit = state, self.weight(h, 0.5 * h), np.eye(len(state))[..., None]

        def equation(y: Array) -> tuple[Array, Array]:
            return y - x - s * problem.drift(t + h, y), unit - s * problem.derivative_of_drift(t + h, y)

        root = newton(equation, x, update_tolerance(largest(x)))
        return Step(root.x + problem.diffused(t, root.x, noise.dW), failed=~root.converged)


@dataclass(frozen=True)
class LinearlyImplicit(Twin):
    """x+ = x + h k + B dW with (Id - h Df(x)) k = f(x); wrong with 1.1 h k."""

    name: ClassVar[str] = "right-linearly-implicit"
    claims: ClassVar[tuple[Claim, ...]] = EULER

    def refuses(self, problem: SDE) -> str:
        """Refuse drifts that cannot be differentiated."""
        return problem.why_not_derivative_of_drift()

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        x = state
        J = np.broadcast_to(problem.derivative_of_drift(t, x), (len(x), *x.shape))
        A = np.moveaxis(np.eye(len(x))[..., None] - h * J, -1, 0)
        k = np.linalg.solve(A, np.moveaxis(np.broadcast_to(problem.drift(t, x), x.shape), -1, 0)[..., None])[..., 0].T
        return Step(x + h * self.weight(1.0, 1.1) * k + problem.diffused(t, x, noise.dW))


@dataclass(frozen=True)
class TamedMilstein(Twin):
    """x+ = x + h f/(1 + h |f|) + g dW + g' g (dW^2 - h)/2; wrong with 0.4 for 1/2."""

    name: ClassVar[str] = "right-tamed-milstein"
    claims: ClassVar[tuple[Claim, ...]] = ONE

    def refuses(self, problem: SDE) -> str:
        """Refuse several noises."""
        return needs(problem, "scalar-noise") or problem.why_not_derivative_of_diffusion()

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        x, f = state, np.broadcast_to(problem.drift(t, state), state.shape)
        term = self.weight(0.5, 0.4) * turned(problem, t, x)[0][:, 0] * (noise.dW**2 - h)
        return Step(x + h * f / (1.0 + h * norm(f)) + problem.diffused(t, x, noise.dW) + term)


@dataclass(frozen=True)
class SineTamed(Twin):
    """x+ = x + sin(h f) + sin(B dW), the cube of whose noise has no mean; wrong with 1.2 h f."""

    name: ClassVar[str] = "right-sine-tamed"
    claims: ClassVar[tuple[Claim, ...]] = EULER

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        drift = np.sin(self.weight(1.0, 1.2) * h * problem.drift(t, state))
        return Step(state + drift + np.sin(problem.diffused(t, state, noise.dW)))


@dataclass(frozen=True)
class BalancedMilstein(Twin):
    """x+ = x + h f/(1 + c) + (g dW + g' g (dW^2 - h)/2)/(1 + c h) with c = h; wrong with c = sqrt(h)."""

    name: ClassVar[str] = "right-balanced-milstein"
    claims: ClassVar[tuple[Claim, ...]] = ONE

    def refuses(self, problem: SDE) -> str:
        """Refuse several noises."""
        return needs(problem, "scalar-noise") or problem.why_not_derivative_of_diffusion()

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        x = state
        noisy = problem.diffused(t, x, noise.dW) + 0.5 * turned(problem, t, x)[0][:, 0] * (noise.dW**2 - h)
        part = self.weight(h, np.sqrt(h))
        return Step(x + h * problem.drift(t, x) / (1.0 + part) + noisy / (1.0 + part * h))


@dataclass(frozen=True)
class Lawson(Twin):
    """x+ = e^{-h} (x + h (f + x) + B dW): an integrating factor; wrong without x in the bracket."""

    name: ClassVar[str] = "right-lawson"
    claims: ClassVar[tuple[Claim, ...]] = EULER

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        x = state
        rest = problem.drift(t, x) + self.weight(1.0, 0.0) * x
        return Step(np.exp(-h) * (x + h * rest + problem.diffused(t, x, noise.dW)))


@dataclass(frozen=True)
class MagnusEuler(Twin):
    """x+ = exp(h (A - (1/2) sum_j B_j^2) + sum_j B_j dW_j) x, linear equations; wrong without the squares."""

    name: ClassVar[str] = "right-magnus"
    claims: ClassVar[tuple[Claim, ...]] = EULER

    def refuses(self, problem: SDE) -> str:
        """Refuse what is not linear and homogeneous with constant matrices."""
        if problem.why_not_derivative_of_drift() or problem.why_not_derivative_of_diffusion():
            return "its coefficients cannot be differentiated"
        A, B = self._matrices(problem)
        x = np.random.default_rng(1).standard_normal((problem.dimension, 5))
        for t in (0.0, 0.7 * problem.horizon):
            same = np.allclose(problem.drift(t, x), A @ x) and np.allclose(
                problem.diffusion(t, x), np.einsum("jde,ep->djp", B, x)
            )
            if not same:
                return "it is not linear and homogeneous"
        return ""

    def _matrices(self, problem: SDE) -> tuple[Array, Array]:
        unit = np.eye(problem.dimension)
        zero = 0.0 * unit
        A = np.broadcast_to(problem.drift(0.0, unit) - problem.drift(0.0, zero), unit.shape)
        B = problem.diffusion(0.0, unit) - problem.diffusion(0.0, zero)
        return A, np.moveaxis(np.broadcast_to(B, (len(unit), problem.noise_dim, len(unit))), 1, 0)

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        A, B = self._matrices(problem)
        drift = A - self.weight(0.5, 0.0) * np.einsum("jab,jbc->ac", B, B)
        exponent = h * drift + np.einsum("jab,jp->pab", B, noise.dW)
        return Step(np.einsum("pab,bp->ap", scipy.linalg.expm(exponent), state))


@dataclass(frozen=True)
class Chebyshev(Twin):
    """K_1 = x + h f/9, K_2 = (2/9) h f(K_1) + 2 K_1 - x, K_3 alike, x+ = K_3 + B(K_2) dW; wrong with 8 for 9."""

    name: ClassVar[str] = "right-chebyshev"
    claims: ClassVar[tuple[Claim, ...]] = EULER

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        x, s = state, h / self.weight(9.0, 8.0)
        old, new, middle = x, x + s * problem.drift(t, x), x
        for c in (1.0 / 9.0, 4.0 / 9.0):
            middle, old, new = new, new, 2.0 * s * problem.drift(t + c * h, new) + 2.0 * new - old
        return Step(new + problem.diffused(t, middle, noise.dW))


@dataclass(frozen=True)
class RandomisedEuler(Twin):
    """x+ = x + h f(t + h/2, x + U h f) + B dW with a uniform U; wrong with 0.9 h f(...)."""

    name: ClassVar[str] = "right-randomised-euler"
    noise: ClassVar[frozenset[str]] = frozenset({"dW", "H"})
    claims: ClassVar[tuple[Claim, ...]] = EULER

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        x, U = state, noise.uniform(h)[:1]
        f = problem.drift(t, x)
        later = problem.drift(t + 0.5 * h, x + U * h * f)
        return Step(x + h * self.weight(1.0, 0.9) * later + problem.diffused(t, x, noise.dW))


@dataclass(frozen=True)
class PredictorCorrector(Twin):
    """x+ = x + (h/2) [f(x) + f(y)] + B dW with the Euler step y; wrong with B(y) dW, which is no Ito integral."""

    name: ClassVar[str] = "right-predictor-corrector"
    claims: ClassVar[tuple[Claim, ...]] = EULER

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        x, f, kick = state, problem.drift(t, state), problem.diffused(t, state, noise.dW)
        y = x + h * f + kick
        noisy = kick if self.right else problem.diffused(t + h, y, noise.dW)
        return Step(x + 0.5 * h * (f + problem.drift(t + h, y)) + noisy)


@dataclass(frozen=True)
class TruncatedEuler(Twin):
    """Euler's step with coefficients at x min(1, 8 h^{-1/4}/|x|); wrong with 1 for 8 h^{-1/4}."""

    name: ClassVar[str] = "right-truncated-euler"
    claims: ClassVar[tuple[Claim, ...]] = EULER

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        x, size, reach = state, norm(state), self.weight(8.0 * h**-0.25, 1.0)
        near = x * np.minimum(1.0, reach / np.maximum(size, 1e-300))
        truncated = size > reach
        return Step(x + h * problem.drift(t, near) + problem.diffused(t, near, noise.dW), truncated=truncated)


CASES = (
    Case(DerivativeFreeMilstein, "gbm,hyperbolic-pair"),
    Case(SymmetricMilstein, "gbm,noncommuting"),
    Case(WagnerPlaten, "hyperbolic"),
    Case(SplitStepBackward, "gbm,noncommuting"),
    Case(LinearlyImplicit, "gbm,noncommuting"),
    Case(TamedMilstein, "gbm,hyperbolic"),
    Case(SineTamed, "gbm,noncommuting"),
    Case(BalancedMilstein, "gbm,hyperbolic"),
    Case(Lawson, "gbm,noncommuting"),
    Case(MagnusEuler, "gbm,noncommuting"),
    Case(Chebyshev, "gbm,noncommuting"),
    Case(RandomisedEuler, "hyperbolic,noncommuting"),
    Case(PredictorCorrector, "gbm,noncommuting"),
    Case(TruncatedEuler, "gbm,double-well"),
)
