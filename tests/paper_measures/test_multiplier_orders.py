"""Remainders of multipliers: the closed form on the circle, exponents of right schemes, and wrong ones refuted."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import pytest

from facade import HalfExplicitEuler, judge_exponent, pendulum, pendulum_tangential, pendulum_velocity_noise
from sdaeverify import Array, HolonomicSDAE, HolonomicState, Increment, Scheme, SchemeError, Step
from sdaeverify.measuring import Opinion, Verdict, packed, unpacked
from sdaeverify.numerics import apply
from sdaeverify.probing import cloud
from sdaeverify_measures.multipliers.multiplier_orders import (
    LEVELS,
    Multipliers,
    multiplier_orders,
    multipliers,
    why_not_multipliers,
)
from sdaeverify_schemes.projections._old_normals import onto_constraint

NONE = HalfExplicitEuler(truncation="none")
KAPPA, FREE, NOISE = range(3)
CLAIMED = {KAPPA: 2.0, FREE: 2.0, NOISE: 1.0}
# A change of the multipliers: (problem, state, h, dW, kappa, lambda) -> kappa, lambda.
Change = Callable[[HolonomicSDAE, HolonomicState, float, Array, Array, Array], tuple[Array, Array]]


@dataclass(frozen=True)
class Altered(HalfExplicitEuler):
    """The half-explicit scheme that gives out other multipliers."""

    change: Change = lambda p, s, h, w, kappa, lam: (kappa, lam)
    truncation: str | float = "none"

    def step(self, problem: HolonomicSDAE, state: HolonomicState, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        result = super().step(problem, state, t, h, noise)
        given = self.change(problem, state, h, noise.dW, result.outputs["kappa"], result.outputs["lambda"])
        return result._replace(outputs=dict(zip(("kappa", "lambda"), given, strict=True)))


def found(scheme: Scheme, problem: HolonomicSDAE) -> Multipliers:
    """Return the sizes, from evidence that was stored in between."""
    record = unpacked("kept", Multipliers, packed("kept", multipliers(scheme, problem)))
    assert record is not None
    return record


def opinions(scheme: Scheme, problem: HolonomicSDAE | None = None) -> list[Opinion]:
    record = found(scheme, problem or pendulum())
    return [judge_exponent(record, index, claim) for index, claim in CLAIMED.items()]


def verdicts(scheme: Scheme, problem: HolonomicSDAE | None = None) -> list[Verdict]:
    return [opinion.verdict for opinion in opinions(scheme, problem)]


def test_sizes_are_those_of_the_closed_form_on_the_circle() -> None:
    """With sin phi = omega h: kappa = 1 - cos phi, lambda^re = omega (tan phi - sin phi) + a_t h tan phi.

    Lambda^re w is tan phi times the tangential part of w, here along the axes and their diagonal.
    """
    problem = pendulum()
    r, v, _ = problem.state(cloud(problem, problem.ito()))
    record, h = found(NONE, problem), LEVELS * 0.5

    omega = r[0] * v[1] - r[1] * v[0]
    sine = omega * h[:, None]
    tangent = np.tan(np.arcsin(sine))
    free = omega * (tangent - sine) - r[0] * h[:, None] * tangent
    along = np.abs([r[1], r[0], (r[0] - r[1]) / np.sqrt(2.0)]).max(axis=0)
    expected = [1.0 - np.sqrt(1.0 - sine**2), np.abs(free), np.abs(tangent * along)]
    for size, scale, closed in zip(record.size, record.scale, expected, strict=True):
        assert (np.abs(size - closed.max(axis=1)) < 1e-14 * scale).all()


@pytest.mark.parametrize(
    ("problem", "orders"),
    [
        (pendulum(), (2.0, 2.0, 1.0)),
        (pendulum(c_g=0.0), (2.0, 3.0, 1.0)),
        (pendulum_tangential(), (2.0, 3.0, 1.0)),
        (pendulum_velocity_noise(), (2.0, 3.0, 1.0)),
    ],
)
@pytest.mark.parametrize("scheme", [NONE, HalfExplicitEuler()])
def test_exponents_of_the_half_explicit_scheme(
    scheme: Scheme, problem: HolonomicSDAE, orders: tuple[float, ...]
) -> None:
    """Its exponents are 2, 2 and 1, and 3 for lambda^re where no force is tangential."""
    assert multiplier_orders(found(scheme, problem)).order == pytest.approx(orders, abs=2e-3)
    assert verdicts(scheme, problem) == [Verdict.VERIFIED] * 3


def rods_constraint(r: Array) -> Array:
    first, second = r[:2], r[2:] - r[:2]
    return 0.5 * np.stack([1.0 - (first * first).sum(axis=0), 0.25 - (second * second).sum(axis=0)])


def test_exponents_with_a_full_mass_matrix_and_two_constraints() -> None:
    """The decomposition holds for a mass matrix, several constraints, explicit time and noise of all kinds."""
    A = np.random.default_rng(4).standard_normal((4, 4))
    rods = HolonomicSDAE(
        force=lambda t, r, v: np.sin(2.0 * r[::-1]) - 0.4 * v + t * v[::-1] ** 2,
        diffusion=lambda t, r, v: np.stack([0.5 + 0.3 * r, 0.2 * v + np.cos(r[::-1])], axis=1),
        constraint=rods_constraint,
        position=[0.6, -0.8, 0.9, -0.4],
        velocity=[0.0, 0.0, 0.0, 0.0],
        mass=np.eye(4) + A @ A.T / 4.0,
        horizon=1.0,
        noise_dim=2,
        source="made up",
    )

    assert multiplier_orders(found(NONE, rods)).order == pytest.approx((2.0, 2.0, 1.0), abs=5e-3)


def test_normals_at_the_new_point_have_the_same_exponents() -> None:
    """The exponents do not tell at which point the normals are taken: an equivalent change."""

    class NewNormals(Scheme):
        name: ClassVar[str] = "new-normals"
        form: ClassVar[type[HolonomicSDAE]] = HolonomicSDAE

        def step(self, problem: HolonomicSDAE, state: HolonomicState, t: float, h: float, noise: Increment) -> Step:
            r, v, mu = state
            new = onto_constraint(problem, r + h * v, problem.linearised(r))
            x = v + h * problem.force(t, r, v) + problem.diffused(t, r, v, noise.dW)
            J = problem.linearised(new.r)
            tangent, lam = problem.tangent(J, x)
            return Step(HolonomicState(new.r, tangent, mu + lam), outputs={"lambda": lam})

    record = found(NewNormals(), pendulum())
    assert record.given.tolist() == [0.0, 1.0, 1.0]
    assert multiplier_orders(record).order[1:] == pytest.approx((2.0, 1.0), abs=2e-3)


def test_a_remainder_that_vanishes_says_so() -> None:
    """Multipliers of nothing but the leading part keep a claim of any order, as rounding."""

    def leading(
        problem: HolonomicSDAE, state: HolonomicState, h: float, w: Array, *given: Array
    ) -> tuple[Array, Array]:
        x, mu = np.concatenate(state), slice(4, None)
        ito, t = problem.ito(), 0.2 * problem.horizon
        return 0.0 * given[0], h * ito.drift(t, x)[mu] + apply(ito.diffusion(t, x), w)[mu]

    found_ = opinions(Altered(change=leading))
    assert [opinion.verdict for opinion in found_] == [Verdict.VERIFIED] * 3
    assert all("round-off" in str(opinion.reason) for opinion in found_)


def test_truncated_steps_tell_no_exponent() -> None:
    """Where every step is truncated, or rounding hides what is not, nothing is decided."""
    truncated = opinions(HalfExplicitEuler(truncation=1e-9))
    record = found(NONE, pendulum())
    hidden = record._replace(size=0.0 * record.size, truncated=np.eye(len(record.h))[0])

    assert {opinion.verdict for opinion in truncated} == {Verdict.INCONCLUSIVE}
    assert "truncated" in str(truncated[0].reason)
    assert judge_exponent(hidden, KAPPA, 2.0).verdict is Verdict.INCONCLUSIVE


def test_coarse_truncated_steps_are_left_out() -> None:
    """With C_eta = 0.01 only fine steps are not truncated, and tell the exponents."""
    record = found(HalfExplicitEuler(truncation=0.01), pendulum())

    assert np.isnan(record.size[0]).any()
    assert multiplier_orders(record).order == pytest.approx((2.0, 2.0, 1.0), abs=2e-3)


def test_what_cannot_be_probed() -> None:
    """A scheme without multipliers is refused, one that gives them in another shape has a defect."""
    pair = Altered(change=lambda p, s, h, w, kappa, lam: (kappa, np.concatenate([lam, lam])))

    class Silent(HalfExplicitEuler):
        def step(self, problem: HolonomicSDAE, state: HolonomicState, t: float, h: float, noise: Increment) -> Step:
            return super().step(problem, state, t, h, noise)._replace(outputs={})

    assert "no outputs kappa or lambda" in why_not_multipliers(Silent(), pendulum())
    assert why_not_multipliers(NONE, pendulum()) == ""
    with pytest.raises(SchemeError, match=r"output lambda has shape \(2, "):
        multipliers(pair, pendulum())
