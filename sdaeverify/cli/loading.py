"""The registry as a command uses it: what is odd about it is said on stderr."""

from collections.abc import Sequence

from ..contracts.opened import openings
from ..registry.load import Registry, load_registry
from .console import complain, output_to_stderr


def load_and_warn(files: Sequence[str], *, lab: bool = False) -> Registry:
    """Load all plugins, and warn of those that are broken and left out.

    Parameters
    ----------
    files : sequence of str
        Plugin files named on the command line.
    lab : bool
        Whether planted bugs, calibration cases and experiments are loaded, too.

    Raises
    ------
    PluginError
        If a file cannot be used, or a plugin is broken and that is not allowed.
    """
    registry = load_quietly(files, lab=lab)
    for warning in registry.complaints:
        complain("warning", warning)
    return registry


def load_quietly(files: Sequence[str], *, lab: bool = False) -> Registry:
    """Load all plugins, and say nothing about them; raises as `load_and_warn`."""
    # Commands may simulate in their own process and keep the evidence, which depends on files that plugins open.
    openings()
    with output_to_stderr():
        return load_registry(files, lab=lab)
