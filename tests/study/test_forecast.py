"""What is left of a study, told from the measured seconds of what is done."""

import pytest

from sdaeverify.contracts.settings import Settings
from sdaeverify.registry.load import load_registry
from sdaeverify.registry.selection import select_measures, select_problems, select_schemes
from sdaeverify.study import Advanced, Study, plan
from sdaeverify.study.forecast import FURTHER, PRIOR, Forecast


def test_nothing_is_known_before_anything_was_measured():
    """Without a measured second nothing is told."""
    assert Forecast({"a": 3}, 256).left([]) == 0.0


def test_a_first_look_costs_what_the_schemes_on_it_have_cost():
    """A problem begun is told by its own schemes, another one by the mean of all."""
    forecast = Forecast({"a": 4, "b": 2}, 256)
    forecast.heard("a", 6.0, 3, None)
    assert forecast.left([]) == pytest.approx(1 * 2.0 + 2 * 2.0)


def test_a_first_look_costs_more_where_what_needs_no_paths_did():
    """Another problem took two seconds on paths for each one without; measured schemes outweigh that by and by."""
    forecast = Forecast({"a": 1, "b": 3}, 256)
    forecast.heard_screening("a", 4.0, 1)
    forecast.heard_screening("b", 3.0, 3)
    forecast.heard("a", 8.0, 1, None)
    assert forecast.left([]) == pytest.approx(3 * 2.0)
    forecast.heard("b", 5.0, 1, None)
    pace = (8.0 + 5.0) / (4.0 + 1.0)
    assert forecast.left([]) == pytest.approx(2 * (5.0 + PRIOR * pace * 1.0) / (1 + PRIOR))


def test_a_further_look_costs_what_its_paths_have_cost():
    """Until one was measured, a path is a part of one of the first look; then it is what it was."""
    forecast = Forecast({"a": 2}, 256)
    forecast.heard("a", 4.0, 2, None)
    forecast.over.add("a")
    assert forecast.left([("a", 1, 512)]) == pytest.approx(FURTHER * 2.0 / 256 * 512)
    forecast.heard("a", 3.0, 1, 512)
    assert forecast.left([("a", 1, 1024)]) == pytest.approx(6.0)


def test_problems_to_come_are_looked_at_again_as_often_as_those_before():
    """Half of the problems went on: so will half of the rest."""
    forecast = Forecast({"a": 1, "b": 1, "c": 1}, 100)
    for name, goes_on in (("a", True), ("b", False)):
        forecast.heard(name, 8.0, 1, None)
        forecast.over.add(name)
        forecast.looked(first=True, goes_on=goes_on)
    assert forecast.left([]) == pytest.approx(8.0 + 0.5 * FURTHER * 8.0)


def test_a_further_look_may_be_followed_by_one_with_twice_as_many_paths():
    """As often as it was so far."""
    forecast = Forecast({"a": 1}, 100)
    forecast.heard("a", 1.0, 1, 100)
    forecast.over.add("a")
    for goes_on in (True, False):
        forecast.looked(first=False, goes_on=goes_on)
    assert forecast.left([("a", 1, 100)]) == pytest.approx(1.0 * (1.0 + 2.0 * 0.5))


def test_a_run_tells_how_far_it_is_by_schemes_on_problems():
    """In this process, too, something is told every few schemes; in the end all is decided and nothing left."""
    registry = load_registry()
    schemes = select_schemes(registry, "euler-maruyama,milstein,heun,tamed-euler,balanced-euler")
    problems, measures = select_problems(registry, "gbm,ou"), select_measures(registry, "strong")
    study = Study(plan(schemes, problems, measures), Settings(paths=256, levels=3))
    told = [event for event in study.run() if isinstance(event, Advanced)]
    assert len(told) > 4
    assert {event.pairs for event in told} == {9} or {event.pairs for event in told} == {10}
    spent = [event.spent for event in told]
    assert spent == sorted(spent)
    assert spent[0] > 0.0
    assert told[-1].left == 0.0
