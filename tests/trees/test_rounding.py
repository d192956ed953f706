"""How far the conditions of right schemes are from holding: roundings, Newton's method, Taylor series."""

import pytest

from facade import CLASSES, Examined, belongs, load_plugins, probe_of, select_schemes

BY_NAME = {kind.name: kind for kind in CLASSES}
# Scheme, class, motions, measure, order and a bound: of roundings, of updates of Newton's method, of a Taylor series.
EXACT, NEWTON, SERIES = 1e-10, 1e-9, 1e-5
RIGHT = [
    ("sri1w1", "scalar", 1, "strong", 1.5, EXACT),
    ("sra1", "additive", 2, "strong", 1.5, EXACT),
    ("sra1", "additive", 2, "weak", 2.0, EXACT),
    ("sra1", "overdamped-gradient", 2, "invariant", 2.0, EXACT),
    ("milstein", "scalar", 1, "strong", 1.0, EXACT),
    ("milstein-areas", "general", 3, "strong", 1.0, EXACT),
    ("heun", "commutative", 2, "strong", 1.0, EXACT),
    ("heun-additive", "additive", 2, "weak", 2.0, EXACT),
    ("platen-weak-2", "scalar", 1, "weak", 2.0, EXACT),
    ("platen-weak-2-general", "general", 2, "weak", 2.0, EXACT),
    ("stochastic-theta", "additive", 2, "weak", 2.0, NEWTON),
    ("stochastic-theta", "scalar", 1, "weak", 1.0, NEWTON),
    ("milstein", "diagonal", 2, "strong", 1.0, SERIES),
    ("heun", "diagonal", 2, "weak", 1.0, SERIES),
]


@pytest.mark.parametrize(("name", "kind", "motions", "measure", "order", "bound"), RIGHT)
def test_conditions_of_right_schemes_hold_to_rounding(name, kind, motions, measure, order, bound):
    """In units of h^(w/2) no defect is larger than its method makes it."""
    (scheme,) = select_schemes(load_plugins(), name)
    of = Examined(probe_of(scheme, BY_NAME[kind], motions, int(2 * order + 1)))
    asked = [each.defect for each in of.found if belongs(each, measure, order)]

    assert asked
    assert max(asked) <= bound
