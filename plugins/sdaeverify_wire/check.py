"""Checks of ``wire --check`` on a program, with one line for each result."""

import time
from collections.abc import Iterator
from typing import Any

import numpy as np

from sdaeverify import Increment, Problem, SchemeError

from .calling import Calling
from .hello import greet
from .scheme import Wired, fields_of, restored, session_of
from .transcript import GOLDEN, read, replay

# Numbers of paths of the steps, not multiples of each other; the last one exceeds the capacity of a pipe.
PATHS = (1, 3, 5000)
H = 2.0**-6
PAUSE = 0.1


def checked(calling: Calling, *, golden: bool) -> Iterator[str]:
    """Yield a line for each verified property of a program.

    Parameters
    ----------
    calling : Calling
    golden : bool
        Whether the program must reproduce the golden transcript.

    Raises
    ------
    SchemeError
        At the first property that the program lacks.
    """
    if golden:
        yield _golden(calling)
    program = calling.connect()
    hello = greet(program)
    claims = [f"{claim.measure} {claim}" for claim in hello.claims]
    yield f"hello: {hello.name} for {' or '.join(hello.form)}, given {', '.join(sorted(hello.noise))}"
    yield f"claims: {', '.join(claims) or 'none'}"
    code = program.finish()
    if code != 0:
        how = "does not end" if code is None else f"ends with exit code {code}"
        raise program.failure(f"{how} when its input is closed, expected exit code 0 or a closed connection")
    program.close()
    yield "end: it ends when its input is closed"
    yield from _steps(restored(calling, hello))


def _golden(calling: Calling) -> str:
    program = calling.connect()
    try:
        return f"transcript: {replay(program, read(GOLDEN.read_bytes()))} answers are those of the golden transcript"
    finally:
        program.close()


def _steps(scheme: Wired) -> Iterator[str]:
    problem = _problem(scheme)
    if problem is None:
        yield "steps: none was made, since it refuses every trivial problem of its form"
        return
    try:
        whole = problem.drawn(np.random.default_rng(1), H, PATHS[-1])
        made = {paths: _step(scheme, problem, whole, paths) for paths in PATHS}
    finally:
        session_of(scheme.calling).drop()
    last = made[PATHS[-1]]
    if not all(np.isfinite(array).all() for array in last.values()):
        raise SchemeError(f"{scheme.name}: a step of a trivial problem is not finite")
    for paths, found in made.items():
        if any(not np.array_equal(found[name], last[name][..., :paths]) for name in last):
            raise SchemeError(f"{scheme.name}: a path differs among {paths} paths and among {PATHS[-1]}")
    yield f"steps: equal with {', '.join(map(str, PATHS))} paths"


def _problem(scheme: Wired) -> Any:
    """Return the first trivial problem with noise that the scheme does not refuse, or None."""
    groups: list[Any] = [group for form in scheme.forms for group in form.trivial_problems()]
    problems: list[Problem] = [trivial.problem for group in reversed(groups) for trivial in group]
    return next((problem for problem in problems if not scheme.why_not(problem)), None)


def _step(scheme: Wired, problem: Any, noise: Increment, paths: int) -> dict[str, Any]:
    given: Any = {
        name: array[..., :paths] for name, array in noise._asdict().items() if isinstance(array, np.ndarray)
    }
    first = problem.add_past(H, noise._replace(**given))
    state = scheme.start(problem, paths, H)
    found = fields_of(scheme.step(problem, state, 0.0, H, first).state)
    # Extra output after an answer then arrives before the next step, which reports it.
    time.sleep(PAUSE)
    return found
