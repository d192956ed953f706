r"""
RLC circuit with thermal noise
==============================

A source U, a resistor R with its thermal noise, an inductor L and a capacitor C in series; a resistor R' in parallel
to the capacitor is a leak. The current i and the voltage u have differential equations. The current y through the
leak obeys Ohm's law without any: the equation is a differential-algebraic one, of index 1.

.. math::

    L \,di = (U - R i - u) \,dt + \sigma \,dW, \qquad C \,du = (i - y) \,dt, \qquad 0 = R' y - u

The equation is linear, so that its expectations follow from matrix exponentials, without simulation.
"""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from matplotlib import pyplot as plt
from scipy.linalg import expm

from sdaeverify import Claim, IndexOneSDAE, Moment, sample, verify
from sdaeverify_schemes.delays.stochastic_theta import StochasticTheta

R, LEAK, L, C, U, SIGMA = 0.5, 4.0, 1.0, 0.5, 1.0, 0.4


def rlc_circuit(horizon: float = 2.0) -> IndexOneSDAE:
    """Series circuit: L di = (U - R i - u) dt + sigma dW, C du = (i - y) dt, 0 = R' y - u."""
    # Means m' = A m + a and second moments of z = (i, u, i^2, i u, u^2, 1), one linear system for all of them.
    A = np.array([[-R / L, -1.0 / L], [1.0 / C, -1.0 / (C * LEAK)]])
    a, noise = np.array([U / L, 0.0]), np.array([SIGMA / L, 0.0])
    pairs = [(0, 0), (0, 1), (1, 1)]
    G = np.zeros((6, 6))
    G[:2, :2], G[:2, 5] = A, a
    for row, (j, k) in enumerate(pairs, start=2):
        for one, other in ((j, k), (k, j)):
            G[row, one] += a[other]
            for n in range(2):
                G[row, 2 + pairs.index((min(one, n), max(one, n)))] += A[other, n]
        G[row, 5] += noise[j] * noise[k]
    observed = {"i": 0, "u": 1, "i^2": 2, "u^2": 4}

    def moment(row: int):
        return lambda t: float(expm(t * G)[row, 5])

    return IndexOneSDAE(
        drift=lambda t, x, y: np.stack([(U - R * x[0] - x[1]) / L, (x[0] - y[0]) / C]),
        diffusion=lambda t, x, y: noise[:, None, None],
        constraint=lambda t, x, y: LEAK * y - x[1:],
        start=[0.0, 0.0],
        algebraic=1,
        noise_dim=1,
        horizon=horizon,
        traits=frozenset({"additive-noise"}),
        observables={
            "i": lambda t, s: s["x"][0],
            "u": lambda t, s: s["x"][1],
            "i^2": lambda t, s: s["x"][0] ** 2,
            "u^2": lambda t, s: s["x"][1] ** 2,
        },
        truths=tuple(Moment(observable=o, value=moment(row), source="linear") for o, row in observed.items()),
        source="Kirchhoff's and Ohm's laws",
    )


paths = sample("stochastic-theta", rlc_circuit, steps=256, paths=20)
figure, axes = plt.subplots(1, 2, figsize=(8, 3), layout="constrained")
for index, name in enumerate(("i", "u")):
    paths.plot("x", index, ax=axes[index]).set(title="", ylabel=name)
    axes[index].plot(paths.times, [rlc_circuit().truths[index].value(t) for t in paths.times], "k", lw=2)

# %%
# Here the stochastic theta method has weak order 2 for theta = 1/2 and weak order 1 for theta = 1. The same claim is
# tested for both.


class Trapezoidal(StochasticTheta):
    """The theta method with theta = 1/2, which claims weak order 2."""

    name: ClassVar[str] = "trapezoidal"
    claims: ClassVar[tuple[Claim, ...]] = (Claim(measure="weak", value=2.0, source="additive noise"),)
    promises = claims


@dataclass(frozen=True)
class Implicit(Trapezoidal):
    """The theta method with theta = 1, which claims weak order 2, too."""

    theta: float = 1.0

    name: ClassVar[str] = "implicit"


result = verify([Trapezoidal(), Implicit()], rlc_circuit, "weak", paths=2048)
result

# %%

verdicts = result.verdicts.groupby("scheme").verdict.agg(set)
print(verdicts.to_string())
assert "verified" in verdicts["trapezoidal"]
assert "refuted" not in verdicts["trapezoidal"]
wrong = result.verdicts.query("scheme == 'implicit' and verdict == 'refuted'")
assert set(wrong.decided_by) == {"T1"}
assert wrong.reason.str.startswith("Weak order 1.00 from one step").all()
