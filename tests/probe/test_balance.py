"""Detailed balance of steps that accept or reject a proposal, found from the step alone."""

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
import pytest

from facade import balance, say_imbalance, why_not_balanced
from sdaeverify import SDE, Array, Claim, Increment, InvariantMean, Scheme, Step, verify

CLAIM = Claim(measure="invariant", value="unbiased", bound=0.01, source="Hastings 1970")
SIZES = [0.25, 0.125, 0.0625]


@dataclass(frozen=True)
class Metropolis(Scheme):
    """Proposals of Euler-Maruyama, accepted with probability min(1, exp(r)).

    r has the weights ``density`` of log rho(y) - log rho(x), ``shift`` and ``square`` of the two parts of
    log q(y, x) - log q(x, y). With `flaw` it takes each proposal (``all``), decides from 1 - u (``upper``), moves a
    rejected state (``moved``), accepts 1 per cent too often from states beyond 1 (``far``), or each proposal beyond
    2.5 standard deviations (``rare``).
    """

    density: float = 1.0
    shift: float = 1.0
    square: float = 1.0
    flaw: str = ""

    name: ClassVar[str] = "metropolis"
    form: ClassVar[type[SDE]] = SDE
    noise: ClassVar[frozenset[str]] = frozenset({"dW", "H"})
    discontinuous_in_noise: ClassVar[bool] = True
    claims: ClassVar[tuple[Claim, ...]] = (CLAIM,)

    def refuses(self, problem: SDE) -> str:
        moving = np.any(problem.drift(0.0, problem.initial(1)) != problem.drift(problem.horizon, problem.initial(1)))
        still = not np.any(problem.diffusion(0.0, problem.initial(1)))
        return "no invariant density" if moving or still or "additive-noise" not in problem.traits else ""

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        x, f = state, problem.drift
        y = x + h * f(t, x) + problem.diffused(t, x, noise.dW)
        variance = h * problem.diffusion(t, x)[0, 0] ** 2
        shift = h * ((y - x) * (f(t, x) + f(t, y))).sum(axis=0) / variance
        square = h**2 * (f(t, x) ** 2 - f(t, y) ** 2).sum(axis=0) / (2.0 * variance)
        ratio = self.density * log_density_ratio(problem, t, x, y) - self.shift * shift + self.square * square
        if self.flaw == "far":
            ratio = ratio + 0.01 * (np.abs(x) > 1.0).any(axis=0)
        u = noise.uniform(h)[0]
        accepted = np.log(1.0 - u if self.flaw == "upper" else u) < ratio
        if self.flaw == "all":
            accepted = np.ones_like(accepted)
        if self.flaw == "rare":
            accepted = accepted | (np.abs(noise.dW) > 2.5 * np.sqrt(h)).any(axis=0)
        return Step(np.where(accepted, y, x + 1e-3 if self.flaw == "moved" else x))


def log_density_ratio(problem: SDE, t: float, x: Array, y: Array) -> Array:
    """Return log rho(y) - log rho(x) = (2/sigma^2) int_x^y f, exact for drifts up to degree 7."""
    nodes, weights = np.polynomial.legendre.leggauss(4)
    drift = sum(w * problem.drift(t, x + 0.5 * (1.0 + z) * (y - x)) for z, w in zip(nodes, weights, strict=True))
    return np.asarray(((y - x) * drift).sum(axis=0) / problem.diffusion(t, x)[0, 0] ** 2)


def wells(dimension: int = 1) -> SDE:
    """Return independent double wells with unit noise."""
    z = np.linspace(-6.0, 6.0, 4001)
    weights = np.exp(-2.0 * (z**4 / 4.0 - z**2 / 2.0))
    return SDE(
        drift=lambda t, x: x - x**3,
        diffusion=lambda t, x: np.eye(dimension)[..., None],
        start=[0.5] * dimension,
        noise_dim=dimension,
        horizon=1.0,
        traits=frozenset({"additive-noise", "overdamped-gradient"}),
        observables={"x^2": lambda t, s: s["x"][0] ** 2},
        truths=(InvariantMean(observable="x^2", value=float(weights @ z**2 / weights.sum()), source="quadrature"),),
        relaxation_time=2.0,
        source="made up",
    )


