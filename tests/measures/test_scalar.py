"""A measure of a number with a bound: fifteen lines of somebody else, told right from wrong at a known level."""

from pathlib import Path
from typing import ClassVar

import numpy as np
import pytest
import scipy

from facade import chernoff_interval
from sdaeverify import SDE, Claim, Scheme, Step, verify
from sdaeverify.measuring import ScalarMeasure
from sdaeverify.numerics import apply, chernoff

ENERGY = Path(__file__).parents[1] / "thirdparty" / "energy" / "src" / "sdaeverify_energy"
FILES = [ENERGY / "negative_share.py", ENERGY / "reflected_euler.py"]
SHARE = "share of negative paths"


@pytest.fixture(scope="module")
def found():
    """Return the verdicts on the right and the wrong scheme, where noise is strong and where it is weak."""
    made = verify("reflected-euler,unreflected-euler,milstein", "gbm[b=2],gbm", "negative-share", plugins=FILES)
    return made.verdicts.set_index(["scheme", "problem"])


def test_the_measure_is_fifteen_lines():
    """Without docstrings, blank lines and imports its author writes less than that."""
    code = FILES[0].read_text().split('"""')[::2]
    lines = [line for line in "".join(code).splitlines() if line.strip() and "import" not in line]
    assert len(lines) <= 15


def test_a_bound_that_holds_is_verified_and_one_that_fails_refuted(found):
    """A reflected path is never negative; without that more than one in a hundred is, if noise is strong."""
    assert found.verdict["reflected-euler", "gbm[b=2]"] == "verified"
    assert found.verdict["unreflected-euler", "gbm[b=2]"] == "refuted"
    assert found.verdict["unreflected-euler", "gbm"] == "verified"
    assert found.verdict["milstein", "gbm"] == "out_of_scope"


def test_the_share_is_that_of_the_law(found):
    """Over one of 8 steps Euler is negative with probability Phi(-(1 + a h)/(b sqrt h)), a run with 1 - (1 - p)^8."""
    h = 1.0 / 8.0
    once = scipy.special.ndtr(-(1.0 + 0.5 * h) / (2.0 * np.sqrt(h)))
    row = found.loc["unreflected-euler", "gbm[b=2]"]

    # The sign changes with each negative factor: the first of them makes the path negative at that time.
    assert row.value_low < 1.0 - (1.0 - once) ** 8 < row.value_high
    assert SHARE in row.reason.lower()
    assert "claimed bound 0.01" in row.reason


class Constant(ScalarMeasure):
    """The same number on every path."""

    name: ClassVar[str] = "constant"
    value_of: ClassVar[str] = "the number"
    limits: ClassVar[tuple[float, float]] = (-1.0, 3.0)

    def number(self, problem, t, parts):
        return np.full(parts["x"].shape[1], 1.0 + t)


class AtEnd(Constant):
    """The same at T."""

    name: ClassVar[str] = "at-end"
    at_end: ClassVar[bool] = True

    def number(self, problem, t, parts):
        return np.full(parts["x"].shape[1], 1.0 - t)


class Euler(Scheme):
    """Euler's method."""

    name: ClassVar[str] = "some-euler"
    form: ClassVar[type] = SDE
    claims: ClassVar = (
        Claim(measure="constant", value="the number", bound=2.5, source="t <= 1"),
        Claim(measure="at-end", value="the number", bound=0.5, source="it is 0"),
    )

    def step(self, problem, state, t, h, noise):
        return Step(state + h * problem.drift(t, state) + apply(problem.diffusion(t, state), noise.dW))


class Exploding(Euler):
    """Euler's method that loses a path in four, of which nothing is known."""

    name: ClassVar[str] = "exploding"

    def step(self, problem, state, t, h, noise):
        state = super().step(problem, state, t, h, noise).state
        return Step(np.where(np.arange(state.shape[1]) % 4 == 0, np.inf, state) if t > 0.9 else state)


class Vague(Euler):
    """The same with claims that say less than a bound at every step size."""

    name: ClassVar[str] = "vague"
    claims: ClassVar = (
        Claim(measure="constant", value="the number", source="no bound"),
        Claim(measure="at-end", value="another number", bound=0.5, source="other words"),
    )


