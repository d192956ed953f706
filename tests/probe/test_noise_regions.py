"""A step that is different in a small region of its noise has no order from the nodes of a rule, which miss it."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

from facade import EulerMaruyama, HeunAdditive, Milstein, double_well, ou
from sdaeverify import Scheme, verify
from sdaeverify.measuring import Verdict
from sdaeverify.probe.step.nodes import gauss_hermite
from sdaeverify.probe.step.two_rules import SCATTERED, scattered
from sdaeverify.probing import moment_errors, why_not_operator
from sdaeverify_schemes.platen_weak_2_general import PlatenWeak2General

# Bounds of the first increment in standard deviations, with 4 per cent of its law; no node of the rules is inside.
LOW, HIGH = 0.2, 0.3


def within(base: type[Scheme]) -> Scheme:
    """Return a scheme that makes Euler's step where the first increment is between the bounds."""

    def prepare(self: Scheme, problem: Any, h: float) -> Callable[..., Any]:
        right, wrong = base.prepare(self, problem, h), EulerMaruyama().prepare(problem, h)

        def stepper(state: Any, t: float, noise: Any) -> Any:
            step, z = right(state, t, noise), noise.dW[0] / np.sqrt(h)
            inside = (z > LOW) & (z < HIGH)
            return step._replace(state=np.where(inside, wrong(state, t, noise).state, step.state))

        return stepper

    own = {"name": f"within-{base.name}", "prepare": prepare, "__module__": __name__}
    return dataclass(frozen=True)(type("Within", (base,), own))()


def verdicts(scheme: Scheme, problem: Any, *measures: str) -> set[str]:
    """Return the verdicts of the claims of one scheme on one problem."""
    given = scheme if scheme.name.startswith("within") else scheme.name
    table = verify([given], [problem], list(measures), paths=256).verdicts
    return set(table[(table.scheme == scheme.label) & (table.claim != "")].verdict)


@pytest.mark.parametrize(
    ("base", "problem", "measure"),
    [(Milstein, "gbm", "strong"), (HeunAdditive, "double-well", "weak"), (HeunAdditive, "ou", "weak")],
)
def test_an_order_that_is_lower_in_a_region_of_the_noise_is_not_verified(base, problem, measure):
    """Euler's step at 4 per cent of the noise has the order of Euler's scheme; the right scheme is verified."""
    assert Verdict.VERIFIED not in verdicts(within(base), problem, measure)
    assert verdicts(base(), problem, measure) == {Verdict.VERIFIED}


def test_a_lower_order_on_paths_is_refuted():
    """Root mean squares of one step at random noise have the lower order."""
    assert verdicts(within(Milstein), "gbm", "strong") == {Verdict.REFUTED}


def test_nodes_give_no_operator_and_no_moments_of_such_a_step():
    """Neither the chart of an SDE nor moments of a linear one are propagated; both are for the right scheme."""
    wrong, right = within(HeunAdditive), HeunAdditive()

    assert "kink or a jump" in why_not_operator(wrong, double_well())
    assert not why_not_operator(right, double_well())
    assert np.isinf(moment_errors(wrong, ou(), (8, 16)).floor).all()
    assert (moment_errors(right, ou(), (8, 16)).floor < 1e-10).all()


@pytest.mark.parametrize("n", SCATTERED)
def test_means_of_polynomials_are_exact_at_random_nodes(n):
    """Those of products of even powers are products of odd factorials, and those of odd functions 0."""
    x, weights = scattered(n, *SCATTERED[n])
    z, w = gauss_hermite(SCATTERED[n][0])
    for power in range(SCATTERED[n][0] + 1):
        assert x[-1] ** power @ weights == pytest.approx(float(z**power @ w), rel=1e-10, abs=1e-9)
    assert (np.sin(3.0 * x.sum(axis=0)) * weights).sum() == pytest.approx(0.0, abs=1e-12)
    # Weights of both signs would enlarge the error of means that are no polynomials.
    assert np.abs(weights).sum() < 1.5


def test_a_right_scheme_for_several_motions_is_not_refused():
    """Random nodes and the nodes of a rule agree on it."""
    assert verdicts(PlatenWeak2General(), "noncommuting", "weak") == {Verdict.VERIFIED}
