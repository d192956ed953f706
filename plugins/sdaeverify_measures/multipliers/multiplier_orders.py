"""Remainders of a scheme's multipliers at fixed states, and their orders in h.

With the equation of the multiplier, dmu = l(t, r, v) dt + L(t, r, v) dw, (2.8) of Lindner & Stroot (2017), the
multiplier of one step with increment w is decomposed, (3.16), into

    lambda(w) = h l + L w + lambda^re + Lambda^re w,      lambda^re = lambda(0) - h l.

The size of lambda(w) - lambda(0) - L w over |w| is used as that of Lambda^re, for any form of the former: a
multiplier that is not affine in w, by a term w^2 for example, has a remainder of order 1/2 there.
"""

from typing import NamedTuple

import numpy as np

from sdaeverify import Array, Increment, Problem, Scheme, SchemeError, Step
from sdaeverify.numerics import norm
from sdaeverify.probing import LocalOrders, Multiplied, OneStep, cloud, last_orders

# Rows of the record: kappa, lambda^re, Lambda^re.
QUANTITIES = ("kappa", "lambda remainder", "Lambda remainder")
KAPPA, LAMBDA = "kappa", "lambda"
# Step sizes 4^-2, ..., 4^-9 of the horizon, or of the unit of time if that is shorter; the coarsest ones may be
# truncated.
LEVELS = 4.0 ** -np.arange(2.0, 10.0)
# Relative bound of rounding errors in the terms that cancel, with a safety factor of some hundred.
ROUNDING = 6e-14


class Multipliers(NamedTuple):
    """Sizes at H step sizes, each the maximum over the states.

    Attributes
    ----------
    h : ndarray, shape (H,)
        Coarsest first.
    size : ndarray, shape (3, H)
        Of kappa, lambda^re and Lambda^re; NaN if some step is truncated or fails, and if it is not an output.
    scale : ndarray, shape (3, H)
        Of the terms that cancel in them.
    given : ndarray, shape (3,)
        1 for quantities that the scheme outputs, else 0.
    truncated, failed : ndarray, shape (H,)
        Share of the steps.
    """

    h: Array
    size: Array
    scale: Array
    given: Array
    truncated: Array
    failed: Array


def why_not_multipliers(scheme: Scheme, view: Problem) -> str:
    """Return why a pair has no multipliers to probe, or an empty string."""
    step = OneStep(scheme, view)
    if reason := step.why_not_probed(run=False):
        return reason
    return step.why_not_probed() if _find_outputs(step).any() else f"its steps give no outputs {KAPPA} or {LAMBDA}"


def multipliers(scheme: Scheme, view: Problem) -> Multipliers:
    """Probe one step of each size at each state of the cloud, with w = 0 and w = +-sqrt(h) in 1 + l directions.

    Parameters
    ----------
    scheme : Scheme
    view : Problem
        The pair has multipliers, see `why_not_multipliers`.

    Returns
    -------
    Multipliers
    """
    step = OneStep(scheme, view)
    x, h = cloud(view, step.equation), LEVELS * step.time_unit
    directions = _directions(view.noise_dim)
    with np.errstate(all="ignore"):
        levels = [_level(step, x, float(size), directions) for size in h]
    size, scale, shares = (np.stack(parts, axis=-1) for parts in zip(*levels, strict=True))
    usable = np.where(shares.any(axis=0), np.nan, size)
    return Multipliers(h, usable, scale, _find_outputs(step), *shares)


def multiplier_orders(record: Multipliers) -> LocalOrders:
    """Return the orders of kappa, lambda^re and Lambda^re in h, each of shape (3,)."""
    return last_orders(record.h, record.size, ROUNDING * record.scale, record.scale)


def _find_outputs(step: OneStep) -> Array:
    x, h = step.equation.initial(2), step.view.horizon / 64.0
    outputs = _result(step, x, h, np.zeros((step.view.noise_dim, 2))).outputs
    return np.array([float(name in outputs) for name in (KAPPA, LAMBDA, LAMBDA)])


def _directions(motions: int) -> Array:
    """Return 0, +-the axes and +-their diagonal as columns, shape (l, K)."""
    axes = np.concatenate([np.eye(motions), np.full((motions, 1), motions**-0.5)], axis=1)
    return np.concatenate([np.zeros((motions, 1)), axes, -axes], axis=1)


def _level(step: OneStep, x: Array, h: float, directions: Array) -> tuple[Array, Array, Array]:
    """Return the sizes and scales at one step size, each of shape (3,), and the shares truncated and failed."""
    states, nodes = x.shape[1], directions.shape[1]
    w = np.sqrt(h) * directions
    result = _result(step, np.repeat(x, nodes, axis=1), h, np.tile(w, states))
    kappa, lam = (_output(step, result, name, states * nodes).reshape(-1, states, nodes) for name in (KAPPA, LAMBDA))
    drift, Lw = _leading(step, x, w)
    remainders = kappa, lam[..., 0] - h * drift, (lam[..., 1:] - lam[..., :1] - Lw[..., 1:]) / np.sqrt(h)
    size = np.array([norm(part.reshape(len(part), -1)).max() for part in remainders])
    shares = [0.0 if flag is None else np.mean(flag) for flag in (result.truncated, result.failed)]
    return size, _scales(step, x, h), np.array(shares)


def _leading(step: OneStep, x: Array, w: Array) -> tuple[Array, Array]:
    """Return l, shape (m, S), and L w, shape (m, S, K)."""
    t, mu = step.time, step.names["mu"]
    L = step.equation.diffusion(t, x)[mu]
    return step.equation.drift(t, x)[mu], np.einsum("mlp,lk->mpk", np.broadcast_to(L, (*L.shape[:2], x.shape[1])), w)


def _scales(step: OneStep, x: Array, h: float) -> Array:
    """Return the sizes of the terms that cancel in a step's multipliers, their change, and that over sqrt(h)."""
    form = step.view.capability(Multiplied)
    assert form is not None
    value, change = (part.max() for part in form.multiplier_scales(step.time, x, h))
    return np.array([value, change, change / np.sqrt(h)])


def _output(step: OneStep, result: Step, name: str, paths: int) -> Array:
    m = step.equation.dimension - step.names["mu"].start
    given = np.asarray(result.outputs.get(name, np.full((m, paths), np.nan)))
    if given.shape != (m, paths):
        raise SchemeError(f"output {name} has shape {given.shape}, expected ({m}, {paths})")
    return given


def _result(step: OneStep, x: Array, h: float, dW: Array) -> Step:
    H = np.zeros_like(dW) if "H" in step.scheme.noise else None
    return step.make(x, step.time, h, Increment(dW, H))
