"""A program on the wire as a scheme."""

import pickle
import threading
from collections import namedtuple
from collections.abc import Callable, Mapping
from functools import lru_cache
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from sdaeverify import Array, DelaySDAE, Increment, Parts, Scheme, SchemeError, Step, hookimpl

from .calling import Calling, Command
from .coefficients import FORMS, Coefficients
from .connection import Connection
from .hello import FIELDS, FLAGS, LAWS, Hello, greet
from .messages import Line, Shape, encode, shape_text

# Seconds without any byte after which a program counts as hung.
PATIENCE = 60.0
MASKS = ("failed", "truncated")
# Prefixes of the names of arrays that are reported in addition to the new state.
OUTPUT, COST = "output.", "cost."
MEMORY = "memory"


class Session:
    """The program of a command in this process, started on demand and restarted after a failure.

    Parameters
    ----------
    calling : Calling
    """

    def __init__(self, calling: Calling) -> None:
        self.calling = calling
        # Workers may be threads of one process.
        self.lock = threading.Lock()
        self._program: Connection | None = None

    def running(self, expected: Hello) -> Connection:
        """Return the running program, after its hello.

        Raises
        ------
        SchemeError
            If the program cannot be started, or its hello differs from that at registration.
        """
        if self._program is None or not self._program.runs:
            # The program may have ended between two steps; restarting is safe because steps are independent.
            self.drop()
            program = self.calling.connect()
            if greet(program) != expected:
                raise program.failure("sends a different hello than when it was registered; run it again")
            self._program = program
        return self._program

    def drop(self) -> None:
        """Kill the program, which may be in the middle of a step."""
        program, self._program = self._program, None
        if program is not None:
            program.close()


@lru_cache(maxsize=16)
def session_of(calling: Calling) -> Session:
    """Return the session of a program in this process, so that each worker has one process of it."""
    return Session(calling)


