"""Schemes, measures and problems that hang, die or eat memory cost their own rows and nothing else."""

import multiprocessing
import sys
from pathlib import Path

import pytest

from evidence import lanes_in, rows_of
from facade import read_limits
from sdaeverify import UsageError

pytestmark = pytest.mark.long

BUDGET = ("--paths", "80", "--block", "40", "--levels", "8..32", "--progress", "none")
GOOD = ("milstein", "euler-maruyama")
SLOW = ("zz-hang", "zz-sleep", "zz-deaf", "zz-timeless", "zz-branch")
DEAD = {
    "zz-leave": "with exit code 0",
    "zz-abort": "of SIGABRT",
    "zz-late": "with exit code 3",
    "zz-orphan": "with exit code 0",
}
PLUGIN = """
HOARD = []

def hang(h, state):
    while True:
        pass

def sleep(h, state):
    time.sleep(300.0)

def deaf(h, state):
    signal.signal(signal.SIGALRM, signal.SIG_IGN)
    while True:
        pass

def timeless(h, state):
    signal.setitimer(signal.ITIMER_REAL, 0.0)
    while True:
        pass

def branch(h, state):
    # Both hang: whoever waits for the end of all that hold the pipes of this process waits for both.
    os.fork()
    time.sleep(300.0)

def orphan(h, state):
    if os.fork():
        os._exit(0)
    time.sleep(300.0)

def split(h, state):
    # Nothing is wrong with the step but that, once, a copy of the worker goes on as well.
    if not HOARD:
        HOARD.append(None)
        os.fork()

def leave(h, state):
    os._exit(0)

def abort(h, state):
    os.abort()

def eat(h, state):
    HOARD.append(np.ones(2**30))

def hoard(h, state):
    # Nothing is left for anybody, and this scheme does not need any.
    try:
        while True:
            HOARD.append(np.ones(2**13))
    except MemoryError:
        pass

def fine(h, state):
    pass

def late(h, state):
    # Only where one path is tried the scheme is well.
    if state.shape[-1] == 40 and h < 0.1:
        os._exit(3)

def made(kind):
    class Bad(Scheme):
        name: ClassVar[str] = f"zz-{kind.__name__}"
        form: ClassVar[type] = SDE
        claims: ClassVar[tuple] = (Claim(measure="strong", value=0.5, source="nowhere"),)

        def step(self, problem, state, t, h, noise):
            kind(h, state)
            dX = (problem.diffusion(t, state) * noise.dW).sum(axis=1)
            return Step(state + h * problem.drift(t, state) + dX)

    Bad.__qualname__ = Bad.__name__ = f"Bad{kind.__name__}"
    globals()[Bad.__name__] = Bad
    return Bad()

KINDS = (hang, sleep, deaf, timeless, branch, orphan, split, leave, abort, eat, hoard, fine, late)
SCHEMES = [made(kind) for kind in KINDS]

@hookimpl
def sdaeverify_schemes():
    return SCHEMES

class Hanging(Measure):
    name = "zz-probe"

    def probe(self, scheme, view, settings):
        if scheme.name == "milstein":
            time.sleep(300.0)
        return Tally()

    def judge(self, evidence):
        return Judgement((Finding(quantity="x", verdict=Verdict.INCONCLUSIVE, settled=True),), ())

@hookimpl
def sdaeverify_measures():
    return [Hanging()]

def problem(drift):
    diffusion = lambda t, x: x[:, None]
    return SDE(drift=drift, diffusion=diffusion, start=[1.0], noise_dim=1, horizon=1.0, source="nowhere")

def zz_hangs() -> SDE:
    return problem(lambda t, x: (time.sleep(300.0) if x.shape[-1] == 40 else None, x)[1])

def zz_dies() -> SDE:
    return problem(lambda t, x: (os._exit(1) if x.shape[-1] == 40 else None, x)[1])

@hookimpl
def sdaeverify_problems():
    return [zz_hangs, zz_dies]
"""
IMPORTS = """
import signal
from sdaeverify.contracts.finding import Finding, Judgement, Verdict
from sdaeverify.contracts.measure import Measure
from sdaeverify.contracts.tally import Tally
"""
POSIX = pytest.mark.skipif(sys.platform == "win32", reason="limits of processes are a matter of POSIX")