def test_limits_are_units(found):
    """Numbers between other limits than 0 and 1 are estimated, and compared with the bound, in their own unit."""
    rows = verify(Euler(), "gbm", [Constant(), AtEnd()], paths=256).verdicts.set_index("measure")

    assert rows.value["constant"] == pytest.approx(2.0)
    assert rows.value["at-end"] == pytest.approx(0.0)
    assert {*rows.verdict} == {"verified"}


def test_what_is_lost_counts_either_way():
    """Paths of which nothing is known could have any number: with a quarter of them nothing is verified."""
    rows = verify(Exploding(), "gbm", [Constant(), AtEnd()], paths=256, levels=3).verdicts

    assert not rows.verdict.isin(["verified"]).any()


class Largest(Constant):
    """The largest state, which may be many times as large as it is on average."""

    name: ClassVar[str] = "largest"
    limits: ClassVar[tuple[float, float]] = (0.0, 50.0)

    def number(self, problem, t, parts):
        return parts["x"][0]


class Bounded(Euler):
    """Euler's method, of whose largest state, 1.93 on average, something is claimed."""

    most: ClassVar[float] = 1.2
    name: ClassVar[str] = "bounded"

    @property
    def promises(self):
        return (Claim(measure="largest", value="the number", bound=self.most, source="made up"),)


class NearlyBounded(Bounded):
    """The same with a bound that is too near to tell."""

    most: ClassVar[float] = 1.8
    name: ClassVar[str] = "nearly-bounded"


def test_more_paths_are_asked_for_where_the_interval_is_wide():
    """A mean that is above its bound is followed until that is sure, or takes more paths than there may be."""
    rows = verify([Bounded(), NearlyBounded()], "gbm", Largest()).verdicts.set_index("scheme")

    assert [*rows.verdict] == ["refuted", "inconclusive"]
    assert rows.value_low["bounded"] > Bounded.most
    assert min(rows.paths) > 1024
    assert "0000 paths would decide" in rows.reason["nearly-bounded"]


class Trivially(Euler):
    """The same with a bound that every number keeps."""

    name: ClassVar[str] = "trivially"
    claims: ClassVar = (Claim(measure="at-end", value="the number", bound=3.0, source="made up"),)


def test_a_bound_that_no_number_can_exceed_verifies_nothing():
    """The limits of a measure are the size of its numbers."""
    rows = verify(Trivially(), "gbm", AtEnd(), paths=256, levels=3).verdicts

    assert [*rows.verdict] == ["inconclusive"]
    assert rows.reason.str.startswith("The claimed bound 3 is not below the size of the quantity, 3").all()


def test_claims_without_a_bound_are_open():
    """Words that are not the measure's, and words without a bound, are not understood."""
    rows = verify(Vague(), "gbm", [Constant(), AtEnd()], paths=256, levels=3).verdicts

    assert [*rows.verdict] == ["inconclusive"] * 2
    assert rows.reason.str.contains("has no test for the cl").all()


@pytest.mark.parametrize("rate", [0.002, 0.05, 0.5])
def test_intervals_contain_the_rate_at_their_confidence(rate):
    """The probability that the interval misses is below alpha, by the binomial law, exactly."""
    n, alpha = 400, 0.05
    hits = np.arange(n + 1)
    ends = np.array([chernoff_interval(k / n, n, 1.0 - alpha) for k in hits])
    missed = (ends[:, 0] > rate) | (ends[:, 1] < rate)

    assert scipy.stats.binom.pmf(hits[missed], n, rate).sum() <= alpha


def test_chernoff_bounds_the_binomial_tail():
    """exp(-n KL) is at least the probability of a mean so far away."""
    n, q, hits = 50, 0.1, np.arange(6, 51)
    # The exponential of x has a relative error of |x| eps, and |x| < 116 here.
    assert (chernoff(hits / n, q, n) * (1.0 + 1e-13) >= scipy.stats.binom.sf(hits - 1, n, q)).all()


def test_the_base_asks_for_a_number():
    """Its method has no default: a subclass that forgets it is in error, not verified."""

    class Mute(ScalarMeasure):
        name = "mute"
        value_of = "nothing"

    (row,) = verify(Euler(), "gbm", [Mute()], paths=100, levels=3).verdicts.to_dict("records")
    assert row["verdict"] == "error"
    assert "NotImplementedError" in row["reason"]
