"""What `info` says of the mean-square stability of an equation with a delay."""

from facade import delay_ou, delay_test, gbm_algebraic
from sdaeverify.cli.commands.info import stability_lines


def test_rates_condition_and_bounds_are_those_of_the_sheet() -> None:
    """Set IV: linearised and with l = 0, C = 7, h_0 = 0.0389 and 0.0486 for theta = 0."""
    text = "\n".join(stability_lines(delay_test("IV")))
    assert "growth rate of E x^2: -1.356 at small states, -1.8602 at large ones" in text
    assert "condition (4.1) holds: C = 7; abar = 8, al0 = 8, al1 = 2, al2 = 1" in text
    assert "theta = 0: stable below h_0 = 0.038889, sharpened 0.048611" in text
    assert "theta = 1: stable below h_0 = inf, sharpened inf" in text


def test_a_linear_equation_has_one_rate_and_a_condition_may_fail() -> None:
    """Set II grows, and (4.1) promises nothing."""
    lines = stability_lines(delay_test("II"))
    assert lines[1] == "  growth rate of E x^2: 0.80494"
    assert lines[2].startswith("  condition (4.1) fails: C = -4;")
    assert len(lines) == 3


def test_better_constants_with_y_eliminated_are_shown() -> None:
    """Set III: (4.1) fails with y, and holds without it."""
    text = "\n".join(stability_lines(delay_test("III")))
    assert "condition (4.1) fails: C = -24.2;" in text
    assert "with y eliminated, condition (4.1) holds: C = 15.8;" in text


def test_where_nothing_is_known_nothing_is_said() -> None:
    """Additive noise, and no delay."""
    assert stability_lines(delay_ou()) == []
    assert stability_lines(gbm_algebraic()) == []
