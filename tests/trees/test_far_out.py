"""Order conditions hold for a class only if a step is the same far out, late, and for further motions."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from facade import CLASSES, distance_far, placements, probe_of
from sdaeverify import Scheme
from sdaeverify_orders import orders
from sdaeverify_schemes.baoab import BAOAB
from sdaeverify_schemes.delays.stochastic_theta import StochasticTheta
from sdaeverify_schemes.euler_maruyama import DriftTruncatedEuler, EulerMaruyama
from sdaeverify_schemes.heun import HeunAdditive
from sdaeverify_schemes.milstein import Milstein
from sdaeverify_schemes.milstein_areas import MilsteinAreas
from sdaeverify_schemes.platen_weak_2_general import PlatenWeak2General
from sdaeverify_schemes.quicsort import QUICSORT
from sdaeverify_schemes.sra1 import SRA1

pytestmark = pytest.mark.long

BY_NAME = {kind.name: kind for kind in CLASSES}
REASON = "a step differs far out, at late times or with more motions"
# What a step is given in the place of problem and noise.
Change = Callable[[Any, Any], tuple[Any, Any]]


def changed(base: Scheme, change: Change) -> Scheme:
    """Return a scheme whose step is given another problem or other noise."""

    def step(self, problem, state, t, h, noise):
        problem, noise = change(problem, noise)
        return super(kind, self).step(problem, state, t, h, noise)

    kind = type(f"Changed{type(base).__name__}", (type(base),), {"name": f"wrong-far-{base.name}", "step": step})
    return kind()


def coefficient(problem: Any, part: str) -> Callable[..., Any]:
    """Return a coefficient as its author gave it: that of an equation without delay is wrapped."""
    given = getattr(problem, part)
    return getattr(given, "f", given)


def clipped(part: str, most: float) -> Change:
    """Return that a coefficient is clipped at a number."""

    def change(problem, noise):
        given = coefficient(problem, part)
        return replace(problem, **{part: lambda *point: np.clip(given(*point), -most, most)}), noise

    return change


def frozen(part: str, last: float) -> Change:
    """Return that a coefficient is that of a time from then on."""

    def change(problem, noise):
        given = coefficient(problem, part)
        return replace(problem, **{part: lambda t, *point: given(min(t, last), *point)}), noise

    return change


def weaker(first: int, factor: float) -> Change:
    """Return that increments from a motion on are multiplied with a factor."""

    def change(problem, noise):
        return problem, noise._replace(dW=np.where(np.arange(len(noise.dW))[:, None] < first, 1.0, factor) * noise.dW)

    return change


def weaker_of_many(most: int, factor: float) -> Change:
    """Return that all increments are multiplied with a factor where a problem has many motions."""

    def change(problem, noise):
        return problem, noise._replace(dW=(factor if problem.noise_dim > most else 1.0) * noise.dW)

    return change


def state_clipped(most: float) -> Change:
    """Return that the drift is taken at a clipped state."""

    def change(problem, noise):
        given = coefficient(problem, "drift")
        return replace(problem, drift=lambda t, x, *y: given(t, np.clip(x, -most, most), *y)), noise

    return change


def stronger_between(low: float, high: float) -> Change:
    """Return that the drift is 1 per cent too large where the first component is between two numbers."""

    def change(problem, noise):
        given = coefficient(problem, "drift")

        def drift(t, x):
            return given(t, x) * (1.0 + 0.01 * ((low < x[:1]) & (x[:1] < high)))

        return replace(problem, drift=drift), noise

    return change


def sometimes(base: Scheme, when: Callable[[int, float], bool]) -> Scheme:
    """Return a scheme whose noise is a tenth too weak in the steps with some numbers n = t/h, or at some times."""

    def step(self, problem, state, t, h, noise):
        factor = 0.9 if when(round(t / h), t) else 1.0
        return super(kind, self).step(problem, state, t, h, noise._replace(dW=factor * noise.dW))

    kind = type(f"Sometimes{type(base).__name__}", (type(base),), {"name": f"wrong-at-{base.name}", "step": step})
    return kind()


@pytest.mark.sweep(others="slow")
@pytest.mark.parametrize(
    ("base", "kind"),
    [
        (Milstein(), "scalar"),
        (EulerMaruyama(), "diagonal"),
        (SRA1(), "additive"),
        (StochasticTheta(), "index-1"),
        (BAOAB(), "langevin"),
    ],
)
@pytest.mark.parametrize(
    "when",
    [lambda n, t: n % 8 == 7, lambda n, t: 0.05 < t < 0.25, lambda n, t: 3.0 < t < 10.0],
    ids=["each eighth step", "early", "late"],
)
def test_a_step_that_is_another_one_at_some_times_is_not_verified(base, kind, when):
    """Steps are compared at random times, which have all remainders and lie in all windows that are not short."""
    rows = [row for row in orders(sometimes(base, when), kind, 2).rows if row.promise]

    assert rows
    assert {str(row.verdict) for row in rows}.isdisjoint({"verified"})


WRONG = [
    *(
        (EulerMaruyama(), clipped("drift", most), kind)
        for most in (10.0, 50.0, 3e3)
        for kind in ("scalar", "diagonal")
    ),
    (EulerMaruyama(), clipped("diffusion", 50.0), "general"),
    (Milstein(), clipped("diffusion", 10.0), "scalar"),
    (HeunAdditive(), clipped("drift", 3e3), "additive"),
    (EulerMaruyama(), state_clipped(50.0), "commutative"),
    (StochasticTheta(), state_clipped(10.0), "index-1"),
    (BAOAB(), clipped("force", 10.0), "langevin"),
    (QUICSORT(), clipped("force", 3e3), "langevin-gradient"),
    (EulerMaruyama(), frozen("drift", 1.0), "ode"),
    (EulerMaruyama(), frozen("drift", 1.0), "diagonal"),
    (EulerMaruyama(), frozen("diffusion", 20.0), "scalar"),
    (SRA1(), frozen("drift", 300.0), "additive"),
    (StochasticTheta(), frozen("drift", 1.0), "index-1-additive"),
    *(
        (EulerMaruyama(), weaker(first, 0.9), kind)
        for first in (3, 4)
        for kind in ("general", "diagonal", "additive")
    ),
    (EulerMaruyama(), weaker_of_many(3, 0.9), "general"),
    (StochasticTheta(), weaker(3, 0.9), "index-1-additive"),
    (PlatenWeak2General(), weaker(4, 0.99), "general"),
    # Drawn at random: a region and a size.
    (EulerMaruyama(), stronger_between(2.0, 3.0), "scalar"),
    (EulerMaruyama(), stronger_between(-np.inf, -1e4), "additive"),
]


@pytest.mark.sweep(others="slow")
@pytest.mark.parametrize(("base", "change", "kind"), WRONG)
def test_a_step_that_is_wrong_far_out_late_or_for_further_motions_is_not_verified(base, change, kind):
    """All conditions hold at states and times of size 1, and the claim is left to paths."""
    rows = [row for row in orders(changed(base, change), kind, 2).rows if row.promise]

    assert rows
    assert all((row.verdict, row.held) == ("inconclusive", row.of) for row in rows)
    assert all(row.premise.startswith(REASON) for row in rows)
    assert {row.verdict for row in orders(base, kind, 2).rows if row.promise} == {"verified"}


def test_a_drift_that_is_truncated_by_its_size_and_h_is_compared_at_short_steps():
    """The threshold 1/h is met far out by long steps alone."""
    for kind in ("scalar", "diagonal", "general"):
        assert probe_of(DriftTruncatedEuler(), BY_NAME[kind], BY_NAME[kind].motions or 2, 3).unlike_far_out == 0.0


def test_areas_of_all_pairs_of_five_motions_are_met():
    """A pair of motions whose area is lost is met by one of the placements, whatever pair it is."""
    for lost in range(10):
        kept = (np.arange(10) != lost)[:, None]

        def change(problem, noise, kept=kept):
            return problem, noise._replace(A=kept * noise.A if len(noise.A) == len(kept) else noise.A)

        assert probe_of(changed(MilsteinAreas(), change), BY_NAME["general"], 3, 3).unlike_far_out > 1e-3


@pytest.mark.parametrize("motions", [1, 2, 3, 4, 5])
def test_placements_are_in_order_and_meet_each_pair(motions):
    """Rows are unit vectors in ascending order; each motion and each pair is placed."""
    found = placements(motions)
    counts = sum(np.outer(placed.sum(axis=0), placed.sum(axis=0)) for placed in found)

    assert all((np.diff(placed.argmax(axis=1)) > 0).all() and (placed.sum(axis=1) == 1).all() for placed in found)
    assert (counts[~np.eye(5, dtype=bool)] >= (motions > 1)).all()
    assert (np.diag(counts) >= 1).all()


def test_a_class_without_far_equations_is_compared_near_alone():
    """Without pairs there is no distance."""
    assert distance_far(EulerMaruyama(), (), None) == 0.0
