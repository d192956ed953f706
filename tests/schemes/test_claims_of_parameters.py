"""What a scheme claims by its parameters, and parameters that it refuses."""

from math import inf, nan
from typing import Any

import pytest

from facade import load_registry
from sdaeverify import ParameterError, Scheme

HALF, PROJECTIONS = "half-explicit-euler", ("explicit-projection-euler", "semi-implicit-projection-euler")
THETAS = ("lagged-algebraic-theta", "stochastic-theta")
# Parameters, and the values of all claims for some measures, in their order.
CLAIMED: list[tuple[str, dict[str, Any], dict[str, list[str]]]] = [
    # A root and convergence are claimed with the constants of the theory, bounded moments with any truncation.
    (HALF, {"truncation": "theory"}, {"solvability": ["every h"], "uniform": ["converges"], "moments": ["bounded"]}),
    (HALF, {"truncation": 0.5}, {"solvability": [], "uniform": [], "moments": ["bounded"]}),
    (HALF, {"truncation": "none"}, {"solvability": [], "uniform": [], "moments": []}),
    (HALF, {}, {"multipliers": ["order >= 2.0", "order >= 2.0", "order >= 1.0"]}),
    # Exact constraints are claimed where every step is projected, and to the last bit.
    ("implicit-euler-ggl", {}, {"drift": ["round-off"]}),
    ("implicit-euler-ggl", {"tolerance": 1e-8}, {"drift": []}),
    *[(name, {}, {"drift": ["round-off"]}) for name in PROJECTIONS],
    ("semi-implicit-projection-euler", {"noise_projector": "new"}, {"drift": ["round-off"]}),
    *[(PROJECTIONS[0], {"solver": each, "tolerance": 1e-4}, {"drift": []}) for each in ("gram", "newton")],
    (PROJECTIONS[0], {"skip": 2}, {"drift": ["order >= 1.0"]}),
    # A-stability from theta = 1/2 on, order 2 in law at theta = 1/2 alone.
    ("stochastic-theta", {"theta": 0.0}, {"stability": ["conditional"] * 2}),
    ("stochastic-theta", {"theta": 0.499}, {"stability": ["conditional"] * 2, "weak": ["order >= 1.0"]}),
    ("stochastic-theta", {"theta": 0.5}, {"stability": ["A-stable"] * 2, "weak": ["order >= 1.0", "order >= 2.0"]}),
    ("stochastic-theta", {"theta": 0.6}, {"stability": ["A-stable"] * 2, "weak": ["order >= 1.0"]}),
    # Bounded variables have no strong order.
    *[("uniformly-accurate", {"xi": each}, {"strong": ["order >= 0.5"]}) for each in ("gaussian", "clipped")],
    ("uniformly-accurate", {"xi": "three-point"}, {"strong": []}),
]
REFUSED: list[tuple[str, dict[str, Any], str]] = [
    ("constrained-euler", {"direction": "mean"}, "direction must be old or new, got 'mean'"),
    ("constrained-euler", {"direction": "new", "solver": "frozen"}, "requires the normals at the old point"),
    ("explicit-projection-euler", {"skip": -1}, r"skip must be at least 0"),
    ("explicit-projection-euler", {"skip": 1.5}, r"skip .*a whole number"),
    *[(HALF, {"truncation": each}, "truncation") for each in ("thoery", 0.0, -1.0, nan, inf)],
    (HALF, {"no_root": "redraw"}, "no_root"),
    ("implicit-euler-ggl", {"guess": "V3"}, "guess"),
    *[("implicit-euler-ggl", {"tolerance": each}, "tolerance") for each in (-1e-3, 1.0, nan)],
    ("implicit-euler-ggl", {"max_iterations": 0}, "max_iterations"),
    ("implicit-euler-ggl", {"stages": 0}, "stages"),
    *[
        (each, {"theta": odd}, r"theta .*must be (between 0 and 1|finite), got")
        for each in THETAS
        for odd in (1.1, nan)
    ],
    ("semi-implicit-projection-euler", {"noise_projector": "now"}, "old or new, got 'now'"),
    *[(name, {"solver": "frozen"}, "solver must be gram or newton") for name in PROJECTIONS],
    *[(name, {"tolerance": -1.0}, r"tolerance .*must be") for name in PROJECTIONS],
    ("uniformly-accurate", {"theta": -0.1}, "theta must be between 0 and 1, got -0.1"),
    ("uniformly-accurate", {"xi": "two-point"}, "xi must be gaussian, three-point or clipped"),
    ("uniformly-accurate", {"p": 0.0}, "p must be positive"),
    ("uniformly-accurate", {"solver": "picard"}, "solver must be newton or frozen"),
    ("uniformly-accurate", {"no_root": "redraw"}, "no_root must be hold or fail"),
    ("uniformly-accurate", {"theta": 0.5, "solver": "frozen"}, "solver=frozen requires the normals at the old point"),
]


REGISTRY = load_registry([])


def made(scheme: str, parameters: dict[str, Any]) -> Scheme:
    return type(REGISTRY.schemes[scheme].make())(**parameters)


@pytest.mark.parametrize(("scheme", "parameters", "claims"), CLAIMED)
def test_claims_follow_from_parameters(scheme: str, parameters: dict[str, Any], claims: dict[str, list[str]]) -> None:
    """What a variant cannot keep, it does not promise."""
    promises = made(scheme, parameters).promises

    assert {each: [str(claim) for claim in promises if claim.measure == each] for each in claims} == claims


@pytest.mark.parametrize(("scheme", "parameters", "message"), REFUSED)
def test_bad_parameters_are_named(scheme: str, parameters: dict[str, Any], message: str) -> None:
    """One line says which parameter it is."""
    with pytest.raises(ParameterError, match=message) as caught:
        made(scheme, parameters)

    assert "\n" not in str(caught.value)
