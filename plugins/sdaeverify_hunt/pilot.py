"""Pilot run of a scheme on an example: the states that it reaches, and its growth."""

from typing import NamedTuple

import numpy as np

from sdaeverify import Array, Parts, Problem, Scheme
from sdaeverify.errors import FAULTS
from sdaeverify.studying import Brownian, LevelNoise, Source, Track, match

from .strategies.example import Example

# Number of steps over the horizon, and of paths.
STEPS, PATHS = 32, 4
# Parts of the horizon after which an example may begin; shrinking prefers the first, its original start.
PARTS = (0.0, 0.5, 1.0, 4.0)
# Digits and largest size of stored states; larger states would only show overflow.
DIGITS, LARGEST = 3, 1e3
# Largest growth, also that of a run that ends in NaN or infinity.
MOST = 10.0


def place(scheme: Scheme, example: Example, part: float) -> Example:
    """Move the start of an example to a state that the scheme reaches after a part of the horizon, if it is usable.

    Parameters
    ----------
    scheme : Scheme
    example : Example
    part : float
        Part of the horizon; above 1 the run continues beyond it.
    """
    if not part:
        return example
    with np.errstate(all="ignore"):
        try:
            return _place(scheme, example, part)
        except FAULTS:
            return example


def _place(scheme: Scheme, example: Example, part: float) -> Example:
    view = match(scheme, example.build()).problem
    if view is None:
        return example
    *_, last = _run(scheme, view, round(part * STEPS))
    begins = {name: _rounded(last.parts[name][:, 0]) for name in example.begun_by}
    largest = max(abs(x) for values in begins.values() for x in values)
    return example.begun_at(begins, last.t) if largest <= LARGEST else example


def _rounded(x: Array) -> list[float]:
    return [float(f"{value:.{DIGITS}g}") for value in x.tolist()]


def growth(scheme: Scheme, view: Problem) -> float:
    """Return log10 of the largest factor by which 1 + |x| grows over the horizon on a few paths, at most 10.

    Parameters
    ----------
    scheme : Scheme
    view : Problem
        Problem in the scheme's form.
    """
    first, *_, last = (stop.largest for stop in _run(scheme, view, STEPS))
    found = float(np.log10((1.0 + last) / (1.0 + first)).max())
    return min(found, MOST) if np.isfinite(found) else MOST


class _Stop(NamedTuple):
    t: float
    parts: Parts
    largest: Array


def _run(scheme: Scheme, view: Problem, steps: int) -> list[_Stop]:
    h, stops = view.horizon / STEPS, list[_Stop]()
    track = Track(scheme, view, 0, h, PATHS)

    def advance(_: int, noise: LevelNoise) -> None:
        track.advance(noise, ())
        parts = track.parts()
        largest = np.abs(np.concatenate([*parts.values()])).max(axis=0)
        stops.append(_Stop(track.step * h, parts, largest))

    source = Source(1, "pilot", 0, PATHS)
    Brownian(source, view.noise_dim, h, 0, view.noise, view.records).follow(steps, advance)
    return stops
