"""Errors of several schemes against one reference, on common paths.

If no solution is known, a measure compares a scheme with finer steps of itself. The error is then that with respect
to the scheme's own limit, so that errors of schemes with different limits are not comparable. Here all schemes are
compared with the truth of the problem or, if there is none, with one scheme at finer steps. The time of a step is
measured on the same blocks of paths, so that all times refer to arrays of the same size.
"""

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from itertools import count
from time import perf_counter
from typing import NamedTuple

import numpy as np

from ...arrays import Array, Parts
from ...contracts.scheme import AT_T
from ...contracts.settings import Settings
from ...errors import FAULTS
from ...forms import Problem
from ...measures.path_errors.errors import STATE
from ...noise.brownian import Brownian, LevelNoise, Source
from ...simulate.reference import OWN_REFERENCE, Reference
from ...simulate.tracks import Track
from ...study.plan import Cell
from ...study.run import Compared

# Measure whose errors are those of means of observables; all others use distances between components.
OF_MEANS = "weak"


Show = Callable[[Compared], None]


class CommonErrors(NamedTuple):
    """Errors of schemes in one quantity.

    Attributes
    ----------
    reference : str
        Reference of the errors, in words; empty without a reference.
    errors : mapping of str to sequence of (int, float, float)
        Number of steps, error and standard error at each level, by label of the scheme.
    step_seconds : mapping of str to float
        Mean time of a step on a path at the finest level, by label of the scheme.
    """

    reference: str
    errors: Mapping[str, Sequence[tuple[int, float, float]]]
    step_seconds: Mapping[str, float]


def common_errors(
    cells: Sequence[Cell],
    asked: tuple[str, str],
    settings: Settings,
    best: Cell | None = None,
    show: Show = lambda _: None,
) -> CommonErrors:
    """Compute the errors of schemes in one quantity against one reference.

    Parameters
    ----------
    cells : sequence of Cell
        Runnable cells of one problem.
    asked : tuple of str
        Names of the measure and of the quantity; if the quantity is empty, only times are measured.
    settings : Settings
    best : Cell, optional
        Cell of the scheme that serves as reference if the problem has no pathwise truth.
    show : callable, Compared -> None, optional
        Called at the end of each coarsest step.
    """
    problem = cells[0].spec.build()
    compared = asked[1] != "" and (problem.pathwise is not None or best is not None)
    runners = {cell.scheme.label: _Runner(cell, settings) for cell in cells}
    for block in range(settings.blocks):
        noted = partial(_tell, show, settings, block, cells[0].spec.label)
        _run_block(block, (problem, best if compared else None), settings, [*runners.values()], asked, noted)
    found = {label: runner.estimates(asked[0]) for label, runner in runners.items() if compared}
    times = {label: runner.seconds / runner.steps for label, runner in runners.items() if runner.steps}
    return CommonErrors(_in_words(problem, best, settings) if compared else "", found, times)


def _tell(show: Show, settings: Settings, block: int, problem: str, step: int) -> None:
    """Report progress: a block has completed `step` of its coarsest steps."""
    paths, ended = settings.paths_of(block), step == settings.coarsest
    done = settings.totals[block] - paths * (1.0 - step / settings.coarsest)
    show(Compared(done, settings.paths, problem, ended))


def _in_words(problem: Problem, best: Cell | None, settings: Settings) -> str:
    if problem.pathwise is not None:
        kind = "exact solution" if problem.pathwise.exact else "fine reference of the problem"
        return f"the {kind} on each path ({problem.pathwise.source})"
    assert best is not None
    steps = settings.coarsest * 2 ** (settings.levels - 1 + OWN_REFERENCE)
    return f"{best.scheme.label} with {steps} steps on the same noise"


