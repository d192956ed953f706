"""Bounded variables share the first moments of the normal law and are coupled to it."""

from dataclasses import dataclass
from math import erf, sqrt
from typing import ClassVar

import numpy as np
import pytest
import scipy

from sdaeverify import (
    GAUSSIAN,
    SDE,
    THREE_POINT,
    TWO_POINT,
    Claim,
    Increment,
    Law,
    Scheme,
    Step,
    UsageError,
    verify,
)
from sdaeverify_orders import orders
from sdaeverify_schemes.milstein import Milstein

# A standard normal variable is within it with probability 1/2.
QUARTILE = 0.6744897501960817
BOUNDED = pytest.mark.parametrize("law", [THREE_POINT, TWO_POINT], ids=lambda law: law.name)


def cdf(x):
    """Return the standard normal distribution function."""
    return 0.5 * (1.0 + erf(x / sqrt(2.0)))


@pytest.mark.parametrize(("law", "matched"), [(THREE_POINT, 5), (TWO_POINT, 3)], ids=["three-point", "two-point"])
def test_moments_are_the_normal_ones_up_to_the_promised_degree(law, matched):
    """E xi^k is 0, 1, 0, 3, 0 up to degree 5 of the three-point law and 3 of the two-point law, and no further."""
    values, weights = np.array(law.values), np.array(law.weights)
    normal = {1: 0.0, 2: 1.0, 3: 0.0, 4: 3.0, 5: 0.0, 6: 15.0}
    moments = {k: weights @ values**k for k in normal}

    for k in range(1, matched + 1):
        assert moments[k] == pytest.approx(normal[k], abs=1e-15)
    assert abs(moments[matched + 1] - normal[matched + 1]) > 1.0


@BOUNDED
def test_the_coupled_variable_takes_each_atom_with_its_probability(law):
    """The quantile map sends intervals of the normal law of the right probability to the atoms."""
    edges = np.linspace(-6.0, 6.0, 4801)
    found = law.couple(0.5 * (edges[:-1] + edges[1:]))
    mass = np.diff([cdf(x) for x in edges])

    for value, weight in zip(law.values, law.weights, strict=True):
        # The edge of an atom falls into one interval of the grid: half of its probability is the error.
        assert mass[np.isclose(found, value)].sum() == pytest.approx(weight, abs=0.5 * mass.max() + 2e-9)


@BOUNDED
def test_increments_have_the_size_of_the_step(law):
    """The increment is dW = sqrt(h) xi, and H is a sign of its variance h/12; what is not drawn stays out."""
    noise = Increment(np.sqrt(0.25) * np.array([[-2.0, 0.1, 2.0]]), np.array([[-0.3, 0.0, 0.01]]))

    bounded = law.increment(noise, 0.25)

    assert bounded.dW == pytest.approx(0.5 * law.couple(np.array([[-2.0, 0.1, 2.0]])))
    assert pytest.approx(np.sqrt(0.25 / 12.0) * np.array([[-1.0, 1.0, 1.0]])) == bounded.H
    assert law.increment(noise._replace(H=None), 0.25).H is None


def test_gaussian_increments_are_passed_on():
    """The normal law changes nothing."""
    noise = Increment(np.ones((1, 3)), np.ones((1, 3)))

    assert GAUSSIAN.increment(noise, 0.1) is noise


@pytest.mark.parametrize("p", [1.0, 2.0, 4.0])
@pytest.mark.parametrize("h", [0.25, 1e-2, 1e-4])
def test_clipped_increments_are_close_to_the_brownian_ones(h, p):
    """They are bounded by sqrt(h) A_h, A_h^2 = 2 p |ln h|, and on average at most h^p apart in square; H is kept."""
    law, x = Law.clipped_gaussian(p), np.linspace(-12.0, 12.0, 200_001)
    noise = Increment(np.sqrt(h) * x[None], x[None])

    clipped = law.increment(noise, h)

    bound = np.sqrt(-2.0 * p * np.log(h))
    inside = np.abs(x) <= bound
    density = np.exp(-0.5 * x**2) / np.sqrt(2.0 * np.pi) * (x[1] - x[0])
    apart = density @ (x - clipped.dW[0] / np.sqrt(h)) ** 2
    assert np.abs(clipped.dW).max() == pytest.approx(np.sqrt(h) * bound)
    assert np.array_equal(clipped.dW[0, inside], noise.dW[0, inside])
    assert clipped.H is noise.H
    # Half of the bound is lost at most where A_h is not large: it is h^p times a function that decreases in A_h.
    assert 1e-3 * h**p < apart < h**p
    assert not law.bounded


