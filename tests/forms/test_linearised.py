"""What authors may give instead of matrices: a linearised constraint and a product with the diffusion."""

from functools import partial

import numpy as np
import pytest

from sdaeverify import SDE, Array, DenseJacobian, HolonomicSDAE, ProblemError


def constraint(r: Array) -> Array:
    return 0.5 * (1.0 - (r * r).sum(axis=0))[None]


def on_the_circle(**changes) -> HolonomicSDAE:
    given = {
        "force": lambda t, r, v: -r,
        "diffusion": lambda t, r, v: np.stack([r, v], axis=1),
        "constraint": constraint,
        "position": [0.6, 0.8],
        "velocity": [-0.8, 0.6],
        "horizon": 1.0,
        "noise_dim": 2,
        "source": "made up",
    }
    return HolonomicSDAE(**{**given, **changes})


def product(factor: float, t: float, r: Array, v: Array, w: Array) -> Array:
    return factor * (r * w[0] + v * w[1])


def linearised(factor: float, r: Array) -> DenseJacobian:
    return DenseJacobian(-factor * r[None])


def test_what_is_given_is_used():
    """The author's product and linearisation take the place of matrices, in the inherent SDE, too."""
    given = on_the_circle(diffusion_product=partial(product, 1.0), linearisation=partial(linearised, 1.0))
    r, v, w = np.array([[0.6], [0.8]]), np.array([[-1.6], [1.2]]), np.array([[0.3], [0.7]])
    assert np.allclose(given.diffused(0.0, r, v, w), on_the_circle().diffused(0.0, r, v, w), rtol=1e-14)
    x = np.concatenate([r, v, [[0.0]]])
    view, dense = given.ito(), on_the_circle().ito()
    assert np.allclose(view.drift(0.0, x), dense.drift(0.0, x), rtol=1e-13)
    assert np.allclose(view.diffused(0.0, x, w), np.einsum("nlp,lp->np", dense.diffusion(0.0, x), w), rtol=1e-13)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"diffusion_product": partial(product, 1.1)}, "diffusion_product disagrees"),
        ({"diffusion_product": lambda t, r, v, w: w[:1]}, "diffusion_product returned shape"),
        ({"linearisation": partial(linearised, 1.1)}, "linearisation.* disagrees with the derivative"),
        ({"linearisation": partial(linearised, 1.0), "mass": 2.0 * np.eye(2)}, "without mass matrix"),
    ],
    ids=["another product", "its shape", "another derivative", "mass"],
)
def test_what_is_wrong_is_refused(changes, message):
    """An author's short cut that leads elsewhere is named where the problem is built."""
    with pytest.raises(ProblemError, match=message):
        on_the_circle(**changes)


def test_a_wrong_product_of_an_sde_is_refused():
    """The product of an SDE is checked, too."""
    sde = partial(SDE, drift=lambda t, x: -x, diffusion=lambda t, x: x[:, None], start=[1.0], horizon=1.0)
    sde(noise_dim=1, source="made up", diffusion_product=lambda t, x, w: x * w)
    with pytest.raises(ProblemError, match="diffusion_product disagrees"):
        sde(noise_dim=1, source="made up", diffusion_product=lambda t, x, w: x + w)
