"""Problems on charts and schemes for them, for the tests of transition operators, all written by hand."""

from dataclasses import replace
from typing import ClassVar

import numpy as np
from scipy.special import ive

from sdaeverify import SDE, Angle, Chart, HolonomicSDAE, InvariantMean, Line, Moment, Scheme, Step
from sdaeverify.numerics import apply

GAMMA, SIGMA = 0.5, 0.7
KT = SIGMA**2 / (2 * GAMMA)


def means(**values):
    """Return invariant means."""
    return tuple(InvariantMean(observable=name, value=value, source="test") for name, value in values.items())


def identity(*axes):
    """Return the chart of a problem whose components are the coordinates."""
    return Chart(axes, lambda z: z, lambda x: x)


OU = SDE(
    drift=lambda t, x: -x,
    diffusion=lambda t, x: np.full((1, 1, 1), SIGMA),
    start=[1.0],
    horizon=1.0,
    noise_dim=1,
    source="test",
    observables={"x": lambda t, s: s["x"][0], "square": lambda t, s: s["x"][0] ** 2},
    truths=means(square=0.5 * SIGMA**2),
    chart=identity(Line(0.0, SIGMA)),
    relaxation_time=1.0,
)
ANGLE = SDE(
    drift=lambda t, x: np.stack([x[1], -np.sin(x[0]) - GAMMA * x[1]]),
    diffusion=lambda t, x: np.array([[[0.0]], [[SIGMA]]]),
    start=[1.0, 0.0],
    names={"q": slice(0, 1), "p": slice(1, 2)},
    horizon=1.0,
    noise_dim=1,
    source="test",
    observables={
        "cosine": lambda t, s: np.cos(s["q"][0]),
        "p": lambda t, s: s["p"][0],
        "square": lambda t, s: s["p"][0] ** 2,
        "q": lambda t, s: s["q"][0],
    },
    truths=means(cosine=float(ive(1, 1 / KT) / ive(0, 1 / KT)), p=0.0, square=KT),
    chart=identity(Angle(), Line(0.0, np.sqrt(KT))),
    relaxation_time=4.0,
)


class Euler(Scheme):
    """x+ = x + f h + B dW."""

    name: ClassVar[str] = "euler"
    form: ClassVar[type[SDE]] = SDE

    def step(self, problem, x, t, h, noise):
        return Step(x + h * problem.drift(t, x) + apply(problem.diffusion(t, x), noise.dW))


class AdditiveHeun(Scheme):
    """x+ = x + (h/2) [f(x) + f(x + h f + B dW)] + B dW."""

    name: ClassVar[str] = "additive-heun"
    form: ClassVar[type[SDE]] = SDE

    def step(self, problem, x, t, h, noise):
        kick, f = apply(problem.diffusion(t, x), noise.dW), problem.drift(t, x)
        return Step(x + 0.5 * h * (f + problem.drift(t, x + h * f + kick)) + kick)


class Splitting(Scheme):
    """BAOAB for `ANGLE`."""

    name: ClassVar[str] = "splitting"
    form: ClassVar[type[SDE]] = SDE

    def step(self, problem, x, t, h, noise):
        q, p = x
        c = np.exp(-GAMMA * h)
        p = p - 0.5 * h * np.sin(q)
        middle = c * p + np.sqrt(KT * (1 - c * c) / h) * noise.dW[0]
        q = q + 0.5 * h * (p + middle)
        return Step(np.stack([q, middle - 0.5 * h * np.sin(q)]))


# ---------------------------------------------------------------- the circle in the plane, velocity included


def normal(theta):
    return np.stack([np.sin(theta), -np.cos(theta)])


def tangent(theta):
    return np.stack([np.cos(theta), np.sin(theta)])


def embed(z):
    return np.concatenate([normal(z[0]), z[1] * tangent(z[0]), 0.0 * z[:1]])


def read(x):
    return np.stack([np.arctan2(x[0], -x[1]), x[0] * x[3] - x[1] * x[2]])


OBSERVABLES = {
    "r_2": lambda t, s: s["r"][1],
    "v_1": lambda t, s: s["v"][0],
    "v_2": lambda t, s: s["v"][1],
    "r_1^2": lambda t, s: s["r"][0] ** 2,
    "|v|^2": lambda t, s: (s["v"] ** 2).sum(axis=0),
    "mu": lambda t, s: s["mu"][0],
}


def plane_pendulum(c_g=0.0, gamma=0.0, sigma=1.0, theta_0=0.5, scale=1.0, noises=1):
    """Return the pendulum in the plane from angular velocity 1/2; T = 1/2, invariant means if there is friction.

    Its noise is tangential, or isotropic if there are two; (r, v) has the same law.
    """
    isotropic = sigma * np.eye(2)[..., None]
    pendulum = HolonomicSDAE(
        force=lambda t, r, v: np.array([[0.0], [-c_g]]) - gamma * v,
        diffusion=lambda t, r, v: isotropic if noises == 2 else sigma * np.stack([-r[1], r[0]])[:, None],
        constraint=lambda r: 0.5 * (1.0 - r[0] * r[0] - r[1] * r[1])[None],
        jacobian=lambda r: -r[None],
        curvature=lambda r, y, z: -(y[0] * z[0] + y[1] * z[1])[None],
        constraint_bound=1.0 / 0.99**2,
        position=normal(theta_0),
        velocity=0.5 * tangent(theta_0),
        horizon=0.5,
        noise_dim=noises,
        source="test",
        observables=OBSERVABLES,
        chart=Chart((Angle(), Line(0.0, scale)), embed, read),
    )
    return replace(pendulum, truths=_limits(c_g, sigma**2 / (2 * gamma)), relaxation_time=3.0) if gamma else pendulum


def free_moments(t, theta_0=0.5, omega_0=0.5):
    """Return E r_2, E v_1, E v_2, E |v|^2 and E r_1^2 without gravity and friction, sigma = 1: theta is Gaussian."""
    size, m = np.exp(-(t**3) / 6), theta_0 + omega_0 * t
    r, v = size * normal(m), size * (omega_0 * tangent(m) - 0.5 * t**2 * normal(m))
    square = 0.5 * (1.0 - np.cos(2.0 * m) * size**4)
    names = ("r_2", "v_1", "v_2", "|v|^2", "r_1^2")
    return {name: float(value) for name, value in zip(names, (r[1], *v, omega_0**2 + t, square), strict=True)}


def with_moments(pendulum, theta_0):
    """Return a pendulum that knows its moments."""
    values = {name: (lambda t, name=name: free_moments(t, theta_0)[name]) for name in free_moments(0.0)}
    moments = (Moment(observable=name, value=value, source="test") for name, value in values.items())
    return replace(pendulum, truths=tuple(moments))


def _limits(c_g, kT):
    I = ive([0, 1, 2], c_g / kT)
    values = {"r_2": -I[1] / I[0], "r_1^2": 0.5 * (1.0 - I[2] / I[0]), "|v|^2": kT}
    return tuple(InvariantMean(observable=name, value=float(value), source="test") for name, value in values.items())
