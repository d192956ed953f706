"""Values of formula sheets and papers, to all digits printed."""

from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import numpy as np
import pytest

from facade import TABLE, exponential_strip, orthogonal_group, torus, tube_torus
from sdaeverify import InvariantMean, Moment, Problem
from sdaeverify_problems.curves.constrained_curve import constrained_curve
from sdaeverify_problems.matrices._eigenangle_law import mean_trace
from sdaeverify_problems.matrices._polar_law import PolarLaw
from sdaeverify_problems.rigid_trimer import rigid_trimer
from sdaeverify_problems.spheres._pulled_law import invariant_means, on_the_sphere
from sdaeverify_problems.spheres._radial_law import RadialLaw
from sdaeverify_problems.tori._law import surface_means


def known(problem: Problem) -> dict[str, float]:
    """Return the invariant means of a problem."""
    return {truth.observable: truth.value for truth in problem.truths if isinstance(truth, InvariantMean)}


def on_a_curve(shape: str, theta: float, name: str) -> float:
    """Return a moment on a curve at t = 1, sigma = 0.8."""
    truths = constrained_curve(0.0, shape, 0.8, theta).truths
    return next(t.value(1.0) for t in truths if isinstance(t, Moment) and t.observable == name)


def strip(q: int, name: str, power: int = 0) -> Callable[[float], float]:
    """Return a mean over a power of eps, for alpha = kappa = sigma = 1 and c = 1/2."""
    return lambda eps: known(exponential_strip(eps, q))[name] / eps**power


def pulled(name: str) -> Callable[[float], float]:
    """Return a mean around the sphere for d = 3, k = 3, sigma = 1."""
    return lambda eps: invariant_means(eps, 3, 1.0, 1.5)[name]


def on_the_group(m: int) -> Callable[[float], float]:
    """Return E tr x around the orthogonal group, kappa = 100."""
    return lambda eps: PolarLaw(eps, 100.0, 2.0**0.5, m).trace()


class Printed(NamedTuple):
    """A function of one parameter, its values at some, and half of a unit of their last digit, or as stated."""

    function: Callable[[float], float]
    parameters: str
    values: str
    accuracy: str