class _Runner:
    """A scheme at all levels, its errors on the simulated paths, and the time of its finest steps."""

    def __init__(self, cell: Cell, settings: Settings) -> None:
        self.cell, self.settings, self.broken = cell, settings, False
        self.tracks: list[Track] = []
        self.sums: list[Array] = []
        self.seconds, self.steps = 0.0, 0
        self.now = np.zeros(0)

    def begin(self, paths: int) -> None:
        """Create tracks at all levels for a block of paths."""
        view, levels = self.cell.seen, self.settings.levels
        assert view is not None
        h = view.horizon / self.settings.coarsest
        self.tracks = [Track(self.cell.scheme, view, level, h / 2**level, paths) for level in range(levels)]
        self.now = np.zeros((levels, paths))

    def advance(self, level: int, noise: LevelNoise) -> None:
        """Make the steps of a piece of noise; a scheme that raises is excluded from then on."""
        if self.broken or level >= len(self.tracks):
            return
        begun = perf_counter()
        try:
            self.tracks[level].advance(noise, ())
        except FAULTS:
            self.broken = True
        if level == len(self.tracks) - 1:
            self.seconds += perf_counter() - begun
            self.steps += len(noise.dW) * self.now.shape[-1]

    def note(self, problem: Problem, truth: Parts, asked: tuple[str, str], t: float) -> None:
        """Record the errors at time `t`.

        Errors are a running maximum of the norm, the norm at `t`, or the difference of an observable.
        """
        if self.broken or not truth:
            return
        measure, quantity = asked
        for level, track in enumerate(self.tracks):
            value = _difference(problem, (track.parts(), truth), asked, t)
            if value is None:
                self.now[level] = np.nan
            elif measure != OF_MEANS and not quantity.endswith(AT_T):
                self.now[level] = np.maximum(self.now[level], value)
            else:
                self.now[level] = value

    def end(self) -> None:
        """Append the errors of the block."""
        self.sums.append(self.now)

    def estimates(self, measure: str) -> list[tuple[int, float, float]]:
        """Return number of steps, error and standard error at each level; NaN if a path is lost."""
        values = np.concatenate(self.sums, axis=1) if not self.broken else np.full((self.settings.levels, 2), np.nan)
        means, spread = values.mean(axis=1), values.std(axis=1, ddof=1) / np.sqrt(values.shape[1])
        sizes = np.abs(means) if measure == OF_MEANS else means
        return [
            (self.settings.coarsest * 2**level, float(error), float(se))
            for level, (error, se) in enumerate(zip(sizes, spread, strict=True))
        ]


def _difference(problem: Problem, both: tuple[Parts, Parts], asked: tuple[str, str], t: float) -> Array | None:
    """Return the error on each path, or None if the quantity is not known for both."""
    (parts, truth), (measure, quantity) = both, asked
    if measure == OF_MEANS:
        values = [problem.observe(quantity, t, known) for known in both]
        return None if any(value is None for value in values) else values[0] - values[1]  # type: ignore[operator]
    name = quantity.removesuffix(AT_T)
    common = [each for each in parts if each in truth and name in {each, STATE}]
    squares = [((parts[each] - truth[each]) ** 2).sum(axis=0) for each in common]
    return np.sqrt(np.sum(squares, axis=0)) if squares else None


class _Truth:
    """The reference on a block: the truth of the problem, a scheme at finer steps, or none."""

    def __init__(self, problem: Problem, best: Cell | None, settings: Settings, block: int) -> None:
        asked_for = problem.pathwise is not None or best is not None
        self.reference = Reference(problem, settings, block, asked_for=asked_for)
        self.fine: Track | None = None
        if problem.pathwise is None and best is not None:
            level, view = self.reference.finest, best.seen
            assert view is not None
            h = problem.horizon / settings.coarsest / 2**level
            self.fine = Track(best.scheme, view, level, h, self.reference.paths)

    def advance(self, level: int, noise: LevelNoise, extra: np.random.Generator) -> None:
        """Make the steps of a piece of noise."""
        self.reference.advance(level, noise, extra)
        if self.fine is not None and level == self.fine.level:
            self.fine.advance(noise, ())

    def parts(self) -> Parts:
        """Return the known components; empty without a reference."""
        return self.fine.parts() if self.fine is not None else next(iter(self.reference.parts()), {})


def _run_block(
    block: int,
    known: tuple[Problem, Cell | None],
    settings: Settings,
    runners: Sequence[_Runner],
    asked: tuple[str, str],
    noted: Callable[[int], None],
) -> None:
    """Simulate a block of paths, and record the errors and call `noted` after each coarsest step."""
    problem, truth = known[0], _Truth(*known, settings, block)
    drawn, paths, finest = truth.reference.drawn, truth.reference.paths, truth.reference.finest
    # The stream of noise is that of the run, which does not depend on schemes.
    source = Source(settings.seed, runners[0].cell.spec.label, block, drawn, paths)
    extra, h = source.stream("truth", truth.reference.level), problem.horizon / settings.coarsest
    for runner in runners:
        runner.begin(paths)

    def advance(level: int, noise: LevelNoise) -> None:
        truth.advance(level, noise, extra)
        for runner in runners:
            runner.advance(level, noise)

    def note() -> None:
        step = next(steps)
        for runner in runners:
            runner.note(problem, truth.parts(), asked, step * h)
        noted(step)

    steps = count(1)
    brownian = Brownian(source, problem.noise_dim, h, finest, problem.noise, problem.records)
    with np.errstate(all="ignore"):
        brownian.follow(settings.coarsest, advance, note)
    for runner in runners:
        runner.end()
