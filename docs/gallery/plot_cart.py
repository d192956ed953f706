r"""
Pendulum on a cart
==================

A cart of mass M moves without friction along x; a pendulum of length 1 and mass 1 hangs from it. Noise pushes the
cart.

.. math::

    g = (1 - (X - x)^{2} - Y^{2})/2 = 0

Gravity is vertical and the rod's force is internal: the horizontal momentum p = M x' + X' is p(0) + sigma W exactly,
for any motion of the pendulum. Its mean square is p(0)^2 + sigma^2 t.
"""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from matplotlib import pyplot as plt

from sdaeverify import HolonomicSDAE, Moment, sample, verify
from sdaeverify_schemes.projections.half_explicit_euler import HalfExplicitEuler

M, SIGMA, ANGLE = 2.0, 1.0, 0.6


def pendulum_on_a_cart(horizon: float = 0.5) -> HolonomicSDAE:
    """r = (x, X, Y) with masses M, 1, 1, gravity on the pendulum, noise on the cart, which moves at the start."""

    def momentum(t, s):
        return M * s["v"][0] + s["v"][1]

    v = np.array([0.5, 0.5, 0.0])
    p = float(M * v[0] + v[1])
    return HolonomicSDAE(
        force=lambda t, r, v: np.array([[0.0], [0.0], [-1.0]]),
        diffusion=lambda t, r, v: np.array([[[SIGMA]], [[0.0]], [[0.0]]]),
        constraint=lambda r: 0.5 * (1.0 - (r[1] - r[0]) ** 2 - r[2] ** 2)[None],
        mass=np.diag([M, 1.0, 1.0]),
        position=[0.0, np.sin(ANGLE), -np.cos(ANGLE)],
        velocity=v,
        noise_dim=1,
        horizon=horizon,
        traits=frozenset({"additive-noise"}),
        observables={"p": momentum, "p^2": lambda t, s: momentum(t, s) ** 2},
        truths=(
            Moment(observable="p", value=lambda t: p, source="p = p(0) + sigma W"),
            Moment(observable="p^2", value=lambda t: p**2 + SIGMA**2 * t, source="p = p(0) + sigma W"),
        ),
        source="Lagrange's equations of the first kind",
    )


paths = sample("half-explicit-euler[truncation=none]", pendulum_on_a_cart, steps=256, paths=10)
figure, axes = plt.subplots(1, 2, figsize=(8, 3), layout="constrained")
paths.plot("r", 0, ax=axes[0]).set(title="the cart", ylabel="x")
axes[1].plot(paths["r"][:, 1], paths["r"][:, 2], lw=0.8)
axes[1].set(title="the pendulum", xlabel="X", ylabel="Y", aspect="equal")

# %%
# A wrong scheme: the force of the rod acts only on the positions, not on the velocities.


@dataclass(frozen=True)
class LooseRod(HalfExplicitEuler):
    """The half-explicit scheme without the force of the rod on the velocity."""

    truncation: str = "none"

    name: ClassVar[str] = "loose-rod"

    def step(self, problem, state, t, h, noise):
        """Make one step."""
        made = super().step(problem, state, t, h, noise)
        push = problem.force(t, state.r, state.v) * h + problem.diffused(t, state.r, state.v, noise.dW)
        return made._replace(state=made.state._replace(v=state.v + problem.inverse_mass(push)))


result = verify([HalfExplicitEuler(truncation="none"), LooseRod()], pendulum_on_a_cart, "weak,drift", paths=2048)
result

# %%

verdicts = result.verdicts.groupby("scheme").verdict.agg(set)
print(verdicts.to_string())
assert "verified" in verdicts["half-explicit-euler[truncation=none]"]
assert "refuted" not in verdicts["half-explicit-euler[truncation=none]"]
wrong = result.verdicts.query("scheme == 'loose-rod' and verdict == 'refuted'")
assert set(wrong.decided_by) == {"T0"}
assert wrong.reason.str.startswith("Not exact on dv = c dt + S dW").all()
