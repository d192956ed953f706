"""Right schemes are not refuted, also on problems that make steps look coarse, or whose parameters are random.

Not all of the 1000 random sets have been run. Of those below 345 about 280 were, most of them while rules were still
changing: number 323 was the last that was refuted, by drift on steps too coarse for its order, and is not any more.
Of 64 from 345 to 428 and the first 8, 17 were run at c116bc5 and 55 at 10ece6b: none is refuted, two ended with the
time limit on a busy machine, and five claim nothing.
"""

from itertools import product

import numpy as np
import pytest

from facade import LATE, problem_spec
from sdaeverify import UsageError, verify
from statistical import random_problems
from statistical.random_problems import FACTOR, TIMEOUT, collected, drawn, shipped, verdicts

PROBLEMS = [
    *(f"gbm[a={a},b={b}]" for a, b in product((-8, -2, 0.5, 2, 4), (0.02, 0.1, 0.3, 1))),
    *(f"ou[a={a},sigma={sigma}]" for a, sigma in product((0.2, 1, 4, 8), (0.02, 0.1, 0.7))),
    "pendulum[horizon=2]",
    "pendulum[omega_0=3,horizon=1]",
    "pendulum[c_g=20]",
    "pendulum-tangential[horizon=2]",
    "pendulum-velocity-noise[horizon=1]",
    "pendulum-velocity-noise[sigma=0.1,gamma=2,horizon=1]",
    "pendulum-velocity-noise[sigma=0.2]",
]
SETS, PARTS = 1000, 20


@pytest.mark.slow
def test_shipped_claims_hold_on_other_parameters():
    """Over 39 parameter sets, stiff, noisy and nearly noise-free ones among them, no shipped claim is refuted."""
    found = verify(problems=PROBLEMS, paths=4096).verdicts

    assert found[found.verdict.isin(["refuted", "error"])].empty
    assert (found.verdict == "verified").sum() > 300


@pytest.mark.slow
@pytest.mark.parametrize("part", range(PARTS))
def test_no_claim_is_refuted_on_random_parameters(part):
    """Of 1000 sets, each run again by `collected([number])`: none is refuted or in error, some are verified."""
    found = collected(range(part * SETS // PARTS, (part + 1) * SETS // PARTS))
    too_long = found.reason == LATE.format(TIMEOUT)

    wrong = found[(found.verdict == "refuted") | (found.verdict == "error") & ~too_long]
    assert wrong.empty, wrong[["number", "scheme", "problem", "measure", "quantity", "reason"]].to_string()
    assert (found.verdict == "verified").sum() > SETS // PARTS


def test_a_set_is_known_by_its_number():
    """Drawn again it is the same; the next numbers go through all problems."""
    sets = [drawn(number) for number in range(len(shipped()))]

    assert drawn(3) == sets[3]
    assert len({each.problem.name for each in sets}) == len(sets)
    assert all(each.schemes for each in sets)
    assert drawn(3 + len(sets)).problem.label != sets[3].problem.label


@pytest.mark.long
def test_factors_are_log_uniform_between_a_fifth_and_five():
    """The noise of one problem, in 300 sets: the factor's logarithm has mean 0 and variance 1/3 of log^2 5."""
    place = [family.__name__ for family in shipped()].index("ou")
    sets = [drawn(place + len(shipped()) * k) for k in range(300)]
    logs = np.log([each.problem.build().diffusion(0.0, np.ones((1, 1)))[0, 0, 0] / 0.7 for each in sets])

    assert np.abs(logs).max() <= np.log(FACTOR) * 1.01
    # Four standard errors.
    assert abs(logs.mean()) < 4.0 * np.log(FACTOR) / np.sqrt(3.0 * 300)
    assert np.mean(logs**2) / np.log(FACTOR) ** 2 == pytest.approx(1.0 / 3.0, abs=4.0 * np.sqrt(4.0 / 45.0 / 300))


@pytest.mark.long
def test_what_a_problem_rejects_is_drawn_again(monkeypatch):
    """A sphere in one dimension is none: its problem says so in one line, and the set has another dimension."""
    place = [family.__name__ for family in shipped()].index("stiefel")
    sets = [drawn(place + len(shipped()) * k) for k in range(12)]
    rejected = [text for each in sets for text in each.rejected]

    assert rejected
    assert not any("\n" in text for text in rejected)
    with pytest.raises(UsageError):
        problem_spec(shipped()[place], {"d": "1"}).build()
    monkeypatch.setattr(random_problems, "DRAWS", 0)
    with pytest.raises(RuntimeError, match="0 draws"):
        drawn(place)


@pytest.mark.parametrize("name", ["gbm", "ou"])
def test_a_set_of_a_plain_problem_is_verified(name):
    """Its rows have the number, and none is refuted."""
    number = [family.__name__ for family in shipped()].index(name)
    found = verdicts(drawn(number))

    assert set(found.number) == {number}
    assert set(found.verdict) <= {"verified", "inconclusive", "out_of_scope"}
    assert "verified" in set(found.verdict)
