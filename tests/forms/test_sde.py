"""The SDE form: what it refuses, its derivative of the diffusion, its named components."""

import numpy as np
import pytest

from forms.refusing import refusal
from sdaeverify import SDE, HolonomicSDAE, Moment, Pathwise, ProblemError, SchemeError

EPS = np.finfo(float).eps


def drift(t, x):
    """Return a linear drift."""
    return -x


def diffusion(t, x):
    """Return a diffusion matrix of shape (2, 2, P) that mixes the components."""
    zero = 0.0 * x[0]
    return np.stack([np.stack([x[0] * x[1], zero]), np.stack([np.sin(x[0]), np.exp(x[1])])])


def make(**changes):
    """Return a valid problem with some of its arguments changed."""
    valid = {"drift": drift, "diffusion": diffusion, "start": [0.5, -0.3], "horizon": 1.0, "noise_dim": 2}
    return SDE(**{**valid, "source": "made up", **changes})


def moment(observable):
    """Return a truth about an observable."""
    return Moment(observable=observable, value=lambda t: 1.0, source="made up")


def ellipse(x):
    """Return x_1^2/4 + x_2^2 - 1, shape (1, P)."""
    return (0.25 * x[0] ** 2 + x[1] ** 2 - 1.0)[None]


def on_the_ellipse(**changes):
    """Return a problem that starts on the ellipse and claims to stay there."""
    return make(**{"constraint": ellipse, "start": [1.2, 0.8], **changes})


def uneven(t, x):
    """Return a full diffusion matrix that depends on the state."""
    return (1.0 + x[0]) * np.ones((2, 2, 1))


def known(parts):
    """Return a solution on a path of these components."""
    return Pathwise(start=make().initial, advance=lambda z, t, h, dw: z, parts=parts, source="made up")


CONSTANT = {"diffusion": lambda t, x: np.eye(2)[..., None]}
GRADIENT = {"traits": {"overdamped-gradient"}, **CONSTANT}
REFUSED = [
    ({"horizon": 0.0}, "horizon must be a positive time, got 0.0"),
    ({"horizon": np.inf}, "horizon must be a positive time, got inf"),
    ({"noise_dim": 0}, "noise_dim must be a whole number of at least 1, got 0"),
    ({"noise_dim": 2.0}, "noise_dim must be a whole number of at least 1, got 2.0"),
    ({"traits": {"additiv-noise"}}, "'vanishing-milstein-term']; did you mean additive-noise?"),
    ({"traits": {"white-noise"}}, "unknown traits ['white-noise']; known are ['additive-noise',"),
    ({"truths": (moment("energy"),)}, "a truth is about observable 'energy'; known are []"),
    ({"start": [[0.5, -0.3]]}, "start must be a vector of finite numbers, got [[0.5, -0.3]]"),
    ({"start": []}, "start must be a vector of finite numbers, got []"),
    ({"start": [0.5, np.nan]}, "start must be a vector of finite numbers, got [0.5, nan]"),
    ({"start": [0.5, 1j]}, "start must be a vector of finite numbers, got [0.5, 1j]"),
    ({"drift": lambda t, x: x.T}, "drift(t, x) returned shape (3, 2), expected (2, 3) for 3 paths (paths last)"),
    ({"drift": lambda t, x: [x[0], 1.0]}, "drift(t, x) returned list, expected an array of real numbers"),
    ({"drift": lambda t, x: x + 0j}, "drift(t, x) returned an array of complex128, expected an array of real"),
    ({"drift": lambda t, x: x + np.inf}, "drift(t, x) is not finite at the initial state: [inf, inf]"),
    ({"diffusion": lambda t, x: x}, "diffusion(t, x) returned shape (2, 3), expected (2, 2, 3)"),
    ({"noise_dim": 1}, "diffusion(t, x) returned shape (2, 2, 3), expected (2, 1, 3)"),
    (
        {"drift_derivative": lambda t, x: x},
        "drift_derivative(t, x) returned shape (2, 3), expected (2, 2, 3)",
    ),
    (
        {"diffusion_derivative": lambda t, x, y: x},
        "diffusion_derivative(t, x, y) returned shape (2, 3), expected (2, 2, 3)",
    ),
    (
        {"diffusion_derivative": lambda t, x, y: np.full((2, 2, x.shape[-1]), 7.0)},
        "diffusion_derivative disagrees with a difference quotient",
    ),
    ({"diffusion_product": lambda t, x, w: x + w}, "diffusion_product disagrees"),
    ({"names": {"x": slice(2, 3)}}, "names['x'] must be a slice of the 2 components, got slice(2, 3, None)"),
    ({"names": {"x": 0}}, "names['x'] must be a slice of the 2 components, got 0"),
    ({"observables": {"phi": lambda t, s: s["y"][0]}}, "'phi' asks for 'y'; the problem's components are x"),
    ({"observables": {"phi": lambda t, s: s["x"]}}, "'phi' returned shape (2, 3), expected (3,)"),
    ({"truths": (known(lambda t, z: {"y": z}),)}, "the truth provides ['y'], the problem's components are ['x']"),
    ({"truths": (known(lambda t, z: {"x": z[:1]}),)}, "paths last"),
    ({"truths": (known(lambda t, z: {"x": z + 1.0}),)}, "the truth starts with x at"),
    ({"traits": {"additive-noise"}, "diffusion": uneven}, "trait additive-noise: the diffusion"),
    ({"traits": {"diagonal-noise"}, "diffusion": uneven}, "trait diagonal-noise: the diffusion"),
    ({"traits": {"commutative-noise"}}, "trait commutative-noise: DB_j B_k and DB_k B_j differ"),
    ({**GRADIENT, "diffusion": lambda t, x: np.diag([1.0, 2.0])[..., None]}, "the diffusion is not a multiple of Id"),
    ({**GRADIENT, "drift": lambda t, x: (1.0 + t) * x}, "trait overdamped-gradient: the drift depends on time"),
    ({**GRADIENT, "drift": lambda t, x: x[::-1] * [[1.0], [2.0]]}, "trait overdamped-gradient: Df is not symmetric"),
    ({"constraint": None, "jacobian": lambda x: x[None]}, "jacobian is given without constraint"),
]
OFF_THE_ELLIPSE = [
    ({"start": [1.2, 0.9]}, "the initial state violates constraint = 0: constraint is 0.1"),
    ({"constraint": lambda x: np.abs(x[:1]) - 1.2}, "constraint is not analytic"),
    ({"jacobian": lambda x: x}, "jacobian(x) returned shape (2, 3), expected (1, 2, 3)"),
    ({"jacobian": lambda x: x[None]}, "jacobian disagrees with a difference quotient"),
    ({"constraint": lambda x: 0.0 * x[0]}, "constraint(x) returned shape (3,), expected (1, 3)"),
    ({"constraint": lambda x: None}, "constraint(x) returned NoneType"),
]
REFUSED += [({"constraint": ellipse, "start": [1.2, 0.8], **changes}, text) for changes, text in OFF_THE_ELLIPSE]


