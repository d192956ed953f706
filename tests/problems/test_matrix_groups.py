"""Matrices near x^T x = Id: closed forms against the dense ones, and what is known of their laws."""

import numpy as np
import pytest

from problems.generator import generator, observed
from sdaeverify import ConstraintGeometry, Increment, ParameterError
from sdaeverify.forms.truths import InvariantMean, Moment
from sdaeverify.probe.step.nodes import step_nodes
from sdaeverify.testing.checks.differences import SECOND_ERROR
from sdaeverify_problems import _lyapunov
from sdaeverify_problems._eigenangle_law import mean_trace
from sdaeverify_problems._lyapunov import Lyapunov, dense
from sdaeverify_problems._polar_law import PolarLaw, rotations_in_space
from sdaeverify_problems.orthogonal_group import orthogonal_group, trace
from sdaeverify_problems.stiefel import stiefel
from sdaeverify_schemes.uniformly_accurate import UniformlyAccurate

SIZES = [(2, 2), (3, 3), (5, 5), (3, 2), (4, 1), (6, 3)]
FORMS = ("zeta", "share", "relaxation", "quadratic", "fixman", "divergence", "normal_traces", "dual")
PATHS = 5
ROOT = 2.0**0.5
# E tr x under the invariant law, kappa = 100: printed values and half of a unit of their last digits, or as stated.
LIMIT = {2: 1.9949937185, 3: 2.9849811079, 4: 3.9699621198, 5: 4.9499367055}
FLAT = {2: 1.7270452220, 3: 2.1636105347, 4: 2.3074332356, 5: 2.2425482845}
PRINTED = [(1e-4, 2, 1.9954871718, 6e-11), (1e-3, 2, 1.9994092856, 6e-11), (5e-3, 2, 2.0099269859, 6e-11)]
PRINTED += [(5e-2, 2, 2.0259708609, 6e-11), (1e-4, 3, 2.9860173, 1e-7), (1e-3, 3, 2.994260, 1e-6)]
PRINTED += [(5e-3, 3, 3.0164269, 6e-8), (5e-2, 3, 3.050646, 3e-6)]


def points(d, p, size=0.2, seed=1):
    return np.eye(d, p).ravel()[:, None] + size * np.random.default_rng(seed).standard_normal((d * p, PATHS))


def close(a, b):
    return a.shape == np.broadcast_shapes(a.shape, b.shape) and np.allclose(a, b, rtol=1e-10, atol=1e-11)


@pytest.mark.parametrize(("d", "p"), SIZES)
def test_closed_forms_are_the_dense_ones(d, p):
    """What follows from C alone is what the Gram matrix and the Hessians give."""
    problem, x = stiefel(0.1, d, p), points(d, p)
    ours, dense_ = problem.near(x), ConstraintGeometry(problem, x)
    for name in FORMS:
        assert close(getattr(ours, name), getattr(dense_, name)), name


