"""Benchmarks: the time of a scheme's step relative to an Euler step on the same arrays, for pytest-benchmark.

Times depend on the machine. The ratio of two tasks timed alternately depends on it far less, and can be compared
between runs. pytest-benchmark saves it as ``extra_info.ratio``.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from statistics import median
from time import perf_counter
from typing import TYPE_CHECKING, Any, ClassVar

from ..contracts.scheme import Scheme, Step
from ..contracts.settings import whole
from ..errors import UsageError
from ..forms import as_sde
from ..registry.selection import select_schemes
from ..report.plain import visible
from .subjects import CellSubject, Problems, cells_of, load_plugins

if TYPE_CHECKING:
    import pytest

# With few paths the overhead of a call dominates, with many paths the cost of a path.
PATHS = (256, 4096)
# Number of pairs of alternately timed steps, and of steps over the horizon.
PAIRS, STEPS = 31, 64


@dataclass(frozen=True)
class StepTiming:
    """Timing of a step, as a parameter of a test.

    Attributes
    ----------
    cell : CellSubject
        Scheme and problem.
    paths : int
    """

    sdaeverify_part: ClassVar[str] = "timings"

    cell: CellSubject
    paths: int

    def __call__(self, benchmark: Any) -> float:
        """Time the step with pytest-benchmark, and return its time in Euler steps.

        The ratio is the median over 31 pairs of alternately timed steps, so that a slow phase of the machine affects
        both.

        Parameters
        ----------
        benchmark : BenchmarkFixture
        """
        step, euler = self._step, self._euler
        # The first call of each may compile or allocate.
        step()
        euler()
        ratio = median(_seconds(step) / _seconds(euler) for _ in range(PAIRS))
        benchmark.group = f"{self.cell.label}, {self.paths} paths"
        benchmark.extra_info.update(scheme=self.cell.scheme.label, problem=self.cell.label, ratio=ratio)
        benchmark(step)
        return ratio

    @property
    def name(self) -> str:
        """Identifier of the test: scheme, problem and number of paths."""
        return f"{self.cell.scheme.label}-{self.cell.label}-{self.paths}"

    def __repr__(self) -> str:
        return self.name

    @cached_property
    def _trial(self) -> Any:
        return self.cell.of_paths(self.paths, STEPS)

    @property
    def _step(self) -> Callable[[], Step]:
        state, noise, step = self._trial.state, self._trial.noise, self._trial.step
        return lambda: step(state, noise)

    @property
    def _euler(self) -> Callable[[], Any]:
        """Euler step of the equation as an SDE, at its start on all paths."""
        sde = as_sde(self.cell.problem)
        if sde is None:
            raise UsageError(f"{self.cell.label} has no view as an SDE, so that Euler's step is not defined on it")
        x, h, dW = sde.initial(self.paths), self._trial.h, self._trial.noise.dW
        return lambda: x + h * sde.drift(0.0, x) + sde.diffused(0.0, x, dW)


def _seconds(task: Callable[[], object]) -> float:
    begun = perf_counter()
    task()
    # The resolution of the clock may exceed the time of a short task.
    return max(perf_counter() - begun, 1e-9)


def parametrize_with_benchmarks(
    schemes: Sequence[str | Scheme], problems: Problems | None = None, *, paths: Sequence[int] = PATHS
) -> "pytest.MarkDecorator":
    """Return a decorator for a test function of ``timing`` that times a step of each scheme against Euler's.

    ::

        @parametrize_with_benchmarks([MyScheme()])
        def test_speed(benchmark, timing):
            timing(benchmark)

    The tests have the marker ``benchmark``; ``pytest -m benchmark --benchmark-json FILE`` writes the ratios.
    ``timing(benchmark)`` returns the ratio as well, so that a test can bound it.

    Parameters
    ----------
    schemes : sequence of Scheme or str
        Schemes, and patterns of registered schemes.
    problems : str or sequence of str, ProblemSpec or callable, optional
        Problems that each scheme solves; by default the smallest registered problem of the scheme's form.
    paths : sequence of int, optional
        Numbers of paths of a step.

    Returns
    -------
    pytest.MarkDecorator

    Raises
    ------
    UsageError
        If no scheme is named, a name is unknown, or a number of paths is invalid.
    """
    import pytest  # noqa: PLC0415 - the kit itself needs no pytest

    if not schemes:
        raise UsageError("schemes is empty; name the schemes whose steps are timed")
    if small := [count for count in paths if whole("paths", count) < 1]:
        raise UsageError(f"paths expects positive numbers, got {small[0]}")
    registry, cases = load_plugins(), []
    for scheme in select_schemes(registry, schemes):
        cells = cells_of(scheme, problems, registry)
        cases += [StepTiming(cell, count) for cell in (cells if problems else cells[:1]) for count in paths]
    named = [pytest.param(case, id=visible(case.name), marks=pytest.mark.benchmark) for case in cases]
    return pytest.mark.parametrize("timing", named)
