"""dx = J x dW with a rotation J: x(1) = sqrt(e) exp(J W) x(0). Needs QuTiP alone."""

import numpy as np
import qutip
from qutip.core.data import Dense
from qutip.solver.sode.ssystem import SimpleStochasticSystem
from qutip.solver.stochastic import SMESolver

J = qutip.Qobj([[0.0, -1.0], [1.0, 0.0]])
system = SimpleStochasticSystem(qutip.QobjEvo(0.0 * J), [qutip.QobjEvo(J)])
dW = np.random.default_rng(1).normal(0.0, 128**-0.5, (200, 128))
W = dW.sum(axis=1)
exact = np.exp(0.5) * np.array([np.cos(W), np.sin(W)])


def end(method, increments, steps):
    run = SMESolver.avail_integrators()[method].stepper(system).run
    noise = increments.reshape(steps, -1).sum(axis=1)[:, None, None].copy()
    return run(0.0, Dense(np.array([[1.0 + 0j], [0.0]])), 1.0 / steps, noise, steps).to_array()[:, 0].real


print("rms error at time 1 with 16, 32, 64, 128 steps, QuTiP", qutip.__version__)
for method in ("euler", "pred_corr", "milstein"):
    found = [np.array([end(method, each, n) for each in dW]).T for n in (16, 32, 64, 128)]
    rms = [np.sqrt(np.mean(np.sum((y - exact) ** 2, axis=0))) for y in found]
    print(f"{method:10} {' '.join(f'{e:.4f}' for e in rms)}  order {np.log2(rms[-2] / rms[-1]):.2f}")
