"""Random parameters for the shipped problems: set number n of a seed, which can be drawn and run again by its number.

Each number is multiplied by a factor between 1/5 and 5, whose logarithm is uniform; numbers that are 0 stay 0, whole
numbers stay whole. What a problem rejects as a wrong parameter is drawn again.
"""

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Executor
from contextlib import contextmanager
from dataclasses import replace
from functools import cache
from itertools import islice
from math import isnan
from numbers import Integral, Real
from typing import NamedTuple

import numpy as np
import pandas as pd

from facade import (
    SETS,
    Limits,
    Plan,
    ProblemSpec,
    Processes,
    Registry,
    Study,
    claims_of,
    function_parameters,
    load_registry,
    match,
    plan_of,
    problem_spec,
    result_of,
    select_schemes,
)
from sdaeverify import ProblemError, Scheme, Settings, UsageError
from sdaeverify_problems.curves._curve_shapes import SHAPES

SEED, FACTOR, SIGNIFICANT = 13, 5.0, 3
# Schemes of a set, and how often a set is drawn until the problem accepts it and a scheme solves it.
SCHEMES, DRAWS = 1, 100
CELL = ["scheme", "problem", "measure"]
WORDS = {"set": tuple(SETS), "shape": tuple(SHAPES), "measure": ("arc", "delta")}
# One claim in ten million is refuted by chance; fewer than 800 paths decide nothing at such a level.
SETTINGS = Settings(paths=1024, tests_reserved=10**5)
# Seconds of one scheme on one block.
TIMEOUT = 30.0


class Drawn(NamedTuple):
    """A set of parameters.

    Attributes
    ----------
    number : int
    problem : ProblemSpec
    schemes : tuple of str
        Labels of some that solve it.
    rejected : tuple of str
        Labels that were drawn before, and why the problem rejects them.
    """

    number: int
    problem: ProblemSpec
    schemes: tuple[str, ...]
    rejected: tuple[str, ...] = ()


@cache
def registry() -> Registry:
    """Return what is registered."""
    return load_registry()


@cache
def shipped() -> tuple[Callable[..., object], ...]:
    """Return the problem functions of this distribution, by name."""
    entries = registry().problems
    families = (entries[name].thing for name in sorted(entries))
    return tuple(family for family in families if family.__module__.startswith("sdaeverify_problems."))


@cache
def schemes() -> tuple[Scheme, ...]:
    """Return the schemes of this distribution, and both ends of theta beside 1/2."""
    return tuple(select_schemes(registry(), ["*", "stochastic-theta[theta=0]", "stochastic-theta[theta=1]"]))


def drawn(number: int, seed: int = SEED) -> Drawn:
    """Return a set; consecutive numbers go through all problems."""
    family = shipped()[number % len(shipped())]
    rng, rejected = np.random.Generator(np.random.Philox(key=[seed, number])), []
    for spec in islice(_specs(family, rng), DRAWS):
        try:
            problem = spec.build()
        except (UsageError, ProblemError) as error:
            rejected.append(f"{spec.label}: {error}")
            continue
        known = [scheme for scheme in schemes() if match(scheme, problem).problem is not None]
        chosen = rng.permutation(len(known))[:SCHEMES]
        return Drawn(number, spec, tuple(known[place].label for place in sorted(chosen)), tuple(rejected))
    raise RuntimeError(f"set {number}: {DRAWS} draws rejected, the last ones {rejected[-2:]}")


def verdicts(chosen: Drawn, executor: Executor | None = None) -> pd.DataFrame:
    """Return one row for each claim of a set, with its number and its command.

    Only cells that put a claim to the test are run, and no controls: these keep claims from being verified, and a
    refutation from being one where the positive control is refuted, too.
    """
    study = Study(_claimed(plan_of(registry(), chosen.schemes, [chosen.problem], ())), SETTINGS)
    for _ in study.run(executor, 1):
        pass
    result = result_of(study, registry(), [])
    table = result.verdicts.assign(
        reproduce=[result.command(*row) for row in result.verdicts[CELL].itertuples(index=False)]
    )
    claimed = table[table.claim.notna() & (table.claim != "") | (table.verdict == "error")]
    return claimed.assign(number=chosen.number)


@contextmanager
def watched(seconds: float = TIMEOUT) -> Iterator[Executor]:
    """Give a process in which no block of paths takes longer than it may."""
    with Processes(1, limits=Limits(timeout=seconds)) as executor:
        yield executor


def collected(numbers: Sequence[int]) -> pd.DataFrame:
    """Return the rows of several sets."""
    with watched() as executor:
        return pd.concat([verdicts(drawn(number), executor) for number in numbers], ignore_index=True)


def _claimed(made: Plan) -> Plan:
    kept = []
    for each in made.problems:
        cells = tuple(cell for cell in each.cells if claims_of(cell))
        kept.append(replace(each, cells=cells, controls=()))
    return Plan(tuple(kept))


def _specs(family: Callable[..., object], rng: np.random.Generator) -> Iterator[ProblemSpec]:
    base, parameters = problem_spec(family), function_parameters(family)
    while True:
        values = {parameter.name: parameter.default for parameter in parameters}
        words = {name: str(rng.choice(WORDS[name])) for name, value in values.items() if isinstance(value, str)}
        own = SETS[words["set"]]._asdict() if "set" in words else {}
        scaled = {name: _scaled(own.get(name, value), rng) for name, value in values.items() if name not in words}
        texts = {name: str(value) for name, value in (words | scaled).items() if value != values[name]}
        yield problem_spec(family, texts) if texts else base


def _scaled(value: object, rng: np.random.Generator) -> object:
    factor = FACTOR ** rng.uniform(-1.0, 1.0)
    if isinstance(value, bool) or not isinstance(value, Real) or isnan(value):
        return value
    if isinstance(value, Integral):
        return round(int(value) * factor)
    return float(f"{float(value) * factor:.{SIGNIFICANT}g}")
