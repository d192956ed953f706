"""
A foreign solver on a cluster
=============================

The solver of this example is independent of this package: a function that integrates an equation over a grid and
draws its own noise unless it gets increments. A scheme calls it for one step at a time, with the increments that all
schemes get. It is tested on a Dask cluster, here with workers on one machine; the address of another cluster works in
the same way.

Heun's method solves equations in the sense of Stratonovich. The first bridge converts the drift accordingly. The
second one passes the Ito coefficients unchanged, which is the most frequent mistake.
"""

import os
import tempfile
from pathlib import Path

from distributed import Client
from distributed.deploy import SubprocessCluster

from sdaeverify import verify

PLUGIN = '''
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from sdaeverify import SDE, Claim, Pathwise, Scheme, Step, hookimpl


def heun_solver(drift, diffusion, x0, times, increments=None, rng=None):
    """The foreign library: one equation with one noise, Stratonovich, over a grid."""
    x = np.array(x0, dtype=float)
    for n, h in enumerate(np.diff(times)):
        dW = increments[n] if increments is not None else np.sqrt(h) * rng.standard_normal(x.shape)
        y = x + h * drift(x) + diffusion(x) * dW
        x = x + 0.5 * h * (drift(x) + drift(y)) + 0.5 * (diffusion(x) + diffusion(y)) * dW
    return x


def logistic_growth(sigma: float = 0.5, horizon: float = 1.0) -> SDE:
    """dx = x (1 - x) dt + sigma x dW, x(0) = 1/2, whose paths are quotients of exponentials and their integrals."""
    rate = 1.0 - 0.5 * sigma**2

    def advance(z, t, h, noise):
        # log E, E = exp(rate t + sigma W), and int E: by the trapezoidal rule, with the area of the path.
        grown = z[0] + rate * h + sigma * noise.dW[0]
        area = 0.5 * h * (np.exp(z[0]) + np.exp(grown)) + sigma * h * noise.H[0] * np.exp(0.5 * (z[0] + grown))
        return np.stack([grown, z[1] + area])

    truth = Pathwise(
        start=lambda paths: np.zeros((2, paths)),
        advance=advance,
        parts=lambda t, z: {"x": (0.5 * np.exp(z[0]) / (1.0 + 0.5 * z[1]))[None]},
        order=1.0,
        source="Kloeden & Platen 1992, (4.4.38)",
    )
    return SDE(
        drift=lambda t, x: x * (1.0 - x),
        diffusion=lambda t, x: sigma * x[:, None],
        start=[0.5],
        noise_dim=1,
        horizon=horizon,
        truths=(truth,),
        source="Kloeden & Platen 1992, (4.4.38)",
    )


@dataclass(frozen=True)
class BridgedHeun(Scheme):
    """The foreign solver over a grid of one step, with Stratonovich's drift."""

    name: ClassVar[str] = "bridged-heun"
    form: ClassVar[type] = SDE
    claims: ClassVar = (Claim(measure="strong", value=1.0, when=frozenset({"scalar-noise"}), source="its manual"),)
    corrected: ClassVar[bool] = True

    def refuses(self, problem):
        return "" if problem.noise_dim == 1 else "the solver knows one noise, and the problem has more"

    def step(self, problem, state, t, h, noise):
        def diffusion(x):
            return problem.diffusion(t, x)[:, 0]

        def drift(x):
            b = diffusion(x)
            return problem.drift(t, x) - self.corrected * 0.5 * problem.derivative_of_diffusion(t, x, b)[:, 0]

        return Step(heun_solver(drift, diffusion, state, [t, t + h], increments=[noise.dW[0]]))


@dataclass(frozen=True)
class MistakenHeun(BridgedHeun):
    """The foreign solver with Ito's drift."""

    name: ClassVar[str] = "mistaken-heun"
    corrected: ClassVar[bool] = False


@hookimpl
def sdaeverify_schemes():
    return [BridgedHeun(), MistakenHeun()]


@hookimpl
def sdaeverify_problems():
    return [logistic_growth]
'''

file = Path(tempfile.mkdtemp()) / "foreign_heun.py"
written = file.write_text(PLUGIN)

# %%
# A Dask client has the interface of an executor. This client starts a scheduler and two worker processes, which get
# the plugin file with each call; ``Client("tcp://host:8786")`` connects to a running scheduler.


def judged(executor=None):
    """Return the result of a run there."""
    return verify("*-heun", "logistic-growth", "strong", plugins=[file], paths=2048, executor=executor, jobs=2)


worker = {"nthreads": 1, "dashboard": False}
with SubprocessCluster(n_workers=2, worker_kwargs=worker) as cluster, Client(cluster) as client:
    client.wait_for_workers(2)
    print(len({*client.run(os.getpid).values()} - {os.getpid()}), "processes beside this one")
    result = judged(client.get_executor())
result

# %%
# The tables do not depend on the executor, bit for bit.

assert result.levels.equals(judged("serial").levels)

# %%

axes = result.plot.convergence("bridged-heun", "logistic-growth", quantity="x")
print(result.cell("mistaken-heun", "logistic-growth"))
verdicts = result.verdicts.groupby("scheme").verdict.agg(set)
print(verdicts.to_string())
assert "verified" in verdicts["bridged-heun"]
assert "refuted" not in verdicts["bridged-heun"]
wrong = result.verdicts.query("scheme == 'mistaken-heun' and verdict == 'refuted'")
assert set(wrong.decided_by) == {"T0"}
assert wrong.reason.str.startswith("The mean of one step").all()
