"""What is wrong with a fibre is said in one line."""

import numpy as np
import pytest

from facade import Fibre, clamped_chain, fibre_problem, free_chain
from sdaeverify import ProblemError

CHAIN = clamped_chain(3, 2)


def planted(**others):
    return fibre_problem(Fibre(chain=CHAIN, **others), 0.01)


@pytest.mark.parametrize(
    ("functions", "message"),
    [
        ({"flow": lambda r, t: r[0]}, r"flow u\(r, t\) returned \(4, 3\), expected \(2, 4, 3\)"),
        ({"flow": lambda r, t: np.zeros(2)}, r"flow u\(r, t\) returned \(2,\)"),
        ({"flow": lambda r, t: 0.0}, r"flow u\(r, t\) returned float"),
        ({"flow": lambda r, t: np.zeros((2, 3, 3))}, r"flow u\(r, t\) returned \(2, 3, 3\)"),
        ({"C": lambda r, tau, t: r}, r"C\(r, tau, t\) returned \(2, 4, 3\), expected \(2, 2, 4, 3\)"),
        ({"D": lambda r, v, tau, t: np.eye(2)}, r"D\(r, v, tau, t\) returned \(2, 2\), expected \(2, 2, 4, 3\)"),
    ],
)
def test_functions_of_the_wrong_shape_are_refused(functions, message):
    """A flow, a drag or a turbulence that returns another shape is named with what was expected."""
    with pytest.raises(ProblemError, match=message) as caught:
        planted(**functions)
    assert "\n" not in str(caught.value)


def test_functions_may_be_the_same_on_all_edges_and_paths():
    """Shapes of length 1 along the last two axes are the right ones, too."""
    one = np.eye(2)[..., None, None]
    problem = planted(flow=lambda r, t: one[0], C=lambda r, tau, t: 2.0 * one, D=lambda r, v, tau, t: 3.0 * one)
    r, v, _ = problem.initial(4)

    expected = 6.0 * planted().diffusion(0.0, r, v)
    np.testing.assert_allclose(problem.diffusion(0.0, r, v), expected, rtol=1e-14)


@pytest.mark.parametrize(
    ("chain", "row", "message"),
    [
        (CHAIN, 0, r"0\.3 from the clamp r_0 to point 1, expected ds = 0\.25"),
        (CHAIN, 2, r"0\.3 from point 2 to point 3, expected ds = 0\.25"),
        (free_chain(4, 2), 3, r"0\.3 from point 3 to point 4, expected ds = 0\.25"),
    ],
)
def test_chains_that_violate_the_length_constraint_are_refused(chain, row, message):
    """The worst edge is named with its length."""
    position = chain.straight().reshape(chain.N, chain.d)
    position[row:] *= 1.0 + 0.05 / np.linalg.norm(position[row])
    with pytest.raises(ProblemError, match=message) as caught:
        fibre_problem(Fibre(chain=chain), 0.01, position=position)
    assert "\n" not in str(caught.value)


def test_positions_of_the_wrong_shape_are_refused():
    """Points come first, components second."""
    with pytest.raises(ProblemError, match=r"position has shape \(6,\), expected \(3, 2\): points, components"):
        fibre_problem(Fibre(chain=CHAIN), 0.01, position=np.zeros(6))


def test_velocities_that_stretch_the_chain_are_refused():
    """The hidden constraint must hold, too."""
    with pytest.raises(ProblemError, match="violate Dg v = 0"):
        fibre_problem(Fibre(chain=CHAIN), 0.01, velocity=[[0.0, 0.0], [0.0, 0.0], [0.0, -1.0]])
