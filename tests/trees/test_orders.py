"""Order conditions of schemes: orders found, verdicts, premises."""

import re
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import pytest

from facade import rows_of_classes, tree_classes_of
from sdaeverify import SDE, Claim, Step, UsageError
from sdaeverify_lab.planted._within import ScaledEuler
from sdaeverify_lab.planted.coefficients import WrongTimes
from sdaeverify_orders import orders
from sdaeverify_schemes.delays.stochastic_theta import StochasticTheta
from sdaeverify_schemes.euler_maruyama import EulerMaruyama
from sdaeverify_schemes.heun import HeunAdditive
from sdaeverify_schemes.milstein_areas import MilsteinAreas
from sdaeverify_schemes.platen_weak_2_general import PlatenWeak2General
from trees.wrong import FORTY, SIX, AromaticEuler, FewSigns, SignedHeun

pytestmark = pytest.mark.long

# Orders (strong, weak) that are found, None where nothing is said of paths, by scheme and class.
FOUND = [
    ("euler-maruyama", "scalar", 0.5, 1.0),
    ("euler-maruyama", "additive", 1.0, 1.0),
    ("euler-maruyama", "vanishing-milstein-term", 1.0, 1.0),
    ("euler-maruyama", "general", 0.5, 1.0),
    ("euler-maruyama", "diagonal", 0.5, 1.0),
    ("milstein", "scalar", 1.0, 1.0),
    ("milstein", "diagonal", 1.0, 1.0),
    ("milstein-areas", "general", 1.0, 1.0),
    ("heun", "scalar", 1.0, 1.0),
    ("heun", "commutative", 1.0, 1.0),
    ("heun", "additive", 1.0, 2.0),
    ("heun", "general", 0.5, 1.0),
    ("heun", "diagonal", 1.0, 1.0),
    ("heun-additive", "additive", 1.0, 2.0),
    ("sra1", "additive", 1.5, 2.0),
    ("sri1w1", "scalar", 1.5, 1.5),
    ("platen-weak-2", "scalar", None, 2.0),
    ("platen-weak-2", "additive", None, 2.0),
    ("platen-weak-2-general", "general", None, 2.0),
    ("stochastic-theta", "scalar", 0.5, 1.0),
    ("stochastic-theta", "additive", 1.0, 2.0),
    ("stochastic-theta[theta=1]", "additive", 1.0, 1.0),
]
SLOW = [("sri1w1", "diagonal", 1.5, 1.5), ("platen-weak-2", "diagonal", None, 2.0)]


def check(scheme, kind, strong, weak):
    """Check the orders found, and that what is claimed is verified."""
    report = orders(scheme, kind, 2)
    found = dict(zip(report.table.measure, report.table.order, strict=True))

    assert found == {"weak": weak} if strong is None else found == {"strong": strong, "weak": weak}
    assert set(report.table.verdict[report.table.claim.notna()]) == {"verified"}
    assert report.failing == ()


@pytest.mark.parametrize(("scheme", "kind", "strong", "weak"), FOUND)
def test_shipped_schemes_have_the_orders_that_they_claim(scheme, kind, strong, weak):
    """The orders found are those that are known, and each claim is verified."""
    check(scheme, kind, strong, weak)


@pytest.mark.slow
@pytest.mark.parametrize(("scheme", "kind", "strong", "weak"), SLOW)
def test_schemes_of_higher_order_have_it_for_diagonal_noise(scheme, kind, strong, weak):
    """The same by Taylor series up to the weight 5."""
    check(scheme, kind, strong, weak)


@pytest.mark.parametrize(
    ("scheme", "kind", "strong", "weak"),
    [("balanced-euler", "scalar", 0.5, 0.5), ("balanced-euler", "additive", 0.5, 0.5),
     ("tamed-euler", "scalar", 0.5, 1.0), ("tamed-euler", "additive", 1.0, 1.0), ("displaced-euler", "scalar", 0, 0)],
)  # fmt: skip
def test_weights_that_depend_on_the_step_size_verify_nothing(scheme, kind, strong, weak):
    """Orders are then those as h tends to 0, for information, and the premise is told."""
    table = orders(scheme, kind, 2).table

    assert list(table.order) == pytest.approx([strong, weak], abs=0.05)
    assert not {"verified", "refuted"} & set(table.verdict)
    assert all("weights of a step depend on h" in premise for premise in table.premise)