STOPS = """
@dataclass(frozen=True)
class Stops(Scheme):
    where: str = "step"
    name: ClassVar[str] = "zz-stops"
    form: ClassVar[type] = SDE
    claims: ClassVar[tuple] = (Claim(measure="strong", value=0.5, source="nowhere"),)

    def refuses(self, problem):
        if self.where == "asked":
            raise KeyboardInterrupt
        return ""

    def step(self, problem, state, t, h, noise):
        if self.where == "step" or (self.where == "late" and state.shape[-1] == 40):
            raise KeyboardInterrupt
        return Step(state + h * problem.drift(t, state) + problem.diffused(t, state, noise.dW))

@hookimpl
def sdaeverify_schemes():
    return [Stops()]

def zz_unbuilt() -> SDE:
    raise KeyboardInterrupt

@hookimpl
def sdaeverify_problems():
    return [zz_unbuilt]
"""


@pytest.fixture
def plugin(write):
    """Write a plugin with everything that is bad."""
    return write(IMPORTS + PLUGIN)


@pytest.fixture
def rows(call, plugin, tmp_path):
    """Run ``matrix`` with the bad plugin and return its rows by scheme, problem and measure."""

    def run(schemes, *arguments, measures="strong", problems="gbm", out="out"):
        chosen = ("-s", ",".join(schemes), "-p", problems, "-m", measures, "--plugin", plugin, "--out", out)
        outcome = call("matrix", *chosen, *BUDGET, *arguments)
        assert "Traceback" not in outcome.err
        assert not multiprocessing.active_children()
        found = {}
        for row in rows_of(tmp_path / out / "verdicts.csv"):
            found.setdefault((row["scheme"], row["problem"], row["measure"]), []).append(row)
        return found

    return run


def of(rows, *schemes):
    """Return the rows of some schemes, without what corrects for the number of tests of the run."""
    left = {"p_family", "family", "p_adjusted"}
    return {
        key: [{name: text for name, text in row.items() if name not in left} for row in found]
        for key, found in rows.items()
        if key[0] in schemes
    }


def why(rows, scheme, problem="gbm", measure="strong"):
    """Return verdict and reason of a cell without evidence."""
    (row,) = rows[scheme, problem, measure]
    return row["verdict"], row["reason"]


@pytest.mark.slow
@POSIX
def test_bad_schemes_beside_good_ones(rows):
    """Some that hang and some that die, in one block: the good ones have exactly the rows they have without them.

    Neither a signal that is ignored, nor an alarm that is turned off, nor a copy of the process helps a step.
    """
    alone = rows((*GOOD, "zz-fine"), "-j", "1", out="alone")

    beside = rows((*GOOD, *SLOW, *DEAD, "zz-fine", "zz-split"), "-j", "2", "--timeout", "10")

    assert of(beside, *GOOD, "zz-fine") == of(alone, *GOOD, "zz-fine")
    assert {row["verdict"] for row in beside["zz-split", "gbm", "strong"]} == {
        row["verdict"] for row in beside["zz-fine", "gbm", "strong"]
    }
    for scheme in SLOW:
        assert why(beside, scheme) == ("error", "no answer within 10 s (--timeout)")
    for scheme, how in DEAD.items():
        assert why(beside, scheme) == ("error", f"its worker process died {how}, twice")


@POSIX
def test_a_scheme_that_eats_memory(rows):
    """Who asks for more than a worker may have gets an error that names the limit; the others have their rows."""
    alone = rows(GOOD, "-j", "1", out="alone")

    beside = rows((*GOOD, "zz-eat"), "-j", "1", "--memory", "1G")

    assert of(beside, *GOOD) == of(alone, *GOOD)
    verdict, reason = why(beside, "zz-eat")
    assert verdict == "error"
    assert reason.startswith("MemoryError")
    assert reason.endswith("a worker may have 1 GiB (--memory)")


