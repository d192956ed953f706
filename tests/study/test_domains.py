"""Schemes for states that stay in a domain: right ones are not refuted, wrong twins are."""

from dataclasses import dataclass, replace
from functools import partial
from typing import ClassVar

import numpy as np
import pytest

from facade import (
    Examined,
    cir,
    exactness_violation,
    gbm,
    load_registry,
    match,
    member_classes,
    ou,
    probe_of,
    tree_classes_of,
    violation,
)
from sdaeverify import SDE, Claim, Domain, Scheme, Step, verify
from sdaeverify.probing import OneStep, cloud
from sdaeverify_hunt.attacks import _forms, _matching

CLAIMS = (
    Claim(measure="strong", value=0.5, source="made up"),
    Claim(measure="weak", value=1.0, source="made up"),
)


@dataclass(frozen=True)
class Reflected(Scheme):
    """|x + f h + B dW|, of a diffusion that is not defined below 0, with a planted mistake.

    Attributes
    ----------
    noise_factor, drift_factor : float
        Factors of both terms.
    kept : bool
        Whether the modulus is taken.
    """

    noise_factor: float = 1.0
    drift_factor: float = 1.0
    kept: bool = True

    name: ClassVar[str] = "reflected-euler"
    form: ClassVar[type[SDE]] = SDE
    domain: ClassVar[Domain] = Domain.orthant()
    claims: ClassVar[tuple[Claim, ...]] = CLAIMS

    def step(self, problem, x, t, h, noise):
        new = x + self.drift_factor * h * problem.drift(t, x) + self.noise_factor * problem.diffused(t, x, noise.dW)
        return Step(np.abs(new) if self.kept else new)


@dataclass(frozen=True)
class FullTruncation(Scheme):
    """x+ = x + f(max(x, 0)) h + B(max(x, 0)) dW, of which max(x, 0) is shown: Lord, Koekkoek & van Dijk 2010.

    Attributes
    ----------
    noise_factor, drift_factor : float
        Of both terms; 1 but for planted mistakes.
    """

    noise_factor: float = 1.0
    drift_factor: float = 1.0

    name: ClassVar[str] = "full-truncation"
    form: ClassVar[type[SDE]] = SDE
    domain: ClassVar[Domain] = Domain.orthant()
    claims: ClassVar[tuple[Claim, ...]] = CLAIMS[1:]

    def parts(self, problem, state):
        return problem.parts(np.maximum(state, 0.0))

    def step(self, problem, state, t, h, noise):
        x = np.maximum(state, 0.0)
        kick = self.noise_factor * problem.diffused(t, x, noise.dW)
        return Step(state + self.drift_factor * h * problem.drift(t, x) + kick)


class Everywhere(Reflected):
    """The same for all states, as its author forgets to say what it is for."""

    name: ClassVar[str] = "reflected-everywhere"
    domain: ClassVar[Domain | None] = None


class Asking(Everywhere):
    """The same, whose claims ask for states at or above 0."""

    name: ClassVar[str] = "reflected-asking"
    claims: ClassVar[tuple[Claim, ...]] = tuple(replace(each, when=frozenset({"nonnegative"})) for each in CLAIMS)


BEYOND = partial(cir, sigma=2.0)
RIGHT = (Reflected(), FullTruncation())
WRONG = (
    Reflected(noise_factor=0.9),
    Reflected(drift_factor=-1.0),
    FullTruncation(noise_factor=0.9),
    FullTruncation(drift_factor=-1.0),
)
PROBLEMS = {"cir": cir, "beyond Feller": BEYOND, "gbm": gbm}


@pytest.mark.parametrize("scheme", RIGHT, ids=lambda scheme: scheme.label)
@pytest.mark.parametrize("name", PROBLEMS)
def test_right_schemes_break_no_contract(name, scheme):
    """Trivial equations, short steps and far noise leave a right scheme alone, beyond Feller's condition as well."""
    assert violation(scheme, PROBLEMS[name]()) == ""


@pytest.mark.sweep
@pytest.mark.parametrize("scheme", WRONG, ids=lambda scheme: scheme.label)
@pytest.mark.parametrize("name", PROBLEMS)
def test_wrong_twins_are_refuted(name, scheme):
    """A wrong factor of the noise and a wrong sign of the drift are found without paths."""
    assert violation(scheme, PROBLEMS[name]()) != ""


def test_a_missing_reflection_is_named():
    """Beyond Feller's condition the reason says that the scheme leaves what it is for."""
    assert "a step leaves the states with x >= 0 that the scheme is for" in violation(Reflected(kept=False), BEYOND())


def test_without_a_domain_the_scheme_is_put_to_all_states():
    """The modulus misses dx = 0 below 0: a scheme has to say what it is for."""
    assert "not exact on dx = 0" in violation(Everywhere(), cir())


