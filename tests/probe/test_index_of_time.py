"""Steps that make their index of their time are probed where runs make them: at whole numbers of steps."""

from typing import ClassVar

import numpy as np

from facade import judge_weak, local_weak, weak_order
from probe.weak_cells import SIGMA, constant, equation
from sdaeverify import SDE, Scheme, Step

FORCED = equation(lambda t, x: np.sin(3.0 * t) - x, constant([SIGMA]), [0.6])


class Indexed(Scheme):
    """Heun's scheme for additive noise at the time n h with n = int(t/h), as code with a table in time has it."""

    name: ClassVar[str] = "indexed"
    form: ClassVar[type[SDE]] = SDE
    late: ClassVar[float] = 0.0

    def step(self, problem, state, t, h, noise):
        """Make one step."""
        begin = h * (int(t / h + 1e-9) + self.late)
        kick, f = problem.diffused(t, state, noise.dW), problem.drift(begin, state)
        return Step(state + 0.5 * h * (f + problem.drift(begin + h, state + h * f + kick)) + kick)


class Late(Indexed):
    """The same, a fifth of a step too late: of order 1."""

    name: ClassVar[str] = "late"
    late: ClassVar[float] = 0.2


def test_an_index_made_of_the_time_costs_no_order():
    """The order 2 of Heun's scheme is found, and refuted for the twin that is late."""
    verdicts = [str(judge_weak(weak_order(local_weak(each, FORCED)), 2.0).verdict) for each in (Indexed(), Late())]

    assert verdicts == ["verified", "refuted"]
