"""Adaptive solvers of diffrax as a plugin file: its solvers and controllers as they are, on the verifier's path.

`sdaeverify adaptive --plugin reports/adaptive/field/diffrax_solvers.py 'diffrax-*'`
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any, ClassVar

import diffrax
import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np

from sdaeverify import SDE, Claim, hookimpl
from sdaeverify_adaptive import TICKS, Adaptive, Path, Solved
from sdaeverify_bridges.kit import Coefficients, why_not_bridged

jax.config.update("jax_enable_x64", True)
jax.config.update("jax_platforms", "cpu")

MOST_STEPS = 2**16
ADDITIVE = ("ShARK", "SRA1")
TABLE = "documentation of diffrax, SDE solver table, for steps of one length"
CONJECTURE = "a conjecture: its documentation names no rate in the tolerance"
COMMUTATIVE, ADDED = frozenset({"commutative-noise"}), frozenset({"additive-noise"})


class Holder:
    """The path that is solved along now: one compiled function serves all of them."""

    path: Path

    def increments(self, row: np.ndarray, t0: np.ndarray, t1: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return dW and H between two times on each path, shape (P, l); times that are no ticks are refused."""
        rows, begin, end = np.broadcast_arrays(np.asarray(row), np.asarray(t0), np.asarray(t1))
        path = self.path.only(np.atleast_1d(rows))
        a, b = (path.at(np.atleast_1d(path.ticks_of(t))) for t in (begin, end))
        h = np.maximum((b.tick - a.tick) * path.tick, path.tick)
        dW = b.W - a.W
        H = np.where(b.tick > a.tick, (b.J - a.J) / h - a.W - 0.5 * dW, 0.0)
        shape = (*rows.shape, path.dimension)
        return dW.T.reshape(shape), H.T.reshape(shape)


class OnPath(diffrax.AbstractBrownianPath):
    """One row of the verifier's path."""

    row: Any
    dimension: int = eqx.field(static=True)
    fetch: Callable[..., Any] = eqx.field(static=True)
    levy_area: ClassVar[Any] = diffrax.SpaceTimeLevyArea
    t0: ClassVar[float] = -jnp.inf
    t1: ClassVar[float] = jnp.inf

    def evaluate(self, t0: Any, t1: Any = None, left: bool = True, use_levy: bool = False) -> Any:
        """Return the increment, with its space-time area where it is asked for."""
        one = jax.ShapeDtypeStruct((self.dimension,), jnp.float64)
        begin, end = (0.0, t0) if t1 is None else (t0, t1)
        dW, H = jax.pure_callback(self.fetch, (one, one), self.row, begin, end, vmap_method="broadcast_all")
        return diffrax.SpaceTimeLevyArea(dt=end - begin, W=dW, H=H) if use_levy else dW


