"""Blocks on executors that are nobody's here: the same bits, evidence that comes home, workers that are lost."""

import os
import sys
from concurrent.futures import BrokenExecutor, Executor, Future, ThreadPoolExecutor

import pandas as pd
import pytest

import sdaeverify
from evidence import lanes_in
from facade import LostExecutorError, RemoteCall, Serial, Workers, execute
from sdaeverify import UsageError

pytestmark = pytest.mark.long

ASKED = ("euler-maruyama,milstein", "gbm", "strong,weak")
SMALL = {"paths": 512, "levels": 3}
# Of the time that it took, and of who ran it.
PLUGIN = """
from typing import ClassVar
from sdaeverify import SDE, Claim, Scheme, Step, hookimpl


class Brought(Scheme):
    name: ClassVar[str] = "brought-euler"
    form: ClassVar[type] = SDE
    claims: ClassVar[tuple] = (Claim(measure="strong", value=0.5, source="nowhere"),)

    def step(self, problem, state, t, h, noise):
        moved = state + h * problem.drift(t, state) + problem.diffused(t, state, noise.dW)
        return Step(moved)


@hookimpl
def sdaeverify_schemes():
    return [Brought()]
"""


# Of two processes that come here at once one dies: nobody would be left.
DYING = """        import os, pathlib, signal
        try:
            dies = os.getpid() != {tester} and pathlib.Path({died!r}).touch(exist_ok=False) is None
        except FileExistsError:
            dies = False
        if dies:
            os.kill(os.getpid(), signal.SIGKILL)
"""


def mortal(died):
    """Return a plugin whose scheme kills the first process that makes a step, this one apart, and notes it."""
    named = PLUGIN.replace("Brought", "Mortal").replace("brought", "mortal")
    dying = DYING.format(died=str(died), tester=os.getpid())
    return named.replace("        moved =", f"{dying}        moved =")


class Failing(Executor):
    """An executor whose workers are lost on some calls, by their number."""

    def __init__(self, *lost: int) -> None:
        self.lost, self.calls = lost, 0

    def submit(self, fn, /, *args, **kwargs):
        """Make a call at once, or lose it."""
        self.calls += 1
        if self.calls not in self.lost:
            return Serial().submit(fn, *args, **kwargs)
        future: Future = Future()
        future.set_exception(BrokenExecutor("gone"))
        return future


class Closed(Executor):
    """An executor that takes no calls."""

    def submit(self, fn, /, *args, **kwargs):
        """Refuse a call."""
        raise RuntimeError("no scheduler")


@pytest.fixture(scope="module")
def here():
    """Return the tables of a run in this process."""
    return sdaeverify.verify(*ASKED, **SMALL)


def same(one, other):
    """Compare the tables of two runs bit by bit."""
    pd.testing.assert_frame_equal(one.verdicts, other.verdicts, check_exact=True)
    pd.testing.assert_frame_equal(one.levels, other.levels, check_exact=True)


def test_serial(here):
    """An executor that makes each call at once leads to the same bits."""
    same(here, sdaeverify.verify(*ASKED, **SMALL, executor="serial"))


def test_threads(here):
    """Threads of this process lead to the same bits."""
    with ThreadPoolExecutor(3) as executor:
        same(here, sdaeverify.verify(*ASKED, **SMALL, executor=executor, jobs=3))


def test_a_lost_worker_costs_a_second_call():
    """A call whose worker is lost is made once more, and changes nothing."""
    sound, lossy = Failing(), Failing(1, 3)

    same(sdaeverify.verify(*ASKED, **SMALL, executor=sound), sdaeverify.verify(*ASKED, **SMALL, executor=lossy))
    assert lossy.calls == sound.calls + 2


@pytest.mark.parametrize(
    ("executor", "why"), [(Failing(*range(1, 99)), "lost twice: .*gone"), (Closed(), "no scheduler")]
)
def test_an_executor_that_is_gone(executor, why):
    """A call that fails twice, or that nobody takes, ends the run in one line."""
    with pytest.raises(LostExecutorError, match=why):
        sdaeverify.verify(*ASKED, **SMALL, executor=executor)


