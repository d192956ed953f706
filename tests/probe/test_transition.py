"""Transition operators against laws in closed form, and what keeps a scheme from having one."""

from dataclasses import dataclass, field, replace
from typing import ClassVar

import numpy as np
import pytest

from facade import HalfExplicitEuler, chart_basis, stationary, transition
from probe.chart_cells import ANGLE, OU, AdditiveHeun, Euler, identity, plane_pendulum
from sdaeverify import TWO_POINT, Chart, HolonomicSDAE, HolonomicState, Law, Line, Scheme, Step
from sdaeverify.numerics import apply
from sdaeverify.probing import OneStep, step_nodes, why_not_operator

SIGMA, H = 0.7, 0.125
BASIS = chart_basis(OU.chart, line=8)
UNTRUNCATED = HalfExplicitEuler(truncation="none")


def operator(scheme, view, h=H, basis=None):
    """Return the operator of a scheme in a small basis."""
    return transition(OneStep(scheme, view), basis or chart_basis(view.chart, 5, 8), h)


# ---------------------------------------------------------------- closed forms


def test_euler_on_an_ou_process_shrinks_polynomials():
    """Of x+ = (1 - h) x + sigma dW the eigenvalues are (1 - h)^n, and degrees never grow."""
    T = operator(Euler(), OU).matrix
    assert np.abs(np.tril(T, -1)).max() < 1e-12
    assert np.allclose(np.diag(T), (1 - H) ** np.arange(8), rtol=0.0, atol=1e-12)


PLANE = replace(
    OU,
    diffusion=lambda t, x: SIGMA * np.eye(2)[..., None],
    noise_dim=2,
    start=[1.0, 0.0],
    chart=identity(Line(0.0, SIGMA), Line(0.5, SIGMA)),
)
CURVED = replace(PLANE, drift=lambda t, x: np.stack([x[1], -np.sin(x[0])]))
CALM = replace(PLANE, diffusion=lambda t, x: np.where(x[0] < 0.0, SIGMA, 0.0) * np.eye(2)[..., None])


@pytest.mark.parametrize("scheme", [Euler(), AdditiveHeun()])
@pytest.mark.parametrize("view", [PLANE, CURVED, CALM, ANGLE])
def test_all_functions_are_averaged_over_all_nodes(scheme, view):
    """A coordinate may be moved by one of two noises, by both or by none, and not everywhere."""
    basis, nodes = chart_basis(view.chart, 5, 8), step_nodes(view.noise_dim, 8)
    x = np.repeat(basis.nodes, len(nodes.weights), axis=1)
    reached = scheme.step(view, x, 0.0, H, nodes.increment(H, basis.nodes.shape[1])).state
    values = basis.values(reached).reshape(-1, basis.nodes.shape[1], len(nodes.weights))
    assert np.allclose(operator(scheme, view).matrix, basis.project((values @ nodes.weights).T), rtol=0.0, atol=1e-13)


OBLIQUE = np.array([[0.5, 0.2, -0.1], [0.3, -0.4, 0.2]])
SLANTED = replace(PLANE, diffusion=lambda t, x: OBLIQUE[..., None], noise_dim=3, start=[0.0, 0.0])


@dataclass(frozen=True)
class Counting(Euler):
    """Euler's method with what it was asked: the number of paths of each step, and a term quadratic in the noise."""

    bend: float = 0.0
    paths: list[int] = field(default_factory=list)

    def step(self, problem, x, t, h, noise):
        self.paths.append(x.shape[1])
        return Step(super().step(problem, x, t, h, noise).state + self.bend * noise.dW[:1] ** 2)


def test_a_step_that_is_affine_in_several_normals_leads_to_a_normal_law():
    """x+ = (1 - h) x + S dW has the stationary covariance S S^T/(2 - h), and is made at 4 + 8 of 125 nodes."""
    scheme, basis = Counting(), chart_basis(SLANTED.chart, line=8)
    law = stationary(operator(scheme, SLANTED, basis=basis).matrix)
    products = np.stack([basis.nodes[0] * basis.nodes[0], basis.nodes[0] * basis.nodes[1], basis.nodes[1] ** 2], 1)
    expected = (OBLIQUE @ OBLIQUE.T / (2.0 - H))[[0, 0, 1], [0, 1, 1]]
    assert np.allclose(law @ basis.project(products), expected, rtol=0.0, atol=1e-13)
    assert scheme.paths == [12 * basis.nodes.shape[1]]