@pytest.mark.long
@POSIX
def test_a_scheme_that_hoards_memory(rows):
    """A scheme that keeps all the memory of its worker costs no rows of problems or classes that are judged there."""
    alone = rows(GOOD, "-j", "1", out="alone")

    beside = rows((*GOOD, "zz-hoard"), "-j", "1", "--memory", "300M")

    assert of(beside, *GOOD) == of(alone, *GOOD)


@pytest.mark.slow
@POSIX
def test_a_measure_that_hangs(rows):
    """A probe that hangs costs its own cell: other measures of the scheme and that measure of others stay."""
    names = {"measures": "strong,zz-probe", "out": "beside"}
    alone = rows(GOOD, "-j", "1", out="alone")

    beside = rows(GOOD, "-j", "1", "--timeout", "10", **names)

    strong = {key: found for key, found in beside.items() if key[2] == "strong"}
    assert of(strong, *GOOD) == of(alone, *GOOD)
    assert why(beside, "milstein", measure="zz-probe") == (
        "error",
        "no result within 10 s on a block of paths (--timeout)",
    )
    assert why(beside, "euler-maruyama", measure="zz-probe")[0] == "inconclusive"


@pytest.mark.slow
@POSIX
def test_problems_that_hang_or_die(rows):
    """A problem whose drift never comes back or ends the process costs its own rows."""
    alone = rows(GOOD, "-j", "1", out="alone")

    beside = rows(GOOD, "-j", "2", "--timeout", "10", problems="gbm,zz-hangs,zz-dies", out="beside")

    good = {key: found for key, found in beside.items() if not key[1].startswith("zz-")}
    assert of(good, *GOOD) == of(alone, *GOOD)
    for scheme in GOOD:
        assert why(beside, scheme, "zz-hangs")[0] == "error"
        assert "no result within 10 s on a block of paths (--timeout)" in why(beside, scheme, "zz-hangs")[1]
        assert why(beside, scheme, "zz-dies")[0] == "error"
        assert "its worker process died" in why(beside, scheme, "zz-dies")[1]


@pytest.mark.slow
@POSIX
def test_what_failed_is_tried_again_and_the_rest_is_not(rows):
    """A run that is repeated computes the blocks of the bad schemes only, and comes to the same."""
    chosen = (*GOOD, "zz-leave")
    first = rows(chosen, "-j", "1", "--timeout", "60")
    kept = {name: lane.seconds for _, name, lane in evidence()}

    second = rows(chosen, "-j", "1", "--timeout", "60")

    assert second == first
    assert kept == {name: lane.seconds for _, name, lane in evidence()}
    schemes = {lane.scheme for _, _, lane in evidence()}
    assert {*GOOD} < schemes
    assert "zz-leave" not in schemes


def evidence():
    """Return the evidence of a run in this folder."""
    return lanes_in(Path("out", "evidence"))


KILLED = """
HERE = os.path.dirname(__file__)

def killed(name, times):
    def drift(t, x):
        # In the process of a block, as an operator or the system would end it.
        file = os.path.join(HERE, name)
        died = os.path.getsize(file) if os.path.exists(file) else 0
        if died < times and x.shape[-1] == 256:
            with open(file, "a") as mark:
                mark.write("x")
            os.kill(os.getpid(), 9)
        return 0.5 * x
    return drift

def made(name, times) -> SDE:
    control = Control(measure="strong", order=1.0, positive="milstein", negative="zz-still")
    return SDE(
        drift=killed(name, times), diffusion=lambda t, x: 0.5 * x[:, None], start=[1.0], noise_dim=1, horizon=1.0,
        controls=(control,), source="nowhere",
    )

def zz_once() -> SDE:
    return made("once", 1)

class Still(Scheme):
    name: ClassVar[str] = "zz-still"
    form: ClassVar[type] = SDE

    def step(self, problem, state, t, h, noise):
        if state.shape[-1] == 256 and os.path.exists(os.path.join(HERE, "deadly")):
            os.kill(os.getpid(), 9)
        return Step(state + h * problem.drift(t, state) + problem.diffused(t, state, noise.dW))

@hookimpl
def sdaeverify_schemes():
    return [Still()]

@hookimpl
def sdaeverify_problems():
    return [zz_once]
"""