@pytest.mark.parametrize(
    ("scheme", "motions", "name", "texts"),
    [
        (SIX[0], 2, "f(t)", ("0", "1/2")),
        (SIX[1], 2, "b1 . b1(t)", ("0", "1/2")),
        (SIX[2], 2, "b1 . b1(t)", ("1", "1/2")),
        (SIX[3], 2, "f(b1,b2)", ("1/6", "0")),
        (SIX[4], 3, "b1(b3)", ("0.5 I and 0.61 else", "I")),
    ],
    ids=lambda value: getattr(value, "label", None),
)
def test_errors_that_vanish_on_linear_and_autonomous_problems_are_told(scheme, motions, name, texts):
    """The first failing tree, what is found and what is wanted."""
    report = orders(scheme, "additive" if isinstance(scheme, SignedHeun) else "general", motions)
    (failing,) = report.failing

    assert (failing.name, failing.texts) == (name, texts)


def test_signs_that_serve_three_motions_may_not_serve_four():
    """The fourth sign is the product of the first three, which two trees of a forest with four noises tell."""
    (row,) = orders(FewSigns(), "general", 4, 4).rows

    assert (row.verdict, row.order) == ("refuted", 1.0)
    assert (row.first.name, row.first.texts) == ("b1(b2) . b3(b4)", ("1/4", "0"))


def test_too_few_trees_neither_verify_nor_refute():
    """Weak order 2 needs the weight 5."""
    (row,) = orders(PlatenWeak2General(), "general", 2, 4).rows

    assert (row.verdict, row.premise) == ("inconclusive", "the claimed order needs trees up to the weight 5")


def test_their_right_counterparts_are_verified():
    """The same schemes with what is right."""
    for scheme, kind in ((PlatenWeak2General(), "general"), (SignedHeun(), "additive")):
        assert list(orders(scheme, kind, 2).table.verdict) == ["verified"]


def test_signs_that_serve_three_motions_are_not_verified_for_two():
    """A class has any number of motions: two of five are treated otherwise than two alone."""
    (row,) = orders(FewSigns(), "general", 2).rows

    assert (row.verdict, row.held) == ("inconclusive", row.of)
    assert row.premise.startswith("a step differs far out, at late times or with more motions")


@pytest.mark.sweep(others="slow")
@pytest.mark.parametrize(("scheme", "kind"), FORTY, ids=[scheme.name for scheme, _ in FORTY])
def test_a_wrong_scheme_is_refuted_by_a_tree(scheme, kind):
    """Wrong sizes, correlations, areas, signs and times."""
    report = orders(scheme, kind, 2)

    assert "refuted" in set(report.table.verdict)
    assert report.failing


def test_a_trace_is_told_by_maps_that_are_not_invertible():
    """All trees hold for Euler's method with (tr DB_1) B_1, as derivatives of the universal SDE are nilpotent."""
    table = orders(AromaticEuler(), "general", 2).table

    assert list(table.held) == list(table.of)
    assert set(table.verdict) == {"inconclusive"}
    words = r"a step does not commute with affine maps and shifts of time \(by (.*?)\)"
    found = {re.match(words, premise)[1] for premise in table.premise}
    assert min(map(float, found)) > 1e-4


@pytest.mark.parametrize("scheme", [ScaledEuler(of_drift=0.98), ScaledEuler(of_noise=1.005), WrongTimes(c=0.0)])
def test_coefficients_at_wrong_places_are_never_verified(scheme):
    """The origin of trees is neither zero nor at time zero."""
    assert "verified" not in set(orders(scheme, "scalar").table.verdict)


class AtTimeZero(StochasticTheta):
    """A theta method whose coefficients are those of time 0."""

    def step(self, problem, state, t, h, noise):
        """Make one step."""
        return super().step(problem, state, 0.0, h, noise)


@pytest.mark.slow
@pytest.mark.parametrize("theta", [0.0, 0.5])
def test_coefficients_of_time_zero_are_never_verified_by_trees_of_low_weights(theta):
    """A run asks for the trees of a claim alone, and those of order 1/2 have no leaf t: the shift of time tells."""
    wrong, right = AtTimeZero(theta=theta), StochasticTheta(theta=theta)
    found = {scheme: [*rows_of_classes(scheme, tree_classes_of(scheme), None)] for scheme in (wrong, right)}

    assert "verified" not in {row.verdict for row in found[wrong]}
    assert {row.verdict for row in found[right] if row.promise} == {"verified"}
    assert any("shifts of time" in row.premise for row in found[wrong] if row.kind == "general")
    # y at time 0 is not the one that enter sets: memory tells before.
    assert any("steps of a run differ" in row.premise for row in found[wrong] if row.kind == "index-1")