@pytest.mark.sweep
@pytest.mark.parametrize("dimension", [1, 3])
@pytest.mark.parametrize("flaw", ["", "upper"])
def test_detailed_balance_holds_to_rounding(dimension: int, flaw: str) -> None:
    """Both sides of the Metropolis-adjusted Langevin algorithm are equal to rounding at all pairs."""
    found = balance(Metropolis(flaw=flaw), wells(dimension), SIZES)
    # An acceptance near 0 is known to rounding errors of numbers near 1.
    known = found.seen & (np.minimum(found.forth, found.back) > 1e-6)
    assert found.seen.mean() > 0.9
    assert np.abs(found.defect[known]).max() < 1e-9
    assert found.holds


@pytest.mark.sweep
@pytest.mark.parametrize(
    ("scheme", "words"),
    [
        (Metropolis(1.0, 0.0, 0.0), "lacks the densities of the proposals"),
        (Metropolis(0.0, 1.0, 1.0), "lacks the invariant density"),
        (Metropolis(1.0, -1.0, -1.0), "has the densities of the forward and the reverse proposal exchanged"),
        (Metropolis(-1.0, 1.0, 1.0), "has the invariant densities of the current and the proposed state exchanged"),
        (Metropolis(-1.0, -1.0, -1.0), "has its ratio upside down"),
        (Metropolis(1.0, 1.0, -1.0), "evaluates the drift in the density of each proposal at the wrong state"),
        (Metropolis(0.5, 1.0, 1.0), "has the invariant density to the power 0.5"),
        (Metropolis(1.0, 0.5, 1.0), "of 2 times its drift and 4 times its variance"),
        (Metropolis(flaw="all"), "each proposal is accepted"),
        (Metropolis(1.0, 1.0, 1.01), "of 1.01 times its drift and 1.01 times its variance"),
        (Metropolis(flaw="far"), "the acceptance is off by a factor of up to 1.01"),
    ],
)
def test_a_wrong_acceptance_is_named(scheme: Metropolis, words: str) -> None:
    """Weights of the ratio are found from acceptances, and the sentence names the mistake alone."""
    found = balance(scheme, wells(), SIZES)
    assert not found.holds
    assert say_imbalance(found).endswith(words)


@pytest.mark.parametrize("dimension", [1, 3])
def test_proposals_that_are_rare_are_looked_at(dimension: int) -> None:
    """One of 80 proposals of one component is beyond 2.5 standard deviations, and each of these is accepted."""
    assert not balance(Metropolis(flaw="rare"), wells(dimension), SIZES).holds


def test_a_step_that_does_not_stay_is_not_probed() -> None:
    """A rejected state that moves is another proposal: nothing is said."""
    assert balance(Metropolis(flaw="moved"), wells(), SIZES) is None


def test_without_a_density_nothing_is_probed() -> None:
    """Two components whose drift is no gradient have no density that the drift tells."""
    problem = wells(2)
    turning = replace(problem, traits=frozenset({"additive-noise"}))
    assert why_not_balanced(Metropolis(), turning) == "no invariant density is known from the drift"
    assert why_not_balanced(Metropolis(), problem) == ""


@pytest.mark.long
@pytest.mark.parametrize(
    ("scheme", "verdict"),
    [
        (Metropolis(), "verified"),
        (Metropolis(1.0, 0.0, 0.0), "refuted"),
        pytest.param(Metropolis(flaw="all"), "refuted", marks=pytest.mark.slow),
    ],
)
def test_balance_decides_what_is_unbiased(scheme: Metropolis, verdict: str) -> None:
    """Detailed balance verifies; where it fails chains refute, and the reason has the mistake."""
    result = verify([scheme], [wells], ["invariant"], seed=1)
    rows = result.verdicts[result.verdicts.claim.notna()]
    assert set(rows.verdict) == {verdict}
    assert rows.reason.str.contains("etailed balance").all()
