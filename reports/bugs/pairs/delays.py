"""Reports on delay equations: where the past is read."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from _report import Report, pair_of

from sdaeverify import Claim, DelaySDAE, DelayState, Increment, Scheme, Step, hookimpl


@dataclass(frozen=True)
class DelayEuler(Scheme):
    """x+ = x + h f(t, x, v, y) + g(t, x, v, y) dW with v = x(t - tau), and y+ on the constraint.

    Faulty with the history's last value for v wherever the solution itself is meant.
    """

    mended: bool = True

    name: ClassVar[str] = "ordinarydiffeq-3254"
    form: ClassVar[type] = DelaySDAE
    claims: ClassVar[tuple[Claim, ...]] = (
        Claim(measure="strong", value=0.5, source="Buckwar 2000"),
        Claim(measure="weak", value=1.0, source="Buckwar & Shardlow 2005"),
    )

    def step(self, problem: DelaySDAE, state: DelayState, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        (x, y), lag = state, problem.lag(state.x, h, noise)
        now = lag.now if self.mended or t < problem.delay else np.broadcast_to(problem.past(0.0), x.shape)
        new = x + h * problem.drift(t, x, now, y) + problem.diffused(t, x, now, y, noise.dW)
        y_new = problem.eliminated(t + h, new, lag.ahead(new)) if problem.constraint is not None else y
        return Step(DelayState(new, y_new))


REPORTS = (
    Report(
        DelayEuler,
        "https://github.com/SciML/OrdinaryDiffEq.jl/issues/3254",
        "The history is read in place of the solution once a delay is over.",
        "delay-ou,delay-linear",
        ("only with a delay",),
    ),
)


@hookimpl
def sdaeverify_schemes() -> list[Scheme]:
    """Register the pairs."""
    return [scheme for report in REPORTS for scheme in pair_of(report)]
