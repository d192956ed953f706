"""Whether a scheme's state is all its memory: a run that is taken up from a copy of it goes on as before."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ..contracts.scheme import State, Stepper
from ..noise.brownian import Increment
from .batches import each, equal, frozen
from .own_run import brownian
from .trial import Trial

# A run of so many steps is taken up after none and after some of them.
STEPS, TAKEN_UP = 8, (0, 3)


class Stop(NamedTuple):
    """A state of a run, with the noise of the step that follows it."""

    state: State
    noise: Increment


def carries_its_memory(trial: Trial) -> str:
    """Go on from copies of the state, field by field, with a copy of the scheme that has never made a step."""
    stops, end = _run(trial)
    for begin in TAKEN_UP:
        fresh = replace(trial.scheme)
        state, stepper = each(np.array, stops[begin].state), fresh.prepare(trial.view, trial.h)
        if not equal(_last(stepper, state, trial.h, begin, [stop.noise for stop in stops[begin:]]), end):
            when = f"after {begin} steps" if begin else "at its start"
            text = f"a run taken up {when} from a copy of its state ends elsewhere"
            return f"{text}: the scheme remembers more than its state"
    return ""


def _run(trial: Trial) -> tuple[list[Stop], State]:
    state, stops = trial.scheme.start(trial.view, trial.paths, trial.h), list[Stop]()
    recall = trial.view.recall(trial.h, trial.paths)
    for n, drawn in enumerate(_noises(trial)):
        noise = frozen(drawn if recall is None else recall.driven(drawn))
        stops.append(Stop(frozen(state), noise))
        state = trial.stepper(stops[n].state, n * trial.h, noise).state
        if recall is not None:
            recall.push(trial.scheme.parts(trial.view, state)["x"])
    return stops, state


def _noises(trial: Trial) -> Iterator[Increment]:
    for n in range(STEPS):
        drawn = brownian(trial.view.noise_dim, trial.paths, trial.h, n)
        yield trial.lawful(drawn if "H" in trial.view.noise else drawn._replace(H=None))


def _last(stepper: Stepper, state: State, h: float, begin: int, noises: Sequence[Increment]) -> State:
    for n, noise in enumerate(noises, begin):
        state = stepper(frozen(state), n * h, noise).state
    return state
