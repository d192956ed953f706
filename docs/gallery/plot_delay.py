r"""
Delayed feedback
================

An oscillator is controlled by a force that is late: with v(t) = x(t - tau),

.. math::

    \,dx_{1} = x_{2} \,dt, \qquad \,dx_{2} = (-x_{1} - d x_{2} - k v_{1}) \,dt + \sigma \,dW

The means satisfy the same equation without noise. Here a Runge-Kutta method of order 4 solves it, independently of
the schemes, with steps that hit every multiple of the delay.
"""

from typing import ClassVar

import numpy as np
from matplotlib import pyplot as plt

from sdaeverify import Claim, DelaySDAE, Moment, sample, verify
from sdaeverify_schemes.delays.stochastic_theta import StochasticTheta

TAU, DAMPING, GAIN, SIGMA = 0.5, 0.2, 0.8, 0.5
START = np.array([1.0, 0.0])


def feedback(x, v):
    """Return the drift."""
    return np.stack([x[1], -x[0] - DAMPING * x[1] - GAIN * v[0]])


def means(horizon, fine=512):
    """Return E x at the times n tau / fine: the values at the middle of a step of twice the size are known, too."""
    h, x = 2.0 * TAU / fine, [START]
    late = np.repeat(START[:, None], fine + 1, axis=1).T.tolist()
    for n in range(round(horizon / h)):
        v = [np.array(late[2 * n + j]) for j in range(3)]
        a = feedback(x[-1], v[0])
        b = feedback(x[-1] + 0.5 * h * a, v[1])
        c = feedback(x[-1] + 0.5 * h * b, v[1])
        new = x[-1] + h * (a + 2 * b + 2 * c + feedback(x[-1] + h * c, v[2])) / 6
        # The middle by Hermite's interpolation, of order 4.
        late += [0.5 * (x[-1] + new) + 0.125 * h * (a - feedback(new, v[2])), new]
        x.append(new)
    return h * np.arange(len(x)), np.array(x)


def delayed_oscillator(horizon: float = 2.0) -> DelaySDAE:
    """dx_1 = x_2 dt, dx_2 = (-x_1 - d x_2 - k x_1(t - tau)) dt + sigma dW, x = (1, 0) up to 0."""
    t, x = means(horizon)

    def moment(component):
        return lambda at: float(np.interp(at, t, x[:, component]))

    return DelaySDAE(
        drift=lambda t, x, v, y: feedback(x, v),
        diffusion=lambda t, x, v, y: np.array([[[0.0]], [[SIGMA]]]),
        delay=TAU,
        history=lambda t: START,
        noise_dim=1,
        horizon=horizon,
        traits=frozenset({"additive-noise"}),
        observables={"x_1": lambda t, s: s["x"][0], "x_2": lambda t, s: s["x"][1]},
        truths=tuple(
            Moment(observable=f"x_{n + 1}", value=moment(n), source="the means' equation") for n in range(2)
        ),
        source="linear feedback with a delay",
    )


paths = sample("stochastic-theta", delayed_oscillator, steps=256, paths=12)
figure, ax = plt.subplots(figsize=(7, 3), layout="constrained")
axes = paths.plot("x", 0, ax=ax).set_title("")
t, x = means(2.0)
line = ax.plot(t, x[:, 0], "k", lw=2)

# %%
# The theta method, for which weak order 1 is claimed here, and a wrong variant that uses the present state instead of
# the past one. The variant is refuted before any path is drawn, on a trivial equation that it should solve exactly.


class Delayed(StochasticTheta):
    """The theta method with a claim about means."""

    name: ClassVar[str] = "delayed"
    claims: ClassVar[tuple[Claim, ...]] = (Claim(measure="weak", value=1.0, source="Buckwar & Shardlow 2005"),)
    promises = claims


class Undelayed(Delayed):
    """The same that forgets the past."""

    name: ClassVar[str] = "undelayed"

    def step(self, problem, state, t, h, noise):
        """Make one step."""
        if isinstance(problem, DelaySDAE):
            noise = noise._replace(lagged=state.x, ahead=state.x)
        return super().step(problem, state, t, h, noise)


result = verify([Delayed(), Undelayed()], delayed_oscillator, "weak", paths=4096)
result

# %%

verdicts = result.verdicts.groupby("scheme").verdict.agg(set)
print(verdicts.to_string())
assert "verified" in verdicts["delayed"]
assert "refuted" not in verdicts["delayed"]
wrong = result.verdicts.query("scheme == 'undelayed' and verdict == 'refuted'")
assert set(wrong.decided_by) == {"T0"}
assert wrong.reason.str.startswith("Not exact on dx = c dt, y = x(t - tau)").all()
