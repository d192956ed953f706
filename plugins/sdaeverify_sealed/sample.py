"""What is sampled of a solver on a problem: runs with seeds of their own, at several step sizes, look by look.

Each step size has G = `GROUPS` runs a look. Runs differ in their seed and are independent, whatever a solver does
inside one: their means have a standard error that does not depend on how paths within a run are related. No noise is
common to two step sizes, so that the error of a difference is that of both.
"""

import hashlib
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import ceil
from typing import NamedTuple

import numpy as np

from sdaeverify import Array, InvariantMean, Parts, Problem, SchemeError, Settings, UsageError
from sdaeverify.numerics import GROUPS, Tail
from sdaeverify.studying import DEEP_PATHS, Source

from .contract import Ends, Means, Sealed, checked
from .references import INVARIANT, WEAK, Reference, references

# Relaxation times after which the law is taken for the invariant one: e^-16 = 1e-7 of the start is left of it.
BURN_IN = 16.0
# Fewer paths of a run tell nothing of their spread.
FEWEST_OF_RUN = 10
LARGEST = 20


@dataclass(frozen=True)
class Budget:
    """How much is sampled.

    Attributes
    ----------
    paths : int
        Most paths at each step size.
    looks : int
        How often at most a claim is judged, with twice the paths each time.
    steps : tuple of int
        Numbers of steps to the horizon, coarsest first; those of each solver if left out.
    seed : int
    """

    paths: int = 2**16
    looks: int = 3
    steps: tuple[int, ...] = ()
    seed: int = 20170601

    def __post_init__(self) -> None:
        if not 1 <= self.looks <= 20:
            raise UsageError(f"the number of looks must be between 1 and 20, got {self.looks}")
        fewest = max(DEEP_PATHS, FEWEST_OF_RUN * GROUPS) * 2 ** (self.looks - 1)
        if self.paths < fewest:
            raise UsageError(
                f"the number of paths must be at least {fewest} for {self.looks} looks, got {self.paths}"
            )
        check_steps(self.steps)
        # Said before anything is run.
        Settings(seed=self.seed)

    @property
    def sizes(self) -> tuple[int, ...]:
        """Paths of one run of each look: the paths of all looks so far double from one look to the next."""
        first = ceil(self.paths / (GROUPS * 2 ** (self.looks - 1)))
        return (first, *(first * 2**look for look in range(self.looks - 1)))


def check_steps(steps: Sequence[int]) -> None:
    """Raise if numbers of steps do not grow, or are too few for an order.

    Raises
    ------
    UsageError
    """
    growing = all(0 < a < b for a, b in pairwise(steps)) and min(steps, default=1) > 0
    if steps and (len(steps) < 3 or not growing):
        given = ",".join(map(str, steps))
        raise UsageError(f"an order needs at least three increasing numbers of steps, got {given}")


class Plan(NamedTuple):
    """The runs that answer the claims about one measure.

    Attributes
    ----------
    measure : str
        ``weak`` or ``invariant``.
    T : float
        Final time of a run.
    h : ndarray, shape (L,)
        Step sizes, coarsest first.
    names : tuple of str
        Observables, K of them.
    """

    measure: str
    T: float
    h: Array
    names: tuple[str, ...]


class Look(NamedTuple):
    """Means of the runs of one look, and their standard errors.

    Attributes
    ----------
    means : ndarray, shape (L, G, K)
        Mean of each observable in each run.
    within : ndarray, shape (L, G, K)
        Squared standard error of that mean within a run: the variance of its paths over their number, or the value
        that the solver states; NaN if it states none.
    motions : ndarray, shape (L, G, M)
        Means of powers of W(T), see `moments_of_motions`; M is 0 if the solver does not report W.
    heavy : ndarray of bool, shape (K,)
        Whether the squares of an observable rest on few paths in a run of the finest step size.
    """

    means: Array
    within: Array
    motions: Array
    heavy: Array


