"""Random members of forms: consistent, with exact derivatives, and without the features that are left out."""

import pickle

import numpy as np
import pytest

from facade import ORDER_TESTS, ClassTask, GenericClass, MemberClass, member_of
from sdaeverify import ConstrainedLangevin, DelaySDAE, HolonomicSDAE, IndexOneSDAE, ProblemError

FORMS = (HolonomicSDAE, ConstrainedLangevin, DelaySDAE, IndexOneSDAE)
CLASSES = [kind for form in FORMS for kind in form.generic_classes()]
SEED, STEP = 5, 1e-30
MECHANICS, KEPT, PENALISED, DELAYS, INDEX_ONE = CLASSES
every_class = pytest.mark.parametrize("kind", CLASSES, ids=lambda kind: kind.name)


def complex_steps(f, x):
    """Return the derivatives of f by complex steps: of component i by variable k, shape (..., d, P)."""
    steps = [f(x + 1j * STEP * np.eye(len(x))[:, k : k + 1]).imag / STEP for k in range(len(x))]
    return np.stack(steps, axis=-2)


def start_of(member):
    """Return all components of the start in one array."""
    return np.concatenate([*member.parts(member.initial(1)).values()], axis=None)


def near(x):
    """Return some points near others, shape (d, 3)."""
    return x[:, :1] + 0.1 * np.random.default_rng(1).standard_normal((len(x), 3))


@every_class
def test_a_member_is_decided_by_seed_and_index(kind):
    """The same seed and index give the same equation, others another one."""
    first = start_of(kind.member(1, 0))
    assert np.array_equal(first, start_of(kind.member(1, 0)))
    for other in (kind.member(1, 1), kind.member(2, 0)):
        assert not np.array_equal(first[:2], start_of(other)[:2])


@every_class
def test_members_start_consistently(kind):
    """All constraints hold at the start up to rounding, or up to eps where there is a penalty."""
    for index in range(5):
        member = kind.member(SEED, index)
        parts = member.parts(member.initial(1))
        if kind is not PENALISED and not member.moving_constraints:
            for residual in member.residuals(parts).values():
                assert np.abs(residual.value).max() <= 1e-13 * np.max(residual.scale)


def test_derivatives_of_mechanics_are_those_of_complex_steps():
    """The closed derivatives of the force, of g and of Dg agree with complex steps; Dg has full rank."""
    member = MECHANICS.member(SEED, 0)
    r, v = (near(part) for part in member.initial(1)[:2])
    a_r, a_v = member.force_derivatives(0.2, r, v)
    assert np.allclose(a_r, complex_steps(lambda x: member.force(0.2, x, v + 0j * x), r), rtol=1e-11)
    assert np.allclose(a_v, complex_steps(lambda x: member.force(0.2, r + 0j * x, x), v), rtol=1e-11)
    assert np.allclose(member.jacobian(r), complex_steps(member.constraint, r), rtol=1e-11)
    second = complex_steps(member.jacobian, r)
    assert np.allclose(member.curvature(r, v, v), np.einsum("mijp,ip,jp->mp", second, v, v), rtol=1e-11)
    assert np.linalg.matrix_rank(member.jacobian(r[:, :1])[..., 0]) == 2


def test_mechanics_have_all_features():
    """M is full, the velocity tangential and not 0, g curved; a and B depend on time, position and velocity."""
    member = MECHANICS.member(SEED, 0)
    r, v = member.initial(1)[:2]
    M = np.asarray(member.mass)
    assert np.abs(M).min() > 1e-3
    assert np.allclose(M, M.T)
    assert np.linalg.eigvalsh(M)[0] > 0.5
    assert np.abs(member.jacobian(r)[..., 0] @ v).max() < 1e-13 < np.abs(v).max()
    assert np.abs(member.curvature(r, v, v)).min() > 1e-3
    for f in (member.force, member.diffusion):
        known = f(0.2, r, v)
        assert not any(np.allclose(known, f(*other)) for other in ((0.3, r, v), (0.2, r + 0.1, v), (0.2, r, v + 0.1)))


@pytest.mark.parametrize("kind", [KEPT, PENALISED], ids=lambda kind: kind.name)
def test_derivatives_of_langevin_dynamics_are_those_of_complex_steps(kind):
    """Jacobian, contractions of the Hessians and their traces agree with complex steps."""
    member = kind.member(SEED, 0)
    x = near(member.initial(1))
    H = complex_steps(member.jacobian, x)
    A = np.random.default_rng(2).standard_normal((len(x), len(H), x.shape[1]))
    assert np.allclose(member.jacobian(x), complex_steps(member.constraint, x), rtol=1e-11)
    assert np.allclose(member.second(x, A), np.einsum("kijp,jkp->ip", H, A), rtol=1e-11)
    assert np.allclose(member.laplacians(x), np.einsum("kiip->kp", H), rtol=1e-11)
    assert np.abs(member.laplacians(x)).min() > 1e-3


