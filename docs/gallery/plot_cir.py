r"""
Cox, Ingersoll and Ross
=======================

The diffusion of the interest rate of Cox, Ingersoll and Ross is a square root, Lipschitz only away from 0:

.. math::

    \,dx = k (a - x) \,dt + s \sqrt{x} \,dW

Mean and second moment solve linear equations. A scheme has to treat negative states; the first scheme
takes the root of the positive part. The second scheme takes the root at a predicted state. This looks like an
improvement, but it solves another equation: the integrand of Ito's integral must not anticipate the noise.
"""

from typing import ClassVar

import numpy as np
from matplotlib import pyplot as plt

from sdaeverify import SDE, Claim, Moment, Scheme, Step, sample, verify

k, a, s, START = 1.0, 1.0, 0.5, 1.5


def interest_rate(horizon: float = 1.0) -> SDE:
    """dx = k (a - x) dt + s sqrt(x) dW, x(0) = 1.5."""

    def mean(t):
        return a + (START - a) * np.exp(-k * t)

    def square(t):
        e = np.exp(-k * t)
        variance = START * s**2 / k * (e - e**2) + a * s**2 / (2.0 * k) * (1.0 - e) ** 2
        return mean(t) ** 2 + variance

    return SDE(
        drift=lambda t, x: k * (a - x),
        diffusion=lambda t, x: s * np.sqrt(x)[:, None],
        start=[START],
        noise_dim=1,
        horizon=horizon,
        observables={"x": lambda t, p: p["x"][0], "x^2": lambda t, p: p["x"][0] ** 2},
        truths=(
            Moment(observable="x", value=mean, source="Cox, Ingersoll & Ross 1985"),
            Moment(observable="x^2", value=square, source="Cox, Ingersoll & Ross 1985"),
        ),
        source="Cox, Ingersoll & Ross 1985, (17)",
    )


class FullTruncation(Scheme):
    """x+ = x + f(x') h + b(x') dW with the positive part x' of x."""

    name: ClassVar[str] = "full-truncation"
    form: ClassVar[type] = SDE
    claims: ClassVar[tuple[Claim, ...]] = (Claim(measure="weak", value=1.0, source="Lord, Koekkoek & van Dijk 2010"),)

    def step(self, problem, state, t, h, noise):
        """Make one step."""
        x = np.maximum(state, 0.0)
        return Step(state + h * problem.drift(t, x) + problem.diffused(t, x, noise.dW))


class Anticipating(FullTruncation):
    """The same with the noise at the predicted state."""

    name: ClassVar[str] = "anticipating"

    def step(self, problem, state, t, h, noise):
        """Make one step."""
        x = np.maximum(state, 0.0)
        y = np.maximum(super().step(problem, state, t, h, noise).state, 0.0)
        return Step(state + h * problem.drift(t, x) + problem.diffused(t, 0.5 * (x + y), noise.dW))


figure, ax = plt.subplots(figsize=(7, 3), layout="constrained")
axes = sample(FullTruncation(), interest_rate, steps=256, paths=20).plot(ax=ax)
t = np.linspace(0.0, 1.0, 50)
line = ax.plot(t, interest_rate().truths[0].value(t), "k", lw=2)

# %%

result = verify([FullTruncation(), Anticipating()], interest_rate, "weak", paths=4096)
result

# %%

verdicts = result.verdicts.groupby("scheme").verdict.agg(set)
print(verdicts.to_string())
assert "verified" in verdicts["full-truncation"]
assert "refuted" not in verdicts["full-truncation"]
wrong = result.verdicts.query("scheme == 'anticipating' and verdict == 'refuted'")
assert set(wrong.decided_by) == {"T0"}
assert wrong.reason.str.startswith("The mean of one step").all()
