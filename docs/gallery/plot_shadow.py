"""
The equation that Euler-Maruyama really solves
==============================================

Euler-Maruyama samples a double well. If the step size is not small, the density of its samples differs from the right
one. The modified equation predicts it.
"""

from typing import ClassVar

import numpy as np
from matplotlib import pyplot as plt

from sdaeverify import SDE, Claim, Scheme, Step
from sdaeverify_orders import modified_equations, orders

(shadow,) = modified_equations("euler-maruyama", "overdamped-gradient")
[(str(term.forest[0]), round(term.value, 6)) for term in shadow.drift]

# %%
# The drift f = -V' is changed by -h/2 (f'f + f''), for kT = 1, and the covariance by -2 h f'. This is the
# density of the potential V - h V'^2/4 + h V''/2. The picture compares it with the given density and with a histogram
# of Euler-Maruyama at h = 0.2.


def potential(x):
    """Return V and its first two derivatives."""
    return 0.5 * x**2 + np.cos(2.0 * x), x - 2.0 * np.sin(2.0 * x), 1.0 - 4.0 * np.cos(2.0 * x)


h, rng = 0.2, np.random.default_rng(1)
x = np.linspace(-1.0, 1.0, 20_000)
seen = []
for n in range(400):
    x = x - h * potential(x)[1] + np.sqrt(2.0 * h) * rng.standard_normal(x.shape)
    if n >= 100:
        seen.append(x[::10])

grid = np.linspace(-3.5, 3.5, 400)
V, first, second = potential(grid)
shadowed = V - h * first**2 / 4.0 + h * second / 2.0
fig, ax = plt.subplots()
ax.hist(np.concatenate(seen), bins=120, range=(-3.5, 3.5), density=True, color="0.85", label="Euler-Maruyama")
for sampled, style, label in ((V, "--", "given"), (shadowed, "-", "modified")):
    density = np.exp(-sampled)
    ax.plot(grid, density / np.trapezoid(density, grid), style, label=label)
ax.set(xlabel="x", ylabel="density", title="h = 0.2")
ax.legend()

# %%
# A wrong scheme also solves some equation. This scheme evaluates the diffusion at both ends of the step, as Heun's
# method does, but uses the Ito drift.


class BothEnds(Scheme):
    """Heun's method for the noise, with the drift of Ito's equation."""

    name: ClassVar[str] = "both-ends"
    form: ClassVar[type[SDE]] = SDE
    claims: ClassVar[tuple[Claim, ...]] = (Claim(measure="weak", value=1.0, source="hoped"),)

    def step(self, problem, state, t, h, noise):
        """Make one step; the state has shape (d, P)."""
        f, B = problem.drift(t, state), problem.diffusion(t, state)
        y = state + h * f + np.einsum("ijp,jp->ip", B, noise.dW)
        both = 0.5 * (B + problem.diffusion(t + h, y))
        return Step(state + h * f + np.einsum("ijp,jp->ip", both, noise.dW))


(row,) = [row for row in orders(BothEnds(), "scalar").rows if row.measure == "weak"]
row.mistake
