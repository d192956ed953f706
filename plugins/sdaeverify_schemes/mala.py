"""The Metropolis-adjusted Langevin algorithm for one component, with an exact stationary law at every step size."""

from typing import ClassVar

import numpy as np

from sdaeverify import SDE, Array, Claim, Increment, Scheme, Step, hookimpl

BALANCE = "Roberts & Tweedie 1996, section 1.4: detailed balance"
NODES, WEIGHTS = np.polynomial.legendre.leggauss(4)


class MALA(Scheme):
    """A step y = x + h f(x) + sigma dW of Euler-Maruyama is accepted with probability min(1, exp(a)), else x stays.

    a = log[rho(y) q(y, x)] - log[rho(x) q(x, y)] with the invariant density rho and the density q of a step,

        log rho(y) - log rho(x) = (2/sigma^2) int_x^y f,    log q(x, y) = -(y - x - h f(x))^2/(2 sigma^2 h) + const.

    The integral uses 4 Gauss-Legendre nodes, exact for polynomial drifts up to degree 7. exp(a) is compared with a
    uniform variable independent of dW.
    """

    name: ClassVar[str] = "mala"
    form: ClassVar[type[SDE]] = SDE
    noise: ClassVar[frozenset[str]] = frozenset({"dW", "H"})
    discontinuous_in_noise: ClassVar[bool] = True
    claims: ClassVar[tuple[Claim, ...]] = (
        # Below the bias at h <= 1/4 of Euler-Maruyama, which rejects nothing (0.035 of x^2, 0.015 of cos x on `ou`,
        # 0.029 and 0.016 on `double-well`), and on `ou` of a proposal with a tenth too much variance (0.024, 0.0105).
        Claim(measure="invariant", value="unbiased", bound=0.08, source=BALANCE),
        Claim(measure="invariant", value="unbiased", bound=0.012, quantities=("x^2",), source=BALANCE),
        Claim(measure="invariant", value="unbiased", bound=0.005, quantities=("cos x",), source=BALANCE),
    )
    source: ClassVar[str] = "Roberts & Tweedie 1996, section 1.4"

    def refuses(self, problem: SDE) -> str:
        """Refuse problems without an invariant density that is known from the drift at one time."""
        if problem.dimension != 1 or problem.noise_dim != 1 or "additive-noise" not in problem.traits:
            return "it takes one component with additive noise"
        x = problem.initial(1)
        if not np.any(problem.diffusion(0.0, x)):
            return "without noise there is no invariant density"
        moves = np.any(problem.drift(0.0, x) != problem.drift(problem.horizon, x))
        return "the drift depends on time" if moves else ""

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the state x has shape (1, P)."""
        x = state
        y = x + h * problem.drift(t, x) + problem.diffused(t, x, noise.dW)
        accepted = np.log(noise.uniform(h)) < log_ratio(problem, t, h, x, y)
        return Step(np.where(accepted, y, x))


def log_ratio(problem: SDE, t: float, h: float, x: Array, y: Array) -> Array:
    """Return a for proposals from x to y, shape (1, P).

    Parameters
    ----------
    problem : SDE
        Gradient system with scalar noise.
    t, h : float
        Start and size of the step.
    x, y : ndarray, shape (1, P)
        Present state and proposal.
    """
    variance = problem.diffusion(t, x)[:, 0] ** 2
    back, forth = ((b - a - h * problem.drift(t, a)) ** 2 for a, b in ((y, x), (x, y)))
    return density_ratio(problem, t, x, y) + (forth - back) / (2.0 * h * variance)


def density_ratio(problem: SDE, t: float, x: Array, y: Array) -> Array:
    """Return log rho(y) - log rho(x), shape (1, P).

    Parameters
    ----------
    problem : SDE
        Gradient system with scalar noise and invariant density rho.
    t : float
    x, y : ndarray, shape (1, P)
        Present state and proposal.
    """
    middle, half = 0.5 * (x + y), 0.5 * (y - x)
    integral = sum(w * problem.drift(t, middle + z * half) for z, w in zip(NODES, WEIGHTS, strict=True)) * half
    return np.asarray(2.0 * integral / problem.diffusion(t, x)[:, 0] ** 2)


@hookimpl
def sdaeverify_schemes() -> list[Scheme]:
    """Register the scheme."""
    return [MALA()]
