"""Langevin dynamics on an ellipse: the manifold has no symmetry that would hide a wrong metric."""

import numpy as np

from sdaeverify import Angle, Array, Chart, Control, HolonomicSDAE, InvariantMean, Line, ParameterError, hookimpl
from sdaeverify.numerics import norm

NODES = 256
OBSERVABLES = {
    "r_1": lambda t, s: s["r"][0],
    "r_1^2": lambda t, s: s["r"][0] ** 2,
    "r_2^2": lambda t, s: s["r"][1] ** 2,
    "|v|^2": lambda t, s: (s["v"] ** 2).sum(axis=0),
}
START, SPEED = 0.5, 0.5
# It keeps the constraint, which Euler's scheme for the inherent equation leaves in the long run.
HALF_EXPLICIT = "half-explicit-euler[truncation=none]"


def ellipse_langevin(
    a: float = 1.3, force: float = 0.4, gamma: float = 1.0, kT: float = 0.5, horizon: float = 0.5
) -> HolonomicSDAE:
    """Ellipse: dr = v dt, dv = (force e_1 - gamma v) dt + sqrt(2 gamma kT) dw + grad g dmu, g(r) = 0.

    With g = (r_1^2/a^2 + r_2^2 - 1)/2. The invariant law has the density ~ exp(force r_1/kT) with respect to the
    length of the ellipse, and the speed along it is normal with variance kT, independent of the position.

    Parameters
    ----------
    a : float
        Half axis in the direction of r_1, the other one being 1; between 1/2 and 2.
    force : float
        Constant force, unit length/time^2.
    gamma : float
        Friction, unit 1/time, positive.
    kT : float
        Temperature, unit length^2/time^2, positive.
    horizon : float
        Final time.
    """
    if not (0.5 <= a <= 2.0 and gamma > 0.0 and kT > 0.0):
        raise ParameterError(f"expected 1/2 <= a <= 2, gamma > 0 and kT > 0, got a={a!r}, gamma={gamma!r}, kT={kT!r}")
    axes = np.array([[a], [1.0]])
    scale, sigma = axes**-2, np.sqrt(2.0 * gamma * kT)
    means = invariant_means(a, force, kT)
    start = embedded(axes, np.array([[START], [SPEED]]))[:, 0]
    return HolonomicSDAE(
        force=lambda t, r, v: force * np.array([[1.0], [0.0]]) - gamma * v,
        diffusion=lambda t, r, v: sigma * np.eye(2)[..., None],
        constraint=lambda r: 0.5 * (scale * r * r).sum(axis=0, keepdims=True) - 0.5,
        jacobian=lambda r: (scale * r)[None],
        curvature=lambda r, y, z: (scale * y * z).sum(axis=0, keepdims=True),
        position=start[:2],
        velocity=start[2:],
        horizon=horizon,
        noise_dim=2,
        traits=frozenset({"additive-noise"}),
        observables=OBSERVABLES,
        controls=(
            Control(measure="strong", order=1.0, positive="euler-maruyama", negative="balanced-euler"),
            Control(measure="weak", order=2.0, positive="geodesic-baoab", negative="euler-maruyama"),
            Control(measure="invariant", order=2.0, positive="geodesic-baoab", negative=HALF_EXPLICIT),
        ),
        truths=tuple(InvariantMean(observable=name, value=v, source="quadrature") for name, v in means.items()),
        chart=Chart(
            axes=(Angle(), Line(0.0, np.sqrt(kT))),
            embed=lambda z: np.concatenate([embedded(axes, z), 0.0 * z[:1]]),
            read=lambda x: coordinates(axes, x),
        ),
        relaxation_time=2.0 / gamma + gamma / kT,
        units="the shorter half axis 1, time in the unit of 1/gamma",
        source="constrained Langevin dynamics as in Leimkuhler & Matthews 2016, on an ellipse",
    )


def embedded(axes: Array, z: Array) -> Array:
    """Return r and v, shape (4, P), from the angle and the speed along the ellipse."""
    theta, speed = z
    along = axes * np.stack([-np.sin(theta), np.cos(theta)])
    # Analytic, unlike a norm.
    v = speed * along / np.sqrt((along * along).sum(axis=0))
    return np.concatenate([axes * np.stack([np.cos(theta), np.sin(theta)]), v])


def coordinates(axes: Array, x: Array) -> Array:
    """Return the angle and the speed along the ellipse."""
    c, s = x[:2] / axes
    along = axes * np.stack([-s, c])
    return np.stack([np.arctan2(s, c), (x[2:4] * along).sum(axis=0) / norm(along)])


def invariant_means(a: float, force: float, kT: float) -> dict[str, float]:
    """Return the means of the observables, by the trapezoidal rule in the angle: exact up to rounding."""
    theta = 2.0 * np.pi * np.arange(NODES) / NODES
    x, y = a * np.cos(theta), np.sin(theta)
    length = np.hypot(a * np.sin(theta), np.cos(theta))
    weights = length * np.exp(force * (x - abs(a)) / kT)
    weights = weights / weights.sum()
    return {
        "r_1": float(weights @ x),
        "r_1^2": float(weights @ x**2),
        "r_2^2": float(weights @ y**2),
        "|v|^2": kT,
    }


@hookimpl
def sdaeverify_problems() -> list[object]:
    """Register the problem."""
    return [ellipse_langevin]
