"""An executable that makes one step a call, as a scheme."""

import subprocess
from pathlib import Path
from typing import ClassVar

import numpy as np

from sdaeverify import SDE, Claim, Scheme, Step, hookimpl

PROGRAM = Path(__file__).with_name("one_call")


class OneCall(Scheme):
    """Milstein's scheme for scalar equations, made by a program that is started for each step."""

    name: ClassVar[str] = "one-call"
    form: ClassVar[type] = SDE
    claims: ClassVar[tuple] = (Claim(measure="strong", value=1.0, source="Kloeden & Platen 1992, Theorem 10.3.5"),)

    def refuses(self, problem):
        """Refuse equations of more than one component or motion."""
        return "" if problem.dimension == problem.noise_dim == 1 else "it is for scalar equations"

    def step(self, problem, state, t, h, noise):
        """Make one step; the state x has shape (1, P)."""
        f, B = problem.drift(t, state), np.broadcast_to(problem.diffusion(t, state)[:, 0], state.shape)
        sent = np.concatenate([state, f, B, problem.derivative_of_diffusion(t, state, B)[:, 0], noise.dW])
        command = [PROGRAM, repr(float(h)), str(state.shape[-1])]
        done = subprocess.run(command, input=sent.tobytes(), stdout=subprocess.PIPE, check=True)
        return Step(np.frombuffer(done.stdout).reshape(state.shape))


@hookimpl
def sdaeverify_schemes():
    """Register the scheme."""
    return [OneCall()]
