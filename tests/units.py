"""Problems in other units of state and time."""

import numpy as np

from sdaeverify import SDE, Array, DelaySDAE, HolonomicSDAE, Langevin, Problem


def in_units(problem: Problem, scale: float = 1.0, shift: float = 0.0, time: float = 1.0) -> SDE:
    """Return the equation of y = scale x + shift in the time s = time t."""
    old = problem.ito()
    assert old is not None

    def drift(s: float, y: Array) -> Array:
        return scale / time * old.drift(s / time, (y - shift) / scale)

    def diffusion(s: float, y: Array) -> Array:
        return scale / np.sqrt(time) * old.diffusion(s / time, (y - shift) / scale)

    start, horizon = scale * old.initial(1)[:, 0] + shift, time * old.horizon
    return SDE(drift=drift, diffusion=diffusion, start=start, noise_dim=old.noise_dim, horizon=horizon, source="test")


def mechanics_in_units(
    old: HolonomicSDAE, scale: float = 1.0, time: float = 1.0, constraint: float = 1.0
) -> HolonomicSDAE:
    """Return the mechanics of scale r in the time s = time t, its constraint in other units as well."""
    speed = scale / time
    return HolonomicSDAE(
        force=lambda s, r, v: speed / time * old.force(s / time, r / scale, v / speed),
        diffusion=lambda s, r, v: speed / np.sqrt(time) * old.diffusion(s / time, r / scale, v / speed),
        constraint=lambda r: constraint * old.constraint(r / scale),
        position=scale * np.asarray(old.position),
        velocity=speed * np.asarray(old.velocity),
        noise_dim=old.noise_dim,
        horizon=time * old.horizon,
        source="test",
    )


def langevin_in_units(old: Langevin, scale: float = 1.0, time: float = 1.0) -> Langevin:
    """Return the dynamics of scale q in the time s = time t."""
    return Langevin(
        force=lambda q: scale / time**2 * old.force(q / scale),
        friction=old.friction / time,
        strength=scale * time**-1.5 * old.strength,
        position=scale * np.asarray(old.position),
        momentum=scale / time * np.asarray(old.momentum),
        horizon=time * old.horizon,
        source="test",
    )


def delay_in_units(old: DelaySDAE, scale: float = 1.0, time: float = 1.0, constraint: float = 1.0) -> DelaySDAE:
    """Return the equation of scale x and scale y in the time s = time t, its constraint in other units as well."""

    def changed(factor: float, coefficient):
        def function(s: float, *at: Array) -> Array:
            return factor * coefficient(s / time, *(part / scale for part in at))

        return function

    return DelaySDAE(
        drift=changed(scale / time, old.drift),
        diffusion=changed(scale / np.sqrt(time), old.diffusion),
        constraint=changed(constraint, old.constraint),
        algebraic=scale * old.initial(1).y[:, 0],
        delay=time * old.delay,
        history=lambda s: scale * np.asarray(old.history(s / time)),
        noise_dim=old.noise_dim,
        horizon=time * old.horizon,
        source="test",
    )
