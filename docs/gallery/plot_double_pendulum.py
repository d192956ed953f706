r"""
Double pendulum
===============

Two masses on rods of length 1, with noise on both. There is no solution in closed form, but Ito's formula gives
the mean of the energy: the m = 2 constraints leave n - m = 2 of n = 4 directions, each heated at the rate sigma^2/2.

.. math::

    E H(t) = H(0) + (n - m) \sigma ^{2} t/2
"""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from matplotlib import pyplot as plt

from sdaeverify import HolonomicSDAE, Moment, sample, verify
from sdaeverify_schemes.projections.half_explicit_euler import HalfExplicitEuler

SIGMA = 0.7
START = np.array([0.8, -0.6, 0.8, -1.6])


def energy(t, s):
    """Return kinetic and potential energy."""
    return 0.5 * (s["v"] ** 2).sum(axis=0) + s["r"][1] + s["r"][3]


def double_pendulum(horizon: float = 0.5) -> HolonomicSDAE:
    """Masses 1 at r_1 and r_2, |r_1| = |r_2 - r_1| = 1, gravity 1 and noise sigma dw in R^4, from rest."""
    level = START[1] + START[3]
    return HolonomicSDAE(
        force=lambda t, r, v: np.array([[0.0], [-1.0], [0.0], [-1.0]]),
        diffusion=lambda t, r, v: SIGMA * np.eye(4)[..., None],
        constraint=lambda r: (
            0.5 * np.stack([1.0 - r[0] ** 2 - r[1] ** 2, 1.0 - (r[2] - r[0]) ** 2 - (r[3] - r[1]) ** 2])
        ),
        position=START,
        velocity=np.zeros(4),
        noise_dim=4,
        horizon=horizon,
        traits=frozenset({"additive-noise"}),
        observables={"energy": energy},
        truths=(Moment(observable="energy", value=lambda t: level + SIGMA**2 * t, source="Ito's formula"),),
        source="Lagrange's equations of the first kind",
    )


paths = sample("half-explicit-euler[truncation=none]", double_pendulum, steps=256, paths=8)
figure, ax = plt.subplots(figsize=(4.5, 4.5), layout="constrained")
ax.plot(paths["r"][:, 2], paths["r"][:, 3], lw=0.8)
ax.set(title="the lower mass", xlabel="x", ylabel="y", aspect="equal")

# %%
# A scheme whose noise is 10 per cent too small looks right on a picture, but it heats too slowly. One step is enough
# to refute it, without any path.


@dataclass(frozen=True)
class Cold(HalfExplicitEuler):
    """The half-explicit scheme with a tenth too little noise."""

    truncation: str = "none"

    name: ClassVar[str] = "cold"

    def step(self, problem, state, t, h, noise):
        """Make one step."""
        return super().step(problem, state, t, h, noise._replace(dW=0.9 * noise.dW))


result = verify([HalfExplicitEuler(truncation="none"), Cold()], double_pendulum, "weak", paths=2048)
result

# %%

print(result.cell("cold", "double-pendulum"))
verdicts = result.verdicts.groupby("scheme").verdict.agg(set)
print(verdicts.to_string())
assert "verified" in verdicts["half-explicit-euler[truncation=none]"]
assert "refuted" not in verdicts["half-explicit-euler[truncation=none]"]
wrong = result.verdicts.query("scheme == 'cold' and verdict == 'refuted'")
assert set(wrong.decided_by) == {"T0"}
assert wrong.reason.str.startswith("Not exact on dv = c dt + S dW").all()
