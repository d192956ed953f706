"""A driven double pendulum in a fluid, which combines all features of constrained mechanics."""

import numpy as np

from sdaeverify import Array, HolonomicSDAE, Parts, hookimpl, in_matrix

from .._brief import VARIANTS

# Mass matrix of both bodies with the added mass of the surrounding fluid, which couples them.
MASS = np.kron([[1.5, 0.4], [0.4, 1.0]], np.eye(2))
START = np.array([0.6, -0.8, 1.4, -1.4])
VELOCITY = np.array([0.4, 0.3, 0.1, -0.1])


@in_matrix({}, schemes=VARIANTS, measures=("drift", "weak"))
def driven_double_pendulum(
    gamma: float = 0.5, sigma: float = 0.5, drive: float = 2.0, omega: float = 5.0, horizon: float = 0.25
) -> HolonomicSDAE:
    """Double pendulum: M dv = (-c - gamma v + drive cos(omega t) e_1) dt + B(r, v) dw + grad g dmu, dr = v dt.

    The rods have length 1, and c is the weight. The mass matrix M is full, both constraints are curved and depend on
    the position of the upper body, and both noises depend on the state: B = sigma [e_1 + v/2, (1 + sin(r_1)/2) e_3].

    Parameters
    ----------
    gamma : float
        Friction, unit mass/time.
    sigma : float
        Noise amplitude, unit mass length/time^(3/2).
    drive : float
        Amplitude of the force on the upper body, unit mass length/time^2.
    omega : float
        Frequency of the force, unit 1/time.
    horizon : float
        Final time.

    Source
    ------
    Lindner & Stroot (2017), (2.1), with coefficients in whose equations no term vanishes.
    """
    weight = np.array([0.0, 1.5, 0.0, 1.0])[:, None]

    def force(t: float, r: Array, v: Array) -> Array:
        pushed = np.zeros_like(v)
        pushed[0] = drive * np.cos(omega * t)
        return np.asarray(pushed - weight - gamma * v)

    def diffusion(t: float, r: Array, v: Array) -> Array:
        rows = 0.0 * r
        upper, lower = 0.5 * v + np.eye(4)[:, :1], rows + np.eye(4)[:, 2:3] * (1.0 + 0.5 * np.sin(r[0]))
        return np.asarray(sigma * np.stack([upper, lower], axis=1))

    return HolonomicSDAE(
        force=force,
        diffusion=diffusion,
        constraint=lambda r: 0.5 * (1.0 - np.stack([_dot(r[:2], r[:2]), _dot(r[2:] - r[:2], r[2:] - r[:2])])),
        jacobian=_jacobian,
        curvature=lambda r, y, z: -np.stack([_dot(y[:2], z[:2]), _dot(y[2:] - y[:2], z[2:] - z[:2])]),
        mass=MASS,
        position=START,
        velocity=VELOCITY,
        noise_dim=2,
        horizon=horizon,
        observables={
            "r_3": lambda t, s: s["r"][2],
            "r_2 r_4": lambda t, s: s["r"][1] * s["r"][3],
            "v^T M v": _energy,
        },
        units="rods of length 1, weight of the lower body 1",
        source="Lindner & Stroot 2017, (2.1), for two rods",
    )


def _dot(y: Array, z: Array) -> Array:
    return np.asarray((y * z).sum(axis=0))


def _jacobian(r: Array) -> Array:
    rod, none = r[2:] - r[:2], 0.0 * r[:2]
    return np.stack([np.concatenate([-r[:2], none]), np.concatenate([rod, -rod])])


def _energy(t: float, s: Parts) -> Array:
    return np.asarray(np.einsum("ip,ij,jp->p", s["v"], MASS, s["v"]))


@hookimpl
def sdaeverify_problems() -> list[object]:
    """Register the problem."""
    return [driven_double_pendulum]