@dataclass(frozen=True, eq=False)
class Sample:
    """What was sampled for one plan.

    Attributes
    ----------
    plan : Plan
    sizes : tuple of int
        Paths of one run of each look that was planned.
    looks : tuple of Look
        Those that were made.
    known : mapping of str to Reference
        By name of the observable.
    """

    plan: Plan
    sizes: tuple[int, ...]
    looks: tuple[Look, ...]
    known: dict[str, Reference]

    @property
    def paths(self) -> int:
        """Paths at each step size."""
        return GROUPS * sum(self.sizes[: len(self.looks)])

    def means(self, looks: int) -> Array:
        """Return the means of all runs with one group index, over the first looks, shape (L, G, K)."""
        weights = np.array(self.sizes[:looks]) / sum(self.sizes[:looks])
        return np.asarray(np.einsum("j,jlgk->lgk", weights, np.stack([look.means for look in self.looks[:looks]])))

    def errors(self, name: str, looks: int) -> Array:
        """Return the errors of an observable's means, shape (G, L)."""
        column = self.plan.names.index(name)
        return np.asarray(self.means(looks)[:, :, column].T - self.known[name].mean[:, None])


def plans(solver: Sealed, view: Problem, steps: Sequence[int]) -> list[Plan]:
    """Return the plans for what a solver claims on a problem.

    Parameters
    ----------
    solver : Sealed
    view : Problem
        In its form.
    steps : sequence of int
        Numbers of steps to the horizon.
    """
    found, n = [], np.array(steps)
    if names := _claimed(solver, view, WEAK, view.observables):
        found.append(Plan(WEAK, view.horizon, view.horizon / n, names))
    seen = view.with_moment_equations
    stationary = [truth.observable for truth in seen.truths if isinstance(truth, InvariantMean)]
    if (names := _claimed(solver, view, INVARIANT, stationary)) and np.isfinite(view.relaxation_time):
        unit = min(view.horizon, view.relaxation_time)
        whole = ceil(BURN_IN * view.relaxation_time / unit)
        found.append(Plan(INVARIANT, whole * unit, unit / n, names))
    return found


def _claimed(solver: Sealed, view: Problem, measure: str, names: Iterable[str]) -> tuple[str, ...]:
    """Return those of some observables that a claim about a measure covers."""
    claims = [claim for claim in solver.promises if claim.measure == measure and claim.when <= view.traits]
    return tuple(name for name in names if any(claim.covers(measure, name) for claim in claims))


def seed_of(source: Source, *address: object) -> int:
    """Return the seed of a run, between 1 and 2^31 - 1: a hash of its address."""
    text = "|".join(map(str, (source.seed, source.problem, *address)))
    digest = hashlib.blake2b(text.encode(), digest_size=8).digest()
    return 1 + int.from_bytes(digest, "little") % (2**31 - 1)


