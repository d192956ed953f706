"""Milstein's scheme, and the same without its correction: of both it is claimed that energy drifts with order 1.

One step keeps the energy with order 3/2.
"""

from typing import ClassVar

from sdaeverify import SDE, Claim, Scheme, Step, hookimpl

SOURCE = "a strong order 1 and H Lipschitz on bounded sets"
ONE_STEP = "one step of Milstein's scheme, by its expansion in dW and h"


class KuboMilstein(Scheme):
    """x+ = x + f h + b dW + Db b (dW^2 - h)/2."""

    name: ClassVar[str] = "kubo-milstein"
    form: ClassVar[type] = SDE
    claims: ClassVar = (
        Claim(measure="energy-drift", value=1.0, source=SOURCE),
        Claim(measure="energy-defect", value=1.5, source=ONE_STEP),
    )
    correction: ClassVar[float] = 0.5

    def refuses(self, problem):
        """Refuse noise in more than one dimension."""
        return "" if problem.noise_dim == 1 else "its noise has more than one dimension"

    def step(self, problem, state, t, h, noise):
        """Make one step; the state x has shape (d, P)."""
        b = problem.diffusion(t, state)
        further = problem.derivative_of_diffusion(t, state, b[:, 0])[:, 0] * (noise.dW**2 - h)
        return Step(state + h * problem.drift(t, state) + b[:, 0] * noise.dW + self.correction * further)


class KuboForgetful(KuboMilstein):
    """The same without the correction, which leaves order 1/2, and 1 in one step: its claims are wrong."""

    name: ClassVar[str] = "kubo-forgetful"
    correction: ClassVar[float] = 0.0


@hookimpl
def sdaeverify_schemes():
    """Register the schemes."""
    return [KuboMilstein(), KuboForgetful()]
