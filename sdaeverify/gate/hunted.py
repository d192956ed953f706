"""The search for counterexamples of a gate, carried out by a plugin if one is installed."""

from dataclasses import dataclass
from pathlib import Path

import msgspec

from ..errors import FAULTS, PluginError, SdaeverifyError, one_line
from ..registry.discovery import enabled_entry_points, origin_of
from ..registry.load import Registry
from ..report.saved import SavedAttack
from .gate_plan import gated_schemes
from .policy import Policy

# Entry points: functions of schemes, with the keywords of `search`, that return the fields of `Hunted` as a mapping.
GROUP = "sdaeverify.hunts"


@dataclass(frozen=True)
class Hunted:
    """Result of the search for counterexamples of a gate.

    Attributes
    ----------
    refuted : tuple of str
        A line for each refuted claim.
    notes : tuple of str
        The number of examined examples, or the reason why there is no search.
    attacks : tuple of SavedAttack
        The result for each scheme, measure and form.
    """

    refuted: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()
    attacks: tuple[SavedAttack, ...] = ()


def search(registry: Registry, policy: Policy, folder: Path) -> Hunted:
    """Search counterexamples to the gated claims, if the policy and its tier request it.

    Parameters
    ----------
    registry : Registry
    policy : Policy
    folder : Path
        Folder of the gate, for stored results and counterexamples.

    Raises
    ------
    PluginError
        If the plugin of the search is broken.
    """
    if not (policy.hunt and policy.budget.hunts):
        return Hunted()
    known = enabled_entry_points(GROUP)
    if not known:
        return Hunted(notes=(f"hunt of {policy.hunt}: this installation has no hunt",))
    given = {"measures": policy.measures, "seed": policy.seed, "plugins": registry.files, "folder": folder}
    try:
        found = known[0].load()(gated_schemes(registry, policy), seconds=policy.hunt_seconds, **given)
        return msgspec.convert(found, Hunted)
    except SdaeverifyError:
        raise
    except FAULTS as error:
        raise PluginError(f"the hunt of {origin_of(known[0])} is broken: {one_line(error)}") from error