def test_a_scheduler_that_is_gone_is_told_at_once():
    """Where who gives out the calls is known to be gone, that is told, and no call is made again."""
    executor = Failing(*range(1, 99))
    workers = Workers(executor, 1, why_lost=lambda: "the scheduler is dead")

    with pytest.raises(LostExecutorError, match=r"^the scheduler is dead$"):
        RemoteCall(workers, max, b"").outcome()

    assert executor.calls == 1


@pytest.mark.parametrize(
    ("executor", "why"),
    [("dusk", "unknown executor 'dusk'; did you mean dask"), (3, "expects a name or an object with a method submit")],
)
def test_no_executor(executor, why):
    """A name that is unknown, or a thing that takes no calls, is told in one line."""
    with pytest.raises(UsageError, match=why):
        sdaeverify.verify(*ASKED, **SMALL, executor=executor)


def test_a_missing_dask_is_told_with_its_extra(monkeypatch):
    """One line names what lacks and the command that installs it."""
    monkeypatch.setitem(sys.modules, "distributed", None)
    wanted = r"^executor dask needs distributed, which is not installed; pip install 'sdaeverify\[dask\]'$"
    with pytest.raises(UsageError, match=wanted):
        sdaeverify.verify(*ASKED, **SMALL, executor="dask")


def test_evidence_comes_home(tmp_path, capsys):
    """What workers elsewhere have found is kept in the folder of the run, and the next run finds it there."""
    words = ["matrix", "-s", "milstein", "-p", "gbm", "-m", "strong", "--paths", "512", "--levels", "3"]
    words += ["--out", str(tmp_path), "--progress", "none", "--no-html", "--executor", "serial"]
    assert execute(words) == 0
    assert "executor serial does not apply limits of time and memory" in capsys.readouterr().err

    assert lanes_in(tmp_path)
    assert execute(words) == 0
    assert "evidence of 6 of 6 blocks of paths, controls included, was reused" in capsys.readouterr().out


def test_a_scheduler_that_is_not_there(monkeypatch):
    """An address at which nobody answers is told in one line."""
    pytest.importorskip("distributed", reason="dask is not installed (extra cluster)")
    monkeypatch.setattr("sdaeverify.workers.executors.ANSWERS_WITHIN", "500ms")
    with pytest.raises(UsageError, match=r"executor dask://127\.0\.0\.1:9 cannot be used: .*127\.0\.0\.1:9"):
        sdaeverify.verify(*ASKED, **SMALL, executor="dask://127.0.0.1:9")


def test_dask_cluster(here):
    """Two workers of a Dask cluster on this machine lead to the same bits."""
    pytest.importorskip("distributed", reason="dask is not installed (extra cluster)")
    same(here, sdaeverify.verify(*ASKED, **SMALL, executor="dask", jobs=2))


def test_the_script_of_a_slurm_job():
    """What the documentation asks dask-jobqueue for is a job of single-threaded workers that know this package."""
    jobqueue = pytest.importorskip("dask_jobqueue", reason="dask-jobqueue is not installed (extra dask)")
    with jobqueue.SLURMCluster(
        queue="normal",
        cores=16,
        processes=16,
        memory="32GB",
        walltime="02:00:00",
        job_script_prologue=["export OMP_NUM_THREADS=1"],
        scheduler_options={"dashboard_address": None},
    ) as cluster:
        script, address = cluster.job_script().splitlines(), cluster.scheduler_address
    directives = [line for line in script if line.startswith("#SBATCH")]
    assert {"#SBATCH -p normal", "#SBATCH --cpus-per-task=16", "#SBATCH -t 02:00:00"} <= set(directives)
    assert script.index("export OMP_NUM_THREADS=1") < len(script) - 1
    (worker,) = [line for line in script if "dask_worker" in line]
    assert worker.startswith(sys.executable)
    assert "--nworkers 16" in worker
    assert "--nthreads 1" in worker
    # What --executor takes is this address with another scheme.
    assert address in worker
    assert address.startswith("tcp://")
