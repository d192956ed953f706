"""Euler's method reflected at 0, and the same without: of both it is claimed that no path in 100 is negative."""

from typing import ClassVar

import numpy as np

from sdaeverify import SDE, Claim, Scheme, Step, hookimpl
from sdaeverify.numerics import apply


class ReflectedEuler(Scheme):
    """x+ = |y| where x > 0, else y, with y = x + f(t, x) h + B(t, x) dW."""

    name: ClassVar[str] = "reflected-euler"
    form: ClassVar = SDE
    claims: ClassVar = (
        Claim(measure="negative-share", value="share of negative paths", bound=0.01, source="|y| >= 0"),
    )

    def step(self, problem, state, t, h, noise):
        """Make one step; the state x has shape (d, P)."""
        y = state + h * problem.drift(t, state) + apply(problem.diffusion(t, state), noise.dW)
        return Step(np.where(state > 0.0, np.abs(y), y))


class UnreflectedEuler(ReflectedEuler):
    """The same without the modulus: its claim is wrong wherever the noise is strong."""

    name: ClassVar[str] = "unreflected-euler"

    def step(self, problem, state, t, h, noise):
        """Make one step of Euler's method."""
        return Step(state + h * problem.drift(t, state) + apply(problem.diffusion(t, state), noise.dW))


@hookimpl
def sdaeverify_schemes():
    """Register the schemes."""
    return [ReflectedEuler(), UnreflectedEuler()]
