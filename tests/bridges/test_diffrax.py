"""Solvers of diffrax as schemes; skipped where it is not installed."""

from dataclasses import replace
from typing import ClassVar

import numpy as np
import pytest

import sdaeverify
from bridges.equations import curved, drawn
from facade import QUICSORT, SRA1, EulerMaruyama, Heun, Milstein, angle_pendulum, gbm, noncommuting, ou
from sdaeverify import SDE, Increment, ParameterError
from sdaeverify_bridges.diffrax import LANGEVIN, ORDERS, Diffrax, DiffraxLangevin

pytestmark = pytest.mark.filterwarnings("default:os.fork:RuntimeWarning")
H, PATHS = 0.125, 7


@pytest.fixture(scope="module", autouse=True)
def library():
    """Skip where diffrax is not installed."""
    return pytest.importorskip("diffrax", reason="diffrax is not installed; pip install '.[diffrax]'")


@pytest.mark.parametrize(
    ("solver", "ours", "family"),
    [
        ("Euler", EulerMaruyama(), gbm),
        ("Euler", EulerMaruyama(), noncommuting),
        ("Euler", EulerMaruyama(), angle_pendulum),
        ("ItoMilstein", Milstein(), curved),
        ("Heun", Heun(), curved),
        ("Heun", Heun(), noncommuting),
        ("SRA1", SRA1(), ou),
        ("SRA1", SRA1(), angle_pendulum),
    ],
)
def test_our_schemes_agree_to_rounding(solver, ours, family):
    """On the same noise diffrax makes the step that ours makes, whoever takes the derivatives."""
    problem = family().view(SDE)
    x, noise = problem.initial(PATHS) + 0.1 * np.arange(PATHS), drawn(problem, H, PATHS)

    found, expected = (scheme.step(problem, x, 0.5, H, noise).state for scheme in (Diffrax(solver), ours))
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=4.0 * np.finfo(float).eps * np.abs(expected).max())


class Calls:
    """How often a formula was run."""

    number = 0


@pytest.mark.parametrize("solver", ORDERS)
def test_every_solver_is_compiled_once(solver):
    """A second step of another size, on a problem built anew and on fewer paths runs none of its formulas."""
    calls = Calls()

    def counted(rate):
        def drift(t, x):
            calls.number += 1
            return -rate * x

        return SDE(
            drift=drift,
            diffusion=lambda t, x: np.full((1, 1, 1), 0.5),
            start=[1.0],
            noise_dim=1,
            horizon=1.0,
            traits=frozenset({"additive-noise"}),
            source="a test",
        )

    one, other = counted(0.75), counted(0.75)
    scheme, noise = Diffrax(solver), drawn(one, H, PATHS)
    scheme.prepare(one, H)(scheme.start(one, PATHS, H), 0.0, noise)
    start = scheme.start(other, 3, H)
    traced, calls.number = calls.number, 0
    fewer = Increment(noise.dW[:, :3], noise.H[:, :3])
    scheme.prepare(other, 0.5 * H)(start, 0.5, fewer)

    assert traced
    assert not calls.number


@pytest.mark.parametrize("solver", ORDERS)
def test_paths_do_not_see_each_other(solver):
    """A path of a batch is the same to the last bit as that path alone."""
    problem = ou()
    x, noise = problem.initial(PATHS) + 0.1 * np.arange(PATHS), drawn(problem, H, PATHS)
    scheme = Diffrax(solver)
    state = scheme.enter(problem, x, 0.5, H)
    all_of_them = scheme.step(problem, state, 0.5, H, noise).state

    alone = Increment(noise.dW[:, 4:5], noise.H[:, 4:5])
    np.testing.assert_array_equal(scheme.step(problem, state[:, 4:5], 0.5, H, alone).state, all_of_them[:, 4:5])


def test_quicsort_is_ours_to_rounding():
    """On the same dW, H and K the solver QUICSORT makes the step that ours makes."""
    problem = angle_pendulum()
    x = problem.initial(PATHS) + 0.1 * np.arange(PATHS)
    noise = drawn(problem, H, PATHS)._replace(K=0.01 * np.cos(np.arange(PATHS))[None])

    found, expected = (s.step(problem, x, 0.5, H, noise).state for s in (DiffraxLangevin("QUICSORT"), QUICSORT()))
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=4.0 * np.finfo(float).eps * np.abs(expected).max())


def test_langevin_solver_without_noise_is_the_motion():
    """With a force that vanishes, ALIGN makes the exact step of dv = -gamma v dt + sigma dW, given dW = H = 0."""
    problem = replace(angle_pendulum(c=0.0), momentum=[2.0], truths=())
    nothing = Increment(np.zeros((1, 1)), np.zeros((1, 1)))
    decay = np.exp(-0.5 * H)

    found = DiffraxLangevin().step(problem, problem.initial(1), 0.0, H, nothing).state
    np.testing.assert_allclose(found[:, 0], [1.0 + 2.0 * (1.0 - decay) / 0.5, 2.0 * decay], rtol=1e-14)


def test_solvers_of_additive_noise_refuse_others():
    """What the documentation leaves out is refused, and the reason says why."""
    assert Diffrax("ShARK").refuses(gbm()) == "the noise is not declared additive"
    assert not Diffrax("ShARK").refuses(ou())


@pytest.mark.parametrize(("scheme", "known"), [(Diffrax, ORDERS), (DiffraxLangevin, LANGEVIN)])
def test_solver_is_checked(scheme, known):
    """A name that diffrax has not is refused, and the others are named."""
    with pytest.raises(ParameterError, match=f"must be one of {', '.join(known)}, got 'Dopri5'"):
        scheme("Dopri5")


class Louder(Diffrax):
    """dW is given to the solver with a factor of 1.1."""

    name: ClassVar[str] = "diffrax-louder"

    def compiled(self, problem):
        right = super().compiled(problem)
        return lambda x, t, h, dW: right(x, t, h, 1.1 * dW)


class Mistaken(Diffrax):
    """A Stratonovich solver is given the drift of the Ito equation."""

    name: ClassVar[str] = "diffrax-mistaken"

    @property
    def stratonovich(self):
        return False


@pytest.mark.parametrize("wrong", [Louder("Euler"), Mistaken("Heun")], ids=["scaled noise", "wrong calculus"])
def test_wrong_bridge_is_refuted(wrong):
    """A bridge that hands over the wrong noise or the wrong calculus is refuted, not the library's solver."""
    found = sdaeverify.verify([wrong, Diffrax(wrong.solver)], [gbm], "strong", paths=512, levels=4, jobs=1).verdicts

    by_scheme = found.groupby("scheme")["verdict"].agg(set)
    assert by_scheme[wrong.label] == {"refuted"}
    assert "refuted" not in by_scheme[Diffrax(wrong.solver).label]
