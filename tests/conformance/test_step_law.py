"""Whether the law of single steps is the equation's, in every stretch of a run and whatever noise a step declares."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
import pytest

from sdaeverify import SDE, Array, Claim, Increment, Scheme, Step, verify
from sdaeverify.conformance import violation
from sdaeverify.conformance.violation import departure
from sdaeverify.contracts.matching import match
from sdaeverify.contracts.measure import Evidence
from sdaeverify.contracts.settings import Settings
from sdaeverify.contracts.tally import Tally, unpacked
from sdaeverify.measures.resolution import LAW, step_resolution
from sdaeverify.measures.strong import Strong
from sdaeverify.measures.weak import Weak
from sdaeverify.probe.local.step_law import LawResolution, step_law
from sdaeverify.registry.load import load_registry
from sdaeverify.registry.selection import select_problems, select_schemes
from sdaeverify_problems.delay_ou import delay_ou
from sdaeverify_problems.double_well import double_well
from sdaeverify_problems.gbm import gbm
from sdaeverify_problems.noncommuting import noncommuting
from sdaeverify_problems.ou import ou
from sdaeverify_schemes.euler_maruyama import EulerMaruyama
from sdaeverify_schemes.mala import MALA
from sdaeverify_schemes.milstein_areas import MilsteinAreas
from sdaeverify_schemes.stochastic_theta import StochasticTheta

CLAIMS = tuple(Claim(measure=name, value=value, source="made up") for name, value in (("strong", 0.5), ("weak", 1.0)))
# What factor the drift and the noise of a step at state x and time t have.
Factors = Callable[[Array, float], tuple[Any, Any]]


@dataclass(frozen=True)
class Factored(Scheme):
    """Euler-Maruyama with a wrong factor at drift and noise."""

    factors: Factors = lambda x, t: (1.0, 1.0)

    name: ClassVar[str] = "factored"
    form: ClassVar[type] = SDE
    claims: ClassVar = CLAIMS

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        x, (drift, strength) = state, self.factors(state, t)
        return Step(x + h * drift * problem.drift(t, x) + strength * problem.diffused(t, x, noise.dW))


@dataclass(frozen=True)
class Jumping(Factored):
    """The same, which declares that it jumps."""

    name: ClassVar[str] = "jumping"
    jumps: ClassVar[bool] = True


@dataclass(frozen=True)
class StrongNoise(EulerMaruyama):
    """Euler-Maruyama with noise that is .3 per cent too strong, and that jumps, by its own word."""

    name: ClassVar[str] = "strong-noise"
    jumps: ClassVar[bool] = True
    claims: ClassVar = CLAIMS

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        more = np.where(np.abs(state) > 0.0, 1.003, 1.0)
        return Step(state + h * problem.drift(t, state) + more * problem.diffused(t, state, noise.dW))


@dataclass(frozen=True)
class WithAreas(Factored):
    """The same, which declares that it uses areas."""

    name: ClassVar[str] = "with-areas"
    noise: ClassVar = frozenset({"dW", "A"})


@dataclass(frozen=True)
class WindowedTheta(StochasticTheta):
    """The theta method with noise that is a little too strong for some of the time."""

    begin: float = 0.0
    end: float = 0.0

    name: ClassVar[str] = "windowed-theta"

    def step(self, problem: Any, state: Any, t: float, h: float, noise: Increment) -> Step:
        factor = 1.01 if self.begin < t < self.end else 1.0
        return super().step(problem, state, t, h, noise._replace(dW=factor * noise.dW))


@dataclass(frozen=True)
class SignOnly(EulerMaruyama):
    """Euler-Maruyama that is driven by sqrt(h) times the sign of the increment: right in law."""

    name: ClassVar[str] = "sign-only"
    jumps: ClassVar[bool] = True

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        return super().step(problem, state, t, h, noise._replace(dW=np.sqrt(h) * np.sign(noise.dW)))


def chain(l: int, horizon: float = 1.0) -> SDE:
    """Return dx_i = (x_(i-1) - x_i) dt + sum of two neighbours' noise, with as many motions as components."""

    def diffusion(t: float, x: Array) -> Array:
        B = np.zeros((l, l, x.shape[-1]))
        B[range(l), range(l)] = 0.3 * x
        B[range(l), np.roll(range(l), 1)] = 0.1 * np.roll(x, 2, axis=0)
        return B

    return SDE(
        drift=lambda t, x: np.roll(x, 1, axis=0) - 1.5 * x,
        diffusion=diffusion,
        start=np.linspace(1.0, 2.0, l),
        noise_dim=l,
        horizon=horizon,
        source="made up",
    )


WINDOWS: dict[str, tuple[Any, Factors]] = {
    "two thirds of a long run": (gbm(horizon=16.0), lambda x, t: (1.0 - 0.02 * (1.0 < t < 11.7), 1.0)),
    "of another": (ou(horizon=16.0), lambda x, t: (1.0, 1.0 + 0.02 * (4.5 < t < 15.2))),
    "before the first time that was probed": (double_well(), lambda x, t: (1.0, 1.0 - 0.01 * (t < 0.06))),
    "short and early": (gbm(), lambda x, t: (1.0 - 0.5 * (0.02 < t < 0.06), 1.0)),
    "short and in the middle": (gbm(), lambda x, t: (1.0, 1.0 + 1e-3 * (0.51 < t < 0.58))),
    "the last part": (ou(), lambda x, t: (1.0 + 1e-2 * (t > 0.96 * ou().horizon), 1.0)),
    "a far region": (double_well(), lambda x, t: (1.0, np.where(np.abs(x) > 1.5, 0.99, 1.0))),
}


