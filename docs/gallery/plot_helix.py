r"""
Bead on a helix
===============

A bead slides without friction on the helix (cos s, sin s, c s) under gravity, and its height is shaken by noise:

.. math::

    \,dr = v \,dt, \qquad \,dv = (-e_{3} + ...) \,dt + \sigma e_{3} \,dW + \nabla g \,d\mu , \qquad
    g = (x - \cos (z/c), y - \sin (z/c)) = 0

The slope of a helix is the same everywhere. Along it, gravity and noise are therefore constant, and the height is
known exactly from W and its time integral: z'' = k (-1 + sigma W') with k = c^2/(1 + c^2).
"""

from typing import ClassVar

import numpy as np
from matplotlib import pyplot as plt

from sdaeverify import Claim, HolonomicSDAE, Pathwise, sample, verify
from sdaeverify_schemes.euler_maruyama import EulerMaruyama
from sdaeverify_schemes.projections.half_explicit_euler import HalfExplicitEuler

c, SIGMA = 0.5, 1.0
k = c**2 / (1.0 + c**2)


def on_the_helix(z, u):
    """Return position and velocity of heights z with rates u."""
    x, y = np.cos(z / c), np.sin(z / c)
    return {"r": np.stack([x, y, z]), "v": np.stack([-y * u / c, x * u / c, u])}


def fallen(state, t, h, noise):
    """Return height and rate one step later: exact."""
    (z, u), dW, Z = state, noise.dW[0], noise.time_integral(h)[0]
    return np.stack([z + h * u + k * (SIGMA * Z - 0.5 * h**2), u + k * (SIGMA * dW - h)])


def bead_on_a_helix(horizon: float = 0.5) -> HolonomicSDAE:
    """A bead on (cos s, sin s, c s) with gravity and noise in the height."""
    start = on_the_helix(np.array([0.0]), np.array([0.3]))
    truth = Pathwise(
        start=lambda paths: np.repeat([[0.0], [0.3]], paths, axis=1),
        advance=fallen,
        parts=lambda t, state: on_the_helix(*state),
        source="the slope of a helix is constant",
    )
    return HolonomicSDAE(
        force=lambda t, r, v: np.array([[0.0], [0.0], [-1.0]]),
        diffusion=lambda t, r, v: np.array([[[0.0]], [[0.0]], [[SIGMA]]]),
        constraint=lambda r: np.stack([r[0] - np.cos(r[2] / c), r[1] - np.sin(r[2] / c)]),
        position=start["r"][:, 0],
        velocity=start["v"][:, 0],
        noise_dim=1,
        horizon=horizon,
        traits=frozenset({"additive-noise"}),
        truths=(truth,),
        source="Lagrange's equations of the first kind",
    )


paths = sample("half-explicit-euler[truncation=none]", bead_on_a_helix, steps=256, paths=6)
ax = plt.figure(figsize=(5, 5)).add_subplot(projection="3d")
for path in range(6):
    ax.plot(*paths["r"][:, :, path].T)
ax.set(xlabel="x", ylabel="y", zlabel="z")

# %%
# The half-explicit scheme, and Euler-Maruyama on the inherent SDE. The latter has the same strong order but does not
# project; here it wrongly claims to keep the constraints.


class Unprojected(EulerMaruyama):
    """Euler-Maruyama, which claims to stay on the helix."""

    name: ClassVar[str] = "unprojected"
    claims: ClassVar[tuple[Claim, ...]] = (Claim(measure="drift", value="round-off", source="wishful thinking"),)


result = verify([HalfExplicitEuler(truncation="none"), Unprojected()], bead_on_a_helix, "strong,drift", paths=2048)
result

# %%

axes = result.plot.drift(quantity="g")
verdicts = result.verdicts.groupby("scheme").verdict.agg(set)
print(verdicts.to_string())
assert "verified" in verdicts["half-explicit-euler[truncation=none]"]
assert "refuted" not in verdicts["half-explicit-euler[truncation=none]"]
wrong = result.verdicts.query("scheme == 'unprojected' and verdict == 'refuted'")
assert set(wrong.decided_by) == {"T3"}
assert wrong.reason.str.startswith("Residual").all()
