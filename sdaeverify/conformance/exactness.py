"""Exactness on trivial equations: dx = 0, dx = c dt or dx = S dW must be solved up to rounding errors.

A step of twice the length, noise used twice or for the wrong component, and noise of the wrong strength have a fixed
relative error here, however short the steps. Schemes that tame or balance their increments have an error that
vanishes with the step size, which is accepted. If a scheme claims nothing on paths, only the law of dx = S dW is
checked: (W_{n+1} - W_{n-1})/2 in place of W_{n+1} - W_n has an error of half an increment on each path, and the right
law.

A scheme of several steps may start with a scheme of lower order: an error of size h that is made once does not reduce
orders up to 1, and claims of higher order are checked elsewhere. So it is accepted if the later steps are exact.
"""

from collections.abc import Iterator, Mapping
from functools import cache, reduce
from itertools import chain, islice
from math import inf, isfinite
from typing import Any, NamedTuple

import numpy as np

from ..arrays import Array, Parts
from ..contracts.measure import ALONG_PATHS
from ..contracts.scheme import Scheme, require_step
from ..errors import FAULTS, SchemeError, SdaeverifyError, one_line
from ..forms import Domain
from ..forms.traits import SET_BY_FORM
from ..forms.trivial import H, Trivial, Trivials
from ..noise.brownian import Increment
from ..numerics.statistics import EPS
from ..probe.local.run_memory import remembers
from ..probe.step.nodes import SEED
from .own_run import stops_along

# The law of a run on dx = c dt + S dW: growth of its mean and covariance, computed without sampling.
#
# If the state of a run is affine in all the noise that drives it, X_N = m_N + sum_j R_{N,j} xi_j with independent
# xi_j of variance 1, then the response R_{N,j} is the change by the j-th variable alone, and
#
#     E X_N = m_N,    Cov X_N = R_N R_N^T.
#
# Only the growth from step N to step 2 N is compared with that of the solution, E X = m(t) and Cov X = t A A^T,
# because a scheme that remembers past increments starts without them.


LAW_STEPS = 32
# A state counts as affine in the noise if its deviation is below this part of the response; rounding is smaller.
AFFINE = 1e-6


class LawError(NamedTuple):
    """Error in the growth of the mean or covariance of a law.

    Attributes
    ----------
    quantity : str
        Name of the quantity with the larger error, the mean or the covariance.
    share : float
        Error of the growth relative to the growth of the solution.
    rounding : float
        Part of the error that rounding explains.
    """

    quantity: str
    share: float
    rounding: float


# Mean, shape (d,), and covariance, shape (d, d), of a state.
Moments = tuple[Array, Array]


def law_error(scheme: Scheme, trivial: Trivial, h: float) -> LawError | None:
    """Return the error in the growth of mean and covariance of a scheme's states, compared with the solution.

    Parameters
    ----------
    scheme : Scheme
    trivial : Trivial
        A problem with noise.
    h : float

    Returns
    -------
    LawError or None
        None if the scheme's state is not affine in its noise, or if there is other noise than Brownian motions: the
        law is then unknown.
    """
    if trivial.problem.records:
        return None
    known = list(trivial.solution(0.0, np.zeros((trivial.problem.noise_dim, 1))))
    noises, probe = _unit_noises(scheme, trivial, h)
    run = (scheme.parts(trivial.problem, stop.end) for stop in stops_along(scheme, trivial.problem, h, noises))
    states = [_stack_parts(parts, known) for parts in islice(run, LAW_STEPS - 1, None, LAW_STEPS)]
    found = [_moments(state, probe) for state in states]
    if any(moments is None for moments in found):
        return None
    grown_mean, grown = _growth(*(moments for moments in found if moments is not None))
    right_mean, right = _growth(*(_solution(trivial, known, n * LAW_STEPS * h) for n in (1, 2)))
    variance = float(np.diag(right).max())
    mean = np.abs(grown_mean - right_mean).max() / (np.abs(right_mean).max() + np.sqrt(variance))
    covariance = np.abs(grown - right).max() / variance
    rounding = 64.0 * EPS * len(noises) * (1.0 + float(np.abs(states[-1]).max()) / np.sqrt(variance))
    return LawError(*max(("the covariance", covariance), ("the mean", mean), key=lambda pair: pair[1]), rounding)


