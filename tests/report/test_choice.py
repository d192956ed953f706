"""Which scheme for a problem: steps and work for an accuracy come from the errors and times of a run."""

import math

import pytest

from facade import choices, curves
from report.rows import level, read, verdict
from sdaeverify import SDE, Control, UsageError, verify

SIZES = [8, 16, 32, 64]


def curve(scheme, errors, *, noise=0.0, order="1.0", seconds=1e-6, problem="gbm"):
    """Return what is needed of a scheme with these errors at 8, 16, ... steps."""
    row = verdict(scheme=scheme, problem=problem, path_order=order)
    levels = [
        level(scheme=scheme, problem=problem, quantity=row["quantity"], steps=str(n), estimate=str(e),
              std_error=str(noise), fitted="")
        for n, e in zip(SIZES, errors, strict=True)
    ]  # fmt: skip
    return row, levels, {**row, "step_seconds": str(seconds)}


def chosen(*found, accuracy=math.nan, quantity=""):
    """Return the choices among some curves."""
    rows, levels, details = zip(*found, strict=True)
    known = curves(read(*rows), [each for some in levels for each in some], details)
    return choices(known, "gbm", ("strong", quantity), {"a": "dW, H"}, accuracy)


def test_steps_are_interpolated_and_extrapolated_by_the_order():
    """Between two levels on the line through both; beyond the finest with the order, which is said."""
    found = chosen(curve("a", [0.8, 0.4, 0.2, 0.1]), curve("b", [0.8, 0.4, 0.2, 0.15], seconds=4e-6), accuracy=0.1)
    assert [(one.scheme, one.steps, one.beyond) for one in found.found] == [("a", 64.0, False), ("b", 96.0, True)]
    assert [one.seconds for one in found.found] == pytest.approx([64e-6, 384e-6])
    (one, _) = chosen(curve("a", [0.8, 0.4, 0.2, 0.1]), curve("b", [9, 9, 9, 9]), accuracy=0.3).found
    assert one.steps == math.ceil(16 * 0.4 / 0.3)
    assert one.noise == "dW, H"


def test_the_least_work_comes_first_and_what_is_not_known_last():
    """A dear step may need fewer of them; errors within their noise, and orders of 0, tell no work."""
    known = curve("dear", [0.1, 0.05, 0.025, 0.0125], seconds=1e-5), curve("cheap", [0.8, 0.4, 0.2, 0.1])
    unknown = curve("noisy", [0.1, 0.1, 0.1, 0.1], noise=0.05), curve("stuck", [1.0, 1.0, 1.0, 1.0], order="0.05")
    found = chosen(*unknown, *known, accuracy=0.1)
    assert [one.scheme for one in found.found] == ["cheap", "dear", "noisy", "stuck"]
    assert [math.isfinite(one.seconds) for one in found.found] == [True, True, False, False]


def known_leading(scheme, constant, power, **changes):
    """Return a curve whose errors are within their noise, with a leading error that is known without sampling."""
    row, levels, details = curve(scheme, [1e-3] * 4, noise=1.0, **changes)
    for n, one in zip(SIZES, levels, strict=True):
        one["h"] = str(2.0 / n)
    return row, levels, {**details, "error_constant": str(constant), "error_power": str(power)}


def test_a_leading_error_tells_the_steps_that_paths_do_not():
    """With |C| h^p = accuracy and T = 2; no fewer steps than the coarsest, and none without a constant."""
    fine, coarse = known_leading("fine", -0.5, 2.0), known_leading("coarse", 1e-6, 1.0)
    found = chosen(fine, coarse, curve("none", [1e-3] * 4, noise=1.0), accuracy=1e-4).found
    steps = {one.scheme: (one.steps, one.beyond, one.leading) for one in found}

    assert steps["fine"] == (math.ceil(2.0 * math.sqrt(0.5 / 1e-4)), True, "-0.5 h^2")
    assert steps["coarse"] == (8.0, True, "1e-06 h")
    assert math.isnan(steps["none"][0])
    assert steps["none"][2] == ""


def test_errors_along_paths_count_before_a_leading_error():
    """Where levels tell the steps, they are taken from these."""
    row, levels, details = curve("a", [0.8, 0.4, 0.2, 0.1])
    found = chosen((row, levels, {**details, "error_constant": "100.0", "error_power": "1.0"}), accuracy=0.1).found

    assert (found[0].steps, found[0].beyond, found[0].leading) == (64.0, False, "100 h")


def test_choices_are_a_table():
    """A row for each scheme in its order; a notebook shows it, texts of plugins as texts."""
    found = chosen(curve("<b>", [0.8, 0.4, 0.2, 0.1]), curve("b", [0.8, 0.4, 0.2, 0.15]), accuracy=0.1)
    assert found.table.scheme.tolist() == ["<b>", "b"]
    assert found.table.steps.tolist() == [64.0, 96.0]
    assert "&lt;b&gt;" in found._repr_html_()
    assert "<b>b" not in found._repr_html_()
    assert "an error of 0.1" in found._repr_html_()


