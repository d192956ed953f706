"""Steps that are too coarse for an equation refute nothing: parameters at which they once did."""

from dataclasses import replace

import numpy as np
import pytest

from facade import (
    SRA1,
    BalancedEuler,
    Drift,
    EulerMaruyama,
    HalfExplicitEuler,
    Heun,
    Moments,
    Strong,
    Study,
    TamedEuler,
    Weak,
    contract_violation,
    fibre_clamped,
    fibre_free,
    follows_coefficients,
    forced_ou,
    gbm,
    growing_algebraic,
    hold_back,
    orthogonal_group,
    plan,
    problem_spec,
)
from sdaeverify import SDE, Settings
from sdaeverify.measuring import Evidence, PathTests, Reason, Tally, Verdict
from sdaeverify.numerics import norm
from sdaeverify.probing import OneStep, cloud


def fast_noise():
    """Return an equation whose noise goes up and down by four radians within the finest step."""
    return SDE(
        drift=lambda t, x: -x,
        diffusion=lambda t, x: np.full((1, 1, 1), 0.5 + 0.25 * np.sin(1000.0 * t)),
        diffusion_derivative=lambda t, x, y: np.zeros((1, 1, 1)),
        start=[1.0],
        noise_dim=1,
        horizon=1.0,
        traits=frozenset({"vanishing-milstein-term"}),
        source="planted",
    )


CELLS = {
    "residuals grow while the bending of a fibre is not resolved": (
        TamedEuler(),
        problem_spec(fibre_clamped, {"alpha": "0.27", "beta": "0.227", "Dr": "0.392", "N": "5", "horizon": "0.252"}),
        Drift(),
    ),
    "its moments explode on steps longer than its fastest time": (
        HalfExplicitEuler(),
        problem_spec(fibre_free, {"alpha": "0.647", "beta": "0.022", "Dr": "0.0268", "N": "6", "horizon": "0.0771"}),
        Moments(),
    ),
    "differences of means grow before they fall": (
        BalancedEuler(),
        problem_spec(orthogonal_group, {"eps": "0.693", "m": "4", "stiffness": "1.57", "horizon": "0.663"}),
        Weak(),
    ),
    "noise goes up and down within a step": (Heun(), problem_spec(fast_noise), Strong()),
}


@pytest.mark.sweep(others="slow")
@pytest.mark.long
@pytest.mark.parametrize("why", CELLS)
def test_steps_that_are_too_coarse_refute_nothing(why):
    """The cell is left open: finer levels would decide."""
    scheme, problem, measure = CELLS[why]
    made = Study(plan([scheme], [problem], [measure], lambda _: None), Settings(paths=1024))
    for _ in made.run():
        pass

    found = [finding for finding in made.results()[0].findings if finding.claim is not None]

    assert found
    assert {finding.verdict for finding in found} <= {Verdict.INCONCLUSIVE, Verdict.VERIFIED}


def test_states_at_which_orders_are_probed_are_not_far_out():
    """A law over twenty powers of ten: at its outer states taming takes all of the drift, in a step however short."""
    view = TamedEuler().view_of(growing_algebraic(b=3.0, growth=5.0, horizon=1.5))
    step = OneStep(TamedEuler(), view)
    start = step.equation.initial(1)
    x, h = cloud(view, step.equation), 2.0**-18

    f = step.equation.drift(step.time, x)
    nothing = step.equation.drawn(np.random.default_rng(0), 0.0, x.shape[1])
    moved = step(x, step.time, h, nothing) - x
    assert norm(x - start).max() > 100.0
    np.testing.assert_allclose(moved, h * f, rtol=0.02)


@pytest.mark.parametrize(
    ("problem", "h", "follows"),
    [
        (gbm(), 0.5, True),
        (forced_ou(omega=2.0), 0.125, True),
        (forced_ou(omega=500.0), 2.0**-8, False),
        (forced_ou(omega=500.0), 2.0**-10, True),
        (replace(gbm(), drift=lambda t, x: x * np.floor(3.0 * t)), 2.0**-8, True),
        (replace(gbm(), drift=lambda t, x: x * (1.0 + 1e-3 * np.sin(500.0 * t))), 2.0**-8, True),
    ],
)
def test_coefficients_that_swing_within_a_step_are_not_followed(problem, h, follows):
    """A single jump is, at all steps but one, and so is what hardly changes the coefficient."""
    assert follows_coefficients(problem, h) is follows


@pytest.mark.parametrize(("lost", "levels", "refuted"), [(2, 3, 1.0), (0, 3, 1e-9), (2, 4, 1e-9)])
def test_few_levels_beside_those_that_lose_paths_refute_nothing(lost, levels, refuted):
    """Paths that all but explode carry their errors; four levels are enough."""
    settings = Settings(paths=1024)
    health = Tally(sums={"lost": np.array([lost] * (6 - levels) + [0] * levels)})
    evidence = Evidence(EulerMaruyama(), gbm(), gbm(), settings, Tally(), health)

    found = hold_back(PathTests(1.0, 1e-9, Reason("order 0.1")), evidence, np.arange(6 - levels, 6))

    assert (found.refuted, found.against) == (refuted, 1e-9)


def test_a_limit_is_held_back_with_the_order():
    """Where one step verifies a weak order, only a mean far off refutes it: not on steps too long for it."""
    stiff = replace(gbm(), fastest_time=1e-3)
    evidence = Evidence(EulerMaruyama(), stiff, stiff, Settings(paths=1024), Tally(), Tally())

    found = hold_back(PathTests(1.0, 1e-9, Reason("far off"), limit=1e-9), evidence, np.arange(2, 6))

    assert (found.refuted, found.limit, found.against) == (1.0, 1.0, 1e-9)


def test_a_view_resolves_what_its_problem_resolves():
    """The equation without constraint of a fibre has the fibre's fastest time."""
    fibre = fibre_clamped()

    assert TamedEuler().view_of(fibre).fastest_time == fibre.fastest_time < np.inf


@pytest.mark.long
def test_the_rounding_of_an_algorithm_is_no_dependence_on_the_place():
    """The inverse of an ill-conditioned matrix depends on how sums are taken: by more than rounding of the state."""
    problem = orthogonal_group(eps=0.892, m=7, stiffness=0.728, horizon=0.794)
    assert contract_violation(SRA1(), SRA1().view_of(problem)) == ""