class Runner(NamedTuple):
    """Runs of one solver on one problem.

    Attributes
    ----------
    solver : Sealed
    view : Problem
        In its form.
    source : Source
        Seed and label of the problem.
    """

    solver: Sealed
    view: Problem
    source: Source

    @property
    def seen(self) -> Problem:
        """The problem with its moment equations as observables."""
        return self.view.with_moment_equations

    def once(self, plan: Plan, h: float, paths: int, seed: int) -> Ends | Means:
        """Return what one run returns, after a check of its shape.

        Parameters
        ----------
        plan : Plan
            For the final time.
        h : float
        paths : int
        seed : int
        """
        found = self.solver.run(self.view, float(h), float(plan.T), paths, seed)
        return checked(self.solver, self.view, found, paths)

    def seeds(self, plan: Plan, level: int, look: int) -> list[int]:
        """Return the seeds of the runs of a look at one step size.

        Parameters
        ----------
        plan : Plan
            For its measure.
        level : int
            Index of the step size.
        look : int
        """
        return [seed_of(self.source, plan.measure, level, look, group) for group in range(GROUPS)]

    def look(self, plan: Plan, look: int, paths: int) -> tuple[Look, list[str]]:
        """Make the runs of a look; return their means, and a digest of each run.

        Parameters
        ----------
        plan : Plan
        look : int
            Its index.
        paths : int
            Of one run.
        """
        noted, digests = list[list[tuple[Array, Array, Array, Array]]](), list[str]()
        for level, h in enumerate(plan.h):
            row = []
            for seed in self.seeds(plan, level, look):
                found = self.once(plan, h, paths, seed)
                digests.append(digest_of(found))
                row.append(self.note(plan, found))
            noted.append(row)
        means, within, motions = (np.array([[one[part] for one in row] for row in noted]) for part in range(3))
        return Look(means, within, motions, np.any([one[3] for one in noted[-1]], axis=0)), digests

    def note(self, plan: Plan, found: Ends | Means) -> tuple[Array, Array, Array, Array]:
        """Return the means of a run, their squared standard errors, the moments of W, and which tails are heavy."""
        if isinstance(found, Means):
            return self._stated(plan, found)
        state: Parts = found.state  # type: ignore[assignment] # a check has split it
        values = [self.seen.observe(name, plan.T, state) for name in plan.names]
        for name, value in zip(plan.names, values, strict=True):
            if value is None:
                raise SchemeError(f"{self.solver.name} returned no component that {name} needs")
        x = np.stack([np.asarray(value, dtype=float) for value in values])
        within = x.var(axis=-1, ddof=1) / x.shape[-1]
        heavy = np.array([is_heavy((row - row.mean()) ** 2) for row in x])
        return x.mean(axis=-1), within, moments_of_motions(found.W, plan.T), heavy

    def _stated(self, plan: Plan, found: Means) -> tuple[Array, Array, Array, Array]:
        missing = [name for name in plan.names if name not in found.values]
        if missing:
            named = "a claim that names its quantities asks for these alone"
            raise SchemeError(f"{self.solver.name} returned no mean of {missing[0]}; {named}")
        means = np.array([float(found.values[name]) for name in plan.names])
        errors = np.array([float(found.errors.get(name, np.nan)) for name in plan.names])
        return means, errors**2, np.zeros(0), np.zeros(len(means), dtype=bool)


def moments_of_motions(W: Array, T: float) -> Array:
    """Return means of w_i, of w_i w_j - delta_ij for i <= j, and of w_i^4 - 3, w = W/sqrt(T): all 0 for a motion.

    Parameters
    ----------
    W : ndarray, shape (l, P)
        W(T) of l motions.
    T : float
    """
    w = W / np.sqrt(T)
    products = [np.mean(w[i] * w[j]) - (i == j) for i in range(len(w)) for j in range(i, len(w))]
    return np.array([*w.mean(axis=-1), *products, *((w**4).mean(axis=-1) - 3.0)])


def is_heavy(squares: Array) -> bool:
    """Return whether a mean of squares, shape (P,), rests on few paths."""
    if not squares.any():
        return False
    largest = np.sort(squares)[::-1][: max(LARGEST, int(np.sqrt(len(squares))))]
    return Tail.of(float(squares.sum()), float((squares**2).sum()), largest, len(squares)).heavy


def digest_of(found: Ends | Means) -> str:
    """Return a digest of what a run returned: the same for the same numbers."""
    parts = found.values if isinstance(found, Means) else found.state
    assert not isinstance(parts, np.ndarray)
    rows = b"".join(name.encode() + np.ascontiguousarray(parts[name]).tobytes() for name in sorted(parts))
    return hashlib.blake2b(rows, digest_size=16).hexdigest()


def known_of(runner: Runner, plan: Plan, paths: int) -> dict[str, Reference]:
    """Return the references of a plan's observables.

    Parameters
    ----------
    runner : Runner
    plan : Plan
    paths : int
        Of a reference whose mean is sampled.
    """
    source = runner.source._replace(problem=f"{runner.source.problem} reference", paths=paths)
    return references(runner.seen, plan.measure, plan.names, source)


def samples(runner: Runner, plan: Plan, budget: Budget) -> Iterator[tuple[Sample, list[str]]]:
    """Yield the sample after each look, with the digests of the runs of that look.

    Parameters
    ----------
    runner : Runner
    plan : Plan
        Its observables without a reference are left out.
    budget : Budget
    """
    known, looks = known_of(runner, plan, budget.paths), list[Look]()
    plan = plan._replace(names=tuple(name for name in plan.names if name in known))
    if not plan.names:
        return
    for look, paths in enumerate(budget.sizes):
        made, digests = runner.look(plan, look, paths)
        looks.append(made)
        yield Sample(plan, budget.sizes, tuple(looks), known), digests
