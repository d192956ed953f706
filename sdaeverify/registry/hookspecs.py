"""The hooks: all extension points for plugins.

A plugin is a module, named by an entry point of its distribution or given as a file, with functions of these
names marked `hookimpl`::

    # pyproject.toml of a distribution
    [project.entry-points.sdaeverify]
    my-schemes = "my_schemes"           # a module, or a package whose modules are one plugin each

    [project.entry-points."sdaeverify.lab"]
    my-bugs = "my_planted_bugs"         # plugins for some commands only: imported when one of these needs them

    [project.entry-points."sdaeverify.hooks"]
    sdaeverify_tables = "my_tables:Table"   # a hook of your own, and the class of the objects it returns

    [project.entry-points."sdaeverify.sources"]
    models = "my_models:MODELS"         # a sdaeverify.commands.PluginSource, which makes the option --models

    # my_schemes.py, or: sdaeverify matrix --plugin my_schemes.py
    from sdaeverify import hookimpl

    @hookimpl
    def sdaeverify_schemes():
        return [MyScheme()]

No hook is called inside the time loop. Those of an installed plugin are called once in a process, and again after a
file of its package or a folder of `sys.path` has changed. A plugin that fails in any way, or registers a name that
is taken, is left out as a whole and listed with the reason.
"""

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import pluggy

from ..contracts.scheme import Scheme
from ..forms import Problem

PROJECT = "sdaeverify"

hookspec = pluggy.HookspecMarker(PROJECT)
hookimpl = pluggy.HookimplMarker(PROJECT)


@hookspec
def sdaeverify_schemes() -> Iterable[Scheme]:  # type: ignore[empty-body]
    """Return schemes.

    When: once, as the registry is loaded.
    Given: no arguments.

    Returns
    -------
    iterable of Scheme
        Instances of frozen dataclasses. Several instances of one class are the default variants of its name.
        Each parameter has a default that is a bool, an int, a float or a str. A scheme rejects invalid values in
        ``__post_init__`` by raising `ParameterError`.
    """


@hookspec
def sdaeverify_problems() -> Iterable[Callable[..., Problem]]:  # type: ignore[empty-body]
    """Return problem functions, without calling them.

    When: once, as the registry is loaded; a function is called when its problem is run, in any process.
    Given: no arguments.

    Returns
    -------
    iterable of callable, keyword parameters -> Problem
        Functions at the top level of a module. Each parameter has a default that is a bool, an int, a float
        or a str. ``pendulum_tangential`` is registered as ``pendulum-tangential``.
    """


@hookspec
def sdaeverify_measures() -> Iterable[Any]:  # type: ignore[empty-body]
    """Return measures.

    When: once, as the registry is loaded.
    Given: no arguments.

    Returns
    -------
    iterable of measures
        Instances of subclasses of `sdaeverify.measuring.Measure`.
    """


@hookspec
def sdaeverify_report(folder: Path, result: Any) -> None:
    """Write further files to the folder of a report.

    When: at the end of a run, after all tables are written.

    Parameters
    ----------
    folder : Path
        Folder of the report; it exists, and its own files must not be changed.
    result : Result
        The result of the run, as `sdaeverify.verify` returns it: its tables are `verdicts` and `levels`, its cells
        with their findings `results`. As for any hook, an implementation may omit this argument.

    Returns
    -------
    None
    """
