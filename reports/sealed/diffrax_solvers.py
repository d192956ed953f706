"""`diffeqsolve` with an adaptive controller and its own Brownian motion as sealed solvers, a plugin file.

`sdaeverify sealed --plugin reports/sealed/diffrax_solvers.py diffrax-heun -p 'gbm[a=0.1,b=0.8]'`
"""

from functools import lru_cache
from typing import Any, ClassVar

import diffrax
import jax
import jax.numpy as jnp
import numpy as np

from sdaeverify import SDE, Claim, hookimpl
from sdaeverify_bridges.kit import Coefficients, why_not_bridged
from sdaeverify_sealed import Ends, Sealed

jax.config.update("jax_enable_x64", True)
jax.config.update("jax_platforms", "cpu")

MADE_UP = "a user's expectation of a small tolerance; the documentation of diffrax names no bound"


class DiffraxHeun(Sealed):
    """Heun's scheme with `PIDController` and `VirtualBrownianTree`, h being both tolerances, one key a path."""

    name: ClassVar[str] = "diffrax-heun"
    steps: ClassVar[tuple[int, ...]] = (64, 256, 1024)
    claims: ClassVar[tuple[Claim, ...]] = (
        Claim(measure="weak", value="unbiased", bound=0.05, quantities=("x",), source=MADE_UP),
        Claim(measure="weak", value="unbiased", bound=0.3, quantities=("x^2",), source=MADE_UP),
    )
    source: ClassVar[str] = f"diffrax {diffrax.__version__}; Kidger 2021"

    def refuses(self, problem: SDE) -> str:
        """Refuse formulas that only NumPy can run."""
        return why_not_bridged(problem, stratonovich=True)

    def run(self, problem: SDE, h: float, T: float, paths: int, seed: int) -> Ends:
        """Solve with both tolerances h, one key for each path."""
        keys = jax.random.split(jax.random.key(seed), paths)
        state, W = solve_all(self, problem, T)(keys, h)
        return Ends(np.asarray(state).T, np.asarray(W).T)

    def motion(self, T: float, l: int, key: Any) -> Any:
        """Return the Brownian motion of a key."""
        return diffrax.VirtualBrownianTree(0.0, T, tol=T * 2.0**-14, shape=(l,), key=key)


class DiffraxUnsafe(DiffraxHeun):
    """The same with `UnsafeBrownianPath`, which draws anew what it is asked again, and its check taken out.

    diffrax refuses it with an adaptive controller. Here the path says that it is none, as a user may make it say.
    """

    name: ClassVar[str] = "diffrax-unsafe"

    def motion(self, T: float, l: int, key: Any) -> Any:
        """Return a path that forgets."""
        return Forgetful(shape=jax.ShapeDtypeStruct((l,), jnp.float64), key=key)


class Forgetful(diffrax.AbstractBrownianPath):
    """Increments that are drawn from a key for each interval, without regard to other intervals."""

    shape: Any
    key: Any
    levy_area: ClassVar[Any] = diffrax.BrownianIncrement
    t0: ClassVar[float] = -jnp.inf
    t1: ClassVar[float] = jnp.inf

    def evaluate(self, t0: Any, t1: Any = None, left: bool = True, use_levy: bool = False) -> Any:
        """Return an increment of the right variance."""
        begin, end = (0.0, t0) if t1 is None else (t0, t1)
        bits = jnp.asarray([begin, end]).view(jnp.uint32)
        key = self.key
        for part in bits:
            key = jax.random.fold_in(key, part)
        dW = jnp.sqrt(end - begin) * jax.random.normal(key, self.shape.shape, self.shape.dtype)
        return diffrax.BrownianIncrement(dt=end - begin, W=dW) if use_levy else dW


@lru_cache(maxsize=8)
def solve_all(solver: DiffraxHeun, problem: SDE, T: float) -> Any:
    """Return the compiled function of keys and a tolerance that returns final states and W(T), a row a path."""
    equation, start = Coefficients(problem, jnp, stratonovich=True), jnp.asarray(problem.initial(1)[:, 0])

    def drift(t: Any, y: Any, _: Any) -> Any:
        return equation.drift(t, y[:, None])[:, 0]

    def diffusion(t: Any, y: Any, _: Any) -> Any:
        return equation.diffusion(t, y[:, None])[..., 0]

    def one(key: Any, tolerance: Any) -> Any:
        motion = solver.motion(T, problem.noise_dim, key)
        terms = diffrax.MultiTerm(diffrax.ODETerm(drift), diffrax.ControlTerm(diffusion, motion))
        controller = diffrax.PIDController(rtol=tolerance, atol=tolerance, pcoeff=0.1, icoeff=0.3)
        found = diffrax.diffeqsolve(
            terms, diffrax.Heun(), 0.0, T, None, start, stepsize_controller=controller, max_steps=2**16
        )
        return found.ys[-1], motion.evaluate(0.0, T)

    return jax.jit(jax.vmap(one, in_axes=(0, None)))


@hookimpl
def sdaeverify_sealed() -> list[Sealed]:
    """Register both."""
    return [DiffraxHeun(), DiffraxUnsafe()]