def test_claims_about_nonnegative_states_alone_are_not_put_to_others():
    """A scheme may say by the trait of its claims what it is for: T0 and members have no such problem."""
    scheme = Asking()
    assert violation(scheme, cir()) == ""
    assert "wrong equation" in violation(Asking(noise_factor=0.9), cir())
    assert member_classes(scheme, 1) == {}


def test_hunts_have_registered_problems_in_the_domain():
    """Equations that are drawn at random are of all states: a scheme with a domain is not put to them."""
    assert _forms(Reflected(), ()) == ["registered"]
    assert _forms(Reflected(), ("SDE", "registered")) == ["registered"]
    assert _forms(Everywhere(), ()) == ["SDE"]
    found = {spec.name for spec in _matching(load_registry(), Reflected())}
    assert "gbm" in found
    assert "ou" not in found


def test_trivial_equations_stay_in_the_domain():
    """There are rest and motion along a line in it, which find a wrong drift."""
    trivial = [each for variants in SDE.trivial_problems_in(Domain.orthant()) for each in variants]
    assert {each.name for each in trivial} == {"dx = 0 with x >= 0", "dx = c dt with x >= 0"}
    for each in trivial:
        W = np.zeros((each.problem.noise_dim, 1))
        assert all(each.problem.domain.contains(each.solution(t, W)["x"]).all() for t in np.linspace(0.0, 8.5, 9))
    assert exactness_violation(Reflected()) == ""
    assert "not exact on dx = c dt with x >= 0" in exactness_violation(Reflected(drift_factor=-1.0))


def test_a_domain_of_more_components_has_trivial_equations_of_as_many():
    """A box of three components is not asked about two."""
    trivial = SDE.trivial_problems_in(Domain.box([0.0, 0.0, 0.0], [1.0, 1.0, 2.0]))
    assert {each.problem.dimension for variants in trivial for each in variants} == {3}


def test_a_scheme_with_a_domain_is_not_put_to_problems_without():
    """The reason says so, and members and order conditions, which are of all states, are not asked."""
    reason = "requires states with x >= 0, and the problem declares no domain"
    assert match(Reflected(), ou()).reason == reason
    assert match(Reflected(), gbm()).reason == ""
    assert member_classes(Reflected(), 1) == {}
    kinds = tree_classes_of(Reflected())
    reasons = {Examined(probe_of(Reflected(), kind, kind.motions or 2, 3)).why_not for kind in kinds}
    assert reason in reasons
    assert "" not in reasons


def square_root(low):
    """Return a diffusion with a square root that is not defined below 0, on a domain or on none."""
    return SDE(
        drift=lambda t, x: 1.0 - x,
        diffusion=lambda t, x: 0.5 * np.sqrt(x)[:, None],
        start=[1.0],
        noise_dim=1,
        horizon=1.0,
        source="made up",
        domain=low,
    )


def test_states_that_are_probed_are_in_the_domain():
    """The cloud and reached states of a process that comes near 0 are at or above 0, scattered ones as well."""
    for problem in (BEYOND(), square_root(Domain.orthant())):
        step = OneStep(Reflected(), problem)
        assert (cloud(problem, step.equation) >= 0.0).all()


def test_steps_across_the_boundary_are_not_asked():
    """Where a step of Euler's method leaves the domain the scheme makes another one: no order shows there."""
    step, h = OneStep(Reflected(), BEYOND()), np.array([2.0**-4, 2.0**-20])
    x = np.array([[1.0, 1e-3]])
    assert step.truncated(x, h, [0.2, 0.2]).tolist() == [[True, False], [True, False]]
    assert not OneStep(Everywhere(), ou()).truncated(x, h, [0.2, 0.2]).any()


@pytest.mark.long
def test_right_schemes_are_verified_on_gbm_and_cir():
    """The modulus of Euler's step, and full truncation, are verified; a tenth less noise is refuted on both."""
    result = verify([*RIGHT, Reflected(noise_factor=0.9)], [gbm, cir], ["strong", "weak"], seed=1)
    frame = result.verdicts
    right = frame[frame.scheme.isin([scheme.label for scheme in RIGHT])]
    wrong = frame[~frame.scheme.isin([scheme.label for scheme in RIGHT])]
    assert set(right.verdict) <= {"verified", "out_of_scope"}
    assert {"verified"} <= set(right.verdict)
    assert set(wrong.verdict) == {"refuted"}


@pytest.mark.long
def test_beyond_fellers_condition_no_claim_is_refuted():
    """Where 0 is reached the right schemes are not refuted."""
    result = verify(RIGHT, ["cir[sigma=2]"], ["strong", "weak"], seed=1)
    assert "refuted" not in set(result.verdicts.verdict)
