"""A Dask scheduler with two worker processes, as on a cluster: the same tables, whoever dies."""

import subprocess
import sys
import threading
import time
from contextlib import contextmanager
from pathlib import Path

import pandas as pd
import pytest

from evidence import lanes_in
from facade import execute

from .test_executors import mortal

distributed = pytest.importorskip("distributed", reason="dask is not installed (extra cluster)")

SMALL = ["-p", "gbm", "-m", "strong", "--paths", "512", "--levels", "3", "--progress", "none", "--no-html"]
PATIENCE = 120.0
HERE = ("-j", "1", "--timeout", "0", "--memory", "0")


@contextmanager
def started(*words):
    """Run a program of Dask until the block is left."""
    process = subprocess.Popen(
        [sys.executable, "-m", *words], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, cwd=Path.home()
    )
    try:
        yield process
    finally:
        process.kill()
        process.wait()


@contextmanager
def cluster(folder):
    """Give a scheduler's process and its address; two workers that nobody starts again have joined it."""
    file = folder / "scheduler.json"
    scheduler = ("distributed.cli.dask_scheduler", "--port", "0", "--no-dashboard", "--scheduler-file", str(file))
    worker = ("distributed.cli.dask_worker", "--scheduler-file", str(file), "--nthreads", "1", "--no-nanny")
    with started(*scheduler, "--host", "127.0.0.1") as process, started(*worker), started(*worker):
        with distributed.Client(scheduler_file=str(file), timeout=PATIENCE) as client:
            client.wait_for_workers(2, timeout=PATIENCE)
            address = client.scheduler.address
        yield process, address.replace("tcp://", "dask://")


def tables(folder):
    """Return verdicts and levels as they are written."""
    return [pd.read_csv(folder / f"{name}.csv", dtype=str) for name in ("verdicts", "levels")]


def same(one, other):
    """Compare the tables of two folders, number by number as they are written."""
    for a, b in zip(tables(one), tables(other), strict=True):
        pd.testing.assert_frame_equal(a, b)


def test_one_of_two_workers_dies_over_a_plugin_that_they_have_never_seen(tmp_path):
    """The tables are those of this process though a worker of the cluster is killed."""
    file, died = tmp_path / "mortal.py", tmp_path / "died"
    file.write_text(mortal(died))
    words = ["matrix", "-s", "mortal-euler,milstein,euler-maruyama", "--plugin", str(file), *SMALL]
    died.touch()
    assert execute([*words, *HERE, "--out", str(tmp_path / "here")]) == 0

    with cluster(tmp_path) as (_, address):
        died.unlink()
        assert execute([*words, "--executor", address, "--out", str(tmp_path / "lossy")]) == 0

    assert died.exists()
    same(tmp_path / "here", tmp_path / "lossy")


def test_the_scheduler_dies_in_the_middle(tmp_path, capsys):
    """One line says so, what was found until then is in the folder, and the next run goes on from there."""
    words = ["matrix", "-s", "euler-maruyama,milstein,heun", *SMALL, "--out", str(tmp_path / "out")]

    def kill_after_first_evidence(process):
        end = time.monotonic() + PATIENCE
        while not lanes_in(tmp_path / "out") and time.monotonic() < end:
            time.sleep(0.001)
        process.kill()

    with cluster(tmp_path) as (scheduler, address):
        killer = threading.Thread(target=kill_after_first_evidence, args=(scheduler,))
        killer.start()
        code = execute([*words, "--executor", address])
        killer.join()

    told = [line for line in capsys.readouterr().err.splitlines() if line.startswith("sdaeverify: error")]
    assert code == 3
    (line,) = told
    assert (
        f"error: the scheduler at {address.removeprefix('dask://')} is dead, or cannot be reached any more; " in line
    )
    assert "jobs" not in line
    kept = lanes_in(tmp_path / "out")
    assert kept
    assert execute([*words, *HERE]) == 0
    assert f"evidence of {len(kept)} of " in capsys.readouterr().out