def test_errors_that_rise_again_do_not_count_as_reached():
    """An accuracy is reached where all finer levels have it, too: a zero of the error is no accuracy."""
    (one,) = chosen(curve("a", [0.8, 0.01, 0.3, 0.1]), accuracy=0.2).found
    assert 32 < one.steps <= 64


def test_half_of_the_schemes_reach_the_accuracy_that_is_left_out():
    """The median of the errors at the finest level, rounded up."""
    found = chosen(*(curve(name, [0.8, 0.4, 0.2, e]) for name, e in (("a", 0.012), ("b", 0.042), ("c", 0.19))))
    assert found.accuracy == 0.05
    assert sum(not one.beyond for one in found.found) == 2


def test_what_was_not_measured_is_an_error_of_the_user():
    """One line with the quantities that there are."""
    with pytest.raises(UsageError, match="no strong error of z is known on gbm; there are x"):
        chosen(curve("a", [0.8, 0.4, 0.2, 0.1]), quantity="z")
    with pytest.raises(UsageError, match="no strong error is known on gbm"):
        chosen(curve("a", [0.8, 0.4, 0.2, 0.1], problem="ou"))


def test_a_result_chooses():
    """Milstein's order 1 needs fewer steps than Euler's 1/2, and the noise of both is told."""
    result = verify("milstein,euler-maruyama", "gbm", "strong", paths=1024, levels=4)
    found = {one.scheme: one for one in result.choose("gbm", accuracy=0.03).found}
    assert found["milstein"].steps < found["euler-maruyama"].steps
    assert {one.noise for one in found.values()} == {"dW"}
    assert {one.verdict for one in found.values()} == {"verified"}


def test_a_finished_run_counts_errors_of_verified_schemes_alone():
    """Others may have errors to limits of their own; a refuted scheme is left out, one without a claim is last."""
    right, small = curve("right", [0.8, 0.4, 0.2, 0.1]), [1e-3, 5e-4, 2.5e-4, 1.25e-4]
    open_, wrong, mute = (curve(name, small) for name in ("open", "wrong", "mute"))
    open_[0]["verdict"], wrong[0]["verdict"], mute[0]["verdict"] = "inconclusive", "refuted", "out_of_scope"
    mute[0]["claim"] = ""
    found = chosen(right, open_, wrong, mute, accuracy=0.1)
    assert [(one.scheme, one.seconds > 0.0) for one in found.found] == [
        ("right", True),
        ("open", False),
        ("mute", False),
    ]
    assert found.left_out == ("wrong",)


def noisy_without_truth(displaced: bool = False) -> SDE:
    """Return dx = -x/2 dt + x/2 dW, of which no solution is given."""
    controls = (
        (Control(measure="weak", order=1.0, positive="milstein", negative="displaced-euler"),) if displaced else ()
    )
    return SDE(
        drift=lambda t, x: -0.5 * x, diffusion=lambda t, x: 0.5 * x[:, None], start=[1.0], noise_dim=1, horizon=1.0,
        source="made up", observables={"x": lambda t, parts: parts["x"][0]}, controls=controls,
    )  # fmt: skip


def test_all_errors_are_to_one_reference():
    """A scheme that tends to the wrong limit has its true error, and stands below those with a claim."""
    result = verify("euler-maruyama,milstein,displaced-euler", [noisy_without_truth], "weak", paths=2048, levels=4)
    found = result.choose("noisy-without-truth", "weak")
    *claimed, last = found.found
    assert {one.scheme for one in claimed} == {"euler-maruyama", "milstein"}
    assert found.reference.endswith("on the same noise")
    # E x(1) = exp(-1/2); with y = 1.05 x + .05 in the drift the mean of the wrong limit is off by .03.
    assert (last.scheme, last.claim) == ("displaced-euler", "")
    assert last.error == pytest.approx(0.031, abs=0.015)
    assert all(one.error < 0.01 for one in claimed)


def test_negative_controls_are_left_out():
    """A control of the problem that claims nothing is in no table."""
    problem = noisy_without_truth

    def noisy_with_control() -> SDE:
        return problem(displaced=True)

    found = verify("milstein,displaced-euler", [noisy_with_control], "weak", paths=512, levels=3).choose(
        "noisy-with-control", "weak", accuracy=1.0
    )
    assert [one.scheme for one in found.found] == ["milstein"]
    assert found.left_out == ("displaced-euler",)


def test_times_are_of_the_same_arrays():
    """Work is timed on the same blocks for all schemes: a step with a copy of itself takes no less."""
    result = verify("euler-maruyama,balanced-euler", "gbm", "strong", paths=1024, levels=3)
    found = {one.scheme: one for one in result.choose("gbm", accuracy=0.2).found}
    assert found["euler-maruyama"].at == found["balanced-euler"].at == 32
    assert all(one.seconds > 0.0 for one in found.values())