def _growth(half: Moments, end: Moments) -> Moments:
    return end[0] - half[0], end[1] - half[1]


def _unit_noises(scheme: Scheme, trivial: Trivial, h: float) -> tuple[list[Increment], Array]:
    """Return noise of J + 2 paths and the variables xi of the last path, shape (J,).

    The first path has none of the J variables, each of the next J paths has one of them, and the last path has all.
    """
    fields, l = 1 + ("H" in scheme.noise), trivial.problem.noise_dim
    size = 2 * LAW_STEPS * fields * l
    probe = np.random.Generator(np.random.Philox(key=SEED)).standard_normal(size)
    xi = np.concatenate([np.zeros((size, 1)), np.eye(size), probe[:, None]], axis=1)
    xi = xi.reshape(2 * LAW_STEPS, fields, l, size + 2)
    areas = [np.sqrt(h / 12.0) * part[1] if fields > 1 else None for part in xi]
    # The state is affine in independent variables: areas, which contain products of these, are set to 0.
    K, A = np.zeros((l, size + 2)), np.zeros((l * (l - 1) // 2, size + 2))
    drawn = (Increment(np.sqrt(h) * part[0], area) for part, area in zip(xi, areas, strict=True))
    return [noise._replace(K=K, A=A) for noise in drawn], probe


def _moments(x: Array, probe: Array) -> Moments | None:
    """Return mean and covariance from the states of all J + 2 paths, shape (d, J + 2); None if not affine."""
    mean, response = x[:, 0], x[:, 1:-1] - x[:, :1]
    expected = mean + response @ probe
    if not np.abs(x[:, -1] - expected).max() <= AFFINE * np.abs(response).max():
        return None
    return mean, response @ response.T


def _solution(trivial: Trivial, known: list[str], t: float) -> Moments:
    l = trivial.problem.noise_dim
    x = _stack_parts(trivial.solution(t, np.sqrt(t) * np.eye(l, l + 1, k=1)), known)
    response = x[:, 1:] - x[:, :1]
    return x[:, 0], response @ response.T


def _stack_parts(parts: Parts, known: list[str]) -> Array:
    return np.concatenate([parts[name] for name in known])


# Appended to an error on more Brownian motions than the problem has.
SEVERAL = "; if the scheme does not support several, say so in refuses"
STEPS, PATHS = 8, 3
# After this many steps a scheme of several steps has forgotten its start: roots up to 7/8 have decayed to rounding.
# The same number of steps is then compared, to include errors that occur periodically.
BEGUN = 272
# A relative error of order 1/2 or more in h decreases by more than this power of the factor between step sizes.
VANISHING = 0.4


def exactness_violation(scheme: Scheme, motions: float = inf, *, followed: Mapping[str, str]) -> str:
    """Return the first trivial problem on which a scheme is not exact, in one line, or an empty string.

    Parameters
    ----------
    scheme : Scheme
    motions : float
        Number of Brownian motions of the problem under test. An error on more Brownian motions is reported only if no
        variant with at most this number can be tried.
    followed : mapping of str to str
        `Measure.follows` by name of the measure.

    Raises
    ------
    SchemeError
        If a step raises.
    """
    forms: Any = scheme.forms
    paths = any(followed.get(claim.measure) == ALONG_PATHS for claim in scheme.promises)
    every = chain.from_iterable(_trivial_problems(form, scheme.domain) for form in forms)
    missed = (variants for variants in every if _misses(scheme, variants, paths=paths))
    texts = (_first_miss(_tries(scheme, variants, paths=paths), motions) for variants in missed)
    return next(filter(None, texts), "")


@cache
def _misses(scheme: Scheme, variants: tuple[Trivial, ...], *, paths: bool) -> bool:
    """Return whether a scheme is not exact on a trivial problem, or raises; cached for all problems."""
    first = next(_tries(scheme, variants, paths=paths), None)
    return first is not None and first.text != ""


@cache
def _trivial_problems(form: Any, domain: Domain | None) -> Trivials:
    # Built once for all schemes. A derived form inherits trivial problems that may be of its base form: they are left
    # out.
    found: Trivials = form.trivial_problems() if domain is None else form.trivial_problems_in(domain)
    own = (tuple(each for each in variants if isinstance(each.problem, form)) for variants in found)
    return tuple(variants for variants in own if variants)


class _Try(NamedTuple):
    """Result of a scheme on a trivial problem: its error in words, empty if exact, and the exception it raised."""

    motions: int
    text: str
    error: BaseException | None = None


def _first_miss(tries: Iterator[_Try], motions: float) -> str:
    """Return the error on the first variant that can be tried, preferably one with at most `motions` motions."""
    found = next(tries, None)
    if found is None or not found.text:
        return ""
    if found.motions > motions:
        found = next((other for other in tries if other.motions <= motions), found)
    if found.error is not None:
        raise SchemeError(found.text) from found.error
    return found.text + (SEVERAL if found.motions > motions else "")


def _tries(scheme: Scheme, variants: tuple[Trivial, ...], *, paths: bool) -> Iterator[_Try]:
    """Yield the results of a scheme on all variants that it refuses neither beforehand nor in its step."""
    for trivial in variants:
        tried = _is_claimed(scheme, trivial) and not scheme.why_not(trivial.problem)
        if tried and (found := _try(scheme, trivial, paths=paths)) is not None:
            yield found


def _is_claimed(scheme: Scheme, trivial: Trivial) -> bool:
    """Return whether a scheme can use the noise of a trivial problem, and one of its claims may apply to the problem.

    A claim that requires a trait set by the form does not apply to problems without the trait: a scheme only for the
    limit eps = 0 need not be exact for eps > 0. Other traits may hold without being declared.
    """
    asked, problem = [claim.when & SET_BY_FORM for claim in scheme.promises], trivial.problem
    return scheme.noise <= problem.noise and (not asked or any(when <= problem.traits for when in asked))


def _try(scheme: Scheme, trivial: Trivial, *, paths: bool) -> _Try | None:
    several = trivial.problem.noise_dim
    where = f"on {trivial.name}" + (f" with {several} Brownian motions" if several > 1 else "")
    try:
        text = _miss(scheme, trivial, paths=paths)
    except SdaeverifyError:
        return None
    except FAULTS as fault:
        return _Try(several, f"a step raises {one_line(fault)} {where}", fault)
    return _Try(several, text and f"not exact {where}: {text}")


def _miss(scheme: Scheme, trivial: Trivial, *, paths: bool) -> str:
    error, moved, bound, where = _error(scheme, trivial, H)
    if error <= bound:
        return ""
    fine, fine_moved, fine_bound, _ = _error(scheme, *trivial.short_run)
    if fine <= max(fine_bound, trivial.shorter**VANISHING * fine_moved * error / moved if moved else 0.0):
        return ""
    if trivial.noisy and not paths:
        return _miss_in_law(scheme, trivial)
    small = _is_small_start(scheme, trivial) if remembers(scheme, trivial.problem) else None
    if small:
        return ""
    hint = (
        _unread_lag(scheme, trivial)
        if small is None
        else "; later steps are exact, so that enter sets a wrong memory"
    )
    size = f"error {error:.2g}{where}" if isfinite(error) else "the state is not finite"
    return f"{size} after {STEPS} steps, the solution moves by {moved:.2g}{hint}"


def _miss_in_law(scheme: Scheme, trivial: Trivial) -> str:
    coarse, fine = law_error(scheme, trivial, H), law_error(scheme, *trivial.short_run)
    if coarse is None or fine is None or fine.share <= max(fine.rounding, trivial.shorter**VANISHING * coarse.share):
        return ""
    return f"{fine.quantity} after many steps is off by {fine.share:.2g} of its exact growth"


def _is_small_start(scheme: Scheme, trivial: Trivial) -> bool | None:
    """Return whether the error of the first steps is of order 1 in h; None if later steps are not exact."""
    error, off, bound = _late_error(scheme, trivial, H)
    if not off <= bound:
        return None
    fine_error, fine_off, fine_bound = _late_error(scheme, *trivial.short_run)
    if not fine_off <= fine_bound:
        return None
    return fine_error <= max(fine_bound, 2.0 * trivial.shorter * error)


def _late_error(scheme: Scheme, trivial: Trivial, h: float) -> tuple[float, float, float]:
    """Return the largest error after many steps, its change over as many more steps, and the bound of rounding."""
    begun, end = _run(scheme, trivial, h, (BEGUN, 2 * BEGUN))
    first, last = ({name: got[name] - after[name] for name in after} for got, after in (begun, end))
    size = max(_largest(begun[1]), _largest(end[1]))
    changed = _largest({name: last[name] - first[name] for name in last})
    return _largest(last), changed, 128.0 * EPS * BEGUN * size


def _error(scheme: Scheme, trivial: Trivial, h: float) -> tuple[float, float, float, str]:
    """Return the largest error after some steps, the move of the solution, the bound of rounding, and where it fails.

    The last is a text such as `` of y``, empty if all components fail.
    """
    ((got, after),) = _run(scheme, trivial, h, (STEPS,))
    start = trivial.solution(0.0, np.zeros((trivial.problem.noise_dim, PATHS)))
    before = {name: start[name] for name in after}
    errors = {name: _largest({name: got[name] - after[name]}) for name in after}
    moved = _largest({name: after[name] - before[name] for name in after})
    bound = 64.0 * EPS * STEPS * max(_largest(before), _largest(after))
    off = [name for name, error in errors.items() if error > bound]
    return max(errors.values()), moved, bound, f" of {', '.join(off)}" if 0 < len(off) < len(errors) else ""


def _run(scheme: Scheme, trivial: Trivial, h: float, counts: tuple[int, ...]) -> list[tuple[Parts, Parts]]:
    """Return the components of a scheme after some numbers of steps, and the solution in the same components."""
    problem, noises = trivial.problem, _noises(scheme, trivial, h, counts[-1])
    stops = list(stops_along(scheme, problem, h, noises))
    found = list[tuple[Parts, Parts]]()
    for count in counts:
        W = sum((noise.dW for noise in noises[:count]), np.zeros((problem.noise_dim, PATHS)))
        jumps = {r.name: reduce(r.joined, (n.records[r.name] for n in noises[:count])) for r in problem.records}
        got, solution = scheme.parts(problem, stops[count - 1].end), trivial.solution(count * h, W, **jumps)
        # A scheme may leave out components; its report has none of them.
        found.append((got, {name: part for name, part in solution.items() if name in got}))
    return found


def _noises(scheme: Scheme, trivial: Trivial, h: float, count: int) -> list[Increment]:
    rng = np.random.Generator(np.random.Philox(key=SEED))
    return [scheme.law.increment(trivial.problem.drawn(rng, h, PATHS), h) for _ in range(count)]


def _unread_lag(scheme: Scheme, trivial: Trivial) -> str:
    """Return which lagged value a step does not depend on, as the end of a message; empty if there is none.

    A scheme that keeps the past itself, in a state of its own, may read no lagged value of the noise. Equations that
    are driven by noise have no lagged term.
    """
    problem = trivial.problem
    if trivial.noisy:
        return ""
    stop = next(stops_along(scheme, problem, H, _noises(scheme, trivial, H, 1)))
    lagged, ahead = stop.noise.lagged, stop.noise.ahead
    plain = type(stop.state) is type(problem.initial(PATHS))
    if lagged is None or ahead is None or not plain:
        return ""

    def depends_on(**moved: Any) -> bool:
        end = require_step(scheme.prepare(problem, H)(stop.state, 0.0, stop.noise._replace(**moved))).state
        got, known = scheme.parts(problem, end), scheme.parts(problem, stop.end)
        return any(not np.array_equal(got[name], known[name]) for name in got)

    if not depends_on(lagged=lagged + 1.0, ahead=ahead + 1.0):
        return "; no step depends on x(t - tau), so that it solves an equation without delay"
    if problem.constraint is not None and not depends_on(ahead=ahead + 1.0):
        return "; no step depends on x(t + h - tau), which y at its end follows"
    return ""


def _largest(parts: Parts) -> float:
    return max(float(np.abs(part).max()) for part in parts.values())