def test_long_steps_are_clipped_no_closer_than_at_one_over_e():
    """Where |ln h| is small or h > 1, A_h is that of h = 1/e."""
    law = Law.clipped_gaussian(4.0)

    assert [law.bound(h) for h in (0.9, 1.0, 50.0)] == [law.bound(np.exp(-1.0))] * 3
    assert GAUSSIAN.bound(0.1) == np.inf


@dataclass(frozen=True)
class Clipped(Milstein):
    """Milstein's scheme with clipped increments."""

    p: float = 4.0

    name: ClassVar[str] = "clipped-milstein"

    @property
    def law(self) -> Law:
        """Normal variables clipped at sqrt(2 p |ln h|)."""
        return Law.clipped_gaussian(self.p)


@pytest.mark.parametrize(
    ("p", "strong", "weak"),
    [
        (2.0, "verified", "verified"),
        pytest.param(1.0, "open", "verified", marks=pytest.mark.long),
        pytest.param(0.5, "open", "open", marks=pytest.mark.long),
    ],
)
def test_clipped_increments_have_the_order_of_normal_ones_where_p_is_large_enough(p, strong, weak):
    """Their variance lacks a part h^p, so that weak order 1 needs p = 1 and strong order 1 needs p = 2.

    One step is compared at nodes of the normal law, and few paths meet what is clipped.
    """
    scheme = Clipped(p)
    cells, classes = verify(scheme, "gbm", ["strong", "weak"]).verdicts, orders(scheme, "scalar").table

    for measure, expected in {"strong": strong, "weak": weak}.items():
        found = set(cells.verdict[cells.measure == measure])
        assert found == {"verified"} if expected == "verified" else "verified" not in found
        (of_class,) = classes.verdict[classes.measure == measure]
        assert of_class == ("verified" if expected == "verified" else "inconclusive")


def euler_with(law):
    """Return Euler-Maruyama with increments of a law, which claims weak order 1."""

    def step(self, problem, state, t, h, noise):
        return Step(state + h * problem.drift(t, state) + problem.diffused(t, state, noise.dW))

    claims = (Claim(measure="weak", value=1.0, source="made up"),)
    return type("Given", (Scheme,), {"name": "given", "form": SDE, "law": law, "claims": claims, "step": step})()


def uniform(size):
    """Return a coupling to uniform variables in [-size/2, size/2]."""
    return lambda x: size * (scipy.special.ndtr(x) - 0.5)


UNUSABLE = {
    "uniform, variance 1": (Law("uniform", uniform(sqrt(12.0))), "no atoms"),
    "uniform, variance 1/12": (Law("uniform", uniform(1.0)), "no atoms"),
    "clipped and coupled": (Law("clipped", uniform(1.0), clip=1.0), "no atoms"),
    "clipped and atoms": (TWO_POINT._replace(clip=1.0), "clipped and has atoms"),
    "small atoms": (
        Law("small", lambda x: np.sign(x) / sqrt(12.0), (-0.288675, 0.288675), (0.5, 0.5)),
        "1",
    ),
    "atoms of mean 1": (Law("shifted", lambda x: np.where(x < 0, 0.0, 2.0), (0.0, 2.0), (0.5, 0.5)), "have mean 1"),
    "weights of sum 2": (TWO_POINT._replace(weights=(1.0, 1.0)), "with sum 1"),
    "a weight too few": (TWO_POINT._replace(weights=(1.0,)), "with sum 1"),
    "another variable": (TWO_POINT._replace(couple=lambda x: x), "not one of its atoms"),
    "another quantile": (
        THREE_POINT._replace(couple=lambda x: sqrt(3) * np.trunc(np.clip(x, -1, 1))),
        "probability 0.68",
    ),
    "one number": (TWO_POINT._replace(couple=np.max), "an array of the shape it is given"),
    "raises": (TWO_POINT._replace(couple=lambda x: x[5]), "IndexError"),
    "no law": ("two-point", "expects a Law"),
}


@pytest.mark.parametrize("name", UNUSABLE)
def test_a_law_that_is_not_what_it_says_is_refused(name):
    """A coupling without atoms, which would not be applied, and atoms that are no standard variable cost one line."""
    law, told = UNUSABLE[name]

    with pytest.raises(UsageError, match=told) as raised:
        verify(euler_with(law), "ou", "weak", paths=256)
    assert "\n" not in str(raised.value)


@pytest.mark.long
def test_a_law_with_atoms_is_used():
    """The same scheme with the atoms that it couples is verified, by a coupling that is not monotone as well."""
    turned = TWO_POINT._replace(couple=lambda x: np.where(np.abs(x) < QUARTILE, -1.0, 1.0))

    for law in (THREE_POINT, TWO_POINT, turned):
        assert set(verify(euler_with(law), "ou", "weak", paths=256).verdicts.verdict) == {"verified"}
