"""Coefficients of an SDE on the arrays of another library, in the calculus of its solver."""

from collections.abc import Callable
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from sdaeverify import SDE, Array, Langevin

from .foreign import Foreign, Namespace, why_not_run
from .formulas import Formulas

# Traits of noise whose double integrals are functions of the increments.
SEPARATE = frozenset({"scalar-noise", "diagonal-noise", "additive-noise"})


class Coefficients(NamedTuple):
    """Drift and diffusion of dx = f dt + B dW, or of dx = F dt + B o dW with F = f - (1/2) sum_j DB_j B_j.

    Attributes
    ----------
    problem : SDE
    namespace : module
        Functions of the library under NumPy's names; see `Foreign`.
    stratonovich : bool
        Whether the solver converges to the Stratonovich solution, so that it needs F to solve the problem.
    """

    problem: SDE
    namespace: Namespace
    stratonovich: bool = False

    def drift(self, t: Any, x: Any) -> Any:
        """Return f or F, shape (d, P), at states of shape (d, P) and one time."""
        return self._full(self._drift, t, x, (self.problem.dimension, x.shape[-1]))

    def diffusion(self, t: Any, x: Any) -> Any:
        """Return B, shape (d, l, P), at states of shape (d, P) and one time."""
        d, l = self.problem.dimension, self.problem.noise_dim
        if "additive-noise" in self.problem.traits:
            # Libraries check whether B depends on the state, so it is evaluated once regardless of its formula.
            B = self.problem.diffusion(0.0, self.problem.initial(1))
            return self._bare(np.broadcast_to(B[..., :1], (d, l, 1)), (d, l, x.shape[-1]))
        return self._full(self.problem.diffusion, t, x, (d, l, x.shape[-1]))

    def _drift(self, t: Any, x: Any) -> Any:
        # The correction vanishes for additive noise; otherwise it uses the author's derivative or a complex step.
        if not self.stratonovich or "additive-noise" in self.problem.traits:
            return self.problem.drift(t, x)
        return stratonovich_drift(self.problem, t, x)

    def _full(self, formula: Callable[[Any, Any], Any], t: Any, x: Any, shape: tuple[int, ...]) -> Any:
        return self._bare(formula(Foreign(t, self.namespace), Foreign(x, self.namespace)), shape)

    def _bare(self, value: Any, shape: tuple[int, ...]) -> Any:
        bare = value.array if isinstance(value, Foreign) else self.namespace.asarray(value)
        return self.namespace.broadcast_to(bare, shape)


def stratonovich_drift(problem: SDE, t: float, x: Array) -> Array:
    """Return F = f - (1/2) sum_j DB_j B_j, shape (d, P): with it, dx = F dt + B o dW is the Ito equation.

    Parameters
    ----------
    problem : SDE
        Problem in Ito's form.
    t : float
    x : ndarray, shape (d, P)
    """
    B = problem.diffusion(t, x)
    drift = problem.drift(t, x)
    for j in range(problem.noise_dim):
        column = np.broadcast_to(B[:, j], x.shape)
        drift = drift - 0.5 * problem.derivative_of_diffusion(t, x, column)[:, j]
    return drift


def why_not_bridged(problem: SDE, *, stratonovich: bool = False) -> str:
    """Return why the formulas of a problem cannot be run by another library, or an empty string."""
    return _why_not(Formulas(problem), stratonovich)


@lru_cache(maxsize=1024)
def _why_not(formulas: Formulas, stratonovich: bool) -> str:
    problem: SDE = formulas.problem
    if (
        stratonovich
        and "additive-noise" not in problem.traits
        and (reason := problem.why_not_derivative_of_diffusion())
    ):
        return reason
    tried, x = Coefficients(problem, np, stratonovich), problem.initial(1)
    return why_not_run({"drift": tried.drift, "diffusion": tried.diffusion}, np.float64(0.0), x)


def why_not_without_areas(problem: SDE) -> str:
    """Return the reason that a method of order 1 needs Levy areas for the noise, or an empty string."""
    separate = problem.traits & SEPARATE
    return "" if separate else f"noise in {problem.noise_dim} dimensions is neither scalar nor diagonal nor additive"


def why_not_temperature(problem: Langevin) -> str:
    """Return the reason that a problem has no temperature sigma^2/(2 gamma), or an empty string."""
    has_one = problem.friction > 0.0 and problem.strength > 0.0
    return "" if has_one else "without friction or noise it has no temperature"
