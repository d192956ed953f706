"""Parameters of schemes that make no sense are refused in one line that names the parameter."""

from math import inf, nan
from typing import Any

import pytest

from facade import load_registry
from sdaeverify import ParameterError

THETA, TOLERANCE = r"theta .*must be (between 0 and 1|finite), got", r"tolerance .*must be"
PROJECTIONS = ("explicit-projection-euler", "semi-implicit-projection-euler")
REFUSED: list[tuple[str, dict[str, Any], str]] = [
    ("constrained-euler", {"direction": "mean"}, "direction must be old or new, got 'mean'"),
    ("constrained-euler", {"direction": "new", "solver": "frozen"}, "needs the normals at the old point"),
    ("explicit-projection-euler", {"skip": -1}, r"skip must be at least 0"),
    ("explicit-projection-euler", {"skip": 1.5}, r"skip .*a whole number"),
    *[("half-explicit-euler", {"truncation": each}, "truncation") for each in ("thoery", 0.0, -1.0, nan, inf)],
    ("half-explicit-euler", {"no_root": "redraw"}, "no_root"),
    ("implicit-euler-ggl", {"guess": "V3"}, "guess"),
    *[("implicit-euler-ggl", {"tolerance": each}, "tolerance") for each in (-1e-3, 1.0, nan)],
    ("implicit-euler-ggl", {"max_iterations": 0}, "max_iterations"),
    ("implicit-euler-ggl", {"stages": 0}, "stages"),
    *[
        (name, {"theta": each}, THETA)
        for name in ("lagged-algebraic-theta", "stochastic-theta")
        for each in (1.1, nan)
    ],
    ("semi-implicit-projection-euler", {"noise_projector": "now"}, "old or new, got 'now'"),
    *[(name, {"solver": "frozen"}, "solver must be gram or newton") for name in PROJECTIONS],
    *[(name, {"tolerance": -1.0}, TOLERANCE) for name in PROJECTIONS],
    ("uniformly-accurate", {"theta": -0.1}, "theta must be between 0 and 1, got -0.1"),
    ("uniformly-accurate", {"xi": "two-point"}, "xi must be gaussian, three-point or clipped"),
    ("uniformly-accurate", {"p": 0.0}, "p must be positive"),
    ("uniformly-accurate", {"solver": "picard"}, "solver must be newton or frozen"),
    ("uniformly-accurate", {"no_root": "redraw"}, "no_root must be hold or fail"),
    ("uniformly-accurate", {"theta": 0.5, "solver": "frozen"}, "solver=frozen needs the normals at the old point"),
]


@pytest.mark.parametrize(("scheme", "parameters", "message"), REFUSED)
def test_bad_parameters_are_named(scheme: str, parameters: dict[str, Any], message: str) -> None:
    """One line says which parameter it is."""
    kind = type(load_registry([]).schemes[scheme].make())

    with pytest.raises(ParameterError, match=message) as caught:
        kind(**parameters)

    assert "\n" not in str(caught.value)
