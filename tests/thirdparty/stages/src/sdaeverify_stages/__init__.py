"""An examination whose objects are step sizes, and no problems: how often a step calls the drift."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from sdaeverify import SDE, Claim, Scheme, Step, UsageError, hookimpl, sample
from sdaeverify.measuring import Finding, Measure, Method, Reason, Verdict
from sdaeverify.studying import Advanced, Cell, CellResult, Examination, ProblemSpec, select_schemes


@dataclass(frozen=True)
class StagedEuler(Scheme):
    """Euler's scheme, whose drift is called in each stage."""

    stages: int = 1
    name: ClassVar[str] = "staged-euler"
    form: ClassVar[type] = SDE
    claims: ClassVar[tuple[Claim, ...]] = (Claim(measure="calls", value="one call", source="its formula"),)

    def step(self, problem, state, t, h, noise):
        """Make one step."""
        drifts = [problem.drift(t, state) for _ in range(self.stages)]
        return Step(state + h * drifts[-1] + problem.diffused(t, state, noise.dW))


class Calls(Measure):
    """The number of calls of the drift in a step, which no problem is asked for."""

    name: ClassVar[str] = "calls"
    value_of: ClassVar[str] = "calls of the drift in a step"

    def refuses(self, scheme, problem):
        """Return why no problem is asked."""
        return "an examination counts calls"


def calls_in(scheme, steps):
    """Return how often a path of some steps calls the drift."""
    times = []

    def counted() -> SDE:
        """Return an equation whose drift is counted."""
        numbers = {"start": np.ones(1), "horizon": 1.0, "noise_dim": 1, "source": "a counter"}
        return SDE(drift=lambda t, x: times.append(t) or -x, diffusion=lambda t, x: np.ones((1, *x.shape)), **numbers)

    sample(scheme, counted, steps=steps, paths=1)
    return len(times)


class Work:
    """The schemes of a policy, at two step sizes each."""

    notes, command = (), ("info", "{scheme}")

    def __init__(self, schemes):
        self.schemes, self.total, self.results = schemes, len(schemes), []

    def run(self, executor=None, window=1):
        """Count the calls of each scheme."""
        for done, scheme in enumerate(self.schemes, 1):
            self.results += [judged(scheme, steps) for steps in (8, 16)]
            yield Advanced(done, self.total, scheme.label)


def judged(scheme, steps):
    """Return what is found at a step size: the calls in so many steps more, by step."""
    calls = (calls_in(scheme, 2 * steps) - calls_in(scheme, steps)) / steps
    verdict, why = Verdict.REFUTED if calls > 1 else Verdict.VERIFIED, Reason(f"{calls:g} calls in a step")
    told = {"claim": scheme.promises[0], "method": Method("calls", 0), "tier": 0, "estimate": calls}
    cell = Cell(scheme, ProblemSpec(f"steps.{steps}", calls_in), Calls())
    return CellResult(cell, (Finding(quantity="drift", verdict=verdict, reason=why, **told),))


class CountCalls(Examination):
    """Calls of the drift."""

    name: ClassVar[str] = "calls"

    def begin(self, registry, asked, settings):
        """Return the work on the schemes that a table names."""
        if set(asked) != {"schemes"}:
            raise UsageError(f"table calls expects schemes, got {', '.join(asked)}")
        return Work(select_schemes(registry, asked["schemes"]))


@hookimpl
def sdaeverify_schemes():
    """Register the scheme, and one that calls twice."""
    return [StagedEuler(), StagedEuler(stages=2)]


@hookimpl
def sdaeverify_measures():
    """Register the measure that claims name."""
    return [Calls()]


@hookimpl
def sdaeverify_examinations():
    """Register the examination."""
    return [CountCalls()]
