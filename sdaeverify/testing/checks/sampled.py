"""Checks of truths against each other and against simulations of the equation, on a fixed sample of paths.

Intervals of means have a level of 1e-6 for the whole check, divided by the number of compared means (Bonferroni). The
noise depends on the problem's label, so that a problem always gives the same result.
"""

from collections import defaultdict
from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np
import scipy

from ...arrays import Array, Parts, each
from ...forms import IndexOne
from ...forms.names import article
from ...forms.truths import Moment, Pathwise
from ...noise.brownian import BROWNIAN, USUAL, Brownian, Increment, LevelNoise, Source
from ...numerics.statistics import EPS, Tail
from ..check import Inapplicable
from ..subjects import ProblemSubject
from .moments import moments
from .solutions import solution

# Simulations for the comparison of truths: Euler's scheme and known solutions, on the same Brownian paths.
#
# Simulations use the noise generator of the ensemble that judges schemes, and none of its other code.


# Steps of the coarsest grid: simulations are compared at T/2 and at T.
COARSEST = 8
SEED = 1


class Walker:
    """A state that is advanced by steps of one length.

    Parameters
    ----------
    state : object
    advance : callable, (state, t, noise) -> state
    parts : callable, (t, state) -> mapping of str to ndarray
    level : int
        Level of refinement: the step size is 2^-level times the coarsest.
    """

    def __init__(
        self,
        state: Any,
        advance: Callable[[Any, float, Increment], Any],
        parts: Callable[[float, Any], Parts],
        level: int,
    ) -> None:
        self.state, self.advance, self.of, self.level, self.step = state, advance, parts, level, 0

    def walk(self, noise: LevelNoise, h: float) -> None:
        """Make the steps of size h within one coarsest step."""
        for index in range(len(noise.dW)):
            self.state = self.advance(self.state, self.step * h, noise.increment(index))
            self.step += 1

    def parts(self, t: float) -> Parts:
        """Return the named components at the present time t."""
        return self.of(t, self.state)


def euler_walker(problem: Any, level: int, paths: int) -> Walker:
    """Return Euler-Maruyama for the Ito equation of a problem, or for its delay equation.

    Parameters
    ----------
    problem : Problem
    level : int
        Level of refinement: the step size is 2^-level times the coarsest.
    paths : int

    Raises
    ------
    Inapplicable
        If the problem has no such equation.
    """
    h = problem.horizon / (COARSEST * 2**level)
    index_one = problem.capability(IndexOne)
    if index_one is not None and (index_one.delay or index_one.constraints):
        return _delay_walker(index_one, level, h, paths)
    equation = problem.equation()
    if equation is None:
        raise Inapplicable(f"{article(type(problem).__name__)} has no Ito equation to simulate")

    def advance(x: Any, t: float, noise: Increment) -> Any:
        return equation.euler(t, x, h, noise)

    return Walker(equation.initial(paths), advance, lambda _, x: equation.parts(x), level)


def _delay_walker(problem: IndexOne, level: int, h: float, paths: int) -> Walker:
    recall = problem.recall(h, paths)

    def advance(state: Any, t: float, noise: Increment) -> Any:
        (x, y), lagged = state, state.x if recall is None else recall.lagged()
        x = x + h * problem.drift(t, x, lagged, y) + problem.diffused(t, x, lagged, y, noise.dW)
        if recall is not None:
            recall.push(x)
        return problem.consistent(t + h, x, x if recall is None else recall.lagged())

    return Walker(problem.initial(paths), advance, lambda _, state: problem.parts(state), level)


def exact_walker(problem: Any, truth: Pathwise, level: int, paths: int) -> Walker:
    """Return the known solution of a problem, with additional normal variables independent of the Brownian paths.

    Parameters
    ----------
    problem : Problem
    truth : Pathwise
        Pathwise truth of the problem.
    level : int
        Level of refinement: the step size is 2^-level times the coarsest.
    paths : int
    """
    h = problem.horizon / (COARSEST * 2**level)
    rng = np.random.default_rng(SEED)

    def advance(z: Any, t: float, noise: Increment) -> Any:
        xi = rng.standard_normal((truth.extra_normals, paths)) if truth.extra_normals else None
        return truth.advance(z, t, h, noise._replace(xi=xi))

    return Walker(truth.start(paths), advance, truth.parts, level)


