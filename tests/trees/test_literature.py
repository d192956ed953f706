"""Runge-Kutta schemes of the literature, entered from their tables: nobody tuned order conditions for them."""

import numpy as np
import pytest

from sdaeverify import Scheme
from sdaeverify_orders import orders
from trees.literature import additive, areas, ito_weak, platen, scalar, stratonovich_weak

pytestmark = pytest.mark.long

# The largest class that each family is made for.
FAMILIES = {
    "additive": additive.SCHEMES,
    "scalar": (*scalar.SCHEMES, *platen.SCHEMES),
    "general": (*areas.SCHEMES, *ito_weak.SCHEMES, *stratonovich_weak.SCHEMES),
}
CASES = [(scheme, kind) for kind, schemes in FAMILIES.items() for scheme in schemes]
NAMES = [scheme.name for scheme, _ in CASES]
# What strong order 1 does not ask for: f(f) of weight 4, and b(f), whose factor has no mean.
NOT_ASKED = {("sri2", "A_0", (1, 0)), ("platen-strong-1", "places", (0,))}
FACTOR = 1.01


def verdicts(scheme: Scheme, classes: str | None = None, motions: int = 2) -> list[str]:
    """Return the verdicts on what is claimed."""
    table = orders(scheme, classes, motions).table
    return list(table.verdict[table.claim.notna()])


def coefficients(scheme: Scheme) -> list[tuple[str, tuple[int, ...]]]:
    """Return the places of the coefficients that are not 0 and on which the claim rests."""
    every = [(field, place) for field, values in scheme.tableau._asdict().items() for place in np.argwhere(values)]
    named = [(field, tuple(int(i) for i in place)) for field, place in every]
    return [each for each in named if (scheme.name, *each) not in NOT_ASKED]


def changed(scheme: Scheme, field: str, place: tuple[int, ...]) -> Scheme:
    """Return a scheme with one coefficient changed by 1 per cent."""
    values = getattr(scheme.tableau, field).copy()
    values[place] *= FACTOR
    tableau = scheme.tableau._replace(**{field: values})
    return type("Changed", (type(scheme),), {"name": "changed", "tableau": tableau})()


def drawn(scheme: Scheme, count: int = 3) -> list[tuple[str, tuple[int, ...]]]:
    """Return some coefficients of a scheme at random, always the same."""
    every = coefficients(scheme)
    return [every[i] for i in np.random.default_rng(len(every)).choice(len(every), count, replace=False)]


@pytest.mark.sweep(others="slow")
@pytest.mark.parametrize("scheme", [scheme for scheme, _ in CASES], ids=NAMES)
def test_a_scheme_of_the_literature_is_verified_for_its_classes(scheme):
    """Every claim is verified for every class that the scheme accepts, by all of its order conditions."""
    found = verdicts(scheme)

    assert len(found) >= 2
    assert set(found) == {"verified"}


@pytest.mark.sweep(others="slow")
@pytest.mark.parametrize(("scheme", "kind"), CASES, ids=NAMES)
def test_a_coefficient_that_is_off_by_one_per_cent_is_refuted(scheme, kind):
    """Three coefficients are drawn at random; a change of any of them is told."""
    for field, place in drawn(scheme):
        assert "refuted" in verdicts(changed(scheme, field, place), kind), (field, place)


@pytest.mark.slow
@pytest.mark.parametrize(("scheme", "kind"), CASES, ids=NAMES)
def test_every_coefficient_that_is_off_by_one_per_cent_is_refuted(scheme, kind):
    """All coefficients are looked at, but for two that a strong order 1 does not depend on."""
    every = coefficients(scheme)
    missed = [each for each in every if "refuted" not in verdicts(changed(scheme, *each), kind)]

    assert missed == []


def test_coefficients_that_are_not_asked_for_are_not_refuted():
    """With the two exceptions the changed schemes are right, and verified."""
    for name, field, place in sorted(NOT_ASKED):
        scheme, kind = CASES[NAMES.index(name)]
        assert set(verdicts(changed(scheme, field, place), kind)) == {"verified"}


@pytest.mark.sweep(others="slow")
@pytest.mark.parametrize("scheme", [ito_weak.RI6(), stratonovich_weak.RS2(), stratonovich_weak.NON()])
def test_three_motions_have_all_their_conditions(scheme):
    """What two motions cannot show holds with three of them, too."""
    assert verdicts(scheme, "general", 3) == ["verified"]


def test_one_sign_for_each_motion_serves_two_motions_and_not_three():
    """V_12 = V_13 = sqrt(h) sign_1, as implementations have it, are correlated; the areas of these pairs are not."""
    scheme = ito_weak.RI6OneSignEach()
    (row,) = orders(scheme, "general", 3).rows

    assert verdicts(scheme, "general", 2) == ["verified"]
    assert row.verdict == "refuted"
    assert (row.order, row.first.name, row.first.texts) == (1.0, "b1 . b1(b2,b3)", ("1/8", "0"))