@pytest.mark.parametrize(("d", "p"), SIZES)
@pytest.mark.parametrize("columns", [(), (3,)])
def test_the_linearised_constraint_is_the_dense_one(d, p, columns):
    """Products with g, and solutions with Gram matrices of one and of two points."""
    problem, rng = stiefel(0.1, d, p), np.random.default_rng(3)
    x, z = points(d, p), points(d, p, seed=2)
    y, c = rng.standard_normal((d * p, *columns, PATHS)), rng.standard_normal((p * (p + 1) // 2, *columns, PATHS))
    (J, K), (Jd, Kd) = ([form(v) for v in (x, z)] for form in (lambda v: problem.near(v).J, problem.linearised))

    assert close(J.times(y), Jd.times(y))
    assert close(J.transposed(c), Jd.transposed(c))
    assert close(J.size(), Jd.size())
    for ours, theirs in ((J.gram(J), Jd.gram(Jd)), (J.gram(K), Jd.gram(Kd))):
        assert close(ours.solve(c), theirs.solve(c))
        assert np.array_equal(ours.positive(), theirs.positive())


def test_the_equation_is_solved_where_its_series_does_not_converge():
    """Beside paths on which it does: eigenvalues with negative real parts, or far from 1, need the dense matrix."""
    M = np.stack([np.eye(3), np.diag([1.0, -0.5, 2.0]), np.diag([1e-6, 1.0, 1.0]), -np.eye(3) + 0.1], axis=-1)
    b = np.random.default_rng(0).standard_normal((6, 4))
    system = Lyapunov.of(M)

    assert system.poor.tolist() == [False, True, True, True]
    residual = np.einsum("ijp,jp->ip", dense(M), system.solve(b)) - b
    assert np.abs(residual).max() < 1e-9
    assert np.array_equal(system.positive(), np.linalg.det(np.moveaxis(dense(M), -1, 0)) > 0.0)
    assert len(system.powers) == _lyapunov.MOST


def test_the_forms_are_analytic():
    """Complex steps through closed forms and Gram matrices give derivatives."""
    problem, x = stiefel(0.1, 3, 3), points(3, 3)
    y, h = points(3, 3, seed=4), 1e-30
    for f in (
        lambda v: problem.near(v).fixman,
        lambda v: problem.near(v).relaxation,
        lambda v: problem.near(v).normal(y),
    ):
        steps = (f(x + 1e-5 * y) - f(x - 1e-5 * y)) / 2e-5
        assert np.allclose(f(x + 1j * h * y).imag / h, steps, rtol=1e-6, atol=1e-7)


def test_the_limit_decays_as_the_heat_equation_says():
    """The Ito drift of (1.2) without force is -(1/2) (d - 1 - (p - 1)/2) X."""
    for d, p in SIZES:
        problem = stiefel(0.0, d, p)
        x = problem.admissible(points(d, p))
        assert np.allclose(problem.ito().drift(0.0, x), -0.5 * (d - 1.0 - 0.5 * (p - 1.0)) * x, atol=1e-12)


@pytest.mark.parametrize("problem", [stiefel(0.0, 4, 2), orthogonal_group(0.0), orthogonal_group(0.0, 3, 1.5)])
def test_moments_of_the_limit_start_with_the_rate_of_the_generator(problem):
    """Their derivative at time 0 is that of the Ito equation."""
    moments = [truth for truth in problem.truths if isinstance(truth, Moment)]
    assert moments
    for moment in moments:
        rate = generator(problem, observed(problem, moment.observable), problem.initial(1))[0]
        s = 1e-4
        slope = (-3.0 * moment.value(0.0) + 4.0 * moment.value(s) - moment.value(2.0 * s)) / (2.0 * s)
        assert slope == pytest.approx(rate, abs=1e-5)


@pytest.mark.parametrize("m", [2, 3, 4, 5])
def test_means_on_the_group_are_the_printed_ones(m):
    """Weyl's integration formula, for a narrow and for a broad law."""
    assert mean_trace(m, 100.0) == pytest.approx(LIMIT[m], abs=6e-11)
    assert mean_trace(m, 2.0) == pytest.approx(FLAT[m], abs=6e-11)


@pytest.mark.parametrize("m", [2, 3])
@pytest.mark.parametrize("stiffness", [0.3, 2.0, 5.0])
def test_the_moment_tends_to_the_invariant_mean(m, stiffness):
    """Two quadratures, one through eigenfunctions."""
    moment, mean = (
        next(truth.value for truth in orthogonal_group(0.0, m, stiffness).truths if isinstance(truth, kind))
        for kind in (Moment, InvariantMean)
    )
    # The polynomials are orthonormal for a weight that varies by e^{4 a}: large by its root where it is low.
    rounding = 8 * np.finfo(float).eps * np.exp(2 * stiffness)
    assert moment(1e3) == pytest.approx(mean, abs=1e-12 + rounding)


@pytest.mark.parametrize(("eps", "m", "value", "accuracy"), PRINTED)
def test_means_around_the_group_are_the_printed_ones(eps, m, value, accuracy):
    """Quadrature over singular values and rotations."""
    assert PolarLaw(eps, 100.0, ROOT, m).trace() == pytest.approx(value, abs=accuracy)


def test_rotations_in_space_integrate_to_their_mean():
    """With a random rotation for each node, exp(a tr(Q diag(s))) has the mean Z and tr(Q diag(s)) the derivative."""
    s, a = np.array([[1.3], [0.9], [0.5]]), 0.8
    q = np.random.default_rng(1).standard_normal((4, 200_000))
    _, x, y, z = q / np.linalg.norm(q, axis=0)
    traced = s[0] * (1 - 2 * (y * y + z * z)) + s[1] * (1 - 2 * (x * x + z * z)) + s[2] * (1 - 2 * (x * x + y * y))
    values = np.exp(a * (traced - s.sum()))
    Z, slope = (part[0] for part in rotations_in_space(a, s))

    assert abs(Z - values.mean()) < 4.0 * values.std() / 200_000**0.5
    assert abs(slope - (values * traced).mean()) < 4.0 * (values * traced).std() / 200_000**0.5


def plane_law(eps, kappa):
    """Return x = Q diag(s) for rotations Q on a grid, and the invariant weights: those of x V^T are the same."""
    z, w = np.polynomial.legendre.leggauss(40)
    total, part = 3.25 * (z + 1.0), 0.5 * (z + 1.0)
    total, part, angle = np.meshgrid(total, part, 2.0 * np.pi * np.arange(32) / 32, indexing="ij")
    rule = (w[:, None, None] * w[:, None] * np.ones(32) * total).ravel()
    s1, s2, angle = (v.ravel() for v in (0.5 * total * (1.0 + part), 0.5 * total * (1.0 - part), angle))
    x = np.stack([s1 * np.cos(angle), -s2 * np.sin(angle), s1 * np.sin(angle), s2 * np.cos(angle)])
    log = -(s1**2 + s2**2) / (4.0 * eps) + (1.0 + 0.5 / eps) * np.log(s1 * s2) + 0.5 * np.log(s1**2 + s2**2)
    log += np.log(s1**2 - s2**2) - 0.5 * kappa * ((x - np.eye(2).reshape(4, 1)) ** 2).sum(axis=0)
    weights = rule * np.exp(log - log.max())
    return x, weights / weights.sum()


def test_means_around_the_plane_rotations_agree_with_another_quadrature():
    """Over two singular values and an angle; the equation's generator leaves that law alone, and not another."""
    eps, kappa = 0.2, 2.0
    problem, (x, weights) = orthogonal_group(eps, 2, kappa), plane_law(eps, kappa)
    known = {truth.observable: truth.value for truth in problem.truths}

    assert known["tr x"] == pytest.approx(weights @ trace(x), abs=1e-7)
    assert known["|x|^2"] == pytest.approx(weights @ (x * x).sum(axis=0), abs=1e-7)
    image = generator(problem, observed(problem, "tr x"), x)
    assert abs(weights @ image) < 1e-6
    assert abs(plane_law(eps, 2.2)[1] @ image) > 1e-2


@pytest.mark.parametrize(("d", "p"), [(3, 2), (2, 2)])
@pytest.mark.parametrize("eps", [1e-4, 0.1, 3.0])
def test_a_uniformly_accurate_step_keeps_the_mean_square(d, p, eps):
    """Without force E |X|^2 is exact for any step, at points off the manifold, too; with three-point noise."""
    problem, h, scheme = stiefel(eps, d, p), 0.01, UniformlyAccurate(xi="three-point", no_root="fail")
    nodes = step_nodes(d * p, 3, law=scheme.law)
    x = points(d, p, size=min(0.05, eps**0.5))[:, :1]
    start = np.repeat(x, len(nodes.weights), axis=1)
    new = scheme.step(problem, start, 0.0, h, Increment(np.sqrt(h) * nodes.dW, None)).state
    level = p + eps * (d * p + p * (p + 1) / 2)
    expected = level + (float((x * x).sum()) - level) * np.exp(-h / eps)

    assert nodes.mean((new * new).sum(axis=0)) == pytest.approx(expected, rel=1e-13)


@pytest.mark.parametrize("kappa", [0.0, 1.3])
def test_the_square_is_known_at_every_time(kappa):
    """The moments of |x|^2 and its generator have the rate d p + q - (Y - p)/eps - 2 kappa Y."""
    problem = stiefel(0.2, 4, 2, kappa)
    moments = {truth.observable: truth.value for truth in problem.truths if isinstance(truth, Moment)}
    t, s = 0.3, 1e-4
    slope = (moments["|x|^2"](t + s) - moments["|x|^2"](t - s)) / (2.0 * s)
    assert slope == pytest.approx(
        11.0 - (moments["|x|^2"](t) - 2.0) / 0.2 - 2.0 * kappa * moments["|x|^2"](t), abs=1e-6
    )
    x = points(4, 2)
    Y = (x * x).sum(axis=0)
    image = generator(problem, observed(problem, "|x|^2"), x)
    assert np.abs(image - (11.0 - (Y - 2.0) / 0.2 - 2.0 * kappa * Y)).max() < 100 * SECOND_ERROR


@pytest.mark.parametrize("eps", [1e-300, 1e-12, 1e300])
def test_extreme_stiffness(eps):
    """Truths are finite, and those of weak noise across the manifold are the limit's."""
    for m in (2, 3):
        value = orthogonal_group(eps, m).truths[0].value
        assert np.isfinite(value)
        assert eps > 1.0 or value == pytest.approx(FLAT[m], abs=1e-8)
    problem = stiefel(eps)
    assert np.isfinite(problem.ito().drift(0.0, problem.initial(1))).all()


def test_tabulated_means_are_known_for_their_parameters_only():
    """Sizes 4 and 5, stiffness 100, four values of eps."""
    (mean, square) = (truth.value for truth in orthogonal_group(5e-3, 4, 100.0).truths)
    assert mean == 4.023898
    assert 2.0 * square == pytest.approx(4.0 + 5e-3 * (200.0 * mean + 2.0 * 26.0), rel=1e-14)
    assert orthogonal_group(5e-3, 4).truths == ()
    assert orthogonal_group(6e-3, 4, 100.0).truths == ()


@pytest.mark.parametrize(
    ("problem", "given", "message"),
    [
        (orthogonal_group, {"eps": -0.1}, "eps must be finite and not negative"),
        (orthogonal_group, {"m": 1}, "m must be at least 2"),
        (orthogonal_group, {"stiffness": 0.0}, "stiffness must be positive"),
        (orthogonal_group, {"stiffness": 1e9}, "stiffness must be at most 1e4"),
        (stiefel, {"eps": float("nan")}, "eps must be finite and not negative"),
        (stiefel, {"p": 4}, "p must be between 1 and d"),
        (stiefel, {"d": 1, "p": 1}, "d at least 2"),
        (stiefel, {"damping": -1.0}, "damping must be finite and not negative"),
    ],
)
def test_bad_parameters_are_named(problem, given, message):
    """One line each."""
    with pytest.raises(ParameterError, match=message) as caught:
        problem(**given)
    assert "\n" not in str(caught.value)