def walk_together(
    problem: Any, label: str, walkers: Sequence[Walker], paths: int, *, mirrored: bool = False
) -> Iterator[float]:
    """Advance walkers on the same Brownian paths, and yield the times T/2 and T when all have reached them.

    Parameters
    ----------
    problem : Problem
    label : str
        Label of the problem, on which the noise depends.
    walkers : sequence of Walker
    paths : int
        Number of paths of each walker.
    mirrored : bool
        Whether the second half of the paths has the noise of the first half with opposite sign (antithetic paths).
    """
    finest, H = max(walker.level for walker in walkers), problem.horizon / COARSEST
    source = Source(SEED, f"{label} in the kit", 0, paths // 2 if mirrored else paths)
    fields = problem.noise & {*BROWNIAN} | USUAL
    steps = Brownian(source, problem.noise_dim, H, finest, fields, problem.records).steps()
    for n, levels in zip(range(COARSEST), steps, strict=False):
        for walker in walkers:
            noise = levels[walker.level]
            walker.walk(_mirror(noise) if mirrored else noise, H / 2**walker.level)
        if n + 1 in {COARSEST // 2, COARSEST}:
            yield (n + 1) * H


def _mirror(noise: LevelNoise) -> LevelNoise:
    def both(part: Array | None, sign: float = -1.0) -> Array | None:
        return None if part is None else np.concatenate([part, sign * part], axis=-1)

    dW = np.concatenate([noise.dW, -noise.dW], axis=-1)
    # Lévy areas are products of two components, so they keep their sign.
    records = each(lambda part: np.concatenate([part, part], axis=-1), noise.records)
    return LevelNoise(dW, both(noise.H), records, K=both(noise.K), A=both(noise.A, 1.0))


LEVEL = 1e-6
# Levels of Euler's scheme (16, 64 and 256 steps), and of an approximate solution.
LEVELS, OWN = (1, 3, 5), 7
PATHS, MANY = 128, 4096
# Euler's strong order is at least 1/2; towards a wrong limit the distance does not fall.
ORDER, MARGIN = 0.5, 0.2
ROUNDING = 1e4 * EPS


def _mean(values: Array) -> tuple[float, float]:
    """Return the mean of independent values, shape (n,), with its standard error."""
    return float(values.mean()), float(values.std(ddof=1) / np.sqrt(len(values)))


def check_solution_simulated(subject: ProblemSubject) -> str:
    """Expect Euler's scheme on the same noise to converge to the solution: the distance falls at least like h^0.3."""
    truth, problem = solution(subject), subject.problem
    level = 0 if truth.exact and not truth.extra_normals else LEVELS[-1] if truth.exact else OWN
    runs = [euler_walker(problem, each, PATHS) for each in LEVELS]
    reference = exact_walker(problem, truth, level, PATHS)
    squares: dict[str, Array] = defaultdict(lambda: np.zeros(len(LEVELS)))
    sizes: dict[str, float] = defaultdict(float)
    for t in walk_together(problem, subject.spec.label, [*runs, reference], PATHS):
        exact = reference.parts(t)
        for name in exact.keys() & runs[0].parts(t).keys():
            squares[name] += [np.mean((run.parts(t)[name] - exact[name]) ** 2) for run in runs]
            sizes[name] = max(sizes[name], float(np.abs(exact[name]).max()))
    if not squares:
        raise Inapplicable("no component of the solution belongs to the simulated equation")
    return next((text for name in sorted(squares) if (text := _no_limit(name, squares[name], sizes[name]))), "")


def _no_limit(name: str, squares: Array, size: float) -> str:
    distances = np.sqrt(squares)
    if not np.isfinite(distances[-1]):
        raise Inapplicable("Euler's scheme with 256 steps leaves all bounds")
    if distances[-1] <= ROUNDING * max(1.0, size):
        return ""
    finite = np.isfinite(distances)
    if finite.sum() < 2:
        raise Inapplicable("Euler's scheme with 64 steps leaves all bounds")
    h = -np.array(LEVELS)[finite]
    slope = float(np.polyfit(h, np.log2(np.maximum(distances[finite], EPS * size)), 1)[0])
    if slope >= ORDER - MARGIN:
        return ""
    shown = ", ".join(f"{distance:.3g}" for distance in distances)
    text = f"the distance of {name} from Euler's scheme with 16, 64 and 256 steps is {shown}"
    return f"{text}: it falls like h^{slope:.2f}, so that truth and coefficients belong to different equations"


def check_solution_averaged(subject: ProblemSubject) -> str:
    """Expect means of the solution over 4096 paths to equal the moments, within an interval of level 1e-6 in all."""
    truth, problem = solution(subject), subject.problem
    wanted = moments(subject)
    reference = exact_walker(problem, truth, 0, MANY)
    quantile, compared = _quantile(2 * len(wanted)), 0
    for t in walk_together(problem, subject.spec.label, [reference], MANY):
        for moment in wanted:
            values = problem.observe(moment.observable, t, reference.parts(t))
            if values is not None and not _heavy(values):
                compared += 1
                if interval := _gap(values, quantile, 0.0, moment.value(t)):
                    return _describe_gap("the solution's", moment, interval, t)
    if not compared:
        raise Inapplicable("no moment belongs to known components with light tails")
    return ""


def check_moments_simulated(subject: ProblemSubject) -> str:
    """Expect means of simulations to equal the moments, up to an interval of level 1e-6 in all and Euler's bias.

    The bias with 256 steps is at most twice the difference from 64 steps, for every order from 0.3 on.
    """
    problem, wanted = subject.problem, moments(subject)
    coarse, fine = euler_walker(problem, 3, 8 * PATHS), euler_walker(problem, 5, 8 * PATHS)
    quantile, compared = _quantile(4 * len(wanted)), 0
    for t in walk_together(problem, subject.spec.label, [coarse, fine], 8 * PATHS, mirrored=True):
        for moment in wanted:
            values = _pair(problem, moment, t, coarse, fine)
            if values is not None:
                compared += 1
                change, change_se = _mean(values[1] - values[0])
                bias = 2.0 * (abs(change) + quantile * change_se)
                if interval := _gap(values[1], quantile, bias, moment.value(t)):
                    return _describe_gap("Euler's", moment, interval, t)
    if not compared:
        raise Inapplicable("no moment has light tails")
    return ""


def _pair(problem: Any, moment: Moment, t: float, coarse: Walker, fine: Walker) -> list[Array] | None:
    """Return the observable of both simulations averaged over antithetic pairs, or None for heavy tails."""
    found = [problem.observe(moment.observable, t, run.parts(t)) for run in (coarse, fine)]
    if any(values is None for values in found):
        return None
    pairs = [values.reshape(2, -1).mean(axis=0) for values in found if values is not None]
    if not all(np.isfinite(values).all() for values in pairs):
        raise Inapplicable("Euler's scheme with 64 steps leaves all bounds")
    return None if _heavy(pairs[1]) else pairs


def _heavy(values: Array) -> bool:
    deviations = np.abs(values - values.mean())
    largest = np.sort(deviations)[::-1][: int(np.sqrt(len(values)))]
    return Tail.of(float(deviations.sum()), float((deviations**2).sum()), largest, len(values)).heavy


def _quantile(means: int) -> float:
    return -float(scipy.special.ndtri(LEVEL / (2 * means)))


def _gap(values: Array, quantile: float, bias: float, expected: float) -> str:
    """Return the interval of a mean in words if it excludes the expectation, or an empty string."""
    mean, se = _mean(values)
    width = quantile * se
    beside = abs(mean - expected) > width + bias + ROUNDING * max(1.0, abs(expected))
    return f"{mean:.6g} +- {width:.2g}" if beside else ""


def _describe_gap(whose: str, moment: Moment, interval: str, t: float) -> str:
    text = f"{whose} {moment.observable} has the mean {interval} at t = {t:.3g}"
    return f"{text}, where the moment is {moment.value(t):.6g}"
