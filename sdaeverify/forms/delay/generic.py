"""Random delay equations with an algebraic constraint: polynomial coefficients, history and constraint."""

from collections.abc import Callable
from typing import Any

import numpy as np

from ...arrays import Array
from ..generic import Generator, Polynomial, draw_polynomial, draw_regular, draw_signed
from .partials import Partials

COMPONENTS, MOTIONS = 2, 2
MOST_ALGEBRAIC = 2
# A lag comparable to the horizon, not a multiple of a step.
LAGS, HORIZON = (0.3, 0.6), 1.0
TIME, STATE, OWN, MANY, ALGEBRAIC, LAGGED = (
    "time",
    "state-noise",
    "current-noise",
    "motions",
    "constraint",
    "delay",
)
INDEX_ONE_FEATURES = {
    TIME: "coefficients that depend on time",
    STATE: "noise that depends on the state or on time",
    MANY: "several Brownian motions",
    ALGEBRAIC: "algebraic components",
}
FEATURES = {
    TIME: INDEX_ONE_FEATURES[TIME],
    STATE: "noise that depends on the state, lagged values or time",
    OWN: "noise that depends on the current state",
    MANY: INDEX_ONE_FEATURES[MANY],
    ALGEBRAIC: INDEX_ONE_FEATURES[ALGEBRAIC],
    LAGGED: "a delay",
}


def draw_delay(form: Callable[..., Any], rng: Generator, without: frozenset[str]) -> Any:
    """Draw a delay equation without the given features.

    Parameters
    ----------
    form : type
        `DelaySDAE`.
    rng : numpy.random.Generator
    without : frozenset of str
        Names of features.
    """
    tau = float(rng.uniform(*LAGS))
    delay = 0.0 if LAGGED in without else tau
    history = _History(1.0 + draw_signed(rng, (COMPONENTS,)), draw_signed(rng, (3, COMPONENTS)))
    centre = np.concatenate([history(0.0), history(-delay)])
    f, g, u, y = _draw_coefficients(rng, centre, without)
    return form(
        drift=f,
        diffusion=g,
        drift_partials=f.partials,
        delay=delay,
        history=history,
        **_constraint(u, y),
        **_given(g, without),
    )


def draw_index_one(form: Callable[..., Any], rng: Generator, without: frozenset[str]) -> Any:
    """Draw an equation of index 1 without delay; see `draw_delay`.

    Parameters
    ----------
    form : type
        `IndexOneSDAE`.
    rng : numpy.random.Generator
    without : frozenset of str
    """
    x = 1.0 + draw_signed(rng, (COMPONENTS,))
    f, g, u, y = _draw_coefficients(rng, np.concatenate([x, x]), without | {LAGGED})
    constraint = {
        "constraint": lambda t, x, y: u(t, x, x, y),
        "constraint_partials": lambda t, x, y: u.partials(t, x, x, y)[::2],
        "algebraic": y,
    }
    return form(
        drift=lambda t, x, y: f(t, x, x, y),
        diffusion=lambda t, x, y: g(t, x, x, y),
        drift_partials=lambda t, x, y: f.partials(t, x, x, y)[::2],
        start=x,
        **(constraint if len(y) else {}),
        **_given(g, without),
    )


class _History:
    def __init__(self, start: Array, slopes: Array) -> None:
        self.start, self.slopes = start, slopes

    def __call__(self, t: float) -> Array:
        return np.asarray(self.start + t ** np.arange(1, 4) @ self.slopes)


class _DelayCoefficient:
    # A polynomial as a function of (t, x, v, y) with values of a given shape.
    def __init__(self, f: Polynomial, shape: tuple[int, ...]) -> None:
        self.f, self.shape, self.first = f, shape, f.derivative

    def __call__(self, t: float, x: Array, v: Array, y: Array) -> Array:
        return self.f(_stacked(t, x, v, y)).reshape(*self.shape, -1)

    def partials(self, t: float, x: Array, v: Array, y: Array) -> Partials:
        """Return the derivatives in x, v and y."""
        D = self.first(_stacked(t, x, v, y)).reshape(*self.shape, len(self.f.centre), -1)
        d = len(x)
        return Partials(D[:, 1 : 1 + d], D[:, 1 + d : 1 + 2 * d], D[:, 1 + 2 * d :])


def _stacked(t: float, x: Array, v: Array, y: Array) -> Array:
    # Without algebraic components, y may have fewer paths than x.
    return np.concatenate([t + 0.0 * x[:1], x, v, np.broadcast_to(y, (len(y), x.shape[1]))])


def _draw_coefficients(rng: Generator, xv: Array, without: frozenset[str]) -> tuple[Any, Any, Any, Array]:
    """Draw f, g, u and y at time 0, where u vanishes at the current and lagged values of x."""
    d, l = COMPONENTS, 1 if MANY in without else MOTIONS
    q = 0 if ALGEBRAIC in without else int(rng.integers(1, MOST_ALGEBRAIC + 1))
    y = draw_signed(rng, (q,))
    centre = np.concatenate([[0.0], xv, y])
    f, g, u = (draw_polynomial(rng, centre, rows) for rows in (d, d * l, q))
    u.coefficients[:, 0] = 0.0
    u.coefficients[:, 1 + 1 + 2 * d : 1 + len(centre)] = draw_regular(rng, q, q)
    left_out = [
        *([0] if TIME in without else []),
        *(range(1 + d, 1 + 2 * d) if LAGGED in without else []),
    ]
    f, g, u = (each.without(*left_out) for each in (f, g, u))
    if OWN in without:
        g = g.without(*range(1, 1 + d), *range(1 + 2 * d, len(centre)))
    if STATE in without:
        g = g.up_to(0)
    return _DelayCoefficient(f, (d,)), _DelayCoefficient(g, (d, l)), _DelayCoefficient(u, (q,)), y


def _constraint(u: _DelayCoefficient, y: Array) -> dict[str, Any]:
    if not len(y):
        return {}
    return {"constraint": u, "constraint_partials": u.partials, "algebraic": y}


def _given(g: _DelayCoefficient, without: frozenset[str]) -> dict[str, Any]:
    traits = {"additive-noise"} if STATE in without else {"delayed-noise"} if OWN in without else set()
    return {
        "noise_dim": g.shape[1],
        "horizon": HORIZON,
        "traits": frozenset(traits),
        "source": "drawn at random",
        "observables": {"x_1": lambda _, s: s["x"][0], "|x|^2": lambda _, s: (s["x"] ** 2).sum(axis=0)},
    }
