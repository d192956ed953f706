"""Stationary biases whose order falls on fine steps: h^2 on the coarse ones, h in the limit."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import pytest

import stationary_cells
from facade import CHAINS, GROUPS, ChainRecord, Invariant, double_well, ou, slowest_fall
from sdaeverify import SDE, Array, Increment, Settings, Step
from sdaeverify.measuring import Evidence, Tally, Verdict, packed
from sdaeverify.numerics import apply

FAR = 99.0
H = 0.25 / 2.0 ** np.arange(4)


@dataclass(frozen=True)
class HeunInStrip(stationary_cells.Euler):
    """Heun's scheme for additive noise between two states, Euler-Maruyama elsewhere: of order 1."""

    order: float = 2.0
    low: float = -FAR
    high: float = FAR

    name: ClassVar[str] = "heun-in-strip"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        f, BdW = problem.drift(t, state), apply(problem.diffusion(t, state), noise.dW)
        euler = state + h * f + BdW
        heun = state + 0.5 * h * (f + problem.drift(t + h, euler)) + BdW
        return Step(np.where((self.low <= state[0]) & (state[0] <= self.high), heun, euler))


def verdicts(scheme, problem):
    """Return the verdicts by observable, of the transition operator and of chains where it leaves claims open."""
    settings = Settings()
    tally = Invariant().probe(scheme, problem, settings)
    evidence = Evidence(scheme, problem, problem, settings, tally, Tally(), level=settings.level)
    return {found.quantity: found.verdict for found in Invariant().judge(evidence).findings}


@pytest.mark.sweep(others="slow")
@pytest.mark.long
@pytest.mark.parametrize(
    ("problem", "strip"),
    [
        (double_well, {"high": 1.8}),
        (double_well, {"high": 1.7}),
        (double_well, {"high": 1.2}),
        (double_well, {"low": -1.9, "high": 1.8}),
        (double_well, {"low": -1.6}),
        (double_well, {"low": -1.6, "high": 1.6}),
        (ou, {"high": 1.2}),
        (ou, {"low": -1.6, "high": 1.6}),
        (stationary_cells.double_well, {"high": 1.8}),
        (stationary_cells.double_well, {"low": -1.9, "high": 1.8}),
    ],
)
def test_an_order_that_falls_is_not_verified(problem, strip):
    """Heun's scheme in a part of the states shows order 2 on coarse steps alone: no observable is verified."""
    assert Verdict.VERIFIED not in verdicts(HeunInStrip(**strip), problem()).values()


@pytest.mark.sweep(others="slow")
@pytest.mark.long
@pytest.mark.parametrize("problem", [double_well, ou, stationary_cells.double_well])
def test_an_order_that_stays_is_verified(problem):
    """Heun's scheme at all states has two observables of order 2, with and without a chart."""
    found = verdicts(HeunInStrip(), problem())

    assert sum(verdict is Verdict.VERIFIED for verdict in found.values()) >= 2
    assert Verdict.REFUTED not in found.values()


def judged(bias):
    """Return the finding of order 2 on x^2 from chains whose means have a bias and next to no noise."""
    problem, rng = stationary_cells.ou(), np.random.default_rng(1)
    exact = np.array([truth.value for truth in problem.truths])
    spread = 1e-5 * rng.normal(size=(1, GROUPS, 1, 3)) + 1e-7 * rng.normal(size=(1, GROUPS, 4, 3))
    levels = exact + bias(H)[:, None] + spread
    counts = dict.fromkeys(("lost", "failed", "truncated"), np.zeros(4))
    scalars = {"planned": 6.0, "paired": 1024.0, "chains": 8192.0, "burn_in": 10.0, "stationary": 1.0}
    record = ChainRecord(
        h=H,
        levels=levels,
        wide=levels[:, :, 0],
        time=np.array([10.0]),
        contraction=1e-6,
        diverged=np.nan,
        **counts,
        **scalars,
    )
    scheme, settings = stationary_cells.Euler(order=2.0), Settings()
    evidence = Evidence(scheme, problem, problem, settings, packed(CHAINS, record), Tally(), level=settings.level)
    return {found.quantity: found for found in Invariant().judge(evidence).findings}["x^2"]


@pytest.mark.parametrize(("share", "verdict"), [(0.0, Verdict.VERIFIED), (0.005, Verdict.INCONCLUSIVE)])
def test_chains_need_the_order_at_the_finest_step_sizes(share, verdict):
    """Biases share h + 0.2 h^2: with local orders 1.91 and 1.84 the next one is below 1.8, and the mean is not."""
    found = judged(lambda h: share * h + 0.2 * h**2)

    assert found.low > 1.8
    assert found.verdict is verdict


@pytest.mark.parametrize(
    ("errors", "most"),
    [
        (H**2, 2.0),
        (0.2 * H**2 + 0.1 * H, np.log2(0.2 * H**2 + 0.1 * H)[2] - np.log2(0.2 * H**2 + 0.1 * H)[3]),
        # Local orders that rise: each pair of neighbours alone counts, the coarsest has the least.
        (H / (1.0 + 4.0 * H), np.log2(H / (1.0 + 4.0 * H))[0] - np.log2(H / (1.0 + 4.0 * H))[1]),
        (H * [1.0, 1.0, -1.0, -1.0], 1.0),
    ],
)
def test_the_slowest_fall_is_the_least_order_of_two_step_sizes(errors, most):
    """Without floors it is a local order; pairs across a change of sign do not count."""
    assert slowest_fall(H, errors, np.zeros(4)).most == pytest.approx(most)


def test_floors_widen_the_slowest_fall():
    """Errors h^2 with equal floors fall like log2 (e_0 + f)/(e_1 - f) at most, where floors matter least."""
    errors, floors = H**2, np.full(4, 0.1 * H[-1] ** 2)
    found = slowest_fall(H, errors, floors)

    assert found.most == pytest.approx(np.log2((H[0] ** 2 + floors[0]) / (H[1] ** 2 - floors[1])))
    assert (found.coarse, found.fine) == (H[0], H[1])


def test_errors_below_their_floors_bound_no_fall():
    """Where no two errors are known there is no bound."""
    assert slowest_fall(H, H**2, np.full(4, 0.02)).most == np.inf