class Wired(Scheme):
    """A scheme whose steps are computed by a program, started once in each worker.

    Attributes
    ----------
    calling : Calling
    hello : Hello
    """

    calling: ClassVar[Calling]
    hello: ClassVar[Hello]

    def __reduce__(self) -> Any:
        """Return how a worker recreates the scheme, without starting the program."""
        if type(self) is not wired_class(self.calling, self.hello):
            raise pickle.PicklingError("a scheme whose claims differ from those of its program")
        return restored, (self.calling, self.hello)

    def refuses(self, problem: Any) -> str:
        """Refuse problems that lack required traits or coefficients, or are too large."""
        for traits in self.hello.needs:
            if not traits & problem.traits:
                return f"it needs a problem with {' or '.join(sorted(traits))}"
        known = Coefficients(problem, self.hello.form, self.hello.asks)
        return known.why_too_large(self.hello.most) or known.why_not()

    def enter(self, problem: Any, state: Any, t: float, h: float) -> Any:
        """Return the state with the initial memory of the program, if it has one."""
        if not self.hello.memory:
            return state
        known, fields = Coefficients(problem, self.hello.form, self.hello.asks), fields_of(state)
        paths = next(iter(fields.values())).shape[-1]
        empty = remembering((*fields, MEMORY))(*fields.values(), np.zeros((known.rows_of(self.hello.memory), paths)))
        times = {"t": np.array([float(t)]), "h": np.array([float(h)])}
        return self._answered(encode("enter", {**times, **fields, **known.constants}), empty, known).state

    def parts(self, problem: Any, state: Any) -> Parts:
        """Return the components of the solution without the program's memory."""
        if self.hello.memory:
            kind, fields = type(problem.initial(1)), state[:-1]
            state = fields[0] if kind is np.ndarray else kind(*fields)
        return super().parts(problem, state)

    def prepare(self, problem: Any, h: float) -> Callable[[Any, float, Increment], Step]:
        """Return the step for one problem and step size."""
        known = Coefficients(problem, self.hello.form, self.hello.asks)
        constants, size = known.constants, np.array([float(h)])

        def stepper(state: Any, t: float, noise: Increment) -> Step:
            sent = {"t": np.array([float(t)]), "h": size, **fields_of(state), **self._noise(noise), **constants}
            if isinstance(problem, DelaySDAE):
                lag = problem.lag(state.x, h, noise)
                sent |= {"lagged": lag.now, "ahead": lag.known, "weight": np.array([lag.weight])}
            return self._answered(encode("step", sent), state, known)

        return stepper

    def _answered(self, message: bytes, state: Any, known: Coefficients) -> Step:
        """Send a message to the program of this process, and return the resulting step."""
        session = session_of(self.calling)
        with session.lock:
            try:
                return made(session.running(self.hello), message, state, known)
            except BaseException:
                session.drop()
                raise

    def step(self, problem: Any, state: Any, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        return self.prepare(problem, h)(state, t, noise)

    def _noise(self, noise: Increment) -> dict[str, Array]:
        drawn: dict[str, Any] = {name: getattr(noise, name) for name in FIELDS if name in self.noise}
        if drawn.get("A", 0) is None and len(noise.dW) == 1:
            # A single Brownian motion has no areas, even if they are declared.
            drawn["A"] = noise.dW[:0]
        if missing := [name for name, array in drawn.items() if array is None]:
            raise SchemeError(f"{missing[0]} is not drawn for this problem")
        return drawn


def made(program: Connection, message: bytes, state: Any, known: Coefficients) -> Step:
    """Let a program compute a step, and answer its requests meanwhile.

    Parameters
    ----------
    program : Connection
    message : bytes
        Encoded ``step`` or ``enter``.
    state : ndarray or NamedTuple of ndarray
        State with the type and shapes of the answer.
    known : Coefficients

    Raises
    ------
    SchemeError
        If the program breaks the protocol, or ends.
    """
    program.send(message)
    while (line := program.line()).word == "ask":
        try:
            known.require(line.about, line.shapes)
        except SchemeError as error:
            raise program.failure(str(error)) from None
        arrays = {name: program.array(shape) for name, shape in line.shapes.items()}
        program.send(encode("give", {line.about: known.answer(line.about, arrays)}))
    if line.word == "error":
        raise program.failure(f"says: {line.about:.300}")
    if line.word != "done":
        told = "expected ask, done or error; words for people go to stderr"
        raise program.failure(f"sent {line.word!r:.60}, {told}")
    return read_step(program, line, state)


def read_step(program: Connection, line: Line, state: Any) -> Step:
    """Read the new state and the other results of a step.

    Parameters
    ----------
    program : Connection
    line : Line
        Line of the message ``done``.
    state : ndarray or NamedTuple of ndarray
        Old state.

    Raises
    ------
    SchemeError
        If arrays are missing, unknown or of other shapes.
    """
    expected = {name: array.shape for name, array in fields_of(state).items()}
    paths = next(iter(expected.values()))[-1]
    if why := why_not_done(line.shapes, expected, paths):
        raise program.failure(why)
    found = {name: program.array(shape) for name, shape in line.shapes.items()}
    flags = {name: _mask(program, name, found[name]) for name in MASKS if name in found}
    fields = [found[name] for name in expected]
    return Step(
        type(state)(*fields) if isinstance(state, tuple) else fields[0],
        failed=flags.get("failed"),
        truncated=flags.get("truncated"),
        outputs={name.removeprefix(OUTPUT): array for name, array in found.items() if name.startswith(OUTPUT)},
        costs={name.removeprefix(COST): array for name, array in found.items() if name.startswith(COST)},
    )


def why_not_done(shapes: Mapping[str, Shape], expected: Mapping[str, Shape], paths: int) -> str:
    """Return why the arrays of a ``done`` are invalid, or an empty string.

    Parameters
    ----------
    shapes : mapping of str to tuple of int
        Shapes of the announced arrays.
    expected : mapping of str to tuple of int
        Shapes of the arrays of the state, which come first.
    paths : int
    """
    first = list(shapes.items())[: len(expected)]
    if first != list(expected.items()):
        told, got = (" ".join(f"{n}={shape_text(s)}" for n, s in each) for each in (expected.items(), first))
        return f"sent 'done {got:.120}', expected {told!r} first"
    for name, shape in list(shapes.items())[len(expected) :]:
        rank = 1 if name in MASKS or name.startswith(COST) else 2
        if not (name in MASKS or name.startswith((OUTPUT, COST))):
            return f"sent {name!r} behind the state, expected {', '.join(MASKS)}, {OUTPUT}NAME or {COST}NAME"
        if len(shape) != rank or shape[-1] != paths:
            return f"sent {name} of shape {shape_text(shape)}, expected {'kx' if rank == 2 else ''}{paths}"
    return ""


def _mask(program: Connection, name: str, array: Array) -> Any:
    if not np.isin(array, (0.0, 1.0)).all():
        raise program.failure(f"sent {name} with numbers other than 0 and 1")
    return array == 1.0


def fields_of(state: Any) -> dict[str, Array]:
    """Return the arrays of a state by name; ``x`` for a state that is a single array."""
    return state._asdict() if isinstance(state, tuple) else {"x": state}  # type: ignore[attr-defined]


@lru_cache(maxsize=64)
def remembering(names: tuple[str, ...]) -> Any:
    """Return the class of states with the given fields, the last of which is the memory."""
    return namedtuple("Remembering", names)


@lru_cache(maxsize=64)
def wired_class(calling: Calling, hello: Hello) -> type[Wired]:
    """Return the class of the scheme of a program, one for each hello.

    Parameters
    ----------
    calling : Calling
    hello : Hello
    """
    declared = {
        "__doc__": hello.about or f"The program {Path(calling.command[0]).name}, by the wire.",
        "calling": calling,
        "hello": hello,
        "build": calling.build,
        "name": hello.name,
        "form": tuple(FORMS[name].kind for name in hello.form),
        "noise": hello.noise,
        "claims": hello.claims,
        "gives": hello.gives,
        "source": hello.source,
        "law": LAWS[hello.law],
        **dict(FLAGS[word] for word in hello.flags),
    }
    return type("Wired", (Wired,), declared)


def restored(calling: Calling, hello: Hello) -> Wired:
    """Return the scheme of a program whose hello is known.

    Parameters
    ----------
    calling : Calling
    hello : Hello
    """
    return wired_class(calling, hello)()


def scheme_of(command: Command, patience: float = PATIENCE, folder: Path | None = None) -> Wired:
    """Start a program, read its hello, end it, and return its scheme.

    Parameters
    ----------
    command : str, Path or sequence of str
        Program with its arguments, or address; a text is split as by a shell.
    patience : float
        Seconds without any byte after which the program counts as hung.
    folder : Path, optional
        Folder of relative paths; by default the current one.

    Raises
    ------
    UsageError
        If there is no such program.
    SchemeError
        If it sends no valid hello.
    """
    calling = Calling.of(command, patience, folder)
    program = calling.connect()
    try:
        return restored(calling, greet(program))
    finally:
        program.close()


def schemes(*commands: Command, patience: float = PATIENCE) -> Callable[[], list[Scheme]]:
    """Return the hook that registers programs; a plugin file names it ``sdaeverify_schemes``.

    Parameters
    ----------
    *commands : str, Path or sequence of str
        Programs with their arguments, or addresses; a text is split as by a shell.
    patience : float
        Seconds without any byte after which a program counts as hung.
    """

    @hookimpl
    def sdaeverify_schemes() -> list[Scheme]:
        return [scheme_of(command, patience) for command in commands]

    return sdaeverify_schemes