@pytest.mark.parametrize(("changes", "message"), REFUSED, ids=[text for _, text in REFUSED])
def test_contradictory_problems_are_refused_in_one_line(changes, message):
    """The message says what was expected and what was given."""
    assert message in refusal(make, **changes)


def test_a_given_derivative_is_used():
    """An author's derivative is not replaced by a complex step."""
    kinked = make(
        diffusion=lambda t, x: np.abs(x)[:, None] + 1.0,
        noise_dim=1,
        diffusion_derivative=lambda t, x, y: (np.sign(x) * y)[:, None],
    )
    x = np.full((2, 4), -3.0)
    assert (kinked.derivative_of_diffusion(0.0, x, np.ones((2, 4))) == -1.0).all()


def absolute(t, x):
    """Return a diffusion with a kink."""
    return np.abs(x)[:, None]


def test_a_diffusion_without_derivative_says_so():
    """A diffusion with a kink is a valid problem, for schemes that need no derivative; the reason is given."""
    kinked = make(diffusion=absolute, noise_dim=1)
    assert "diffusion is not analytic" in kinked.why_not_derivative_of_diffusion()
    assert "give diffusion_derivative" in kinked.why_not_derivative_of_diffusion()
    given = make(diffusion=absolute, noise_dim=1, diffusion_derivative=lambda t, x, y: (np.sign(x) * y)[:, None])
    assert given.why_not_derivative_of_diffusion() == ""
    assert make().why_not_derivative_of_diffusion() == ""


def test_the_start_is_a_read_only_copy():
    """Neither the caller's array nor the problem's can change the problem later."""
    mine = np.array([0.5, -0.3])
    problem = make(start=mine)
    mine[0] = 9.0
    assert problem.start.tolist() == [0.5, -0.3]
    assert not problem.start.flags.writeable


def test_components_have_names():
    """Names select rows; without names the whole state is x."""
    x = np.arange(6.0).reshape(2, 3)
    assert np.array_equal(make().parts(x)["x"], x)
    named = make(names={"q": slice(0, 1), "p": slice(1, 2)}).parts(x)
    assert {name: rows.tolist() for name, rows in named.items()} == {"q": [[0, 1, 2]], "p": [[3, 4, 5]]}


