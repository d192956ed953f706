"""Schemes of a positive order are stable in mean square for small steps, and claim it."""

from typing import ClassVar

import pytest

from facade import load_registry
from sdaeverify import SDE, Claim, Scheme, Step, verify
from sdaeverify.numerics import apply

# Stable in mean square in Ito's sense, 2 a + s^2 = -0.5, and unstable in Stratonovich's, 2 a + 2 s^2 = 1.
STABLE_IN_ITO = "gbm[a=-1,b=1.224744871391589]"
REGISTRY = load_registry(environ={})
SHIPPED = [scheme for entry in REGISTRY.schemes.values() for scheme in entry.variants if not scheme.claimant]
PROBLEMS = {spec.label: spec for entry in REGISTRY.problems.values() for spec in entry.variants}
# Measures whose claims of a positive order imply stability for small steps; see sdaeverify_schemes/_small_steps.py.
ORDERS = ("weak", "strong")


def values_of(scheme, measure):
    """Return the values of the claims of a scheme for a measure, as texts."""
    return {str(claim.value) for claim in scheme.promises if claim.measure == measure}


CLAIMANTS = [scheme for scheme in SHIPPED if values_of(scheme, "stability")]


def known_regions(schemes):
    """Return the labels of schemes that are stable at a step size of a run, on a problem that an order covers."""
    rows = verify(schemes, "*", "stability").verdicts
    labelled, stable = {scheme.label: scheme for scheme in schemes}, rows[rows.value.notna()]
    return {
        row.scheme for row in stable.itertuples() if is_covered(labelled[row.scheme], PROBLEMS[row.problem].build())
    }


def is_covered(scheme, problem):
    """Return whether a claim of a positive order covers the problem."""
    traits = scheme.view_of(problem).traits
    return any(claim.measure in ORDERS and claim.when <= traits for claim in scheme.promises)


class WithoutCorrection(Scheme):
    """Heun's scheme for the Ito drift: it solves the equation in Stratonovich's sense, which is another one."""

    name: ClassVar[str] = "heun-without-correction"
    form: ClassVar[type] = SDE
    claims: ClassVar[tuple] = (Claim(measure="stability", value="conditional", source="test"),)

    def step(self, problem, state, t, h, noise):
        f, B = problem.drift(t, state), problem.diffusion(t, state)
        y = state + h * f + apply(B, noise.dW)
        F, C = problem.drift(t + h, y), problem.diffusion(t + h, y)
        return Step(state + 0.5 * (h * (f + F) + apply(B + C, noise.dW)))


@pytest.mark.sweep
@pytest.mark.parametrize("scheme", ["balanced-euler", "heun", "platen-weak-2", "euler-maruyama"])
def test_small_steps_are_stable(scheme):
    """Where the equation is, though its noise is so strong that in Stratonovich's sense it is not."""
    (row,) = verify(scheme, STABLE_IN_ITO, "stability").rows.verdicts

    assert (row.claim, row.verdict) == ("conditional", "verified")
    assert row.value > 0.0


def test_a_scheme_for_another_equation_is_refuted():
    """Its second moments grow at small steps: the claim is no mere consequence of the measure."""
    (row,) = verify(WithoutCorrection(), STABLE_IN_ITO, "stability").rows.verdicts

    assert row.verdict == "refuted"
    assert row.reason.startswith("Unstable for small h")


class WithoutClaim(WithoutCorrection):
    """The same scheme, which claims an order and not the stability that it has elsewhere."""

    name: ClassVar[str] = "heun-without-claim"
    claims: ClassVar[tuple] = (Claim(measure="weak", value=1.0, source="test"),)


@pytest.mark.slow
@pytest.mark.long
def test_every_scheme_with_a_known_region_claims_stability():
    """No other shipped scheme is stable at a step size of a run where its order is claimed; one that is, is found."""
    others = [scheme for scheme in SHIPPED if scheme not in CLAIMANTS]

    assert known_regions([*others, WithoutClaim()]) == {"heun-without-claim"}


@pytest.mark.slow
@pytest.mark.parametrize("scheme", CLAIMANTS, ids=lambda scheme: scheme.label)
def test_the_stability_that_a_scheme_claims_is_verified(scheme):
    """On one shipped problem at least, and it is refuted on none."""
    found = set(verify(scheme, "*", "stability").verdicts.verdict)

    assert "verified" in found
    assert not found & {"refuted", "error", "diverged"}


def test_stability_at_all_step_sizes_is_claimed_by_an_implicit_scheme_alone():
    """The theta method claims it from 1/2 on; a claim of all others is about small steps."""
    claimed = {scheme.label: values_of(scheme, "stability") for scheme in CLAIMANTS}

    assert claimed.pop("stochastic-theta") == {"A-stable"}
    assert set.union(*claimed.values()) == {"conditional"}
    assert {"balanced-euler", "drift-implicit-milstein", "euler-maruyama", "heun", "milstein"} <= set(claimed)