SIZES, FEW, MANY = "2 3 4 5", "1e-3 1e-2 0.1 1", "1e-4 1e-3 5e-3 1e-2 0.1 1 10"
TORUS = surface_means(25.0)
PRINTED = {
    "E X_1(1) around the sphere, d = 3, sigma = 1, f = 0": Printed(
        lambda eps: RadialLaw(eps, 3, 1.0).harmonic(1, 1.0),
        "1e-8 1e-4 1e-3 1e-2 0.1 1 10",
        "0.367879454967 0.368017396072 0.369258995829 0.381671414778 0.502164483698 1.0073036256266 1.2262197192427",
        "6e-13",
    ),
    "E x_1 around the sphere with a pull": Printed(
        pulled("x_1"), f"0 {FEW}", "0.671636489980 0.674355473622 0.698838717288 0.944892652217 3.5", "6e-13"
    ),
    "E |x|^2 around the sphere with a pull": Printed(
        pulled("|x|^2"), f"0 {FEW}", "1.0 1.006023066421 1.060965161519 1.683467795665 15.5", "6e-13"
    ),
    "E cos theta at t = 1 from a right angle to the pull, in d dimensions": Printed(
        lambda d: on_the_sphere(int(d), 1.0, 1.5).expectation(lambda u: u, 0.0, 1.0),
        "2 3",
        "0.674454805453 0.593766834992",
        "6e-13",
    ),
    "E t, exponential strip, q = 1": Printed(
        strip(1, "t"), FEW, "0.50025062506 0.50256253722 0.53101697298 0.79187250843", "6e-12"
    ),
    "E t, exponential strip, q = 2": Printed(
        strip(2, "t"), FEW, "0.50050175112 0.50517605140 0.56763487269 1.13896751423", "6e-12"
    ),
    "E |n|^2/eps, exponential strip, q = 1": Printed(
        strip(1, "|n|^2", 1), FEW, "0.50049974750 0.50497245314 0.54466124327 0.39593625422", "3e-11"
    ),
    "E |n|^2/eps, exponential strip, q = 2": Printed(
        strip(2, "|n|^2", 1), FEW, "1.0015002423 1.0150171144 1.1425312905 0.81948375711", "8e-11"
    ),
    "E |x|^2 around the torus": Printed(
        lambda eps: known(tube_torus(eps))["|x|^2"],
        MANY,
        "4.12185292876 4.11666192383 4.09698964507 4.07825595135 3.99560411632 3.96986196332 3.96695018393",
        "5.1e-12",
    ),
    "E tr x on the orthogonal group, kappa = 100": Printed(
        lambda m: mean_trace(int(m), 100.0), SIZES, "1.9949937185 2.9849811079 3.9699621198 4.9499367055", "6e-11"
    ),
    "E tr x on the orthogonal group, kappa = 2": Printed(
        lambda m: mean_trace(int(m), 2.0), SIZES, "1.7270452220 2.1636105347 2.3074332356 2.2425482845", "6e-11"
    ),
    "E tr x around the orthogonal group, m = 2": Printed(
        on_the_group(2), "1e-4 1e-3 5e-3 5e-2", "1.9954871718 1.9994092856 2.0099269859 2.0259708609", "6e-11"
    ),
    "E tr x around the orthogonal group, m = 3": Printed(
        on_the_group(3), "1e-4 1e-3 5e-3 5e-2", "2.9860173 2.994260 3.0164269 3.050646", "1e-7 1e-6 6e-8 3e-6"
    ),
    "E |x|^2 on the torus": Printed(lambda _: TORUS["|x|^2"], "0", "4.122449934351530", "4e-15"),
    "E x_1 on the torus": Printed(lambda _: TORUS["x_1"], "0", "2.010383321067417", "4e-15"),
    "Var |x|^2 on the torus": Printed(
        lambda _: TORUS["|x|^4"] - TORUS["|x|^2"] ** 2, "0", "0.0299899522885", "1e-13"
    ),
    **{
        f"E {name} on the {shape} at t = 1": Printed(partial(on_a_curve, shape, name=name), theta, value, "6e-9")
        for shape, theta, name, value in (
            ("ellipse", str(np.pi / 3), "x_1", "0.93983231"),
            ("ellipse", str(np.pi / 3), "x_2", "0.75257412"),
            ("ellipse", str(np.pi / 3), "x_1^2", "1.36695308"),
            ("space", "0.4", "x_1", "0.70399762"),
            ("space", "0.4", "x_2", "0.31706535"),
        )
    },
    # Of the surface measure, (2 pi/3 - sqrt(3)/2)/(2 pi/3 + sqrt(3)), and not the 1/3 of uniform bonds.
    "E c^2 of the rigid trimer": Printed(lambda _: known(rigid_trimer())["c^2"], "0", "0.3210210", "6e-8"),
}


@pytest.mark.parametrize("name", PRINTED)
def test_values_are_those_printed(name: str) -> None:
    """Quadratures and series of problems agree with the values of their sources."""
    function, *texts = PRINTED[name]
    parameters, values, accuracy = (np.array(text.split(), dtype=float) for text in texts)
    assert np.all(np.abs(np.array([function(each) for each in parameters]) - values) <= accuracy)


@pytest.mark.parametrize("eps", TABLE)
def test_the_table_of_the_torus_is_known_for_its_stiffness_only(eps: float) -> None:
    """Ten values of eps, with stiffness 25, and the limit for any."""
    assert known(torus(eps))["|x|^2"] == TABLE[eps][0]
    assert known(torus(eps, 26.0)) == {}
    assert torus(eps, 26.0).relaxation_time == np.inf
    assert known(torus(0.0)) == known(tube_torus(0.0))


def test_tabulated_means_of_the_group_are_known_for_their_parameters_only() -> None:
    """Sizes 4 and 5, stiffness 100, four values of eps."""
    (mean, square) = (truth.value for truth in orthogonal_group(5e-3, 4, 100.0).truths)
    assert mean == 4.023898
    assert 2.0 * square == pytest.approx(4.0 + 5e-3 * (200.0 * mean + 2.0 * 26.0), rel=1e-14)
    assert orthogonal_group(5e-3, 4).truths == ()
    assert orthogonal_group(6e-3, 4, 100.0).truths == ()