@pytest.mark.slow
@POSIX
def test_a_worker_that_is_killed_once(call, write, tmp_path):
    """A worker that is killed in the code of the problem costs nothing; a control that always is, is told."""
    plugin = write("from sdaeverify import Control" + KILLED)
    chosen = ("-s", "milstein", "-p", "zz-once", "-m", "strong", "--plugin", plugin, "-j", "1", "--fresh")
    limits = ("--paths", "512", "--levels", "8..64", "--progress", "none", "--timeout", "60", "--out", "out")

    once = call("matrix", *chosen, *limits)
    rows = _claimed(tmp_path / "out")

    assert (tmp_path / "once").read_text() == "x"
    assert (once.code, {row["verdict"] for row in rows}) == (0, {"verified"})

    (tmp_path / "deadly").write_text("")
    dead = call("matrix", *chosen, *limits)
    rows = _claimed(tmp_path / "out")

    assert (dead.code, {row["verdict"] for row in rows}) == (3, {"error"})
    for row in rows:
        assert "the control zz-still was not measured: its worker process died of SIGKILL" in row["reason"]
        assert "is not refuted" not in row["reason"]


def _claimed(folder):
    return [row for row in rows_of(folder / "verdicts.csv") if row["claim"]]


@POSIX
@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        ((None, None, 1), (600.0,)),
        ((None, None, 2), (600.0,)),
        ((5.0, None, 1), (5.0,)),
        ((0.0, None, 1), (float("inf"),)),
        ((0.0, "0", 2), (float("inf"), 0)),
        ((0.0, "0", 1), None),
    ],
    ids=["one job", "default", "timeout", "no timeout", "none", "none for one job"],
)
def test_limits(arguments, expected):
    """One job has the limits of many; only where all are taken away it runs in this process."""
    workers, limits = read_limits(*arguments)

    assert workers == arguments[2]
    assert limits is None if expected is None else (limits.timeout, limits.memory)[: len(expected)] == expected


@POSIX
def test_the_default_of_memory_is_shared():
    """All workers together may have most of the memory there is."""
    (_, one), (_, four) = read_limits(5.0, None, 1), read_limits(None, None, 4)

    assert one.memory // 4 == pytest.approx(four.memory, abs=4)
    assert one.memory > 2**28


@pytest.mark.parametrize("timeout", [-1.0, float("nan"), float("inf")])
def test_no_limit_of_time(timeout):
    """A time that is none is refused in one line."""
    with pytest.raises(UsageError, match="--timeout expects a number of seconds, or 0 for no limit, got"):
        read_limits(timeout, None, None)


def test_an_interrupt_that_a_plugin_raises(call, write, tmp_path):
    """Where workers run its code, it costs the rows of the plugin: the run goes on and is no interrupted one."""
    stopped = ["zz-stops", "zz-stops[where=asked]", "zz-stops[where=late]"]
    schemes, plugin = ",".join(["milstein", *stopped]), write(STOPS)
    chosen = ("-s", schemes, "-p", "gbm,zz-unbuilt", "-m", "strong", "--plugin", plugin)

    outcome = call("matrix", *chosen, *BUDGET, "-j", "1", "--timeout", "60", "--out", "out")

    assert (outcome.code, outcome.err) == (3, "")
    rows = rows_of(tmp_path / "out" / "verdicts.csv")
    told = {(row["scheme"], row["problem"]): row["reason"] for row in rows}
    assert "raised by the plugin" not in told.pop(("milstein", "gbm"))
    reason = "KeyboardInterrupt: raised by the plugin"
    assert [told[scheme, "gbm"] for scheme in stopped] == [reason] * 3
    assert told["milstein", "zz-unbuilt"] == f"problem zz-unbuilt cannot be built: {reason}"
