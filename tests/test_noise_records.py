"""Noise beside Brownian motions: refined with the levels of a run, and no part of the Brownian streams."""

from dataclasses import dataclass
from itertools import islice, pairwise

import numpy as np
import pytest

from facade import Brownian, half_steps, trials, uses_declared_noise
from sdaeverify import SDE, ProblemError, Scheme, Step
from sdaeverify.studying import Source


class Arrivals:
    """Numbers of arrivals at a rate; a half has a binomial share of them."""

    name = "arrivals"

    def begin(self, rng, h, paths):
        return rng.poisson(9.0 * h, (1, paths)).astype(float)

    def refined(self, coarse, h, rng):
        first = rng.binomial(coarse.astype(int), 0.5).astype(float)
        return np.stack([first, coarse - first], axis=1).reshape(-1, coarse.shape[-1])

    def joined(self, first, second):
        return first + second

    def rule(self, h):
        return np.array([0.0, 1.0]), np.array([1.0 - 9.0 * h, 9.0 * h])


class Queue(SDE):
    """dx = dW + dN."""

    @property
    def records(self):
        return (Arrivals(),)


@dataclass(frozen=True)
class Served(Scheme):
    """x+ = x + dW + dN, which declares N or not."""

    name = "served"
    form = Queue
    heard: bool = True

    @property
    def noise(self):
        return frozenset({"dW", "arrivals"} if self.heard else {"dW"})

    def step(self, problem, state, t, h, noise):
        return Step(state + noise.dW + noise.records["arrivals"])


def queue(**changed):
    given = {
        "drift": lambda t, x: 0.0 * x,
        "diffusion": lambda t, x: 1.0 + 0.0 * x[:, None],
        "start": [1.0],
        "noise_dim": 1,
        "horizon": 1.0,
        "source": "a test",
    }
    return Queue(**{**given, **changed})


BOTH = (Arrivals(),)


def pieces(used=None, records=BOTH, steps=2):
    noise = Brownian(Source(3, "queue", 0, 40, used), 1, 0.5, 5, records=records)
    return [piece for coarsest in islice(noise.pieces(), steps) for piece in coarsest]


def level(found, number, part):
    return np.concatenate([part(noise) for at, noise in found if at == number])


def test_levels_add_up():
    """At every level the arrivals of two neighbouring steps are those of the step they make up."""
    found = pieces()
    arrivals = [level(found, number, lambda noise: noise.records["arrivals"]) for number in range(6)]

    assert arrivals[0].sum() > 0.0
    for coarse, fine in pairwise(arrivals):
        assert np.array_equal(fine[0::2] + fine[1::2], coarse)


def test_paths_do_not_depend_on_how_many_are_used():
    """Of fewer paths each has the same arrivals as among all, at the finest level, too."""
    all_of_them, some = (level(pieces(used), 5, lambda noise: noise.records["arrivals"]) for used in (None, 7))

    assert np.array_equal(all_of_them[..., :7], some)


def test_brownian_motions_are_as_they_were():
    """Streams of records are their own: without them the Brownian increments are the same to the last bit."""
    with_records, without = (
        level(pieces(records=records), 5, lambda noise: noise.dW) for records in ((Arrivals(),), ())
    )

    assert np.array_equal(with_records, without)


@pytest.mark.parametrize("heard", [True, False])
def test_undeclared_record_is_heard(heard):
    """A scheme that uses a record without declaring it is told so, by name."""
    found = uses_declared_noise(trials(Served(heard), queue())[0])

    assert found == ("" if heard else "uses noise that it does not declare: H, arrivals")


def test_records_are_part_of_what_is_drawn():
    """The problem's noise names the record; nothing else can be asked for."""
    assert queue().noise == {"dW", "H", "arrivals"}
    with pytest.raises(ProblemError, match="with arrivals, got"):
        queue(noise=frozenset({"dW", "departures"}))


def test_nodes_are_those_of_both():
    """Each Brownian node comes with each pair of nodes of the half steps; means are those of the product."""
    h = 0.01
    nodes = half_steps(1, 4).with_records((Arrivals(),), h)
    whole, first, second = (part.records["arrivals"] for part in nodes)

    assert np.array_equal(whole, first + second)
    assert nodes.whole.weights.sum() == pytest.approx(1.0, rel=1e-14)
    assert nodes.whole.weights @ whole == pytest.approx(9.0 * h, rel=1e-13)
    assert nodes.whole.mean(nodes.whole.dW[0] ** 2 * whole) == pytest.approx(9.0 * h, rel=1e-12)