def test_a_step_that_is_not_affine_in_its_normals_is_made_at_all_nodes():
    """A bend of 1e-9 is small, and adds up over many steps."""
    scheme, basis = Counting(bend=1e-9), chart_basis(SLANTED.chart, line=4)
    operator(scheme, SLANTED, basis=basis)
    assert scheme.paths[1:] == [125 * basis.nodes.shape[1]]


def test_a_bounded_law_is_given_by_its_atoms():
    """With two-point variables E x^4 after one step from 0 is (sigma^2 h)^2, not three times that."""

    class Coin(Euler):
        law: ClassVar[Law] = TWO_POINT

    fourth = BASIS.project(BASIS.nodes[0] ** 4)
    start = BASIS.values(np.zeros((1, 1)))[:, 0]
    found = [start @ operator(scheme, OU, basis=BASIS).matrix @ fourth for scheme in (Coin(), Euler())]
    assert np.allclose(found, np.array([1.0, 3.0]) * (SIGMA**2 * H) ** 2, rtol=0.0, atol=1e-12)


def test_a_symmetric_step_has_no_odd_means():
    """Steps of q'' = -sin q - p that commute with a reflection mix even functions with even ones alone."""
    basis = chart_basis(ANGLE.chart, 5, 8)
    odd = basis.project(basis.nodes[1])
    T = operator(Euler(), ANGLE).matrix
    law = stationary(T)
    assert law[1] == 0.0
    assert abs(law @ odd) < 1e-15
    assert np.allclose(law @ T, law, rtol=0.0, atol=1e-13)
    pushed = replace(ANGLE, drift=lambda t, x: ANGLE.drift(t, x) + np.array([[0.0], [0.1]]))
    assert abs(stationary(operator(Euler(), pushed).matrix) @ odd) > 0.01


def test_doing_nothing_has_no_unique_stationary_law():
    """Where every law is stationary none is returned."""
    assert np.isnan(stationary(np.eye(4))[1:]).all()


# ---------------------------------------------------------------- what is noticed of the steps


class Unprojected(Scheme):
    """r+ = r + h v, v+ = v + h a + dw, off the circle."""

    name: ClassVar[str] = "unprojected"
    form: ClassVar[type[HolonomicSDAE]] = HolonomicSDAE

    def step(self, problem, state, t, h, noise):
        r, v, mu = state
        return Step(
            HolonomicState(
                r + h * v, v + h * problem.force(t, r, v) + apply(problem.diffusion(t, r, v), noise.dW), mu
            )
        )


def test_a_scheme_without_projection_leaves_the_chart():
    """The gap between a state and its image under read and embed is rounding with it, else of the step's size."""
    assert operator(UNTRUNCATED, plane_pendulum()).departure < 1e-14
    assert operator(Unprojected(), plane_pendulum()).departure > 1e-3


@pytest.mark.parametrize("no_root", ["hold", "fail"])
def test_steps_without_root_are_weighed(no_root):
    """The half-explicit step has no root for h |omega| > 1: its probability under the law of the basis."""
    pendulum = plane_pendulum(scale=1.5)
    basis = chart_basis(pendulum.chart, 5, 8)
    found = operator(HalfExplicitEuler(truncation="none", no_root=no_root), pendulum, h=0.5, basis=basis)
    expected = basis.weights[np.abs(0.5 * basis.nodes[1]) > 1.0].sum()
    assert found.failed == pytest.approx(expected, abs=1e-14)
    assert 0.1 < expected < 0.5
    assert np.isfinite(found.matrix).all()