@pytest.mark.parametrize("kind", [DELAYS, INDEX_ONE], ids=lambda kind: kind.name)
def test_derivatives_of_delay_equations_are_those_of_complex_steps(kind):
    """The derivatives of f and u by x, lagged values and y agree with complex steps; du/dy is regular."""
    member = kind.member(SEED, 0)
    state = member.initial(1)
    x, y = near(state.x), near(state.y)
    lagged = x + 0.1
    for f, found in (
        (member.drift, member.linearised_drift(0.3, x, lagged, y)),
        (member.constraint, member.linearised_constraint(0.3, x, lagged, y)),
    ):
        assert np.allclose(found.x, complex_steps(lambda z, f=f: f(0.3, z, lagged + 0j * z, y), x), rtol=1e-11)
        assert np.allclose(found.y, complex_steps(lambda z, f=f: f(0.3, x, lagged, z), y), rtol=1e-11)
    assert np.abs(np.linalg.det(found.y[..., 0])) > 0.5


def test_lags_are_no_multiple_of_a_step():
    """The lag of a member is a part of the horizon between mesh points of every step count, another in each draw."""
    lags = [DELAYS.member(SEED, index).delay for index in range(3)]
    steps = 2.0 ** -np.arange(1, 20)
    assert len({*lags}) == 3
    assert all(0.3 <= lag <= 0.6 and (lag / steps % 1.0).min() > 0.0 for lag in lags)


def test_what_is_left_out_gives_the_traits_that_follow():
    """Members without a feature lack it, and declare the traits that claims ask for."""
    plain = MECHANICS.member(SEED, 0, MECHANICS.features)
    assert plain.mass is None
    assert (plain.constraints, plain.noise_dim) == (1, 1)
    r, v = plain.initial(1)[:2]
    assert np.allclose(plain.curvature(r, v, v), 0.0)
    assert np.array_equal(plain.force(0.1, r, v), plain.force(0.9, r, 2.0 * v))
    assert "vanishing-milstein-term" in MECHANICS.member(SEED, 0, {"velocity-noise"}).traits
    assert "vanishing-milstein-term" not in MECHANICS.member(SEED, 0).traits
    assert "additive-noise" in DELAYS.member(SEED, 0, {"state-noise"}).traits
    assert "no-delay" in DELAYS.member(SEED, 0, {"delay"}).traits
    assert "algebraic" not in DELAYS.member(SEED, 0, {"constraint"}).traits
    assert {member.eps > 0.0 for member in (KEPT.member(SEED, 0), PENALISED.member(SEED, 0))} == {False, True}


def test_a_member_without_a_feature_keeps_the_rest():
    """A member without a mass matrix has the force of the member with it: parts are switched off one by one."""
    whole, unit = MECHANICS.member(SEED, 0), MECHANICS.member(SEED, 0, {"mass"})
    r = whole.initial(1)[0]
    assert np.array_equal(whole.constraint(r + 0.1), unit.constraint(r + 0.1))
    assert np.array_equal(whole.jacobian(r), unit.jacobian(r))
    assert unit.mass is None


def test_a_draw_that_raises_is_drawn_again():
    """An inconsistent draw is followed by the next one of the same stream, and many of them by the error."""
    drawn = []

    def draw(rng, without):
        drawn.append(float(rng.uniform()))
        if len(drawn) < 3:
            raise ProblemError("inconsistent")
        return drawn[-1]

    def never(rng, without):
        raise ProblemError("no member")

    assert GenericClass("mine", draw).member(1, 0) == drawn[2]
    assert len({*drawn}) == 3
    with pytest.raises(ProblemError, match="no member"):
        GenericClass("mine", never).member(1, 0)


@every_class
def test_a_class_is_sent_to_workers(kind):
    """A task with a class, narrowed or not, is the same after pickling and draws the same members."""
    for members in (MemberClass(kind), MemberClass(kind).narrowed(next(iter(kind.features)))):
        task = pickle.loads(pickle.dumps(ClassTask(ORDER_TESTS, members, ())))
        assert task.kind == members
        assert task.kind.features == members.features
        ours, theirs = member_of(members, SEED, 0), task.kind.of.member(SEED, 0, task.kind.without)
        assert np.array_equal(start_of(ours), start_of(theirs))
