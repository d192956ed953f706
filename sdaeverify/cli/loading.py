"""Loading of the registry for commands, with warnings on stderr."""

from collections.abc import Sequence

from ..contracts.opened import openings
from ..registry.load import Registry, load_registry
from .console import complain, output_to_stderr


def load_and_warn(files: Sequence[str], *, lab: bool = False) -> Registry:
    """Load all plugins, and warn about broken ones, which are left out.

    Parameters
    ----------
    files : sequence of str
        Plugin files named on the command line.
    lab : bool
        Whether planted bugs, calibration cases and experiments are loaded as well.

    Raises
    ------
    PluginError
        If a file cannot be used, or a plugin is broken and broken plugins are not allowed.
    """
    registry = load_quietly(files, lab=lab)
    for warning in registry.complaints:
        complain("warning", warning)
    return registry


def load_quietly(files: Sequence[str], *, lab: bool = False) -> Registry:
    """Load all plugins without warnings; raises as `load_and_warn`."""
    # Record opened files: commands may simulate in this process, and stored evidence depends on those files.
    openings()
    with output_to_stderr():
        return load_registry(files, lab=lab)
