"""Orders that the solver table of diffrax tells too low. Needs diffrax alone.

Strong: dx = J x o dW_1 + x o dW_2 with a rotation J, whose columns commute: x(1) = exp(J W_1 + W_2) x(0).
Weak: dx = sin(2 x) dt + dW from 1, E cos x(1), against 64 steps of the same method on the same paths.
"""

import diffrax
import jax
import jax.numpy as jnp

jax.config.update("jax_enable_x64", True)
J = jnp.array([[0.0, -1.0], [1.0, 0.0]])


def paths(seed, count, steps, motions):
    dW = jax.random.normal(jax.random.key(seed), (count, steps, motions)) / steps**0.5
    return jnp.concatenate([jnp.zeros((count, 1, motions)), jnp.cumsum(dW, axis=1)], axis=1)


def ends(solver, f, g, x, W, steps):
    def one(path):
        control = diffrax.LinearInterpolation(jnp.linspace(0.0, 1.0, len(path)), path)
        terms = diffrax.MultiTerm(diffrax.ODETerm(f), diffrax.ControlTerm(g, control))
        return diffrax.diffeqsolve(terms, solver, 0.0, 1.0, 1.0 / steps, x).ys[-1]

    return jax.jit(jax.vmap(one))(W)


print("diffrax", diffrax.__version__)
W = paths(1, 500, 64, 2)
c, s = jnp.cos(W[:, -1, 0]), jnp.sin(W[:, -1, 0])
exact = jnp.exp(W[:, -1, 1:]) * jnp.stack([c, s], axis=1)
for name in ("EulerHeun", "Heun"):
    solver = getattr(diffrax, name)()
    y = [
        ends(solver, lambda t, x, _: 0.0 * x, lambda t, x, _: jnp.stack([J @ x, x], 1), jnp.array([1.0, 0.0]), W, n)
        for n in (8, 16, 32, 64)
    ]
    rms = [float(jnp.sqrt(jnp.mean(jnp.sum((each - exact) ** 2, axis=1)))) for each in y]
    print(
        f"strong, commutative, {name}: {' '.join(f'{e:.4f}' for e in rms)}  order {jnp.log2(rms[-2] / rms[-1]):.2f}"
    )
W = paths(2, 200_000, 64, 1)
for name in ("Heun", "ReversibleHeun", "EulerHeun"):
    solver = getattr(diffrax, name)()
    y = [
        jnp.cos(ends(solver, lambda t, x, _: jnp.sin(2 * x), lambda t, x, _: jnp.ones((1, 1)), jnp.ones(1), W, n))
        for n in (2, 4, 8, 16, 64)
    ]
    means = [
        f"{float(jnp.mean(e)):.5f} +- {float(jnp.std(e)) / len(W) ** 0.5:.5f}" for e in (z - y[-1] for z in y[:-1])
    ]
    print(f"weak, additive, {name} with 2, 4, 8, 16 steps: {', '.join(means)}")
