r"""
Slider-crank
============

A crank of length 1 turns about the origin; a rod of length b joins its end (x_1, y_1) with a slider at (x_2, 0) that
a noisy load pushes. In these coordinates the equations are simple, with two holonomic constraints:

.. math::

    g = ( (1 - x_{1}^{2} - y_{1}^{2})/2, \qquad (b^{2} - (x_{2} - x_{1})^{2} - y_{1}^{2})/2 ) = 0

With the angle of the crank as coordinate there is no constraint, but there are forces of inertia. The schemes solve
the first form. The second form, derived with Lagrange's equations and solved with strong order 3/2, is the truth with
which they are compared.
"""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from matplotlib import pyplot as plt

from sdaeverify import Claim, HolonomicSDAE, Pathwise, sample, verify
from sdaeverify_schemes.projections.half_explicit_euler import HalfExplicitEuler

b, GRAVITY, SIGMA, PHI, OMEGA = 2.0, 1.0, 0.5, 0.7, 1.0
MASS = np.array([1.0, 1.0, 2.0])


def position(p):
    """Return (x_1, y_1, x_2) of angles, shape (3, P)."""
    return np.stack([np.cos(p), np.sin(p), np.cos(p) + np.sqrt(b**2 - np.sin(p) ** 2)])


def tangent(p):
    """Return the derivative J of the position."""
    s = np.sqrt(b**2 - np.sin(p) ** 2)
    return np.stack([-np.sin(p), np.cos(p), -np.sin(p) - np.sin(p) * np.cos(p) / s])


def bent(p):
    """Return the derivative of J."""
    s, product = np.sqrt(b**2 - np.sin(p) ** 2), np.sin(p) * np.cos(p)
    return np.stack([-np.cos(p), -np.sin(p), -np.cos(p) - np.cos(2.0 * p) / s - product**2 / s**3])


# %%
# Lagrange's equations: m(phi) = J^T M J, and domega = f(phi, omega) dt + c(phi) dW.


def inertia(p):
    """Return m."""
    return (MASS[:, None] * tangent(p) ** 2).sum(axis=0)


def f(p, w):
    """Return the acceleration of the angle."""
    J = tangent(p)
    return (-GRAVITY * MASS[1] * J[1] - (MASS[:, None] * J * bent(p)).sum(axis=0) * w**2) / inertia(p)


def c(p):
    """Return how the noise of the slider turns the crank."""
    return SIGMA * tangent(p)[2] / inertia(p)


def taylor(z, t, h, noise, e=1e-30):
    """Make an Ito-Taylor step of strong order 3/2 of (phi, omega); derivatives by complex step."""
    p, w = z
    dW, Z = noise.dW[0], noise.time_integral(h)[0]
    f_p, f_w, c_p = f(p + 1j * e, w).imag / e, f(p, w + 1j * e).imag / e, c(p + 1j * e).imag / e
    f_ww = f_w / w
    second = 0.5 * h**2 * (f_p * w + f_w * f(p, w) + 0.5 * f_ww * c(p) ** 2)
    new = w + h * f(p, w) + c(p) * dW + f_w * c(p) * Z + c_p * w * (h * dW - Z) + second
    return np.stack([p + h * w + 0.5 * h**2 * f(p, w) + c(p) * Z, new])


def slider_crank(horizon: float = 0.5) -> HolonomicSDAE:
    """Crank, rod and slider: masses 1 and 2, gravity on the crank's end, noise on the slider."""
    start = np.array([PHI])
    truth = Pathwise(
        start=lambda paths: np.repeat([[PHI], [OMEGA]], paths, axis=1),
        advance=taylor,
        parts=lambda t, z: {"r": position(z[0]), "v": tangent(z[0]) * z[1]},
        order=1.5,
        source="Lagrange's equations in the angle",
    )
    return HolonomicSDAE(
        force=lambda t, r, v: np.array([[0.0], [-GRAVITY * MASS[1]], [0.0]]),
        diffusion=lambda t, r, v: np.array([[[0.0]], [[0.0]], [[SIGMA]]]),
        constraint=lambda r: 0.5 * np.stack([1.0 - r[0] ** 2 - r[1] ** 2, b**2 - (r[2] - r[0]) ** 2 - r[1] ** 2]),
        mass=np.diag(MASS),
        position=position(start)[:, 0],
        velocity=(OMEGA * tangent(start))[:, 0],
        noise_dim=1,
        horizon=horizon,
        traits=frozenset({"additive-noise"}),
        truths=(truth,),
        source="Lagrange's equations of the first kind",
    )


paths = sample("half-explicit-euler[truncation=none]", slider_crank, steps=256, paths=20)
figure, axes = plt.subplots(1, 2, figsize=(8, 3), layout="constrained")
paths.plot("r", 2, ax=axes[0]).set(title="slider", ylabel="x_2")
axes[1].plot(paths["r"][:, 0], paths["r"][:, 1], lw=0.8)
axes[1].set(title="end of the crank", xlabel="x_1", ylabel="y_1", aspect="equal")

# %%
# The half-explicit scheme has strong order 1 here, and keeps both constraints to round-off. A copy of the
# scheme that claims order 3/2 is refuted.


@dataclass(frozen=True)
class Boastful(HalfExplicitEuler):
    """The half-explicit scheme with a claim that is too high."""

    truncation: str = "none"

    name: ClassVar[str] = "boastful"
    claims: ClassVar[tuple[Claim, ...]] = (Claim(measure="strong", value=1.5, source="an advertisement"),)
    promises = claims


result = verify([HalfExplicitEuler(truncation="none"), Boastful()], slider_crank, "strong,drift", paths=2048)
result

# %%

axes = result.plot.convergence("half-explicit-euler[truncation=none]", quantity="v")
verdicts = result.verdicts.groupby("scheme").verdict.agg(set)
print(verdicts.to_string())
assert "verified" in verdicts["half-explicit-euler[truncation=none]"]
assert "refuted" not in verdicts["half-explicit-euler[truncation=none]"]
wrong = result.verdicts.query("scheme == 'boastful' and verdict == 'refuted'")
assert set(wrong.decided_by) == {"T1"}
assert wrong.reason.str.startswith("Strong order 1.00 from one step").all()
