"""Modified equations: published ones are found again, and stationary laws are those that they predict."""

import importlib.util
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

import numpy as np
import pytest

from facade import (
    classes_of,
    harmonic_variances,
    modified_equation,
    notation_of,
    number_words,
    sampled_potential,
    summed,
)
from sdaeverify import SDE, Array, Increment, Langevin, Scheme, Step, UsageError
from sdaeverify.numerics import apply
from sdaeverify_orders import modified_equations
from sdaeverify_schemes.baoab import BAOAB
from sdaeverify_schemes.delays.stochastic_theta import StochasticTheta
from sdaeverify_schemes.euler_maruyama import EulerMaruyama, TamedEuler
from sdaeverify_schemes.heun import HeunAdditive
from sdaeverify_schemes.mala import MALA
from sdaeverify_schemes.milstein import Milstein
from sdaeverify_schemes.milstein_areas import MilsteinAreas

REPORT = Path(__file__).parents[2] / "reports" / "modified" / "run.py"


def report():
    """Return the program of the report, whose matrices are exact to rounding."""
    spec = importlib.util.spec_from_file_location("modified_report", REPORT)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def found(scheme, kind, motions=2):
    """Return the modified equation of a scheme for a class."""
    return modified_equation(scheme, classes_of(scheme)[kind], motions)


def formula(of, terms):
    """Return terms as a set of formulas."""
    notation = notation_of(of)
    return {notation.term(each) for each in summed(terms, of.motions)}


