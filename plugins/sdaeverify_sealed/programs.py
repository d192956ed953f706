"""Programs as sealed solvers: one call a run, with words on the command line and numbers on its stdout.

    ./my_solver h=0.25 T=1.0 paths=3277 seed=1804289383

The program writes its final states on stdout: little-endian float64 of shape (d, paths), the path being the fastest
index. The request has four numbers and no array, which any language and any shell script reads without a parser.
There is one request and one answer, so that no protocol is needed. A program that asks for the coefficients of a
problem speaks the wire (`sdaeverify_wire`), step by step.
"""

import shlex
import shutil
import subprocess
from collections.abc import Sequence
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from sdaeverify import Array, Claim, Problem, SchemeError

from .contract import Sealed, rows_of

# Seconds that a run may take.
PATIENCE = 600.0
NUMBER = np.dtype("<f8")
# Letters of stderr that a message ends with.
LAST_WORDS = 300


class _Program(Sealed):
    """A sealed solver that is a program."""

    command: ClassVar[tuple[str, ...]]
    patience: ClassVar[float] = PATIENCE
    given: ClassVar[tuple[Any, ...]]

    def __reduce__(self) -> Any:
        return _restored, self.given

    def run(self, problem: Problem, h: float, T: float, paths: int, seed: int) -> Array:
        """Run the program, and return the states that it writes."""
        words = (f"h={h!r}", f"T={T!r}", f"paths={paths}", f"seed={seed}")
        from sdaeverify_wire.program import WITH_PARENT  # noqa: PLC0415 - functions are judged without the wire, too

        guard = shutil.which(WITH_PARENT[0])
        with_parent = (guard, *WITH_PARENT[1:], "--") if guard else ()
        shown = shlex.join([Path(self.command[0]).name, *self.command[1:], *words])
        return _states(
            _output((*with_parent, *self.command, *words), shown, self.patience), shown, (rows_of(problem), paths)
        )


def _output(command: tuple[str, ...], shown: str, patience: float) -> bytes:
    """Return the stdout of a program that ends with exit code 0.

    Raises
    ------
    SchemeError
        If it cannot be started, does not end in time, or ends with another code.
    """
    try:
        done = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, timeout=patience, check=False)
    except OSError as error:
        raise SchemeError(f"{shown} cannot be started: {error.strerror or error}") from error
    except subprocess.TimeoutExpired:
        raise SchemeError(f"{shown} has not ended after {patience:g} s (patience)") from None
    if done.returncode:
        said = b" | ".join(line.strip() for line in done.stderr.strip().splitlines()[-3:])[-LAST_WORDS:]
        told = f"; its stderr ends: {said.decode('utf-8', 'replace')}" if said else ""
        code = done.returncode
        raise SchemeError(f"{shown} ended with {f'exit code {code}' if code > 0 else f'signal {-code}'}{told}")
    return done.stdout


def _states(written: bytes, shown: str, shape: tuple[int, int]) -> Array:
    expected = NUMBER.itemsize * shape[0] * shape[1]
    if len(written) != expected:
        numbers = f"{shape[0]} x {shape[1]} numbers of {NUMBER.itemsize} bytes"
        raise SchemeError(f"{shown} wrote {len(written)} bytes, expected {expected}: {numbers}")
    return np.frombuffer(written, NUMBER).reshape(shape).astype(float)


def program(
    name: str,
    command: str | Path | Sequence[str],
    problems: Sequence[str],
    claims: Sequence[Claim] = (),
    **declared: Any,
) -> Sealed:
    """Return a program as a sealed solver.

    Parameters
    ----------
    name : str
        Of the solver, in lower case with hyphens.
    command : str, Path or sequence of str
        The program and its first arguments; a text is split as a shell does.
    problems : sequence of str
        Labels of the problems that it solves, from whose initial states it starts.
    claims : sequence of Claim
    **declared
        Further class variables of `Sealed`, and ``patience``, the seconds that a run may take.

    Raises
    ------
    UsageError
        If there is no such program.
    """
    from sdaeverify_wire.calling import split_command  # noqa: PLC0415 - functions are judged without the wire, too

    return _restored(name, split_command(command), tuple(problems), tuple(claims), declared)


def _restored(
    name: str,
    command: tuple[str, ...],
    problems: tuple[str, ...],
    claims: tuple[Claim, ...],
    declared: dict[str, Any],
) -> Sealed:
    fields = {"name": name, "command": command, "problems": problems, "claims": claims, **declared}
    given = (name, command, problems, claims, declared)
    kind: type[Sealed] = type(name, (_Program,), {**fields, "given": given})
    return kind()