class ModulusEuler(EulerMaruyama):
    """Euler-Maruyama with DB B sqrt(h) (abs dW - sqrt(2 h/pi))/5, whose mean is zero: the orders stay as they are."""

    name: ClassVar[str] = "modulus-euler"

    def step(self, problem, state, t, h, noise):
        """Make one step for scalar noise."""
        b = problem.diffusion(t, state)[:, 0]
        excess = np.abs(noise.dW) - np.sqrt(2.0 * h / np.pi)
        change = problem.derivative_of_diffusion(t, state, b)[:, 0]
        return Step(super().step(problem, state, t, h, noise).state + 0.2 * np.sqrt(h) * excess * change)


def test_means_that_no_rule_gives_exactly_refute_nothing():
    """A right scheme that is no polynomial of its noise is not refuted by an error of a rule; the row says why."""
    table = orders(ModulusEuler(), "scalar").table

    assert set(table.verdict) == {"inconclusive"}
    assert all("a step is not a polynomial of its noise" in premise for premise in table.premise)


@dataclass(frozen=True)
class Ambitious(EulerMaruyama):
    """Euler-Maruyama that claims strong order 3/2 for additive noise."""

    name: ClassVar[str] = "ambitious"
    claims: ClassVar[tuple[Claim, ...]] = (Claim(measure="strong", value=1.5, source="nowhere"),)


@dataclass(frozen=True)
class Wide(EulerMaruyama):
    """Euler-Maruyama that claims orders above its own by less than their margins."""

    name: ClassVar[str] = "wide"
    claims: ClassVar[tuple[Claim, ...]] = (
        Claim(measure="strong", value=0.9, margin=0.45, source="nowhere"),
        Claim(measure="weak", value=1.1, margin=0.2, source="nowhere"),
    )


class Scant(HeunAdditive):
    """Heun's scheme for additive noise that claims strong order 3/2."""

    name: ClassVar[str] = "scant"
    claims: ClassVar[tuple[Claim, ...]] = Ambitious.claims


class Processed(Ambitious):
    """The same that says its errors are taken back later."""

    name: ClassVar[str] = "processed"
    local_order_is_global: ClassVar[bool] = False


class Raising(EulerMaruyama):
    """A scheme that raises."""

    name: ClassVar[str] = "raising"

    def step(self, problem: SDE, state, t, h, noise):
        """Raise."""
        raise ZeroDivisionError("too bad")


def test_conditions_are_compared_with_the_order_and_not_with_its_margin():
    """An order within the margin of a claim is below the claim at any step size."""
    assert list(orders(Wide(), "scalar").table.verdict) == ["refuted", "refuted"]
    assert list(orders(EulerMaruyama(), "scalar").table.verdict) == ["verified", "verified"]


def test_a_record_that_cannot_give_an_order_is_told_before_the_scheme_is_blamed():
    """f(b1) = int W ds is no function of dW: no scheme that is given dW alone has strong order 3/2."""
    (row, _) = orders(Scant(), "additive", 2).rows

    assert (row.verdict, row.order) == ("refuted", 1.0)
    assert (row.first.name, row.first.known, row.first.texts) == (
        "f(b1)",
        False,
        ("not a function of the record", "I"),
    )
    assert row.premise.startswith("no scheme that uses only dW can have strong order 1.5 (f(b1) requires more noise)")
    assert "no scheme" not in orders(SIX[3], "additive", 2).premises["additive"]


def test_a_local_order_that_is_not_the_global_one_refutes_nothing():
    """Errors of single steps may be taken back later."""
    assert orders(Processed(), "additive", 2).table.verdict[0] == "inconclusive"


def test_a_scheme_that_raises_is_in_error():
    """What it raises is told."""
    table = orders(Raising(), "scalar").table

    assert set(table.verdict) == {"error"}
    assert all("ZeroDivisionError: too bad" in premise for premise in table.premise)


def test_what_a_scheme_refuses_is_told():
    """A class that a scheme does not take, a step that jumps, another form."""
    assert list(orders(MilsteinAreas(), "scalar").table.verdict) == ["not_applicable"]
    assert orders("mala", "additive").premises["additive"].startswith("a step is discontinuous")
    assert orders("baoab", "additive").premises == {"additive": "solves the form Langevin"}


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"scheme": "no-such"}, "no-such"),
        ({"scheme": "heun*"}, "which matches"),
        ({"classes": "odd"}, "unknown class 'odd'"),
        ({"motions": 0}, "motions must be from 1"),
        ({"weight": 99}, "weight must be from 1"),
    ],
)
def test_bad_arguments_are_told(options, words):
    """One line says what is wrong."""
    with pytest.raises(UsageError, match=words):
        orders(**{"scheme": "milstein", **options})