class OBABO(Scheme):
    """Exact Ornstein-Uhlenbeck half steps around a step of velocity Verlet; both halves have independent noise."""

    name: ClassVar[str] = "obabo"
    form: ClassVar[type] = Langevin
    noise: ClassVar[frozenset[str]] = frozenset({"dW", "H"})

    def step(self, problem: Langevin, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        n, gamma = problem.noise_dim, problem.friction
        decay, scale = np.exp(-0.5 * gamma * h), problem.strength * np.sqrt(-np.expm1(-gamma * h) / (gamma * h))
        halves = [0.5 * (noise.dW + sign * np.sqrt(12.0) * noise.H) for sign in (1.0, -1.0)]
        q, p = state[:n], decay * state[n:] + scale * halves[0]
        p = p + 0.5 * h * problem.force(q)
        q = q + h * p
        p = p + 0.5 * h * problem.force(q)
        return Step(np.concatenate([q, decay * p + scale * halves[1]]))


@dataclass(frozen=True)
class Stages(Scheme):
    """x+ = x + h [(1 - w) f(x) + w f(x + a h f(x) + d B dW)] + B dW of weak order 1; A - 2 B = C - 2 B = -1/2."""

    name: ClassVar[str] = "stages"
    form: ClassVar[type] = SDE

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        f, moved = problem.drift(t, state), apply(problem.diffusion(t, state), noise.dW)
        later = problem.drift(t, state + 0.25 * h * f + 0.5 * moved)
        return Step(state + h * (f / 3.0 + 2.0 * later / 3.0) + moved)


def test_additive_euler_maruyama():
    """Shardlow 2006; Zygalakis 2011: f - (h/2) (f'f + (1/2) f''[S, S]), S S^T - (h/2) (f' S S^T + S S^T f'^T)."""
    of = found(EulerMaruyama(), "additive")

    assert (of.order, of.exists) == (1.0, True)
    assert formula(of, of.drift) == {"-1/2 f' f", "-1/4 sum_j f''[b_j, b_j]", "-1/2 (d_t f)"}
    assert formula(of, of.covariance) == {"-1/2 sum_j sym(f' b_j, b_j)"}


def test_multiplicative_euler_maruyama_has_none():
    """Shardlow 2006: there is a term of third order, -(1/2) D^3 u [b, b, b'b]."""
    scalar, general = found(EulerMaruyama(), "scalar"), found(EulerMaruyama(), "general")

    assert not scalar.exists
    assert formula(scalar, scalar.obstruction) == {"-1/2 D^3 u[b, b, b' b]"}
    assert formula(general, general.obstruction) == {"-1/2 sum_(j,k) D^3 u[b_j, b_j' b_k, b_k]"}


def test_milstein():
    """Zygalakis 2011: f_1 = -(1/2) (f'f + (1/2) f'' b^2), b_1 = -(1/2) (f'b + b'f + (1/2) b'' b^2), autonomous."""
    of = found(Milstein(), "scalar")

    # 2 b b_1 is the change of the covariance, and sym(a, b) = 2 a b in one dimension.
    assert of.exists
    assert formula(of, of.drift) == {"-1/2 f' f", "-1/4 f''[b, b]", "-1/2 (d_t f)"}
    assert formula(of, of.covariance) == {
        "-1/2 sym(f' b, b)",
        "-1/2 sym(b, b' f)",
        "-1/4 sym(b, b''[b, b])",
        "-1/2 sym(b, (d_t b))",
    }


def test_milstein_of_general_noise():
    """With areas the same holds for several motions, and derivatives are summed over all of them."""
    of = found(MilsteinAreas(), "general")

    assert of.exists
    assert "-1/4 sum_(j,k) sym(b_j, b_j''[b_k, b_k])" in formula(of, of.covariance)


@pytest.mark.parametrize("theta", [0.0, 0.25, 1.0])
def test_theta_methods(theta):
    """Abdulle, Cohen, Vilmart & Zygalakis 2012: the theta method has (theta - 1/2) times the terms of order 1."""
    of = found(StochasticTheta(theta=theta), "additive")

    values = {"".join(map(str, each.forest)): each.value for each in of.terms}
    c = theta - 0.5
    wanted = {"f(f)": c, "f(t)": c, "f(b1,b1)": c / 2.0, "f(b2,b2)": c / 2.0, "f(b1)b1": c, "f(b2)b2": c}
    assert values == pytest.approx(wanted, abs=1e-7)


def test_euler_of_an_ode():
    """Without noise it is the classical -(h/2) f'f, and Heun's method has an equation at h^2."""
    euler, heun = found(EulerMaruyama(), "ode"), found(HeunAdditive(), "ode")

    assert formula(euler, euler.drift) == {"-1/2 f' f", "-1/2 (d_t f)"}
    # Hairer, Lubich & Wanner 2006, example IX.1.3 for weights of an explicit rule: f''(f, f)/12 - f'f'f/6.
    assert {"1/12 f''[f, f]", "-1/6 f' f' f"} <= formula(heun, heun.drift)


def test_baoab_without_friction_is_verlet():
    """The terms without friction are Hamilton's equations of p U'' p/12 - |grad U|^2/24, F = -grad U."""
    of = found(BAOAB(), "langevin")

    drift = formula(of, of.drift)
    assert {each for each in drift if "gamma" not in each} == {"-1/6 F' p", "1/12 F''[p, p]", "1/12 F' F"}


def test_harmonic_variances():
    """BAOAB: <p^2> = kT (1 - h^2 k/4), q exact; OBABO: p exact, <q^2> = (kT/k)/(1 - h^2 k/4); EM is linear in h.

    Leimkuhler & Matthews 2013, 2016. Of the linear steps these follow by Lyapunov equations.
    """
    baoab, obabo = (harmonic_variances(found(scheme, "langevin")) for scheme in (BAOAB(), OBABO()))

    assert baoab == (pytest.approx({(1, 0): -0.25}, abs=1e-6), {})
    assert obabo == ({}, pytest.approx({(1, 0): 0.25}, abs=1e-6))


@pytest.mark.long
@pytest.mark.parametrize(("scheme", "change"), [(BAOAB(), -0.25), (OBABO(), 0.0)])
def test_the_kinetic_temperature_of_a_quartic_potential(scheme, change):
    """Gamma (kT - <p^2>) = -h^2 <L_2 H>, and the mean of L_2 H is -(c/1) gamma kT <U''> for U = q^4/4 as well."""
    made, of = report(), found(scheme, "langevin")
    gamma, sigma = made.FRICTION, made.STRENGTH
    kT = sigma**2 / (2.0 * gamma)
    q, p = np.meshgrid(np.linspace(-3.5, 3.5, 401), np.linspace(-5.0, 5.0, 201) * np.sqrt(kT), indexing="ij")
    x = np.array([q.ravel(), p.ravel()])
    density = np.exp(-(0.25 * x[0] ** 4 + 0.5 * x[1] ** 2) / kT)
    density /= density.sum()
    powers = (lambda q: -(q**3), lambda q: -3.0 * q**2, lambda q: -6.0 * q, lambda q: -6.0 + 0.0 * q)

    def force(q, directions=()):
        return powers[len(directions)](q[0]) * np.prod([each[0] for each in directions], axis=0)

    dynamics = made.Periodic("langevin", [[force]])
    # H = U(q) + p^2/2: derivatives by q and p.
    mean = 0.0
    for term in of.terms:
        parts = [dynamics.differential(each, x) for each in term.forest]
        if len(parts) == 1:
            value = -powers[0](x[0]) * parts[0][0] + x[1] * parts[0][1]
        else:
            value = -powers[1](x[0]) * parts[0][0] * parts[1][0] + parts[0][1] * parts[1][1]
        mean += term.value * float((density * value).sum())

    assert mean / gamma == pytest.approx(change * kT * float((density * 3.0 * x[0] ** 2).sum()), abs=1e-6)


def test_the_potential_that_euler_maruyama_samples():
    """It is V - (h/4) |grad V|^2 + (h/2) kT lap V; a harmonic one has the variance (kT/k)/(1 - h k/2)."""
    named = {name: (power, c) for name, power, c in sampled_potential(found(EulerMaruyama(), "overdamped-gradient"))}

    assert named["|grad V|^2"] == (0, pytest.approx(-0.25, abs=1e-7))
    assert named["lap V"] == (1, pytest.approx(0.5, abs=1e-7))


def test_a_higher_invariant_order_samples_the_potential():
    """A scheme of weak order 1 whose invariant measure has order 2 has no terms in h."""
    assert sampled_potential(found(Stages(), "overdamped-gradient")) == []


@pytest.mark.long
def test_the_stationary_density_of_euler_maruyama_is_the_predicted_one():
    """On a periodic potential the density is that of V - h (V'^2/4 - V''/2), for kT = 1, up to h^2."""
    made = report()
    V = made.Waves(np.array([0.6, 0.3]), np.array([[1.0], [2.0]]), np.array([0.4, 2.0]), 0.0)
    # f = -V': each sine becomes a cosine.
    f = made.Waves(-V.sizes * V.rates[:, 0], V.rates, V.phases + 0.5 * np.pi, 0.0)
    b = made.Waves(np.zeros(1), np.ones((1, 1)), np.zeros(1), np.sqrt(2.0))
    of, basis = made.Periodic("additive", [[f], [b]]), made.Basis(1, momentum=False)
    x, one = basis.points, np.ones_like(basis.points)
    left = []
    for h in (0.04, 0.02):
        values, vectors = np.linalg.eig(made.transition(EulerMaruyama(), of, basis, h).T)
        density = np.real(vectors[:, np.argmax(np.real(values))])
        changed = V(x) - h * (0.25 * V(x, (one,)) ** 2 - 0.5 * V(x, (one, one)))
        predicted = np.exp(-changed)
        left.append(np.abs(density / density.sum() - predicted / predicted.sum()).max())

    assert left[1] < left[0] / 3.5


@pytest.mark.long
@pytest.mark.parametrize("kind", ["scalar", "additive"])
@pytest.mark.parametrize("scheme", [EulerMaruyama(), Milstein(), StochasticTheta(theta=1.0)], ids=str)
def test_the_modified_equation_leaves_one_order_more(scheme, kind):
    """The error predicted by the terms, obstructions among them, is right up to one order more."""
    (row,) = report().rows_of(scheme, [kind])

    p = row.equation.order
    assert np.log2(row.errors[-2] / row.errors[-1]) == pytest.approx(p, abs=0.1)
    assert np.log2(row.left[-2] / row.left[-1]) > p + 0.9


@pytest.mark.long
def test_a_wrong_term_leaves_the_error():
    """Without one of the terms what is left has the order of the error itself."""
    made = report()
    (equation,) = [each for each in made.equations() if each.kind == "additive"]
    right = found(EulerMaruyama(), "additive", 1)
    wrong = type(right)(right.scheme, right.kind, 1, right.order, right.terms[1:])
    row = made.measured(EulerMaruyama(), equation, wrong)

    assert np.log2(row.left[-2] / row.left[-1]) == pytest.approx(1.0, abs=0.2)


def test_schemes_without_weights_have_none():
    """A step that is no B-series, or jumps, is told so; a tamed drift has weights that depend on h."""
    tamed, mala = found(TamedEuler(), "additive"), found(MALA(), "additive")

    assert "weights of a step depend on h" in tamed.why_not
    assert "discontinuous" in mala.why_not


def test_from_python():
    """`modified_equations` takes a name and classes; a weight beyond 8 is refused."""
    (of,) = modified_equations("milstein", "scalar")

    assert of.exists
    with pytest.raises(UsageError, match="weight"):
        modified_equations("milstein", "scalar", weight=9)
    with pytest.raises(UsageError, match="one scheme"):
        modified_equations("*")


@pytest.mark.parametrize(
    ("value", "error", "words"),
    [
        (1.0 / 192.0, 1e-9, "1/192"),
        (-0.5, 1e-8, "-1/2"),
        (1.0 - np.sqrt(2.0) / 2.0, 1e-9, "(1 - 1/2 sqrt(2))"),
        (np.sqrt(3.0) / 6.0, 1e-9, "1/6 sqrt(3)"),
        (0.3141593, 1e-6, "0.314159(1)"),
        (0.3127, 1e-3, "0.313(1)"),
    ],
)
def test_numbers_are_told_as_far_as_they_are_known(value, error, words):
    """Fractions and square roots where few numbers are as near to one; else decimals with an error."""
    assert number_words(value, error) == words


def test_random_numbers_are_seldom_fractions():
    """Of random numbers with an error about one in a hundred is told as a fraction."""
    rng = np.random.default_rng(20260118)
    exact = [word for word in (number_words(value, 1e-5) for value in rng.random(1000)) if "(" not in word]

    # 1 per cent and three standard deviations.
    assert len(exact) <= 20
