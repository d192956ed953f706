"""The lock file as a test: what it demands is held against the cells that the other tests have run."""

from ..gate.lock import Claims, compared
from ..report.plain import visible
from .claims import ClaimError, ClaimRun

GATE = "sdaeverify gate holds all of them against the lock file"


def check_lock(run: ClaimRun, locked: Claims, workers: int = 1) -> None:
    """Raise what the lock file demands and no claim gives: nothing if all is there.

    Parameters
    ----------
    run : ClaimRun
        No cell is run again.
    locked : dict of Key to str
        Of the tier.
    workers : int
        Processes that the tests are spread over.

    Raises
    ------
    ClaimError
        If a claim that is locked is gone or weaker.
    pytest.skip.Exception
        If nobody can tell, since locked cells were not run in this process.
    """
    __tracebackhide__ = True
    if why := _unknown(run, locked, workers):
        import pytest  # noqa: PLC0415 - the kit itself needs no pytest

        raise pytest.skip.Exception(f"{why}; {GATE}", _use_item_location=True)
    known = (cell for cell in run.plan.cells if run.has_run(cell))
    lock = compared(locked, (outcome for cell in known for outcome in run.outcomes(cell)))
    if lock.violations:
        raise ClaimError("\n".join(f"lock file: {visible(line)}" for line in lock.violations))


def _unknown(run: ClaimRun, locked: Claims, workers: int) -> str:
    # Which process has run what differs from time to time, and a test must not.
    if workers > 1:
        return f"the tests are spread over {workers} processes"
    demanded = {key[:3] for key in locked}
    cells = [c for c in run.plan.cells if (c.scheme.label, c.spec.label, c.measure.name) in demanded]
    missing = sum(not run.has_run(cell) for cell in cells)
    return f"{missing} of {len(cells)} locked cells were not run here" if missing else ""
