"""Known mistakes by name, those of any equation and those that a form knows of its members."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..contracts.scheme import Scheme
from ..errors import FAULTS
from ..forms import Problem
from .local.solved_instead import measured_at, solved_instead
from .local.step_law import short_steps
from .mistakes.given_rates import Given, Rates, squares
from .step.states import states_near_start
from .step.times import first_time

# Theorem: exponent s of the noise of a step, of size h^s, that a consistent step has.
WHITE = 0.5


def named_mistake(scheme: Scheme, view: Problem, mistakes: Sequence[Any] = (), *, paths: bool = False) -> str:
    """Return in a sentence the mistake that explains the rates of short steps, or an empty text.

    Nothing is said where steps have the rates of the equation, where no mistake explains them to the resolution, and
    where several do.

    Parameters
    ----------
    scheme : Scheme
    view : Problem
        Problem in the scheme's form.
    mistakes : sequence, optional
        Mistakes that a form knows of its members, as of a `GenericClass`: the rates of mean and square at states near
        the start are compared with those that each makes of the problem. If omitted, the mistakes known for every
        equation.
    paths : bool
        Whether the refuted claim is about paths, so that noise that is not dW but has its law is a mistake.
    """
    if not mistakes:
        return solved_instead(scheme, view, paths=paths)
    try:
        with np.errstate(all="ignore"):
            step = short_steps(scheme, view)
            if step is None:
                return ""
            t, x = first_time(view.horizon), states_near_start(step.view, step.equation)
            measured = measured_at(step, [Given(step.equation, t, x)])
            if measured is None or not measured.differs or measured.power != WHITE:
                return ""
            made = {each.sentence: each.coefficients(view, t, x) for each in mistakes}
    except FAULTS:
        return ""
    found = [sentence for sentence, (f, B) in made.items() if measured.explained_by([Rates(f, squares(B))])]
    return found[0] if len(found) == 1 else ""
