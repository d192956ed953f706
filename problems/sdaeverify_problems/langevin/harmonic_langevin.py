"""A damped harmonic oscillator in a heat bath: underdamped Langevin dynamics with exact solution and law."""

from functools import lru_cache

import numpy as np
import scipy
from numpy.polynomial import legendre

from sdaeverify import Array, Chart, Increment, Langevin, Line, MomentEquation, Parts, hookimpl

from .. import _controls as controls
from .._arguments import check_positive
from .._known import monomials, normal_means, normal_truths, solution

SOURCE = "linear equations, Arnold 1974, section 8.3"
# Degree of the Legendre polynomials onto which the noise of a step is projected. The remainder of a smooth kernel is
# orthogonal to them, and of size h^(11/2).
DEGREE, NODES = 4, 16
PRODUCTS = {"q": (0,), "q^2": (0, 0), "q p": (0, 1), "p^2": (1, 1)}


def harmonic_langevin(
    omega: float = 1.5, gamma: float = 1.0, sigma: float = 0.8, q_0: float = 1.0, horizon: float = 1.0
) -> Langevin:
    """Langevin dynamics in a harmonic well: dq = p dt, dp = (-omega^2 q - gamma p) dt + sigma dW.

    q and p are normal at every time; their invariant variances are kT/omega^2 and kT = sigma^2/(2 gamma).

    Parameters
    ----------
    omega : float
        Frequency of the well, unit 1/time, positive.
    gamma : float
        Friction, unit 1/time, positive.
    sigma : float
        Noise amplitude, unit 1/time^(3/2), positive.
    q_0 : float
        Initial position.
    horizon : float
        Final time.

    Source
    ------
    Pavliotis (2014), Stochastic Processes and Applications, section 6.3.
    """
    check_positive(omega=omega, gamma=gamma, sigma=sigma)
    M = np.array([[0.0, 1.0], [-(omega**2), -gamma]])
    kT = sigma**2 / (2.0 * gamma)
    still = np.diag([kT / omega**2, kT])

    @lru_cache(maxsize=32)
    def step(h: float) -> tuple[Array, Array]:
        return scipy.linalg.expm(M * h), sigma * weights(M, h)

    def advance(x: Array, t: float, h: float, noise: Increment) -> Array:
        flow, of_noise = step(h)
        return flow @ x + of_noise @ np.concatenate([noise.dW, noise.H, noise.K, noise.xi])

    def law(t: float) -> tuple[Array, Array]:
        flow = scipy.linalg.expm(M * t)
        return flow @ [q_0, 0.0], still - flow @ still @ flow.T

    def parts_of(t: float, x: Array) -> Parts:
        return {"q": x[:1], "p": x[1:]}

    return Langevin(
        controls=controls.SMOOTH_LANGEVIN,
        force=lambda q: -(omega**2) * q,
        friction=gamma,
        strength=sigma,
        position=[q_0],
        momentum=[0.0],
        horizon=horizon,
        noise=frozenset({"dW", "H", "K"}),
        observables=monomials(*PRODUCTS),
        truths=(
            solution([q_0, 0.0], advance, SOURCE, parts=parts_of, extra_normals=2),
            *normal_truths(normal_means(PRODUCTS), law, (np.zeros(2), still), SOURCE),
            MomentEquation(observable="q p", source="virial theorem"),
        ),
        chart=Chart(axes=tuple(Line(0.0, float(s)) for s in np.sqrt(np.diag(still))), embed=same, read=same),
        relaxation_time=float(-1.0 / np.linalg.eigvals(M).real.max()),
        units="mass 1, time in its own unit",
        source="Pavliotis 2014, section 6.3",
    )


def same(z: Array) -> Array:
    """Return z, the identity map of the chart: coordinates are the state."""
    return z


def weights(M: Array, h: float) -> Array:
    """Return the weights of dW, H, K and two normals in int_0^h e^{M (h - s)} (0, 1)^T dW(s), shape (2, 5).

    With the Legendre polynomials P_k on the step, dW, -2 H and 12 K are int P_k dW for k = 0, 1, 2; the integrals for
    k = 3 and 4 are normal with variance h/(2k + 1), and independent of all others.
    """
    nodes, quadrature = legendre.leggauss(NODES)
    kernel = np.stack([scipy.linalg.expm(M * h * 0.5 * (1.0 - node))[:, 1] for node in nodes], axis=1)
    values = legendre.legvander(nodes, DEGREE) * (2.0 * np.arange(DEGREE + 1) + 1.0)
    projections: Array = 0.5 * (kernel * quadrature) @ values
    sizes = [np.sqrt(h / (2.0 * k + 1.0)) for k in (3, 4)]
    return projections * np.array([1.0, -2.0, 12.0, *sizes])


@hookimpl
def sdaeverify_problems() -> list[object]:
    """Register the problem."""
    return [harmonic_langevin]
