"""Paths of a scheme on a problem for inspection, on the same noise as a run."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from os import PathLike
from typing import TYPE_CHECKING, Any

import numpy as np

from ..arrays import Array, Mask, Parts
from ..contracts.matching import match
from ..contracts.measure import Snapshot
from ..contracts.scheme import Scheme
from ..contracts.settings import Settings, whole
from ..contracts.specs import ProblemSpec
from ..contracts.spelling import counted
from ..contracts.stages import FIRST_BLOCK
from ..contracts.tally import Tally
from ..errors import SchemeError, UsageError
from ..forms import Problem
from ..noise.brownian import Brownian, LevelNoise, Source
from ..registry.load import load_registry
from ..registry.selection import only, select_problems, select_schemes
from ..simulate.ensemble import one_thread
from ..simulate.tracks import Track
from .paper.axes import axes_of
from .tables.datasets import dataset

if TYPE_CHECKING:
    import pandas as pd
    import xarray

DEFAULT = Settings()


@dataclass(frozen=True, repr=False)
class Paths:
    """Paths of one scheme on one problem.

    Attributes
    ----------
    scheme, problem : str
        Labels.
    times : ndarray, shape (steps + 1,)
    components : mapping of str to ndarray, shape (steps + 1, k, P)
        Parts of the state: ``x`` for an SDE; ``r``, ``v`` and ``mu`` for constrained mechanics.
    without_root, lost : ndarray of bool, shape (P,)
        Whether a step found no root on a path, and whether the path is not finite or blew up.
    """

    scheme: str
    problem: str
    times: Array
    components: Mapping[str, Array]
    without_root: Mask
    lost: Mask

    def __getitem__(self, name: str) -> Array:
        """Return a component, shape (steps + 1, k, P)."""
        if name not in self.components:
            raise UsageError(f"no component {name!r}; there are {', '.join(self.components)}")
        return self.components[name]

    def __repr__(self) -> str:
        steps, shapes = len(self.times) - 1, {name: values.shape[1] for name, values in self.components.items()}
        parts = ", ".join(f"{name} ({size})" for name, size in shapes.items())
        gone = f"{np.count_nonzero(self.lost)} lost, {np.count_nonzero(self.without_root)} without root"
        made = f"{counted(len(self.lost), 'path')} of {self.scheme} on {self.problem}: {gone}"
        return f"{made}\n{steps} steps to t = {self.times[-1]:g}; components {parts}"

    def to_xarray(self) -> "xarray.Dataset":
        """Return a dataset whose components have the dimensions time, component index and path.

        Raises
        ------
        UsageError
            If xarray is not installed.
        """
        variables = {name: (("time", f"{name}_index", "path"), part) for name, part in self.components.items()}
        noted = {"without_root": ("path", self.without_root), "lost": ("path", self.lost)}
        about = {"scheme": self.scheme, "problem": self.problem}
        return dataset({**variables, **noted}, {"time": ("time", self.times)}, about)

    def frame(self) -> "pd.DataFrame":
        """Return a table with a row for each time and columns (component, index, path)."""
        import pandas as pd  # noqa: PLC0415 - whoever wants no table need not wait for it

        columns = [
            (name, i, p)
            for name, values in self.components.items()
            for i in range(values.shape[1])
            for p in range(values.shape[2])
        ]
        values = np.concatenate([part.reshape(len(self.times), -1) for part in self.components.values()], axis=1)
        names = pd.MultiIndex.from_tuples(columns, names=["component", "index", "path"])
        return pd.DataFrame(values, index=pd.Index(self.times, name="time"), columns=names)

    def plot(self, component: str | None = None, index: int = 0, ax: Any = None) -> Any:
        """Draw a component of every path against time, and return the axes.

        Parameters
        ----------
        component : str, optional
            Name of the component; by default the first.
        index : int
            Index of an entry of the component.
        ax : matplotlib Axes, optional

        Raises
        ------
        UsageError
            If there is no such entry, or matplotlib is not installed.
        """
        name = next(iter(self.components)) if component is None else component
        values = self[name]
        if not 0 <= whole("index", index) < values.shape[1]:
            raise UsageError(f"index must be from 0 to {values.shape[1] - 1} for {name}, got {index!r}")
        ax = axes_of(ax)
        ax.plot(self.times, values[:, index], lw=0.8)
        ax.set(xlabel="t", ylabel=f"{name}_{index + 1}", title=f"{self.scheme} on {self.problem}")
        return ax


def sample(
    scheme: str | Scheme,
    problem: str | ProblemSpec | Callable[..., Problem],
    *,
    steps: int = DEFAULT.coarsest * 2 ** (DEFAULT.levels - 1),
    paths: int = 10,
    seed: int = DEFAULT.seed,
    plugins: Sequence[str | PathLike[str]] = (),
) -> Paths:
    """Simulate paths of a scheme on a problem.

    The paths are the first paths of a run with the same seed, at the level of ``--levels 8..N`` with this number of
    steps.

    Parameters
    ----------
    scheme : str or Scheme
        Label of a scheme, or a scheme.
    problem : str, recipe or function
        Label of a problem, a specification, or a problem function.
    steps : int
        Number of steps up to the final time, 8 times a power of 2.
    paths : int
        Number of paths, from 1 to 256.
    seed : int
    plugins : sequence of str or path
        Plugin files.

    Raises
    ------
    UsageError
        If an argument is invalid, or does not name exactly one scheme and one problem.
    SchemeError
        If the scheme cannot solve the problem.
    """
    steps, paths = whole("steps", steps), whole("paths", paths)
    seed, coarsest = Settings(seed=seed).seed, DEFAULT.coarsest
    level = (steps // coarsest).bit_length() - 1
    if steps < coarsest or coarsest * 2**level != steps:
        raise UsageError(f"steps must be {coarsest} times a power of 2, got {steps}")
    if not 1 <= paths <= FIRST_BLOCK:
        raise UsageError(f"paths must be from 1 to {FIRST_BLOCK}, got {paths}")
    registry = load_registry([str(path) for path in plugins])
    one = only("scheme", scheme, select_schemes(registry, [scheme]))
    spec = only("problem", problem, select_problems(registry, [problem]))
    source = Source(seed, spec.label, 0, FIRST_BLOCK, paths)
    with np.errstate(all="ignore"), one_thread():
        return _simulate(one, spec, source, level)


def _simulate(scheme: Scheme, spec: ProblemSpec, source: Source, level: int) -> Paths:
    problem = spec.build()
    matched = match(scheme, problem)
    if matched.problem is None:
        raise SchemeError(f"scheme {scheme.label} on {spec.label}: {matched.reason}")
    h = problem.horizon / DEFAULT.coarsest
    track = Track(scheme, matched.problem, level, h / 2**level, source.used or 0)
    book = _Book(track, DEFAULT.coarsest * 2**level)
    brownian = Brownian(source, problem.noise_dim, h, level, problem.noise, problem.records)

    def advance(at: int, noise: LevelNoise) -> None:
        if at == level:
            track.advance(noise, (book,))

    brownian.follow(DEFAULT.coarsest, advance)
    track.find_lost(0.0)
    times = np.linspace(0.0, problem.horizon, len(book.parts))
    components = {name: np.stack([parts[name] for parts in book.parts]) for name in book.parts[0]}
    return Paths(scheme.label, spec.label, times, components, track.failed, track.lost)


class _Book:
    """Observer that stores the components after every step."""

    def __init__(self, track: Track, steps: int) -> None:
        self.track = track
        self.wanted: list[Sequence[int]] = [()] * track.level + [range(1, steps + 1)]
        self.parts: list[Parts] = [track.parts()]

    def after_step(self, level: int, step: int, parts: Parts) -> None:  # noqa: ARG002 - there is one level
        """Store the components."""
        self.parts.append(self.track.parts())

    def after_coarsest_step(self, snapshot: Snapshot) -> None:
        """Ignore the coarsest step, since a track has one level."""

    def tally(self) -> Tally:
        """Return an empty tally."""
        return Tally()
