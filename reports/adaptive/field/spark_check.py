"""Adaptive SPaRK of diffrax, without the verifier: its estimate has a double zero where its error has none.

For dy = b y o dW over a step, with u = b W, q = b H (H the space-time Levy area) and y before the step,

    estimate of the step       -sqrt(3) y u (q + u/(2 sqrt(3)))^2            exactly,
    error of the step          y (e^u - 1 - u - u^2/2 + ...) = y u^3/6 + ...  where the estimate is 0.

A long step h passes with a probability like sqrt(tol/h^(3/2)): its error is then not bounded by the tolerance.

Needs diffrax alone: `python reports/adaptive/field/spark_check.py`
"""

import diffrax
import jax
import jax.numpy as jnp
import numpy as np

jax.config.update("jax_enable_x64", True)
PATHS = 400
TOLERANCES = [2.0**-n for n in (5, 7, 9, 11)]
A, B = 0.1, 0.8


class Given(diffrax.AbstractBrownianPath):
    """A path that is known over one step."""

    W: jax.Array
    H: jax.Array
    levy_area = diffrax.SpaceTimeLevyArea
    t0 = 0.0
    t1 = 1.0

    def evaluate(self, t0, t1=None, left=True, use_levy=False):
        """Return what is given."""
        return diffrax.SpaceTimeLevyArea(dt=t1 - t0, W=self.W, H=self.H) if use_levy else self.W


def terms(path, drift, diffusion):
    """Return the terms of dy = drift dt + diffusion o dW."""
    return diffrax.MultiTerm(diffrax.ODETerm(drift), diffrax.ControlTerm(diffusion, path))


def one_step(W, H):
    """Return a step of SPaRK for dy = B y o dW from y = 1, and its estimate."""
    given = terms(Given(W, H), lambda t, y, _: 0.0 * y, lambda t, y, _: B * y)
    y, error, *_ = diffrax.SPaRK().step(given, 0.0, 1.0, jnp.float64(1.0), None, None, made_jump=False)
    return y, error


def check_formula():
    """Print how far the estimate is from the formula, and the error where the estimate vanishes."""
    W, H = 0.5 * np.random.default_rng(1).standard_normal((2, 1000))
    H /= 12**0.5
    _, error = jax.vmap(one_step)(W, H)
    u, q = B * W, B * H
    formula = -np.sqrt(3.0) * u * (q + u / np.sqrt(12.0)) ** 2
    print(f"estimate against -sqrt(3) u (q + u/sqrt(12))^2: largest difference {np.abs(error - formula).max():.1e}")
    y, error = one_step(jnp.float64(0.5), jnp.float64(-0.5 / np.sqrt(12.0)))
    sizes = abs(error), abs(y - np.exp(0.5 * B)), (0.5 * B) ** 3 / 6
    print("W = 0.5, H = -W/sqrt(12): estimate {:.1e}, error {:.1e}, u^3/6 = {:.1e}".format(*sizes))


PROBLEMS = {
    "gbm": (lambda t, y, _: (A - 0.5 * B * B) * y, lambda t, y, _: B * y, 1.0),
    "sinh": (lambda t, y, _: 0.5 * jnp.sqrt(1 + y * y), lambda t, y, _: 0.6 * jnp.sqrt(1 + y * y), 0.5),
    "sine": (lambda t, y, _: 0.0 * y, lambda t, y, _: 0.8 * jnp.cos(y), 0.0),
}
EXACT = {
    "gbm": lambda w: np.exp((A - 0.5 * B * B) + B * w),
    "sinh": lambda w: np.sinh(np.arcsinh(0.5) + 0.5 + 0.6 * w),
    # dy/ds = cos y from 0 is the Gudermannian function.
    "sine": lambda w: 2.0 * np.arctan(np.tanh(0.4 * w)),
}


def runner(problem, solver, controller):
    """Return a compiled solve of all paths: ends, W(1) and numbers of tries."""
    drift, diffusion, start = PROBLEMS[problem]

    def one(key, tol):
        path = diffrax.VirtualBrownianTree(0.0, 1.0, 2.0**-18, (), key, levy_area=diffrax.SpaceTimeLevyArea)
        found = diffrax.diffeqsolve(
            terms(path, drift, diffusion), solver, 0.0, 1.0, 0.125, jnp.float64(start),
            stepsize_controller=controller(tol), adjoint=diffrax.ForwardMode(), max_steps=2**16,
        )  # fmt: skip
        return found.ys[-1], path.evaluate(0.0, 1.0), found.stats["num_steps"]

    return jax.jit(jax.vmap(one, in_axes=(0, None)))


CONTROLLERS = {
    "rtol = atol, pcoeff .1, icoeff .3": lambda tol: diffrax.PIDController(tol, tol, pcoeff=0.1, icoeff=0.3),
    "rtol = atol, default coefficients": lambda tol: diffrax.PIDController(tol, tol),
    "atol alone, pcoeff .1, icoeff .3": lambda tol: diffrax.PIDController(0.0, tol, pcoeff=0.1, icoeff=0.3),
    "rtol alone, pcoeff .1, icoeff .3": lambda tol: diffrax.PIDController(tol, 0.0, pcoeff=0.1, icoeff=0.3),
}


def table(problem, name, solver, controllers):
    """Print rms, median and share of the worst hundredth of the paths, and the slopes."""
    keys = jax.random.split(jax.random.PRNGKey(7), PATHS)
    for setting in controllers:
        run, rms, tries = runner(problem, solver, CONTROLLERS[setting]), [], []
        for tol in TOLERANCES:
            y, w, steps = map(np.asarray, run(keys, tol))
            squares = np.sort((y - EXACT[problem](w)) ** 2)
            rms.append(np.sqrt(squares.mean()))
            tries.append(steps.mean())
        share = squares[-PATHS // 100 :].sum() / squares.sum()
        slope = np.polyfit(np.log2(TOLERANCES), np.log2(rms), 1)[0]
        order = -np.polyfit(np.log2(tries), np.log2(rms), 1)[0]
        sizes = " ".join(f"{each:.2g}" for each in rms)
        print(
            f"{problem}, {name}, {setting}: rms {sizes}; tries {' '.join(f'{n:.0f}' for n in tries)}; slope in tol "
            f"{slope:.2f}, per try {order:.2f}; worst 1 % of the paths hold {100 * share:.0f} % of the square",
            flush=True,
        )


if __name__ == "__main__":
    check_formula()
    first, *_ = CONTROLLERS
    for problem in PROBLEMS:
        table(problem, "SPaRK", diffrax.SPaRK(), CONTROLLERS if problem == "gbm" else [first])
        table(problem, "Heun", diffrax.Heun(), [first])
