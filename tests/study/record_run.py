"""Record what the forecast of a run is told: `python tests/study/record_run.py FILE [OPTIONS of matrix]`.

Says how far the share that was shown was from that of the time that had passed. On an idle machine and with `-j 2`,
it renews `recorded_run.json`, which the tests replay.
"""

import json
import sys
import time
from itertools import starmap
from pathlib import Path

import sdaeverify.study.run
from sdaeverify.cli.program import conclude
from sdaeverify.contracts.settings import Settings
from sdaeverify.study.forecast import Forecast, LaneKey


class Recorder(Forecast):
    """A forecast that notes when it is told what."""

    events = []  # noqa: RUF012 # those of the only run of this process

    def expect(self, problem, pieces, breadth=None):
        """Note what is expected."""
        wanted = sorted(set(pieces))
        self.note("expect", problem, wanted, breadth)
        super().expect(problem, wanted, breadth)

    def heard(self, problem, measured):
        """Note what pieces took."""
        rounded = [(piece, round(seconds, 4)) for piece, seconds in measured]
        self.note("heard", problem, rounded)
        super().heard(problem, rounded)

    def over(self, problem, block, stage=0):
        """Note that a block is done."""
        self.note("over", problem, block, stage)
        super().over(problem, block, stage)

    def note(self, *told):
        """Note something with the time."""
        self.events.append((round(time.monotonic(), 2), *told))


def shown(events):
    """Yield the seconds from the first event to each one, and the share of the work that is shown as done."""
    forecast = Forecast(Settings())
    for now, what, problem, *told in events:
        if what == "expect":
            pieces, breadth = told
            forecast.expect(problem, starmap(LaneKey, pieces), breadth)
        elif what == "heard":
            forecast.heard(problem, [(LaneKey(*piece), seconds) for piece, seconds in told[0]])
        else:
            block, stage = told
            forecast.over(problem, block, stage)
        if what != "expect":
            yield now - events[0][0], forecast.spent / (forecast.spent + forecast.left)


def distances(events):
    """Return the distances of the share that is shown from that of the time, in the last two thirds of a run."""
    told = [*shown(events)]
    whole = told[-1][0]
    return [abs(share - now / whole) for now, share in told if now >= whole / 3]


def main(file, *options):
    """Record a run."""
    sdaeverify.study.run.Forecast = Recorder
    code = conclude(["matrix", "--fresh", "--progress", "none", *options])
    Path(file).write_text(
        json.dumps(Recorder.events, separators=(",", ":")).replace("],[", "],\n["), encoding="utf-8"
    )
    found = distances(Recorder.events)
    print(f"largest distance {max(found):.3f}, mean {sum(found) / len(found):.3f}, of {len(found)} events")
    return code


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
