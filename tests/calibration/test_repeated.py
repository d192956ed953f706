"""Repetitions inside a block: taken apart, pooled and put together again."""

import numpy as np
import pytest

from facade import (
    SAMPLED,
    UNIT,
    Entry,
    Repeated,
    Strong,
    Task,
    Weak,
    append_tallies,
    load_registry,
    one,
    pool,
    run_block,
    select_problems,
    select_schemes,
    stack_tallies,
)
from sdaeverify import Settings
from sdaeverify.measuring import Tally


def tally(seed: int) -> Tally:
    """Return a tally of random numbers."""
    rng = np.random.default_rng(seed)
    tops = np.sort(rng.random((2, 4)))[:, ::-1]
    return Tally({"a": rng.random((3, 2))}, {"b": rng.random(2)}, {"c": tops})


def same(left: Tally, right: Tally, rtol: float = 1e-12) -> bool:
    """Tell whether two tallies hold the same numbers, sums to rounding."""
    pairs = [(getattr(left, kind), getattr(right, kind)) for kind in ("sums", "maxima", "largest")]
    return all(set(a) == set(b) and all(np.allclose(a[n], b[n], rtol=rtol) for n in a) for a, b in pairs)


def test_pooled_repetitions_are_merged_ones():
    """Pooling neighbours gives what merging their tallies one by one gives."""
    tallies = [tally(seed) for seed in range(6)]

    found = pool(stack_tallies(tallies), 3)

    assert same(one(found, 0), tallies[0].merge(tallies[1]).merge(tallies[2]))
    assert same(one(found, 1), tallies[3].merge(tallies[4]).merge(tallies[5]))


def test_first_of_every_few_are_pooled():
    """A look takes the first repetitions of each sequence and leaves the others."""
    tallies = [tally(seed) for seed in range(6)]

    found = pool(stack_tallies(tallies), 2, every=3)

    assert same(one(found, 1), tallies[3].merge(tallies[4]))


def test_stacks_are_appended():
    """Stacked tallies of two blocks follow each other."""
    tallies = [tally(seed) for seed in range(5)]

    both = append_tallies([stack_tallies(tallies[:2]), stack_tallies(tallies[2:])])

    assert all(same(one(both, index), expected) for index, expected in enumerate(tallies))


@pytest.mark.parametrize("measure", [Strong(), Weak()], ids=["strong", "weak"])
def test_repetitions_of_a_block_make_up_its_tally(measure):
    """What is noted for the repetitions of a block adds up to what the measure notes for the whole of it."""
    registry = load_registry(lab=True)
    (spec,), schemes = select_problems(registry, ["gbm"]), select_schemes(registry, ["euler-maruyama"])
    settings = Settings(paths=2 * UNIT, block=2 * UNIT, levels=3)
    task = Task(spec, (Entry(schemes[0], (measure, Repeated(measure))),), settings)

    (lane,) = run_block(task, 0)

    whole, repeated = lane.tallies
    assert lane.errors == ("", "")
    assert {len(sums) for sums in repeated.sums.values()} == {2}
    # Sums keep so many bits: those of two parts and that of the whole are each rounded by half of the last one.
    assert same(Tally(one(pool(repeated, 2), 0).sums), Tally(whole.sums), rtol=2.0 ** (1 - SAMPLED))
