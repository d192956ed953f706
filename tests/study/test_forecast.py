"""What is left of a study, told from the measured seconds of what is done."""

import json
from pathlib import Path

import pytest

from sdaeverify.contracts.settings import SCREENING, Settings
from sdaeverify.registry.load import load_registry
from sdaeverify.registry.selection import select_measures, select_problems, select_schemes
from sdaeverify.study import Advanced, Study, plan
from sdaeverify.study.forecast import AGAIN, ALIKE, FIRST, GROWTH, Forecast, LaneKey
from study.record_run import distances, shown

# A first block of 256 paths, and further ones of 768 and 1024, of so many times its seconds.
THREE = Settings(paths=2048, looks=3, guard_levels=6)
ONE = Settings(paths=256, guard_levels=6)
# Levels of guards, beside all of them.
FEWER = -2
SECOND, THIRD = 1.0 + 2.0 * GROWTH, 1.0 + 3.0 * GROWTH


def forecast(settings=THREE, **schemes):
    """Return a forecast of the first looks at some problems, by their numbers of schemes, of one breadth each."""
    made = Forecast(settings)
    for problem, count in schemes.items():
        blocks = (SCREENING, *range(settings.ends[0]))
        made.expect(problem, [LaneKey(f"s{n}", block) for n in range(count) for block in blocks], count)
    return made


def heard(made, problem, block, seconds, *, stage=0):
    """Tell a forecast what schemes took on a block."""
    made.heard(problem, [(LaneKey(scheme, block, stage), each) for scheme, each in seconds])


def test_nothing_is_known_before_anything_was_measured():
    """Without a measured second nothing is told."""
    assert forecast(a=3).left == 0.0


def test_what_needs_no_paths_costs_what_the_schemes_so_far_have_cost():
    """A problem begun is told by its own schemes, another one by the mean of all; paths are guessed from that."""
    made = forecast(ONE, a=4, b=2)
    heard(made, "a", SCREENING, [("s0", 1.0), ("s1", 2.0), ("s2", 3.0)])
    assert made.left == pytest.approx((1 + 2) * 2.0 + FIRST * 6 * 2.0)


def test_a_problem_not_begun_costs_what_others_have_cost_for_their_breadth():
    """What has a quarter of the breadth of what was measured costs a quarter of it."""
    made = Forecast(ONE)
    for problem, breadth in {"a": 8, "b": 2}.items():
        made.expect(problem, [LaneKey("s0", SCREENING), LaneKey("s1", SCREENING)], breadth)
    heard(made, "a", SCREENING, [("s0", 3.0), ("s1", 5.0)])
    assert made.left == pytest.approx(8.0 / 4)


def test_measured_schemes_outweigh_the_guess_of_a_first_look():
    """What the schemes of a problem took on paths counts as much each as those that the guess stands for."""
    made = forecast(ONE, a=3)
    heard(made, "a", SCREENING, [("s0", 2.0), ("s1", 2.0), ("s2", 2.0)])
    assert made.left == pytest.approx(3 * FIRST * 2.0)
    heard(made, "a", 0, [("s0", 5.0)])
    assert made.left == pytest.approx(2 * (5.0 + ALIKE * FIRST * 2.0) / (1 + ALIKE))


def test_problems_that_paths_have_not_told_of_take_a_part_of_the_further_looks():
    """Until its first look is over, a problem is expected to take a guessed part of what all its looks would cost."""
    made = forecast(a=2)
    heard(made, "a", SCREENING, [("s0", 1.0), ("s1", 1.0)])
    heard(made, "a", 0, [("s0", 3.0), ("s1", 5.0)])
    assert made.left == pytest.approx(AGAIN * (SECOND + THIRD) * 8.0)
    made.expect("a", [])
    assert made.left == 0.0


def test_a_further_look_costs_what_its_own_schemes_have_cost():
    """Each scheme by itself, the more the more paths a block has."""
    made = forecast(a=2)
    heard(made, "a", 0, [("s0", 3.0), ("s1", 5.0)])
    made.expect("a", [LaneKey("s0", 1), LaneKey("s0", 2), LaneKey("s1", 1)])
    assert made.left == pytest.approx(3.0 * (SECOND + THIRD) + 5.0 * SECOND)
    heard(made, "a", 1, [("s0", 4.0)])
    assert made.left == pytest.approx((3.0 + 4.0) / (1.0 + SECOND) * THIRD + 5.0 * SECOND)


def test_guards_cost_their_part_of_the_steps_of_all_levels():
    """Four of six levels make 120 of 504 steps; a part of what all levels would cost is expected behind them."""
    made = Forecast(Settings(paths=256))
    made.expect("a", [LaneKey("s0", 0, stage=FEWER), LaneKey("s1", 0, stage=FEWER)], 2)
    heard(made, "a", 0, [("s0", 120.0)], stage=FEWER)
    unknown = (504.0 + ALIKE * FIRST * 504.0 / FIRST) / (1 + ALIKE)
    assert made.left == pytest.approx(120.0 / 504.0 * unknown + AGAIN * (504.0 + unknown))
    made.over("a", 0, stage=FEWER)
    made.expect("a", [LaneKey("s0", 0)])
    assert made.left == pytest.approx(504.0)


def test_what_was_known_before_is_not_waited_for():
    """Evidence that is found in a folder takes no time; nothing of it is left."""
    made = forecast(ONE, a=2)
    heard(made, "a", SCREENING, [("s0", 1.0)])
    made.over("a", SCREENING)
    assert made.left == pytest.approx(2 * FIRST)
    made.over("a", 0)
    assert made.left == 0.0


def test_problems_to_come_cost_what_the_paths_of_others_have_cost():
    """Where all that needs no paths was known before, first looks are told by those of other problems."""
    made = forecast(ONE, a=1, b=3)
    for problem in "ab":
        made.over(problem, SCREENING)
    heard(made, "a", 0, [("s0", 2.0)])
    assert made.left == pytest.approx(3 * 2.0)


def test_progress_is_correct_to_a_tenth_in_the_last_two_thirds():
    """On what a default run told, the share that is shown is that of the time that has passed, to a tenth."""
    recorded = json.loads(Path(__file__).with_name("recorded_run.json").read_text(encoding="utf-8"))
    assert [*shown(recorded)][-1][1] == 1.0
    assert max(distances(recorded)) <= 0.1


def test_a_run_tells_how_far_it_is_by_schemes_on_problems():
    """In this process, too, something is told every few schemes; in the end all is decided and nothing left."""
    registry = load_registry()
    schemes = select_schemes(registry, "euler-maruyama,milstein,heun,tamed-euler,balanced-euler")
    problems, measures = select_problems(registry, "gbm,ou"), select_measures(registry, "strong")
    study = Study(plan(schemes, problems, measures), Settings(paths=256, levels=3))
    told = [event for event in study.run() if isinstance(event, Advanced)]
    assert len(told) > 4
    assert {event.total for event in told} == {9} or {event.total for event in told} == {10}
    spent = [event.spent for event in told]
    assert spent == sorted(spent)
    assert spent[0] > 0.0
    assert told[-1].left == 0.0
