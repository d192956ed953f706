"""What is left of a study, told from the measured seconds of what is done."""

import heapq
import json
from collections import deque
from pathlib import Path

import pytest

from sdaeverify.cli.progress import share_of
from sdaeverify.contracts.settings import Settings
from sdaeverify.registry.load import load_registry
from sdaeverify.registry.selection import select_measures, select_problems, select_schemes
from sdaeverify.study import Advanced, Study, plan
from sdaeverify.study.forecast import AGAIN, ALIKE, FIRST, LATER, NEXT, PRIOR, Forecast, Queued

LOOKS = [256, 256, 512]


def test_nothing_is_known_before_anything_was_measured():
    """Without a measured second nothing is told."""
    assert Forecast({"a": 3}, LOOKS).left([]) == 0.0


def test_what_needs_no_paths_costs_what_the_schemes_so_far_have_cost():
    """A problem begun is told by its own schemes, another one by the mean of all; paths are guessed from that."""
    forecast = Forecast({"a": 4, "b": 2}, [256])
    forecast.heard_screening("a", 6.0, 3)
    assert forecast.left([]) == pytest.approx((1 * 2.0 + 2 * 2.0) + FIRST * 6 * 2.0 * ALIKE / ALIKE)


def test_a_first_look_costs_more_where_what_needs_no_paths_did():
    """What paths took for each second without outweighs the guess by and by, and measured schemes that."""
    forecast = Forecast({"a": 1, "b": 3}, [256])
    forecast.heard_screening("a", 4.0, 1)
    forecast.heard_screening("b", 3.0, 3)
    forecast.heard("a", 8.0, 1, None)
    guess = PRIOR * (4.0 + 3.0) / 2
    ratio = (FIRST * guess + 8.0) / (guess + 4.0)
    assert forecast.left([]) == pytest.approx(3 * ratio * 1.0)
    forecast.heard("b", 5.0, 1, None)
    ratio = (FIRST * guess + 8.0 + 5.0) / (guess + 4.0 + 1.0)
    assert forecast.left([]) == pytest.approx(2 * (5.0 + ALIKE * ratio * 1.0) / (1 + ALIKE))


def test_a_further_look_costs_what_its_paths_have_cost():
    """Until one was measured, a path is a part of one of the first look; then of one of the look before."""
    forecast = Forecast({"a": 2}, LOOKS)
    forecast.heard("a", 4.0, 2, None)
    forecast.over.add("a")
    assert forecast.left([Queued("a", 1, 512, 2)]) == pytest.approx(NEXT * 2.0 * 512 / 256)
    forecast.heard("a", 3.0, 1, 256)
    forecast.heard("a", 1.0, 1, 256)
    assert forecast.left([Queued("a", 1, 512, 2)]) == pytest.approx(LATER * (4.0 / 2 / 256) * 512)
    assert forecast.left([Queued("a", 1, 256, 2)]) == pytest.approx(4.0 / 2)


def test_problems_to_come_are_looked_at_again_as_often_as_those_before():
    """A guess counts for some problems; those that were judged outweigh it by and by."""
    forecast = Forecast({"a": 1, "b": 1}, [256, 256])
    forecast.heard("a", 8.0, 1, None)
    forecast.over.add("a")
    for goes_on in (True, False, False):
        forecast.looked(first=True, goes_on=goes_on)
    share = (AGAIN * PRIOR + 1) / (PRIOR + 3)
    assert forecast.left([]) == pytest.approx(8.0 + share * NEXT * 8.0)


def test_a_further_look_may_be_followed_by_others():
    """Each as often as it was so far, with its paths, of which each costs less."""
    forecast = Forecast({"a": 1}, [128, 128, 256, 512])
    forecast.heard("a", 1.0, 1, 128)
    forecast.over.add("a")
    share = forecast.further_looks.share
    left = forecast.left([Queued("a", 1, 128, 1)])
    assert left == pytest.approx(1.0 + (share * LATER * 2.0) + (share * LATER * 2.0) ** 2)
    assert forecast.left([Queued("a", 1, 128, 3)]) == pytest.approx(1.0)


RECORDED = json.loads(Path(__file__).with_name("recorded_run.json").read_text(encoding="utf-8"))


class Replay:
    """A forecast that is given the durations of a default run, each piece going to the first worker that is free.

    Parameters
    ----------
    workers : int
    speed : float
        Of the workers.
    """

    def __init__(self, workers, speed):
        self.workers, self.speed = workers, speed
        self.forecast = Forecast(RECORDED["schemes"], RECORDED["looks"])
        self.pieces, self.missing, self.queued = deque(), {}, {}

    def begin(self, problem, look, paths, portions):
        """Put the pieces of a look into the queue."""
        self.missing[problem, look] = len(portions)
        self.pieces.extend((problem, look, paths, schemes, seconds / self.speed) for schemes, seconds in portions)
        if look > 0:
            self.queued[problem, look] = Queued(problem, sum(count for count, _ in portions), paths, look)

    def told(self):
        """Yield the time, and the share of the work that is shown as done."""
        now, running = 0.0, []
        # No path is drawn before all is found that needs none.
        for look, paths, given in ((-1, 0, "screening"), (0, RECORDED["looks"][0], "first")):
            for problem, portions in RECORDED[given]:
                self.begin(problem, look, paths, portions)
            while self.pieces or running:
                while self.pieces and len(running) < self.workers:
                    piece = self.pieces.popleft()
                    heapq.heappush(running, (now + piece[-1], len(self.pieces), piece))
                now, _, piece = heapq.heappop(running)
                self.hear(*piece)
                left = self.forecast.left(self.queued.values())
                yield now, share_of(Advanced(0, 0, piece[0], self.forecast.spent, left))

    def hear(self, problem, look, paths, schemes, seconds):
        """Take note of a piece that is done, and go on with its problem as the run did."""
        if look < 0:
            self.forecast.heard_screening(problem, seconds, schemes)
            return
        self.forecast.heard(problem, seconds, schemes, paths if look else None)
        if look:
            known = self.queued[problem, look]
            self.queued[problem, look] = known._replace(schemes=known.schemes - schemes)
        self.missing[problem, look] -= 1
        if not self.missing[problem, look]:
            self.judge(problem, look)

    def judge(self, problem, look):
        """Look again at a problem where the run did."""
        self.forecast.over.add(problem)
        self.queued.pop((problem, look), None)
        further = [each for each in RECORDED["further"].get(problem, ()) if each[0] == look + 1]
        self.forecast.looked(first=not look, goes_on=bool(further))
        for number, paths, portions in further:
            self.begin(problem, number, paths, portions)


@pytest.mark.parametrize("workers", [1, 2])
@pytest.mark.parametrize("speed", [0.25, 1.0, 4.0])
def test_progress_is_correct_to_a_tenth_in_the_last_two_thirds(workers, speed):
    """On the durations of a default run, the share that is shown is that of the time that has passed, to a tenth."""
    told = list(Replay(workers, speed).told())
    whole = told[-1][0]
    assert told[-1][1] == 1.0
    assert max(abs(shown - now / whole) for now, shown in told if now >= whole / 3) <= 0.1


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