class OnTicks(diffrax.AbstractStepSizeController):
    """A controller whose steps are rounded down to whole ticks, and to at most T/8."""

    inner: Any
    tick: float

    def wrap(self, direction: Any) -> "OnTicks":
        """Return the same with the inner controller wrapped."""
        return OnTicks(self.inner.wrap(direction), self.tick)

    def rounded(self, begin: Any, end: Any) -> Any:
        """Return the end of a step."""
        size = jnp.floor((end - begin) / self.tick * (1.0 + 1e-12))
        return begin + jnp.clip(size, 1, TICKS // 8) * self.tick

    def init(self, terms: Any, t0: Any, t1: Any, *rest: Any) -> tuple[Any, Any]:
        """Return the end of the first step."""
        end, state = self.inner.init(terms, t0, t1, *rest)
        return self.rounded(t0, end), state

    def adapt_step_size(self, *given: Any) -> tuple[Any, ...]:
        """Return what the inner controller says, its next end rounded."""
        keep, begin, end, *rest = self.inner.adapt_step_size(*given)
        return keep, begin, self.rounded(begin, end), *rest


@dataclass(frozen=True)
class Diffrax(Adaptive):
    """A solver of diffrax with its PIDController.

    Attributes
    ----------
    solver : str
        Name of its class.
    scaled : str
        Which of the tolerances is set, the other one being 0: ``rtol``, ``atol`` or ``both``.
    p, i : float
        pcoeff and icoeff: 0 and 1 are the defaults, 0.1 and 0.3 what the documentation names for SDEs.
    stored : int
        store_rejected_steps of ClipStepSizeController; 0 for none.
    """

    solver: str = "Heun"
    scaled: str = "both"
    p: float = 0.0
    i: float = 1.0
    stored: int = 0

    name: ClassVar[str] = "diffrax-pid"
    source: ClassVar[str] = f"diffrax {diffrax.__version__}"

    @property
    def tolerances(self) -> tuple[float, ...]:  # type: ignore[override] # of each solver its own
        """Return tolerances that lead to 16 to 1000 steps or so: Heun's estimate is of the lowest order."""
        return tuple(2.0**-n for n in ((6, 8, 10, 12) if self.solver == "Heun" else (8, 10, 12, 14)))

    @property
    def promises(self) -> tuple[Claim, ...]:
        """Half an order in the tolerance; in the mean number of steps the order that the documentation has."""
        order = Claim(measure="tolerance-steps", value=1.0, when=COMMUTATIVE, source=TABLE)
        rates = (Claim(measure="tolerance", value=0.5, source=CONJECTURE),)
        if self.solver in ADDITIVE or self.solver in {"SPaRK", "SlowRK", "GeneralShARK"}:
            order = Claim(measure="tolerance-steps", value=1.5, when=ADDED, source=TABLE)
            one = Claim(measure="tolerance-steps", value=1.0, when=COMMUTATIVE, source=TABLE)
            return (*rates, order, one)
        return (*rates, order)

    def refuses(self, problem: SDE) -> str:
        """Refuse what the table leaves out, and formulas that JAX cannot run."""
        if self.solver in ADDITIVE and "additive-noise" not in problem.traits:
            return "the noise is not additive"
        if self.solver == "SlowRK":
            return "diffrax gives it no estimate of its error"
        if self.scaled == "rtol" and not np.all(problem.initial(1)):
            return "a relative tolerance alone means nothing where a component is 0 in the beginning"
        return why_not_bridged(problem, stratonovich=True)

    def controller(self, tolerance: Any, tick: float) -> Any:
        """Return the controller."""
        rtol, atol = (tolerance if self.scaled in {name, "both"} else 0.0 for name in ("rtol", "atol"))
        coefficients = {"pcoeff": self.p, "icoeff": self.i}
        inner = diffrax.PIDController(rtol, atol, **coefficients, dtmin=tick, force_dtmin=True)
        if self.stored:
            inner = diffrax.ClipStepSizeController(inner, store_rejected_steps=self.stored)
        return OnTicks(inner, tick)

    def solve(self, problem: SDE, path: Path, tolerance: float) -> Solved:
        """Solve along all rows at once."""
        run, holder = compiled(self, problem)
        holder.path = path.only(np.arange(path.paths))
        state, steps, rejected = run(jnp.arange(path.paths), tolerance)
        steps, rejected = np.asarray(steps), np.asarray(rejected)
        return Solved(np.asarray(state).T, steps, rejected, 2 * (steps + rejected))


@cache
def compiled(solver: Diffrax, problem: SDE) -> tuple[Callable[..., Any], Holder]:
    """Return the compiled solve of a problem, and where it looks for its path."""
    holder, equation = Holder(), Coefficients(problem, jnp, stratonovich=True)
    d, l, T = problem.dimension, problem.noise_dim, problem.horizon

    def drift(t: Any, y: Any, _: Any) -> Any:
        return equation.drift(t, y[:, None])[:, 0]

    def diffusion(t: Any, y: Any, _: Any) -> Any:
        return equation.diffusion(t, y[:, None])[..., 0]

    def one(row: Any, tolerance: Any) -> Any:
        path = OnPath(row, l, holder.increments)
        solution = diffrax.diffeqsolve(
            diffrax.MultiTerm(diffrax.ODETerm(drift), diffrax.ControlTerm(diffusion, path)),
            getattr(diffrax, solver.solver)(),
            t0=0.0,
            t1=T,
            dt0=T / 8,
            y0=jnp.asarray(problem.initial(1)[:, 0]),
            stepsize_controller=solver.controller(tolerance, T / TICKS),
            adjoint=diffrax.ForwardMode(),
            max_steps=MOST_STEPS,
            throw=False,
        )
        failed = solution.result != diffrax.RESULTS.successful
        state = jnp.where(failed, jnp.nan, solution.ys[-1]).reshape(d)
        return state, solution.stats["num_accepted_steps"], solution.stats["num_rejected_steps"]

    return jax.jit(jax.vmap(one, in_axes=(0, None))), holder


@hookimpl
def sdaeverify_adaptive() -> list[Adaptive]:
    """Register what was judged."""
    documented = [Diffrax(name, "both", 0.1, 0.3) for name in ("Heun", "SPaRK", "ShARK", "SRA1")]
    return [
        *documented,
        Diffrax("Heun", "both", 0.1, 0.3, stored=100),
        Diffrax("Heun"),
        Diffrax("SPaRK"),
        Diffrax("SPaRK", "atol", 0.1, 0.3),
        Diffrax("SPaRK", "rtol", 0.1, 0.3),
    ]