@pytest.mark.parametrize(
    ("changes", "traits"),
    [
        ({}, set()),
        ({"noise_dim": 1, "diffusion": lambda t, x: x[:, None]}, {"scalar-noise", "commutative-noise"}),
        (
            {"traits": {"additive-noise"}, **CONSTANT},
            {"additive-noise", "vanishing-milstein-term", "commutative-noise"},
        ),
        ({"traits": {"diagonal-noise"}, **CONSTANT}, {"diagonal-noise", "commutative-noise"}),
        (
            {**GRADIENT, "drift": lambda t, x: -x * (x * x).sum(axis=0)},
            {"overdamped-gradient", "additive-noise", "vanishing-milstein-term", "commutative-noise"},
        ),
    ],
)
def test_traits_that_follow_are_added(changes, traits):
    """One motion is scalar noise; scalar, diagonal and additive noises commute; nothing else follows."""
    assert make(**changes).traits - {"linear-growth"} == traits | {"unconstrained", "no-delay"}


def test_noises_that_commute_may_be_declared_so():
    """A growth and a rotation commute: the trait is believed, and nothing else follows from it."""
    turn = np.array([[0.0, 2.0], [-2.0, 0.0]])
    turned = make(diffusion=lambda t, x: np.stack([x, turn @ x], axis=1), traits={"commutative-noise"})
    assert turned.traits == {"commutative-noise", "unconstrained", "no-delay", "linear-growth"}


def test_views_are_of_its_own_form_only():
    """An SDE is offered as an SDE and as nothing else; it has no constraints."""
    problem = make()
    assert problem.view(SDE) is problem
    assert problem.view(HolonomicSDAE) is None
    assert not problem.has_constraints
    assert problem.residuals({}) == {}


def test_the_pathwise_truth_is_found_among_the_truths():
    """Other truths do not count as a solution on a path."""
    start = make().initial
    path = Pathwise(start=start, advance=lambda z, t, h, dw: z, parts=lambda t, z: {"x": z}, source="made up")
    truths = (moment("energy"), path)
    assert make(truths=truths, observables={"energy": lambda t, s: s["x"][0]}).pathwise is path
    assert path.exact
    assert make().pathwise is None


def test_a_state_with_further_memory_is_not_split():
    """A bare array of another length is no state of the problem."""
    with pytest.raises(SchemeError, match="additional memory"):
        make().parts(np.ones((3, 4)))


def test_a_constraint_is_a_residual():
    """Its defect is called g, and its scale is the size of Dg times that of the state."""
    problem, x = on_the_ellipse(), np.array([[1.2, 2.0], [0.8, 1.0]])
    value, scale = problem.residuals(problem.parts(x))["g"]
    assert problem.has_constraints
    assert np.abs(value - [[0.0, 1.0]]).max() <= 8 * EPS
    expected = np.hypot(0.5 * x[0], 2.0 * x[1]) * np.hypot(*x)
    assert np.abs(scale - expected).max() <= 16 * EPS * expected.max()


def test_a_jacobian_that_is_given_makes_up_for_a_constraint_that_is_not_analytic():
    """Dg is the author's, and complex numbers are asked of nothing."""
    problem = on_the_ellipse(
        constraint=lambda x: ellipse(x.real), jacobian=lambda x: np.stack([0.5 * x[0], 2.0 * x[1]])[None]
    )
    assert problem.dg(np.array([[1.0], [3.0]])).tolist() == [[[0.5], [6.0]]]


def test_admissible_states_are_on_the_manifold_and_near():
    """Points beside the manifold are moved onto it, those on it stay."""
    problem = on_the_ellipse()
    angle = np.linspace(0.0, 6.0, 9)
    x = np.stack([2.0 * np.cos(angle), np.sin(angle)])
    assert np.abs(ellipse(problem.admissible(1.1 * x))).max() <= 8 * EPS
    assert np.abs(problem.admissible(1.1 * x) - x).max() <= 0.5
    assert np.abs(problem.admissible(x) - x).max() <= 8 * EPS


def test_a_drift_derivative_is_the_author_s_or_taken_by_complex_step():
    """Both agree, and a wrong one is refused; a drift that is not analytic needs one."""
    x, A = np.array([[0.3, -1.0], [0.7, 0.2]]), np.array([[1.0, 2.0], [-0.5, 0.25]])
    linear = {"drift": lambda t, x: A @ x}
    given, taken = make(**linear, drift_derivative=lambda t, x: A[..., None]), make(**linear)
    np.testing.assert_allclose(
        np.broadcast_to(given.derivative_of_drift(0.0, x), (2, 2, 2)), taken.derivative_of_drift(0.0, x), rtol=1e-15
    )
    with pytest.raises(ProblemError, match="drift_derivative disagrees with a difference quotient"):
        make(**linear, drift_derivative=lambda t, x: 2.0 * A[..., None])
    assert "drift is not analytic" in make(drift=lambda t, x: np.abs(x)).why_not_derivative_of_drift()