@pytest.mark.parametrize("name", WINDOWS)
def test_every_stretch_of_the_run_is_probed(name: str) -> None:
    """A drift or noise that is wrong for some of the time is told, with a time at which it is."""
    problem, factors = WINDOWS[name]
    text = departure(Factored(factors), problem)
    assert "a short step from [" in text
    assert "at t = " in text


@pytest.mark.parametrize("kind", [Factored, Jumping, WithAreas])
@pytest.mark.parametrize(("drift", "noise"), [(0.98, 1.0), (1.0, 1.003), (1.0, 1.0003), (0.999, 1.0)])
def test_what_is_declared_turns_no_comparison_off(kind: type[Factored], drift: float, noise: float) -> None:
    """Factors beside 1 are told of steps that say that they jump or use areas, as of any other."""
    assert departure(kind(lambda x, t: (drift, noise)), noncommuting())
    assert not departure(kind(), noncommuting())


def test_a_wrong_step_that_declares_jumps_is_refuted_with_all_its_claims() -> None:
    """Noise at 1.003 of its size was verified, because nodes were not asked."""
    table = verify(StrongNoise(), "gbm", ["strong", "weak"], paths=256, levels="8..32")
    claimed = table.verdicts[table.verdicts.scheme == StrongNoise.name]
    assert set(claimed.verdict) == {"refuted"}


@pytest.mark.parametrize(("l", "drift"), [(5, 0.997), (12, 0.997), (24, 0.999)])
def test_many_motions_resolve_means(l: int, drift: float) -> None:
    """A drift that is a little too small is told with 5, 12 and 24 motions, and a right one is not."""
    assert "in its drift" in departure(Factored(lambda x, t: (drift, 1.0)), chain(l))
    assert not departure(Factored(), chain(l))


def test_a_step_that_jumps_rightly_is_let_pass() -> None:
    """What is rejected by fewer and fewer steps is no error of the limit."""
    assert not departure(MALA(), double_well())
    law = step_law(MALA(), double_well())
    assert law is not None
    assert law.points > 500
    assert law.rate_error < 1e-3


def test_a_step_for_which_nodes_are_no_rule_is_let_pass() -> None:
    """Signs of the increments have variance 1, and not so at nodes one of which is 0: two rules do not agree."""
    assert not departure(SignOnly(), gbm())


def test_resolution_is_above_what_was_not_seen() -> None:
    """An error below what is asked of is larger than none, and no larger than the resolution that is told."""
    for size in (1e-5, 3e-5):
        law = step_law(Factored(lambda x, t, size=size: (1.0, 1.0 + size)), gbm())
        assert law is not None
        assert not law.departure
        assert size <= law.rate_error * 1.01 + 1e-12


def test_no_shipped_scheme_departs_where_it_claims_to_follow() -> None:
    """Tamed, balanced, truncated, implicit, uniformly accurate and rejecting steps follow it in the limit."""
    registry = load_registry()
    names = ["double-well", "gbm-heavy", "exponential-strip", "pendulum", "levy-area", "harmonic-langevin"]
    problems = [spec.build() for spec in select_problems(registry, names)]
    pairs = [(s, match(s, p).problem) for p in problems for s in select_schemes(registry, ["*"]) if s.claims]
    with np.errstate(all="ignore"):
        assert not [text for scheme, view in pairs if view is not None and (text := violation(scheme, view))]


def test_areas_are_given_to_steps_that_use_them() -> None:
    """Milstein's scheme with areas follows the equation."""
    law = step_law(MilsteinAreas(), noncommuting())
    assert law is not None
    assert not law.departure


def test_a_delay_is_probed_up_to_its_end_and_beyond() -> None:
    """Noise that is wrong while lagged values are the history's, or for a while after, is told."""
    problem = delay_ou()
    for begin, end in ((0.3, 0.4), (0.6, 0.65)):
        window = (begin * problem.horizon, end * problem.horizon)
        view = match(WindowedTheta(begin=window[0], end=window[1]), problem).problem
        assert view is not None
        assert "at t = " in departure(WindowedTheta(begin=window[0], end=window[1]), view)
        assert not departure(WindowedTheta(), view)


def test_resolution_is_evidence_of_strong_and_weak_cells() -> None:
    """Whoever judges can ask at how many times steps were compared, and how sharply: no gap is larger than that."""
    scheme, problem = EulerMaruyama(), gbm()
    for measure in (Strong(), Weak()):
        tally = measure.probe(scheme, problem, Settings())
        found = unpacked(LAW, LawResolution, tally)
        assert found is not None
        law = step_law(scheme, problem)
        assert law is not None
        gaps = np.diff([0.0, *np.unique(law.t), problem.horizon])
        assert found.times == 32
        assert 0.0 < found.rate_error < 1e-4
        resolution = step_resolution(Evidence(scheme, problem, problem, Settings(), tally, Tally()))
        assert gaps.max() < resolution < 0.15