def test_truncated_steps_are_weighed():
    """Truncation acts for h max(|omega|, omega^2) > C_eta."""
    pendulum = plane_pendulum()
    basis = chart_basis(pendulum.chart, 5, 8)
    found = operator(HalfExplicitEuler(truncation=0.25), pendulum, basis=basis)
    omega = np.abs(basis.nodes[1])
    expected = basis.weights[H * np.maximum(omega, omega**2) > 0.25].sum()
    assert found.truncated == pytest.approx(expected, abs=1e-14)
    assert found.failed == 0.0


def test_what_blows_up_is_put_back_and_counted():
    """A step to 1e9 is no value of a polynomial any more."""

    class Explosive(Euler):
        def step(self, problem, x, t, h, noise):
            return Step(np.where(np.abs(x) > 1.0, 1e9, x))

    found = operator(Explosive(), OU, basis=BASIS)
    outside = np.abs(BASIS.nodes[0]) > 1.0
    assert found.failed == pytest.approx(BASIS.weights[outside].sum(), abs=1e-14)
    assert np.allclose(found.matrix, np.eye(8), rtol=0.0, atol=1e-12)


# ---------------------------------------------------------------- refusals


class Remembering(Euler):
    """Euler's method that carries its last state along."""

    def enter(self, problem, state, t, h):
        return np.concatenate([state, 0.0 * state])

    def parts(self, problem, state):
        return {"x": state[:1]}

    def step(self, problem, state, t, h, noise):
        return Step(np.concatenate([super().step(problem, state[:1], t, h, noise).state, state[:1]]))


class Driven(Unprojected):
    """A multiplier that drives the next step."""

    def step(self, problem, state, t, h, noise):
        return Step(HolonomicState(state.r, state.v + h * state.mu, state.mu))


WRAPPED = Chart(ANGLE.chart.axes, lambda z: z, lambda x: x + np.array([[2 * np.pi], [0.0]]))
NOISY = replace(PLANE, diffusion=lambda t, x: np.ones((2, 5, 1)), noise_dim=5)


@pytest.mark.parametrize(
    ("scheme", "problem", "reason"),
    [
        (Euler(), replace(OU, chart=None), "no chart"),
        (Euler(), replace(OU, drift=lambda t, x: np.sin(t) - x), "depend on time"),
        (Euler(), replace(ANGLE, chart=WRAPPED), "not inverse"),
        (Remembering(), OU, "memory"),
        (Driven(), plane_pendulum(), "pure outputs"),
        (Euler(), NOISY, "5 normals"),
    ],
    ids=["chart", "time", "wrapped", "memory", "outputs", "noises"],
)
def test_what_has_no_operator_is_refused_with_a_reason(scheme, problem, reason):
    """No coordinates, no autonomous step, no map of the coordinates, or no rule of bearable size."""
    assert reason in why_not_operator(scheme, problem)


@dataclass(frozen=True)
class Narrow(Euler):
    """Half of Euler's noise where the state is in an interval."""

    low: float = 0.0
    high: float = 0.0

    def step(self, problem, x, t, h, noise):
        inside = (x > self.low) & (x < self.high)
        kick = problem.diffused(t, x, noise.dW)
        return Step(x + h * problem.drift(t, x) + np.where(inside, 0.5, 1.0) * kick)


def test_a_step_that_is_another_one_between_two_nodes_has_no_operator():
    """No quadrature sees an interval between its nodes: there, the matrix is that of Euler's method."""
    nodes = np.sort(chart_basis(OU.chart).nodes[0])
    low, high = nodes[len(nodes) // 2 : len(nodes) // 2 + 2]
    narrow = Narrow(0.9 * low + 0.1 * high, 0.1 * low + 0.9 * high)
    basis = chart_basis(OU.chart)

    assert np.array_equal(operator(narrow, OU, basis=basis).matrix, operator(Euler(), OU, basis=basis).matrix)
    assert "kink or a jump" in why_not_operator(narrow, OU)


@pytest.mark.parametrize(("scheme", "problem"), [(Euler(), ANGLE), (UNTRUNCATED, plane_pendulum())])
def test_pairs_on_a_chart_are_not_refused(scheme, problem):
    """A scheme that keeps no memory has an operator on an autonomous problem, outputs and all."""
    assert why_not_operator(scheme, problem) == ""
